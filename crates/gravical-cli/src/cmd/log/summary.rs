//! The summary at the end: what the file holds, as `inspect` reads it.

use std::collections::BTreeMap;
use std::path::Path;

use gravical::Result;
use gravical::escape::shell_word;
use gravical::inspect::{Inspection, inspect};
use gravical::numfmt;
use gravical::poses::face::AxisMap;
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
    if counts.rejected > 0 {
        let rejected = counts.rejected;
        text += &format!("  rejected  {rejected} lines, marked in the file\n");
    }
    if counts.gaps > 0 {
        let missing = match counts.missing {
            0 => String::new(),
            n => format!(", {n} rows known to be missing"),
        };
        let gaps = counts.gaps;
        text += &format!("  gaps      {gaps}{missing}; the file names each\n");
    }
    if let Some(inspection) = &ended.inspection {
        text += &content(inspection);
    }
    text + &format!("Next: gravical inspect {}", shell_word(file))
}

/// Poses, unit, rate and findings.
fn content(inspection: &Inspection) -> String {
    let mut poses: BTreeMap<&str, f64> = BTreeMap::new();
    for rest in &inspection.static_intervals {
        let duration_s = rest
            .end_s
            .zip(rest.start_s)
            .map_or(0.0, |(end, start)| end - start);
        if duration_s >= POSE_S {
            *poses
                .entry(rest.face.as_deref().unwrap_or("free"))
                .or_default() += duration_s;
        }
    }
    let poses = poses
        .iter()
        .map(|(face, duration_s)| format!("{face} {duration_s:.1} s"));
    let poses: Vec<String> = poses.collect();
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
