//! What became of every row, for people.

use crate::device::event::Event;

/// The sum, for people.
pub fn summary(file: &str, ended: &Event) -> String {
    let Event::Ended {
        rejected_file,
        elapsed_s,
        account: a,
        ..
    } = ended
    else {
        return String::new();
    };
    let mut text = format!("{file}: {} rows in {elapsed_s:.1} s\n", a.stored);
    let parts = [
        (a.stored, "stored"),
        (a.before_start, "before the start"),
        (a.paused, "paused"),
        (a.other_settings, "with other settings"),
        (a.unstored, "not taken by the disk"),
        (a.after_end, "after the end"),
    ];
    let sum: Vec<String> = parts
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    if sum.len() > 1 {
        text.push_str(&format!(
            "  received  {} rows = {}\n",
            a.received,
            sum.join(" + ")
        ));
    }
    if a.rejected > 0 {
        let kept = rejected_file.as_deref().unwrap_or("not stored");
        let lines = if a.rejected == 1 { "line" } else { "lines" };
        text.push_str(&format!("  rejected  {} {lines} → {kept}\n", a.rejected));
    }
    if a.lost > 0 {
        let rows = if a.lost == 1 { "row" } else { "rows" };
        text.push_str(&format!(
            "  lost      {} {rows} here and there; inspect counts them\n",
            a.lost
        ));
    }
    if a.gaps > 0 {
        let rows = match a.in_gaps() {
            // A recording that was continued; a reset, of which nobody knows.
            0 if a.incomplete == 0 => String::new(),
            0 => ", an unknown number of rows is missing".to_owned(),
            n => format!(", {n} rows known to be missing"),
        };
        text.push_str(&format!(
            "  gaps      {}{rows}; the file names each\n",
            a.gaps
        ));
    }
    text.push_str(&format!("Next: gravical inspect {file}"));
    text
}
