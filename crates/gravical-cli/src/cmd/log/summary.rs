//! The summary at the end, for people.

use gravical::escape::shell_word;
use gravical::numfmt;
use gravical_report::document::Remark;

use crate::device::event::Event;

/// Counts of rows and lines, the poses, and what the file holds.
pub fn summary(file: &str, ended: &Event) -> String {
    let Event::Ended {
        rejected_file,
        elapsed_s,
        poses,
        free_poses,
        counts: c,
        content,
        ..
    } = ended
    else {
        return String::new();
    };
    let mut text = format!("{file}: {} rows in {elapsed_s:.1} s\n", c.stored);
    let parts = [
        (c.stored, "stored"),
        (c.before_start, "before the start"),
        (c.paused, "paused"),
        (c.other_settings, "with other settings"),
        (c.unstored, "not taken by the disk"),
        (c.after_end, "after the end"),
    ];
    let sum: Vec<String> = parts
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    if sum.len() > 1 {
        text.push_str(&format!(
            "  received  {} rows = {}\n",
            c.received,
            sum.join(" + ")
        ));
    }
    if c.rejected > 0 {
        let kept = rejected_file.as_deref().unwrap_or("not stored");
        let lines = if c.rejected == 1 { "line" } else { "lines" };
        text.push_str(&format!("  rejected  {} {lines} → {kept}\n", c.rejected));
    }
    if c.gaps > 0 {
        let rows = match c.in_gaps() {
            // A continuation; after a reset the number is not known.
            0 if c.incomplete == 0 => String::new(),
            0 => ", an unknown number of rows is missing".to_owned(),
            n => format!(", {n} rows known to be missing"),
        };
        text.push_str(&format!(
            "  gaps      {}{rows}; the file names each\n",
            c.gaps
        ));
    }
    let free = free_poses.filter(|n| *n > 0).map(|n| format!("free {n}"));
    let faces = poses.iter().flatten();
    let poses: Vec<String> = faces
        .map(|pose| format!("{} {:.1} s", pose.face, pose.duration_s))
        .chain(free)
        .collect();
    if !poses.is_empty() {
        text.push_str(&format!("  recorded poses: {}\n", poses.join(", ")));
    }
    if let Some(content) = content {
        let unit = numfmt::unit(content.accelerometer.unit.name());
        let range = content.accelerometer.lsb_per_g.map(|lsb| 32768.0 / lsb);
        let range = range.map_or_else(String::new, |g| format!(" of ±{g:.0} g"));
        let rate = content.timing.rate_hz();
        let rate = rate.map_or_else(String::new, |hz| format!(", {hz:.2} Hz"));
        text.push_str(&format!("  accelerometer in {unit}{range}{rate}\n"));
        for remark in Remark::all(&content.findings, false) {
            text.push_str(&remark.to_text());
        }
    }
    text.push_str(&format!("Next: gravical inspect {}", shell_word(file)));
    text
}
