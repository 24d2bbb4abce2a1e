//! The summary at the end: what the file holds, as `inspect` reads it.

use std::path::Path;

use gravical::Result;
use gravical::escape::shell_word;
use gravical::inspect::{Inspection, inspect};
use gravical::numfmt;
use gravical::poses::face::{AxisMap, Face};
use gravical::recording::{ReadOptions, read};
use gravical_report::document::Remark;

use super::POSE_S;
use super::event::Ended;

/// A longer file is not inspected: that takes a while, and `gravical inspect` does it at any time.
const MAX_BYTES: u64 = 100_000_000;

/// What `gravical inspect` says of the file; none of a long one.
///
/// # Errors
///
/// Those of reading.
pub fn inspected(path: &Path) -> Result<Option<Inspection>> {
    if std::fs::metadata(path).is_ok_and(|m| m.len() > MAX_BYTES) {
        return Ok(None);
    }
    let recording = read(path, &ReadOptions::default())?;
    Ok(Some(inspect(&recording, &AxisMap::default())))
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
