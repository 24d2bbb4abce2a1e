//! Runs a filter over the channels of a recording: not across breaks and gaps, and around empty
//! cells.

use std::borrow::Cow;

use crate::recording::Recording;

use super::clock::{Clock, Splits, Stretch, fill_stamps};
use super::filter::{Filter, Treatment};
use super::{Channels, DenoiseOptions};

/// Data common to all filters.
pub(super) struct Runner {
    pub clock: Clock,
    /// Time stamps of all rows; `None` without usable ones.
    time_s: Option<Vec<f64>>,
    /// Segments between breaks, each with its parts without gaps.
    segments: Vec<(std::ops::Range<usize>, Vec<Stretch>)>,
    /// Gaps and steps back between breaks.
    pub splits: Splits,
    /// Number of rows without a time stamp.
    pub stamps_filled: usize,
    /// Number of empty cells, which is the same for all filters.
    pub empty: usize,
}

/// Results of all channels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outcome {
    /// Rows and samples, summed over channels.
    pub treatment: Treatment,
    /// Number of all samples, summed over channels.
    pub samples: usize,
    /// Number of parts, summed over channels, that were too short.
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
        let mut splits = Splits::default();
        let segments = recording
            .segments()
            .into_iter()
            .map(|rows| {
                let stretches = match &time_s {
                    Some(time) => clock.stretches(&time[rows.clone()], &mut splits),
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
            splits,
            stamps_filled,
            empty,
        }
    }

    pub fn stretches(&self) -> usize {
        self.segments.iter().map(|(_, s)| s.len()).sum()
    }

    /// Runs `filter` over the selected channels.
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
            // Channels without empty cells share their time stamps and are processed together.
            let (whole, incomplete): (Vec<_>, Vec<_>) = sensor
                .iter_mut()
                .map(|channel| &mut channel[rows.clone()])
                .partition(|part| part.iter().all(|v| v.is_finite()));
            let time_s = self.time_s.as_deref().map(|t| &t[rows.clone()]);
            run_stretches(filter, time_s, stretches, whole, outcome);
            for part in incomplete {
                self.run_incomplete(filter, time_s, part, outcome);
            }
        }
    }

    /// Filters a channel with empty cells: its values are treated as samples among which some are
    /// missing.
    fn run_incomplete(
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
        // Gaps were counted before; only long runs of empty cells are additional.
        let stretches = self.clock.stretches(&time, &mut Splits::default());
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
        let treatment = filter.apply_at(time_s, &stretch.uneven, &mut parts, 0..stretch.rows.len());
        outcome.samples += count * stretch.rows.len();
        outcome.short_stretches += count * usize::from(treatment.too_short > 0);
        let sum = &mut outcome.treatment;
        sum.fitted += count * treatment.fitted;
        sum.too_few += count * treatment.too_few;
        sum.filled += count * treatment.filled;
        sum.resampled += count * treatment.resampled;
        sum.too_short += count * treatment.too_short;
        // Outliers are already counted over all channels.
        sum.replaced += treatment.replaced;
    }
}

/// The selected sensors of the recording.
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
