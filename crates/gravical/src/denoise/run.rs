//! A filter over the channels of a recording: between breaks and gaps, around what
//! is empty.

use std::borrow::Cow;

use crate::recording::Recording;

use super::clock::{Clock, Parted, Stretch, fill_stamps};
use super::filter::{Filter, Treated};
use super::{Channels, DenoiseOptions};

/// What is the same for every filter.
pub(super) struct Runner {
    pub clock: Clock,
    /// Stamps of all rows; none without usable ones.
    time_s: Option<Vec<f64>>,
    /// Between breaks, each with its stretches.
    segments: Vec<(std::ops::Range<usize>, Vec<Stretch>)>,
    /// Gaps and backward stamps between breaks.
    pub parted: Parted,
    /// Rows that had no stamp.
    pub stamps_filled: usize,
    /// Empty cells of the channels, all filters see the same.
    pub empty: usize,
}

/// What became of all channels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outcome {
    /// Rows and samples, summed over channels.
    pub treated: Treated,
    /// Samples, over channels, that there are in all.
    pub samples: usize,
    /// Stretches, over channels, that were too short.
    pub short_stretches: usize,
}

impl Runner {
    pub fn new(recording: &Recording, options: &DenoiseOptions) -> Self {
        let gap_steps = options.gap_steps.unwrap_or(DenoiseOptions::GAP_STEPS);
        let clock = Clock::of(recording, gap_steps);
        let mut stamps_filled = 0;
        let mut time_s = recording.time_s.clone();
        if let Some(time) = &mut time_s
            && time.iter().any(|t| !t.is_finite())
        {
            stamps_filled = fill_stamps(time, clock.step_s);
        }
        let mut parted = Parted::default();
        let segments = recording
            .segments()
            .into_iter()
            .map(|rows| {
                let stretches = match &time_s {
                    Some(time) => clock.stretches(&time[rows.clone()], &mut parted),
                    None => vec![Stretch {
                        rows: 0..rows.len(),
                        uneven: Vec::new(),
                    }],
                };
                (rows, stretches)
            })
            .collect();
        let all = sensors(recording, options.channels);
        let empty = all.flatten().flatten().filter(|v| !v.is_finite()).count();
        Runner {
            clock,
            time_s,
            segments,
            parted,
            stamps_filled,
            empty,
        }
    }

    pub fn stretches(&self) -> usize {
        self.segments.iter().map(|(_, s)| s.len()).sum()
    }

    /// Runs `filter` over the chosen channels.
    pub fn run(&self, filter: &Filter, recording: &mut Recording, channels: Channels) -> Outcome {
        let mut outcome = Outcome::default();
        if channels != Channels::Gyro {
            self.run_sensor(filter, &mut recording.accel, &mut outcome);
        }
        if channels != Channels::Accel
            && let Some(gyro) = &mut recording.gyro
        {
            self.run_sensor(filter, gyro, &mut outcome);
        }
        outcome
    }

    fn run_sensor(&self, filter: &Filter, sensor: &mut [Vec<f64>; 3], outcome: &mut Outcome) {
        for (rows, stretches) in &self.segments {
            // Whole channels share their stamps, and with them the work.
            let (whole, holed): (Vec<_>, Vec<_>) = sensor
                .iter_mut()
                .map(|channel| &mut channel[rows.clone()])
                .partition(|part| part.iter().all(|v| v.is_finite()));
            let time_s = self.time_s.as_deref().map(|t| &t[rows.clone()]);
            run_stretches(filter, time_s, stretches, whole, outcome);
            for part in holed {
                self.run_holed(filter, time_s, part, outcome);
            }
        }
    }

    /// One channel with empty cells: what is there is filtered as samples among which
    /// some are missing.
    fn run_holed(
        &self,
        filter: &Filter,
        time_s: Option<&[f64]>,
        part: &mut [f64],
        outcome: &mut Outcome,
    ) {
        let there: Vec<usize> = (0..part.len()).filter(|i| part[*i].is_finite()).collect();
        let mut values: Vec<f64> = there.iter().map(|i| part[*i]).collect();
        let stamp = |i: &usize| match time_s {
            Some(time) => time[*i],
            None => *i as f64 * self.clock.step_s,
        };
        let time: Cow<'_, [f64]> = there.iter().map(stamp).collect();
        // What parts the recording was counted before, but for long empty runs.
        let stretches = self.clock.stretches(&time, &mut Parted::default());
        run_stretches(filter, Some(&time), &stretches, vec![&mut values], outcome);
        for (i, value) in there.iter().zip(values) {
            part[*i] = value;
        }
    }
}

fn run_stretches(
    filter: &Filter,
    time_s: Option<&[f64]>,
    stretches: &[Stretch],
    mut channels: Vec<&mut [f64]>,
    outcome: &mut Outcome,
) {
    let count = channels.len();
    if count == 0 {
        return;
    }
    for stretch in stretches {
        let mut parts: Vec<&mut [f64]> = channels
            .iter_mut()
            .map(|channel| &mut channel[stretch.rows.clone()])
            .collect();
        let time_s = time_s.map(|t| &t[stretch.rows.clone()]);
        let treated = filter.apply_at(time_s, &stretch.uneven, &mut parts, 0..stretch.rows.len());
        outcome.samples += count * stretch.rows.len();
        outcome.short_stretches += count * usize::from(treated.too_short > 0);
        let sum = &mut outcome.treated;
        sum.fitted += count * treated.fitted;
        sum.too_few += count * treated.too_few;
        sum.filled += count * treated.filled;
        sum.resampled += count * treated.resampled;
        sum.too_short += count * treated.too_short;
        // Outliers are told over all channels already.
        sum.replaced += treated.replaced;
    }
}

/// The chosen sensors that are there.
pub(super) fn sensors(
    recording: &Recording,
    channels: Channels,
) -> impl Iterator<Item = &[Vec<f64>; 3]> {
    let accel = (channels != Channels::Gyro).then_some(&recording.accel);
    let gyro = recording
        .gyro
        .as_ref()
        .filter(|_| channels != Channels::Accel);
    accel.into_iter().chain(gyro)
}
