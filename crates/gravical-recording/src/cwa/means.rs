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
    let mut means = Means::new(count, rows.columns.len());
    means.add(rows);
    for batch in batches {
        means.add(batch?);
        means.rows.check_size()?;
    }
    means.judge(format, resolution)
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
        }
    }

    fn add(&mut self, batch: Batch) {
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
        self.rows.ledger.append(batch.ledger);
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

    fn judge(mut self, format: &Format, resolution: [[f64; 3]; 2]) -> Result<Recording, Error> {
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
        let measured = Measured::new(&format, self.rows, None, true)?;
        let mut recording = Recording::judge_measured(&format, measured, Some(resolution))?;
        let finding = Finding::new(FindingKind::SamplesAveraged, text);
        recording.findings.push(finding);
        Ok(recording)
    }
}
