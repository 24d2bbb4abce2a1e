//! The numbers of a figure.

use std::io::{Result, Write};

use super::{Figure, Mark, Panel, Scale};

/// Writes the numbers of a figure as CSV, a line a point:
/// `panel,series,x,y,low,high,label`; what a series does not have is empty, and
/// so is a line where a curve breaks. On an axis of names x counts from 0 and the
/// label is the name.
///
/// The units stand in the first line, as a comment. They are the points that are
/// drawn: where a series was thinned, all its samples are in the table of the
/// recording.
///
/// # Errors
///
/// What `out` says.
pub fn write_csv(figure: &Figure, out: &mut dyn Write) -> Result<()> {
    let units: Vec<String> = figure
        .panels
        .iter()
        .enumerate()
        .map(|(i, p)| {
            format!(
                "{}: x {}; y {}",
                panel_name(figure, i),
                p.x.text(),
                p.y.text()
            )
        })
        .collect();
    writeln!(
        out,
        "# {} | {}",
        figure.title,
        units.join(" | ").replace('\n', " ")
    )?;
    let mut table = csv::Writer::from_writer(out);
    table.write_record(["panel", "series", "x", "y", "low", "high", "label"])?;
    for (i, panel) in figure.panels.iter().enumerate() {
        let name = panel_name(figure, i);
        for series in &panel.series {
            let rows = series.y.len().max(series.low.len());
            for k in 0..rows {
                let number = |v: &[f64]| {
                    v.get(k)
                        .filter(|v| v.is_finite())
                        .map_or(String::new(), f64::to_string)
                };
                let x = match series.mark {
                    Mark::Rule => String::new(),
                    _ => number(&series.x),
                };
                let (y, low, high) = (number(&series.y), number(&series.low), number(&series.high));
                let label = match series.labels.get(k) {
                    Some(label) => label,
                    None => name_at(panel, series.x.get(k)),
                };
                table.write_record([name.as_str(), &series.name, &x, &y, &low, &high, label])?;
            }
        }
        for s in &panel.stretches {
            let (from, to) = (s.from.to_string(), s.to.to_string());
            table.write_record([name.as_str(), &s.name, &from, "", "", "", "from"])?;
            table.write_record([name.as_str(), &s.name, &to, "", "", "", "to"])?;
        }
    }
    table.flush()
}

/// What stands at this place of an axis of names; empty on another.
fn name_at<'a>(panel: &'a Panel, x: Option<&f64>) -> &'a str {
    match (&panel.x.scale, x) {
        (Scale::Names(names), Some(x)) if *x >= 0.0 => {
            names.get(x.round() as usize).map_or("", String::as_str)
        }
        _ => "",
    }
}

/// Title of a panel, else its number from 1.
fn panel_name(figure: &Figure, index: usize) -> String {
    match figure.panels.get(index).map(|p| p.title.as_str()) {
        Some(title) if !title.is_empty() => title.to_owned(),
        _ => (index + 1).to_string(),
    }
}
