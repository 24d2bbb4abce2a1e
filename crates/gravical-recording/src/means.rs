//! Whole recordings: their samples, or of more than can be held the means of neighbours.

use std::io;

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::later::Later;
use crate::readings::Readings;
use crate::recording::Recording;
use crate::text::{Batch, Format};

/// Samples of a worn device that are held as they are: three hours at 100 Hz.
const MAX_SAMPLES: usize = 1 << 20;
/// Room for ten days: columns that grow leave holes of their size in memory.
const USUAL_MEANS: usize = 1 << 22;
/// Means follow each other at this rate or faster, Hz: four blocks of five are 8 s, and a rest of a wrist is 10 s.
const MIN_HZ: f64 = 2.5;

/// Collects the batches of a whole file. With `averages` means of neighbours at 2.5 Hz or faster are
/// held of more than 2²⁰ samples of a worn device and of columns of more than a gigabyte, and a note
/// says so ([`FindingKind::SamplesAveraged`]). The samples held until then judge the recording, as
/// for [`Later`].
///
/// # Errors
///
/// Those of reading, of [`Recording::judge`] and of [`Later::read`]; the columns take more than a
/// gigabyte.
pub fn collect(
    format: &Format,
    mut batches: impl Iterator<Item = io::Result<Batch>>,
    averages: bool,
) -> Result<Recording, Error> {
    let mut head = Batch::default();
    while let Some(batch) = batches.next() {
        head.append(batch?);
        let size = head.check_size();
        let is_long = size.is_err() || format.device.is_some() && head.rows() >= MAX_SAMPLES;
        if averages && is_long {
            return average(format, head, batches);
        }
        size?;
    }
    Recording::judge(format, head)
}

fn average(
    format: &Format,
    head: Batch,
    batches: impl Iterator<Item = io::Result<Batch>>,
) -> Result<Recording, Error> {
    let (mut recording, mut later) = Later::judge(format, head)?;
    let rate_hz = recording.working_rate_hz();
    let count = (rate_hz / MIN_HZ).max(2.0) as usize;
    let mut means = Means::new(count);
    let lines = std::mem::take(&mut recording.lines);
    means.add(&Readings::take(&mut recording), &lines);
    for batch in batches {
        let mut batch = batch?;
        recording.ledger.append(std::mem::take(&mut batch.ledger));
        means.add(&later.read(&batch)?, &batch.lines);
        means.rows.check_size()?;
    }
    let (ledger, findings) = later.finish();
    recording.ledger.append(ledger);
    recording.findings.extend(findings);
    let samples = recording.ledger.rows();
    let (rows, [has_gyro, has_temperature, has_time]) = (means.rows, means.has);
    recording.lines = rows.lines;
    recording.breaks = rows.breaks;
    let mut columns = rows.columns.into_iter();
    let mut next = || {
        let mut column = columns.next().unwrap_or_default();
        column.shrink_to_fit();
        column
    };
    recording.accel = std::array::from_fn(|_| next());
    recording.gyro = has_gyro.then(|| std::array::from_fn(|_| next()));
    recording.temperature_c = has_temperature.then(&mut next);
    recording.time_s = has_time.then(next);
    let timing = &mut recording.timing;
    let mut times_s = recording.time_s.iter().flatten().copied().rev();
    let last_s = times_s.find(|t| t.is_finite());
    let duration_s = last_s.unwrap_or(samples as f64 / rate_hz);
    timing.duration_s = timing.duration_s.map(|_| duration_s);
    let present = samples as f64 / (duration_s * rate_hz);
    timing.missing_share = timing.missing_share.map(|_| (1.0 - present).max(0.0));
    let rates = [
        &mut timing.nominal_rate_hz,
        &mut timing.median_rate_hz,
        &mut timing.mean_rate_hz,
    ];
    let rates = rates.into_iter().flatten();
    rates.for_each(|rate_hz| *rate_hz /= count as f64);
    let without = recording.labels.take().map_or("", |_| ", without labels");
    let text = format!(
        "{samples} samples are too many to hold: they are used as {} means of {count} neighbours{without}",
        recording.rows(),
    );
    let finding = Finding::new(FindingKind::SamplesAveraged, text);
    recording.findings.push(finding);
    Ok(recording)
}

/// Means of `count` neighbours each. Samples before a break that are too few for one are left out.
struct Means {
    count: usize,
    /// Columns in the order of [`add`](Self::add).
    rows: Batch,
    /// Whether there are a gyroscope, a thermometer and a clock.
    has: [bool; 3],
    /// Sums of the samples for the next mean, their number, and the line of the first.
    sums: Vec<f64>,
    held: usize,
    line: u32,
    is_after_break: bool,
}

impl Means {
    fn new(count: usize) -> Self {
        Means {
            count,
            rows: Batch::default(),
            has: [false; 3],
            sums: Vec::new(),
            held: 0,
            line: 0,
            is_after_break: false,
        }
    }

    fn add(&mut self, samples: &Readings, lines: &[u32]) {
        let mut columns = samples.channels();
        columns.extend(samples.temperature_c.as_deref());
        columns.extend(samples.time_s.as_deref());
        if self.sums.is_empty() {
            self.has = [
                samples.gyro.is_some(),
                samples.temperature_c.is_some(),
                samples.time_s.is_some(),
            ];
            self.sums = vec![0.0; columns.len()];
            self.rows = Batch::new(columns.len());
            let means = self.rows.columns.iter_mut();
            means.for_each(|column| column.reserve_exact(USUAL_MEANS));
        }
        let mut breaks = samples.breaks.iter().peekable();
        for (row, line) in lines.iter().enumerate() {
            if breaks.next_if(|at| **at == row).is_some() {
                self.held = 0;
                self.is_after_break = self.rows.rows() > 0;
            }
            if !samples.is_measured[row] {
                continue;
            }
            if self.held == 0 {
                self.line = *line;
                self.sums.fill(0.0);
            }
            self.held += 1;
            let sums = self.sums.iter_mut().zip(&columns);
            sums.for_each(|(sum, column)| *sum += column[row]);
            if self.held == self.count {
                self.push();
            }
        }
    }

    fn push(&mut self) {
        if std::mem::take(&mut self.is_after_break) {
            self.rows.breaks.push(self.rows.rows());
        }
        let means = self.rows.columns.iter_mut().zip(&self.sums);
        means.for_each(|(column, sum)| column.push(sum / self.count as f64));
        self.rows.lines.push(self.line);
        self.held = 0;
    }
}
