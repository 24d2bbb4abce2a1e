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
        text.push_str(&format!(
            "  gaps      {}, {} rows known to be missing; the file names each\n",
            a.gaps,
            a.in_gaps()
        ));
    }
    text.push_str(&format!("Next: gravical inspect {file}"));
    text
}
