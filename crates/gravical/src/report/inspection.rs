//! What is in a recording, as text.

use crate::inspect::{Inspection, StillSpan};
use crate::output::one_line;
use crate::recording::Origin;
use crate::recording::units::{AccelUnit, GyroUnit};

use super::temperature::temperature_text;
use super::text::{findings_text, paragraph};

/// Cells of the bar that shows where the recording is still.
const BAR: usize = 64;
/// Stills that are listed one by one.
const LISTED: usize = 16;

/// The whole summary.
#[must_use]
pub fn inspection_text(inspection: &Inspection) -> String {
    let mut out = format!("{}\n", one_line(&inspection.file));
    let mut line = |name: &str, text: String| {
        out.push_str(&paragraph(&format!("  {name:<8}"), &text));
    };
    line("format", inspection.description.clone());
    if let Some(serial) = &inspection.serial {
        line("sensor", format!("serial number {serial}"));
    }
    line("lines", inspection.account.sum.clone());
    line("time", time(inspection));
    line("accel", accel(inspection));
    if let Some(text) = gyro(inspection) {
        line("gyro", text);
    }
    if let Some([low, high]) = inspection.temperature_c {
        line("temp", format!("{low:.1} to {high:.1} °C"));
    }
    if !inspection.labels.is_empty() {
        let shown: Vec<String> = inspection
            .labels
            .iter()
            .take(12)
            .map(|(name, rows)| format!("{name} {rows}"))
            .collect();
        line("labels", shown.join(", "));
    }
    line("still", stillness(inspection));
    out.push_str(&format!("          {}\n", bar(inspection)));
    out.push_str(&stills(inspection));
    if !inspection.turns.is_empty() {
        let about: Vec<String> = inspection
            .turns
            .iter()
            .map(|t| t.axis.to_string())
            .collect();
        out.push_str(&format!(
            "  turns   full turns about {}\n",
            about.join(", ")
        ));
    }
    if let Some(model) = &inspection.temperature_drift {
        out.push_str(&temperature_text(model));
        out.push('\n');
    }
    if inspection.findings.is_empty() {
        out.push_str("  nothing odd was found\n");
    } else {
        out.push_str(&findings_text(&inspection.findings, false));
    }
    out
}

fn time(inspection: &Inspection) -> String {
    let t = &inspection.timing;
    let mut parts = Vec::new();
    if let Some(duration) = t.duration_s {
        parts.push(format!("{duration:.2} s"));
    }
    match (t.unit, t.median_rate_hz) {
        (Some(unit), Some(rate)) => {
            parts.push(format!("stamps in {}", unit.name()));
            parts.push(format!("{rate:.2} Hz"));
            if let Some(mean) = t.mean_rate_hz
                && (mean / rate - 1.0).abs() > 0.002
            {
                parts.push(format!("{mean:.2} rows/s in all"));
            }
            if let Some(jitter) = t.jitter_s {
                parts.push(format!("jitter {:.2} ms", 1000.0 * jitter));
            }
        }
        _ => match t.nominal_rate_hz {
            Some(rate) => parts.push(format!("no time stamps; {rate} Hz is claimed")),
            None => parts.push("no time stamps and no rate (--rate)".to_owned()),
        },
    }
    parts.join(", ")
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Given => "as given",
        Origin::Data => "shown by the data",
        Origin::Header => "as the header says",
        Origin::Assumed => "not known",
    }
}

fn accel(inspection: &Inspection) -> String {
    let a = &inspection.accelerometer;
    match (a.unit, a.lsb_per_g) {
        (AccelUnit::Unknown, _) => "unit unknown: say it with --accel-unit".to_owned(),
        (AccelUnit::Counts, Some(lsb)) => {
            format!(
                "counts, {lsb:.0} per g (±{:.0} g), {}",
                32768.0 / lsb,
                origin(a.origin)
            )
        }
        (AccelUnit::Counts, None) => format!("counts of unknown range, {}", origin(a.origin)),
        (unit, _) => format!("{}, {}", unit.name(), origin(a.origin)),
    }
}

fn gyro(inspection: &Inspection) -> Option<String> {
    let g = inspection.gyroscope?;
    Some(match (g.unit, g.lsb_per_deg_s) {
        (GyroUnit::Unknown, _) => "unit unknown: say it with --gyro-unit".to_owned(),
        (GyroUnit::Counts, Some(lsb)) => {
            format!(
                "counts, {lsb} per °/s (±{:.0} °/s), {}",
                32768.0 / lsb,
                origin(g.origin)
            )
        }
        (unit, _) => format!("{}, {}", unit.name(), origin(g.origin)),
    })
}

fn stillness(inspection: &Inspection) -> String {
    match inspection.stills.len() {
        0 if inspection.account.rows < 40 => "too few rows to tell".to_owned(),
        0 => "never".to_owned(),
        1 => format!(
            "{:.0} % of the rows, in one piece",
            100.0 * inspection.still_share
        ),
        n => format!(
            "{:.0} % of the rows, in {n} pieces",
            100.0 * inspection.still_share
        ),
    }
}

/// `█` where most of a cell is still, `▒` where some is, `·` where it moves.
fn bar(inspection: &Inspection) -> String {
    let rows = inspection.account.rows.max(1) as usize;
    (0..BAR)
        .map(|cell| {
            let from = cell * rows / BAR;
            let to = ((cell + 1) * rows / BAR).max(from + 1);
            let held: usize = inspection
                .stills
                .iter()
                .map(|s| s.end_row.min(to).saturating_sub(s.start_row.max(from)))
                .sum();
            match held as f64 / (to - from) as f64 {
                share if share > 0.6 => '█',
                share if share > 0.05 => '▒',
                _ => '·',
            }
        })
        .collect()
}

fn stills(inspection: &Inspection) -> String {
    let mut out = String::new();
    if inspection.stills.is_empty() {
        return out;
    }
    out.push_str(&format!(
        "\n  {:>3}{:>19}{:>15}{:>6}{:>7}{:>27}\n",
        "", "lines", "seconds", "face", "tilt", "mean reading"
    ));
    for (i, still) in inspection.stills.iter().take(LISTED).enumerate() {
        out.push_str(&still_line(i + 1, still));
    }
    if inspection.stills.len() > LISTED {
        out.push_str(&format!(
            "        … and {} more (--json lists all)\n",
            inspection.stills.len() - LISTED
        ));
    }
    out.push('\n');
    out
}

fn still_line(number: usize, still: &StillSpan) -> String {
    let seconds = match (still.start_s, still.end_s) {
        (Some(from), Some(to)) => format!("{from:.1}–{to:.1}"),
        _ => "–".to_owned(),
    };
    let largest = still.mean.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = super::text::decimals_of(largest, 4);
    let mean: String = still
        .mean
        .iter()
        .map(|v| format!("{v:>9.decimals$}"))
        .collect();
    format!(
        "  {number:>3}{:>19}{seconds:>15}{:>6}{:>7}{mean}\n",
        format!("{}–{}", still.lines[0], still.lines[1]),
        still.face.as_deref().unwrap_or("–"),
        format!("{:.1}°", still.tilt_deg),
    )
}
