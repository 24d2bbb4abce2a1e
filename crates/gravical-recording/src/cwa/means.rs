//! Recordings of worn devices: their samples, or of very many the means of neighbours.

use std::io;

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::full_scale::Clipping;
use crate::judge;
use crate::recording::Recording;
use crate::recording::judging::resolution;
use crate::text::{BATCH_ROWS, Batch, Format};

/// Samples that are held as they are: three hours at 100 Hz.
const MAX_SAMPLES: usize = 1 << 20;
/// Room for ten days: columns that grow leave holes of their size in memory.
const USUAL_MEANS: usize = 1 << 22;
/// Means follow each other at this rate or faster, Hz: four blocks of five are 8 s, and a rest of a wrist is 10 s.
const MIN_HZ: f64 = 2.5;

/// Reads a `.cwa` file. More than 2²⁰ samples are held as means of neighbours at 2.5 Hz or faster,
/// and a note says so ([`FindingKind::SamplesAveraged`]). Samples before a break that are too few for
/// a mean are left out.
///
/// # Errors
///
/// Those of reading and of [`Recording::judge`]; the columns take more than a gigabyte.
pub fn read(
    format: &Format,
    mut batches: impl Iterator<Item = io::Result<Batch>>,
) -> Result<Recording, Error> {
    let mut rows = read_rows(&mut batches, MAX_SAMPLES)?;
    if rows.rows() < MAX_SAMPLES {
        return Recording::judge(format, rows);
    }
    let steps = rows.columns[0].windows(2).map(|w| w[1] - w[0]);
    let period_s = judge::median(steps).unwrap_or(1.0);
    let count = (1.0 / (MIN_HZ * period_s)).max(1.0) as usize;
    if count == 1 {
        let rest = read_rows(&mut batches, usize::MAX)?;
        rows.append(rest);
        return Recording::judge(format, rows);
    }
    let axes = |columns: [usize; 3]| columns.map(|c| rows.columns[c].clone());
    let resolution = resolution(&axes(format.accel), format.gyro.map(axes).as_ref());
    let mut means = Means::new(count, rows.columns.len());
    means.clipping = find_ends(format, &rows);
    means.add(rows);
    for batch in batches {
        means.add(batch?);
        means.rows.check_size()?;
    }
    means.judge(format, resolution)
}

fn read_rows(
    batches: &mut impl Iterator<Item = io::Result<Batch>>,
    max_rows: usize,
) -> Result<Batch, Error> {
    let mut rows = Batch::default();
    while rows.rows() < max_rows
        && let Some(batch) = batches.next()
    {
        rows.append(batch?);
        rows.check_size()?;
    }
    Ok(rows)
}

/// Means of neighbouring samples.
struct Means {
    /// Samples of a mean.
    count: usize,
    rows: Batch,
    /// The first sample of the next mean, the sums of what others differ from it, and how many
    /// samples these are.
    first: Vec<f64>,
    sums: Vec<f64>,
    held: usize,
    line: u32,
    is_after_break: bool,
    /// Of the samples: a mean shows the end of the range only where all of them reach it.
    clipping: Vec<ChannelClipping>,
}

