//! Whole recordings: their samples, or of more than can be held the means of neighbours.

use std::io;

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::later::Later;
use crate::readings::Readings;
use crate::recording::Recording;
use crate::text::{Batch, Format, check_bytes};

/// Samples of a worn device that are held as they are: three hours at 100 Hz.
const MAX_SAMPLES: usize = 1 << 20;
/// Means that are reserved at once, 19 days at 2.5 Hz: columns that grow leave holes of their size in
/// memory.
const USUAL_MEANS: usize = 1 << 22;
/// Means follow each other at this rate or faster, Hz: four blocks of five are 8 s, and a rest of a wrist is 10 s.
const MIN_HZ: f64 = 2.5;

/// Neighbours are at most so many usual steps apart.
const LONGEST_STEP: f64 = 4.5;

/// Collects the batches of a whole file. With `averages` means of neighbours at 2.5 Hz or faster are
/// held of more than 2²⁰ samples of a worn device and of columns of more than a gigabyte, and a note
/// says so ([`FindingKind::SamplesAveraged`]). The samples held until then judge the recording, as
/// for [`Later`]; of less than 5 Hz two become a mean.
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
    let mut means = Means {
        count,
        longest_step_s: LONGEST_STEP / rate_hz,
        ..Means::default()
    };
    let lines = std::mem::take(&mut recording.lines);
    means.add(&recording.take_readings(), &lines);
    for batch in batches {
        let mut batch = batch?;
        let readings = later.read(&mut batch).map_err(Error::into_input)?;
        means.add(&readings, &batch.lines);
        check_bytes(means.bytes())?;
    }
    let (ledger, findings) = later.finish();
    recording.ledger.append(ledger);
    recording.findings.extend(findings);
    let samples = recording.ledger.rows();
    let (readings, lines) = means.finish();
    recording.lines = lines;
    recording.put_readings(readings);
    recording
        .findings
        .retain(|f| f.kind != FindingKind::FrozenAxis);
    let frozen = recording.frozen_axes(format);
    recording.findings.extend(frozen);
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

/// Means of `count` neighbours each, of those that have a value. Samples before a break or gap that are too
/// few for one are left out.
#[derive(Default)]
struct Means {
    count: usize,
    longest_step_s: f64,
    /// Time of the last sample of the next mean, s.
    last_s: f64,
    readings: Readings,
    /// Line of the first sample of each.
    lines: Vec<u32>,
    /// Sums of the values for the next mean in each column, and how many there are.
    sums: Vec<(f64, u32)>,
    samples: usize,
    is_after_break: bool,
}

impl Means {
    fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice()) + self.lines.len() * size_of::<f64>() * self.sums.len()
    }

    fn add(&mut self, samples: &Readings, lines: &[u32]) {
        let columns = samples.columns();
        if self.sums.is_empty() {
            self.sums = vec![(0.0, 0); columns.len()];
            self.readings = samples.map(|_| Vec::with_capacity(USUAL_MEANS));
        }
        let mut breaks = samples.breaks.iter().peekable();
        for (row, line) in lines.iter().enumerate() {
            let time_s = samples.time_s.as_ref().map_or(f64::NAN, |t| t[row]);
            let is_broken = breaks.next_if(|at| **at == row).is_some();
            if is_broken || self.samples > 0 && time_s - self.last_s > self.longest_step_s {
                self.lines.truncate(self.readings.accel[0].len());
                self.samples = 0;
                self.is_after_break |= is_broken && !self.lines.is_empty();
            }
            if !samples.is_measured[row] {
                continue;
            }
            if self.samples == 0 {
                self.lines.push(*line);
                self.sums.fill((0.0, 0));
            }
            self.samples += 1;
            self.last_s = time_s;
            for ((sum, count), column) in self.sums.iter_mut().zip(&columns) {
                if column[row].is_finite() {
                    *sum += column[row];
                    *count += 1;
                }
            }
            if self.samples == self.count {
                self.push();
            }
        }
    }

    fn push(&mut self) {
        if std::mem::take(&mut self.is_after_break) {
            self.readings.breaks.push(self.lines.len() - 1);
        }
        let means = self.readings.columns_mut().into_iter().zip(&self.sums);
        means.for_each(|(column, (sum, count))| column.push(sum / f64::from(*count)));
        self.samples = 0;
    }

    /// The means and their lines.
    fn finish(mut self) -> (Readings, Vec<u32>) {
        self.lines.truncate(self.readings.accel[0].len());
        self.readings
            .columns_mut()
            .into_iter()
            .for_each(Vec::shrink_to_fit);
        (self.readings, self.lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_of_the_values_that_are_there_and_not_across_gaps() {
        let mut means = Means {
            count: 2,
            longest_step_s: 1.0,
            ..Means::default()
        };
        let readings = Readings {
            accel: [(); 3].map(|()| vec![1.0, f64::NAN, 5.0, 6.0, 8.0]),
            is_measured: vec![true; 5],
            time_s: Some(vec![0.0, 0.5, 1.0, 9.0, 9.5]),
            ..Readings::default()
        };
        means.add(&readings, &[2, 3, 4, 5, 6]);
        let (readings, lines) = means.finish();
        assert_eq!(lines, [2, 5]);
        assert_eq!(readings.accel[0], [1.0, 7.0]);
        assert_eq!(readings.time_s.unwrap(), [0.25, 9.25]);
    }
}
