//! More samples of a worn device than are held: means of neighbours.

use std::io::Read;

use gravical_judge::finding::Case;
use gravical_judge::{Error, GAP_PERIODS};

use super::samples::Samples;
use crate::memory::Budget;
use crate::recording::Recording;
use crate::text::{Format, Ledger, Rows};

/// Samples that are held as they are: three hours at 100 Hz.
pub const MAX_SAMPLES: usize = 1 << 20;
/// Means that are reserved at once, 19 days at 2.5 Hz: columns that grow leave holes of their size in
/// memory.
const USUAL_MEANS: usize = 1 << 22;
/// Means follow each other at this rate or faster, Hz: four blocks of five are 8 s, and a rest of a wrist is 10 s.
const MIN_HZ: f64 = 2.5;

/// Judges all samples of a file, or, of more than `max_samples`, their means at 2.5 Hz or faster; of less than
/// 5 Hz two become a mean. Blocks carry clock and unit, so that means are judged as samples are; a note
/// says so (`samples-averaged`).
///
/// # Errors
///
/// Errors of reading, and those of [`Recording::judge`].
pub fn read_means<R: Read>(
    format: &Format,
    mut samples: Samples<R>,
    budget: &Budget,
    max_samples: usize,
) -> Result<Recording, Error> {
    let mut head = Rows::new(format.columns.len());
    while head.rows() <= max_samples
        && let Some(next) = samples.next()
    {
        head.append(next?);
        budget.check_rows(format, head.rows())?;
    }
    if head.rows() <= max_samples {
        return Recording::judge(format, head);
    }
    // Blocks name their nominal rate; the samples that are held tell the true one.
    let first = Recording::judge(format, head.clone())?;
    let rate_hz = first.working_rate_hz();
    let columns = format.columns.len();
    let mut means = Means {
        count: (rate_hz / MIN_HZ).max(2.0) as usize,
        longest_step_s: GAP_PERIODS / rate_hz,
        last_s: f64::NAN,
        rows: Rows::new(columns),
        sums: vec![0.0; columns],
        samples: 0,
        is_after_break: false,
    };
    for column in &mut means.rows.columns {
        column.reserve_exact(USUAL_MEANS);
    }
    let mut ledger = Ledger::default();
    for next in std::iter::once(Ok(head)).chain(samples) {
        let next = next?;
        means.add(&next);
        budget.check_rows(format, means.rows.rows())?;
        ledger.append(next.ledger);
    }
    let Means {
        count, mut rows, ..
    } = means;
    rows.lines.truncate(rows.columns[0].len());
    rows.columns.iter_mut().for_each(Vec::shrink_to_fit);
    let samples = ledger.rows();
    rows.ledger = ledger;
    let format = Format {
        rate_hz: format.rate_hz.map(|rate_hz| rate_hz / count as f64),
        ..format.clone()
    };
    let mut recording = Recording::judge(&format, rows)?;
    let case = Case::SamplesAveraged {
        samples,
        means: recording.rows(),
        neighbours: count,
    };
    recording.findings.push(case.finding());
    Ok(recording)
}

/// Means of `count` neighbours each. Samples before a gap that are too few for one are left out.
struct Means {
    count: usize,
    longest_step_s: f64,
    /// Time of the last sample of the next mean, s.
    last_s: f64,
    rows: Rows,
    /// Sums of the values for the next mean in each column.
    sums: Vec<f64>,
    samples: usize,
    is_after_break: bool,
}

impl Means {
    fn add(&mut self, rows: &Rows) {
        let mut breaks = rows.breaks.iter().peekable();
        for (row, line) in rows.lines.iter().enumerate() {
            let time_s = rows.columns[0][row];
            let is_broken = breaks.next_if(|at| **at == row).is_some();
            if is_broken || time_s - self.last_s > self.longest_step_s {
                self.rows.lines.truncate(self.rows.columns[0].len());
                self.samples = 0;
                self.is_after_break |= is_broken && !self.rows.lines.is_empty();
            }
            if self.samples == 0 {
                self.rows.lines.push(*line);
                self.sums.fill(0.0);
            }
            self.samples += 1;
            self.last_s = time_s;
            for (sum, column) in self.sums.iter_mut().zip(&rows.columns) {
                *sum += column[row];
            }
            if self.samples == self.count {
                self.samples = 0;
                if std::mem::take(&mut self.is_after_break) {
                    self.rows.breaks.push(self.rows.lines.len() - 1);
                }
                for (column, sum) in self.rows.columns.iter_mut().zip(&self.sums) {
                    column.push(sum / self.count as f64);
                }
            }
        }
    }
}