/// Column and name of a channel, and which samples of it are at the end of its range.
type ChannelClipping = (usize, &'static str, Clipping);

/// The ends of the ranges by the first samples; none where these cannot be judged.
fn find_ends(format: &Format, rows: &Batch) -> Vec<ChannelClipping> {
    let judged = Recording::judge(format, rows.first(BATCH_ROWS));
    let ends = judged.as_ref().map(|r| r.ends_of_ranges(format));
    let ends = ends.unwrap_or_default().into_iter();
    let named = ends.zip(format.channels());
    named
        .map(|((_, name, end), column)| (column, name, end))
        .collect()
}

impl Means {
    fn new(count: usize, columns: usize) -> Self {
        let mut rows = Batch::new(columns);
        let all = rows.columns.iter_mut();
        all.for_each(|c| c.reserve_exact(USUAL_MEANS));
        Means {
            count,
            rows,
            first: vec![0.0; columns],
            sums: vec![0.0; columns],
            held: 0,
            line: 0,
            is_after_break: false,
            clipping: Vec::new(),
        }
    }

    fn add(&mut self, mut batch: Batch) {
        for (column, _, clipping) in &mut self.clipping {
            clipping.observe_all(&batch.columns[*column], &batch.lines);
        }
        let mut breaks = batch.breaks.iter().copied().peekable();
        for (row, line) in batch.lines.iter().enumerate() {
            if breaks.next_if_eq(&row).is_some() {
                self.held = 0;
                self.is_after_break = true;
            }
            if self.held == 0 {
                self.line = *line;
                self.sums.fill(0.0);
                for (first, column) in self.first.iter_mut().zip(&batch.columns) {
                    *first = column[row];
                }
            }
            for ((sum, first), column) in self.sums.iter_mut().zip(&self.first).zip(&batch.columns)
            {
                *sum += column[row] - first;
            }
            self.held += 1;
            if self.held == self.count {
                self.push();
            }
        }
        self.rows.ledger.append(std::mem::take(&mut batch.ledger));
        self.rows.findings.append(&mut batch.findings);
    }

    fn push(&mut self) {
        if std::mem::take(&mut self.is_after_break) {
            self.rows.breaks.push(self.rows.rows());
        }
        let values = self.first.iter().zip(&self.sums);
        for (column, (first, sum)) in self.rows.columns.iter_mut().zip(values) {
            column.push(first + sum / self.count as f64);
        }
        self.rows.lines.push(self.line);
        self.held = 0;
    }

    fn judge(mut self, format: &Format, resolution: [f64; 6]) -> Result<Recording, Error> {
        let count = self.count as f64;
        self.rows.columns.iter_mut().for_each(Vec::shrink_to_fit);
        let mut format = format.clone();
        let rates = [&mut format.rate_hz, &mut format.options.rate_hz];
        rates.into_iter().flatten().for_each(|rate| *rate /= count);
        let text = format!(
            "{} samples are too many to hold: they are used as {} means of {} neighbours",
            self.rows.ledger.lines - self.rows.ledger.total(),
            self.rows.rows(),
            self.count
        );
        let mut recording = Recording::judge_means(&format, self.rows, Some(resolution))?;
        let clipped = self.clipping.iter();
        let clipped = clipped.filter_map(|(_, name, c)| c.finding(name));
        let findings = &mut recording.findings;
        findings.retain(|n| n.kind != FindingKind::Clipped);
        findings.extend(clipped);
        findings.push(Finding::new(FindingKind::SamplesAveraged, text));
        Ok(recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;

    #[test]
    fn single_samples_at_the_end_of_the_range_are_told() {
        let names = ["time_s", "ax_g", "ay_g", "az_g"].map(str::to_owned);
        let mut rows = Batch::new(names.len());
        for i in 0..2000_u32 {
            // A knock every half second, of two samples.
            let knock = if i % 50 < 2 {
                2.0 - 1.0 / 16_384.0
            } else {
                0.0
            };
            let noise = f64::from(i * 7919 % 101) / 16_384.0;
            let row = [
                f64::from(i) / 100.0,
                knock + noise * f64::from(i % 50 / 2),
                noise,
                1.0 - noise,
            ];
            for (column, value) in rows.columns.iter_mut().zip(row) {
                column.push(value);
            }
            rows.lines.push(i + 1);
        }
        rows.ledger.lines = 2000;
        let options = ReadOptions::default();
        let format = Format::of_table(&names, names.len(), &rows.first(200), &options).unwrap();
        let mut means = Means::new(20, names.len());
        means.clipping = find_ends(&format, &rows);
        means.add(rows);
        let recording = means.judge(&format, [1.0 / 16_384.0; 6]).unwrap();
        let clipped = recording
            .findings
            .iter()
            .filter(|n| n.kind == FindingKind::Clipped);
        let messages: Vec<&str> = clipped.map(|n| n.message.as_str()).collect();
        assert!(
            matches!(messages[..], [m] if m.starts_with("ax reaches the end of its range in 80 rows")),
            "{messages:?}"
        );
    }
}
