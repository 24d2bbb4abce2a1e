//! The summary at the end: what the file holds, as `inspect` reads it.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use gravical::Result;
use gravical::escape::shell_word;
use gravical::inspect::{Inspection, inspect};
use gravical::numfmt;
use gravical::poses::face::{AxisMap, Face};
use gravical::recording::{ReadOptions, read};
use gravical_report::document::Remark;

use super::POSE_S;
use super::event::Ended;
use super::reporter::Reporter;

/// Time after which it is said that the file is being read.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two looks at the flag of the user.
const LOOK: Duration = Duration::from_millis(20);

/// What `gravical inspect` says of the file; none if the user does not want to wait for it: a long
/// file takes a while.
///
/// # Errors
///
/// Those of reading.
pub fn inspected(
    path: &Path,
    reporter: &mut Reporter,
    interrupted: &AtomicBool,
) -> Result<Option<Inspection>> {
    let (sender, result) = channel();
    let file = path.to_owned();
    thread::spawn(move || {
        let recording = read(&file, &ReadOptions::default());
        // Without a receiver nobody waits.
        let _ = sender.send(recording.map(|recording| inspect(&recording, &AxisMap::default())));
    });
    let begun = Instant::now();
    let mut is_said = false;
    loop {
        match result.recv_timeout(LOOK) {
            Ok(inspection) => return inspection.map(Some),
            Err(RecvTimeoutError::Timeout) if !interrupted.load(Ordering::SeqCst) => {}
            Err(_) => return Ok(None),
        }
        if begun.elapsed() >= PATIENCE && !std::mem::replace(&mut is_said, true) {
            reporter.progress("all rows are safe; reading them for the summary (Ctrl-C skips it)");
        }
    }
}

/// Counts of rows and lines, the poses, and what the file holds, for people.
pub fn summary(ended: &Ended) -> String {
    let (file, counts) = (&ended.file, &ended.counts);
    let mut text = format!("{file}: {} rows in {:.1} s\n", counts.rows, ended.elapsed_s);
    let rejected = counts.rejected;
    if rejected > 0 {
        text += &format!("  rejected  {rejected} lines, marked in the file\n");
    }
    if counts.gaps > 0 {
        let missing = match counts.missing {
            0 => String::new(),
            n => format!(", {n} rows known to be missing"),
        };
        text += &format!(
            "  gaps      {}{missing}; the file names each\n",
            counts.gaps
        );
    }
    if let Some(inspection) = &ended.inspection {
        text += &content(inspection);
    }
    text + &format!("Next: gravical inspect {}", shell_word(file))
}

/// Poses, unit, rate and findings.
fn content(inspection: &Inspection) -> String {
    let rests = inspection.static_intervals.iter();
    let durations = rests.filter_map(|rest| Some((rest.face.clone(), rest.end_s? - rest.start_s?)));
    let poses: Vec<_> = durations.filter(|pose| pose.1 >= POSE_S).collect();
    let of_face = |face: Face| {
        let at_rest = poses.iter().filter(|pose| pose.0 == Some(face.name()));
        let duration_s: f64 = at_rest.map(|pose| pose.1).sum();
        (duration_s > 0.0).then(|| format!("{} {duration_s:.1} s", face.name()))
    };
    let free = poses.iter().filter(|pose| pose.0.is_none()).count();
    let free = (free > 0).then(|| format!("free {free}"));
    let faces = Face::all().into_iter().filter_map(of_face);
    let poses: Vec<String> = faces.chain(free).collect();
    let mut text = String::new();
    if !poses.is_empty() {
        text += &format!("  poses     {}\n", poses.join(", "));
    }
    let unit = numfmt::unit(inspection.accelerometer.unit.name());
    let range = inspection.accelerometer.lsb_per_g.map(|lsb| 32768.0 / lsb);
    let range = range.map_or_else(String::new, |g| format!(" of ±{g:.0} g"));
    let rate = inspection.timing.rate_hz();
    let rate = rate.map_or_else(String::new, |hz| format!(", {hz:.2} Hz"));
    text += &format!("  accelerometer in {unit}{range}{rate}\n");
    let remarks = Remark::all(&inspection.findings, false);
    text.extend(remarks.iter().map(Remark::to_text));
    text
}
