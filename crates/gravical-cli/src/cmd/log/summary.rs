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

use super::event::{Content, Ended, RecordedPose};
use super::reporter::Reporter;

/// Time after which it is said that the file is being read.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two looks at the flag of the user.
const LOOK: Duration = Duration::from_millis(20);
/// A rest of this length is a pose, s.
const POSE_S: f64 = 2.0;

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
) -> Result<Option<Content>> {
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
            Ok(inspection) => return inspection.map(|inspection| Some(content(inspection))),
            Err(RecvTimeoutError::Timeout) if !interrupted.load(Ordering::SeqCst) => {}
            Err(_) => return Ok(None),
        }
        if begun.elapsed() >= PATIENCE && !std::mem::replace(&mut is_said, true) {
            reporter.progress("all rows are safe; reading them for the summary (Ctrl-C skips it)");
        }
    }
}

fn content(inspection: Inspection) -> Content {
    let rests = inspection.static_intervals.iter();
    let rests = rests.filter_map(|rest| Some((rest, rest.end_s? - rest.start_s?)));
    let poses: Vec<_> = rests
        .filter(|(_, duration_s)| *duration_s >= POSE_S)
        .collect();
    let at_rest = |face: Face| {
        let own = poses
            .iter()
            .filter(|(rest, _)| rest.face == Some(face.name()));
        RecordedPose {
            face: face.name(),
            duration_s: own.map(|(_, duration_s)| duration_s).sum(),
        }
    };
    let faces = Face::all().map(at_rest).into_iter();
    Content {
        free_poses: poses.iter().filter(|(rest, _)| rest.face.is_none()).count(),
        poses: faces.filter(|pose| pose.duration_s > 0.0).collect(),
        accelerometer: inspection.accelerometer,
        gyroscope: inspection.gyroscope,
        timing: inspection.timing,
        findings: inspection.findings,
    }
}

/// Counts of rows and lines, the poses, and what the file holds, for people.
pub fn summary(ended: &Ended) -> String {
    let (file, counts) = (&ended.file, &ended.counts);
    let mut text = format!("{file}: {} rows in {:.1} s\n", counts.rows, ended.elapsed_s);
    if counts.rejected > 0 {
        text += &format!(
            "  rejected  {} lines, marked in the file\n",
            counts.rejected
        );
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
    if let Some(content) = &ended.content {
        let poses = content.poses.iter();
        let poses = poses.map(|pose| format!("{} {:.1} s", pose.face, pose.duration_s));
        let free = Some(content.free_poses).filter(|n| *n > 0);
        let poses: Vec<String> = poses.chain(free.map(|n| format!("free {n}"))).collect();
        if !poses.is_empty() {
            text += &format!("  poses     {}\n", poses.join(", "));
        }
        let unit = numfmt::unit(content.accelerometer.unit.name());
        let range = content.accelerometer.lsb_per_g.map(|lsb| 32768.0 / lsb);
        let range = range.map_or_else(String::new, |g| format!(" of ±{g:.0} g"));
        let rate = content.timing.rate_hz();
        let rate = rate.map_or_else(String::new, |hz| format!(", {hz:.2} Hz"));
        text += &format!("  accelerometer in {unit}{range}{rate}\n");
        for remark in Remark::all(&content.findings, false) {
            text += &remark.to_text();
        }
    }
    text + &format!("Next: gravical inspect {}", shell_word(file))
}
