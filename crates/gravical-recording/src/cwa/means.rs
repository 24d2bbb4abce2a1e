//! Recordings of worn devices: their samples, or of very many the means of neighbours.

use std::io;

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::judge;
use crate::recording::Recording;
use crate::recording::judging::measured::Measured;
use crate::recording::judging::resolution;
use crate::text::{Batch, Format};

/// Samples that are held as they are: three hours at 100 Hz.
const MAX_SAMPLES: usize = 1 << 20;
/// Room for ten days: columns that grow leave holes of their size in memory.
const USUAL_MEANS: usize = 1 << 22;
/// Means follow each other at this rate or faster, Hz: four blocks of five are 8 s, and a rest of a wrist is 10 s.
const MIN_HZ: f64 = 2.5;

/// Collects the batches of a whole file. With `averages` more than 2²⁰ samples are held as means of
/// neighbours at 2.5 Hz or faster, and a note says so ([`FindingKind::SamplesAveraged`]). Samples
/// before a break that are too few for a mean are left out.
///
/// # Errors
///
/// Those of reading and of [`Recording::judge`]; the columns take more than a gigabyte.
pub fn collect(
    format: &Format,
    mut batches: impl Iterator<Item = io::Result<Batch>>,
    averages: bool,
) -> Result<Recording, Error> {
    let max_rows = if averages { MAX_SAMPLES } else { usize::MAX };
    let mut rows = Batch::default();
    while rows.rows() < max_rows
        && let Some(batch) = batches.next()
    {
        rows.append(batch?);
        rows.check_size()?;
    }
    if rows.rows() < max_rows {
        return Recording::judge(format, rows);
    }
    let steps = rows.columns[0].windows(2).map(|w| w[1] - w[0]);
    let period_s = judge::median(steps).unwrap_or(1.0);
    // The slowest samples follow each other at 6.25 Hz.
    let count = (1.0 / (MIN_HZ * period_s)).max(2.0) as usize;
    let axes = |columns: [usize; 3]| columns.map(|c| rows.columns[c].clone());
    let resolution = resolution(&axes(format.accel), format.gyro.map(axes).as_ref());
    let mut means = Batch::new(rows.columns.len());
    let columns = means.columns.iter_mut();
    columns.for_each(|column| column.reserve_exact(USUAL_MEANS));
    means.ledger = std::mem::take(&mut rows.ledger);
    add_means(&mut means, &mut rows, count);
    for batch in batches {
        let mut batch = batch?;
        means.ledger.append(std::mem::take(&mut batch.ledger));
        rows.append(batch);
        add_means(&mut means, &mut rows, count);
        means.check_size()?;
    }
    means.columns.iter_mut().for_each(Vec::shrink_to_fit);
    let mut format = format.clone();
    let rates = [&mut format.rate_hz, &mut format.options.rate_hz];
    let rates = rates.into_iter().flatten();
    rates.for_each(|rate_hz| *rate_hz /= count as f64);
    let text = format!(
        "{} samples are too many to hold: they are used as {} means of {count} neighbours",
        means.ledger.rows(),
        means.rows(),
    );
    let measured = Measured::new(&format, means, None, true)?;
    let mut recording = Recording::judge_measured(&format, measured, Some(resolution))?;
    let finding = Finding::new(FindingKind::SamplesAveraged, text);
    recording.findings.push(finding);
    Ok(recording)
}

/// Takes the first rows for means of `count` neighbours each, without a break between them.
fn add_means(means: &mut Batch, rows: &mut Batch, count: usize) {
    let mut from = 0;
    while from + count <= rows.rows() {
        let next_break = rows.breaks.partition_point(|row| *row <= from);
        let (before, after) = rows.breaks.split_at(next_break);
        if let Some(row) = after.first().filter(|row| **row < from + count) {
            from = *row;
            continue;
        }
        if before.last() == Some(&from) {
            means.breaks.push(means.rows());
        }
        for (means, values) in means.columns.iter_mut().zip(&rows.columns) {
            let first = values[from];
            let values = values[from..from + count].iter();
            let sum: f64 = values.map(|value| value - first).sum();
            means.push(first + sum / count as f64);
        }
        means.lines.push(rows.lines[from]);
        from += count;
    }
    rows.crop(from..usize::MAX);
}
