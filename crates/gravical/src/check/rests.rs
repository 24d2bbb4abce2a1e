//! Readings at rest to hold a calibration against, and what their means are worth.

use std::ops::Range;

use crate::calibration_file::CalibrationFile;
use crate::recording::{Finding, FindingKind, Recording, full_scale};
use crate::segment::hold::{HoldNoise, pooled_noise, robust_mean};
use crate::segment::still::{StillOptions, find_calm, find_calmest};
use crate::segment::{SegmentOptions, segment};
use crate::stats::mean_of_finite;
use crate::temperature::cost_text;
use crate::{Error, Result};

/// A recording faster than this is averaged down to it when the correlation of
/// its noise is looked at, Hz: after setting down a sensor rocks for a while,
/// at 5 to 20 Hz, and 20 lags of a fast recording do not see that.
const SLOW_RATE_HZ: f64 = 100.0;

/// A still reading.
pub(super) struct Rest {
    pub recording: usize,
    pub label: Option<String>,
    pub rows: Vec<Range<usize>>,
    /// Accelerometer, in the unit of the file, zero offset added back.
    pub mean: [f64; 3],
    pub standard_error: Option<[f64; 3]>,
    /// Gyroscope, in the unit of the file.
    pub gyro: Option<([f64; 3], Option<[f64; 3]>)>,
    pub count: usize,
    /// None where the rate is not known, or a row is a mean itself.
    pub duration_s: Option<f64>,
    pub temperature_c: Option<f64>,
    pub clipped: usize,
}

impl Rest {
    pub fn first(&self) -> usize {
        self.rows.first().map_or(0, |r| r.start)
    }

    pub fn last(&self) -> usize {
        self.rows.last().map_or(0, |r| r.end.saturating_sub(1))
    }
}

/// A still before its mean is taken.
struct Draft {
    recording: usize,
    label: Option<String>,
    rows: Vec<Range<usize>>,
}

/// All stills of all recordings.
///
/// # Errors
///
/// `no-recordings`; `never-static` when no recording has one.
pub(super) fn rests(
    recordings: &[Recording],
    still: &StillOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Rest>> {
    let Some(first) = recordings.first() else {
        return Err(Error::input("no-recordings", "there is no recording"));
    };
    let mut drafts = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let found = in_one(index, recording, still, findings);
        if found.is_empty() {
            findings.push(
                Finding::new(FindingKind::NoStaticInterval, "never at rest; not used")
                    .in_file(&recording.name),
            );
        }
        drafts.extend(found);
    }
    let noise = Noise::of(recordings, &drafts, |r| {
        Some((&r.accel, r.accel_resolution()))
    });
    let gyro_noise = Noise::of(recordings, &drafts, |r| {
        Some((r.gyro.as_ref()?, r.gyro_resolution()))
    });
    let measured = drafts
        .into_iter()
        .map(|draft| measure(draft, recordings, &noise, &gyro_noise));
    let rests: Vec<Rest> = measured
        .filter(|rest| rest.mean.iter().all(|m| m.is_finite()))
        .collect();
    if rests.is_empty() {
        return Err(Error::input(
            "never-static",
            "never at rest long enough to compare with gravity",
        )
        .at(first.name.as_ref(), None)
        .with_hint("lay the sensor down for 3 s or more, in any pose, better in several"));
    }
    Ok(rests)
}

fn in_one(
    index: usize,
    recording: &Recording,
    still: &StillOptions,
    findings: &mut Vec<Finding>,
) -> Vec<Draft> {
    let as_drafts = |spans: Vec<Range<usize>>| -> Vec<Draft> {
        let one = |rows| Draft {
            recording: index,
            label: None,
            rows: vec![rows],
        };
        spans.into_iter().map(one).collect()
    };
    let found = find_calm(recording, still);
    if !found.is_empty() {
        return as_drafts(found);
    }
    // A table of means, or placements that somebody named: the stills are given.
    if recording.labels.is_some() || recording.rows_in_file() < 40 {
        let given = segment(std::slice::from_ref(recording), &SegmentOptions::default());
        if let Ok(given) = given {
            let named = |label: String| recording.labels.is_some().then_some(label);
            return given
                .placements
                .into_iter()
                .map(|p| Draft {
                    recording: index,
                    label: named(p.label),
                    rows: p.rows,
                })
                .collect();
        }
    }
    as_drafts(find_calmest(recording, findings))
}

/// Noise of all rests, sample by sample and of averages of some samples.
struct Noise {
    fast: HoldNoise,
    slow: HoldNoise,
}

fn group(recording: &Recording) -> usize {
    let (rate, _) = recording.working_rate_hz();
    ((rate / SLOW_RATE_HZ) as usize).max(1)
}

impl Noise {
    fn of<'a>(
        recordings: &'a [Recording],
        drafts: &[Draft],
        channels: impl Fn(&'a Recording) -> Option<(&'a [Vec<f64>; 3], [f64; 3])>,
    ) -> Self {
        let mut step = [0.0_f64; 3];
        let mut fast: Vec<[&[f64]; 3]> = Vec::new();
        let mut averages: Vec<[Vec<f64>; 3]> = Vec::new();
        for draft in drafts {
            let recording = &recordings[draft.recording];
            let Some((channels, own)) = channels(recording) else {
                continue;
            };
            step = std::array::from_fn(|i| step[i].max(own[i]));
            for rows in &draft.rows {
                fast.push(std::array::from_fn(|i| &channels[i][rows.clone()]));
                averages.push(std::array::from_fn(|i| {
                    averaged(&channels[i][rows.clone()], group(recording))
                }));
            }
        }
        let slow: Vec<[&[f64]; 3]> = averages
            .iter()
            .map(|a| a.each_ref().map(|v| &v[..]))
            .collect();
        Noise {
            fast: pooled_noise(&fast, step),
            // Averages come in no steps.
            slow: pooled_noise(&slow, [0.0; 3]),
        }
    }

    /// Robust mean of the channels and its standard error: by blocks where
    /// there are enough of them, else the larger of what samples and what
    /// averages of samples say.
    fn mean(
        &self,
        channels: &[Vec<f64>; 3],
        recording: &Recording,
    ) -> ([f64; 3], Option<[f64; 3]>, usize) {
        let (rate, _) = recording.working_rate_hz();
        let slices: [&[f64]; 3] = channels.each_ref().map(|c| &c[..]);
        let hold = robust_mean(&slices, &self.fast, rate);
        let groups = (hold.rows / group(recording)).max(1) as f64;
        let error = hold.standard_error.map(|error| {
            std::array::from_fn(|i| {
                error[i].max(self.slow.sigma[i] * (self.slow.vif / groups).sqrt())
            })
        });
        (hold.mean, error, hold.rows)
    }
}

/// Means of `group` values each; what is left over at the end is dropped.
fn averaged(values: &[f64], group: usize) -> Vec<f64> {
    values.chunks_exact(group).map(mean_of_finite).collect()
}

fn gathered(channels: &[Vec<f64>; 3], rows: &[Range<usize>]) -> [Vec<f64>; 3] {
    std::array::from_fn(|i| {
        rows.iter()
            .flat_map(|r| channels[i][r.clone()].iter().copied())
            .collect()
    })
}

fn measure(draft: Draft, recordings: &[Recording], noise: &Noise, gyro_noise: &Noise) -> Rest {
    let recording = &recordings[draft.recording];
    let accel = gathered(&recording.accel, &draft.rows);
    let (mean, standard_error, count) = noise.mean(&accel, recording);
    let clipped = (0..3)
        .map(|i| full_scale::clipped_count(&accel[i], &recording.accel_scale))
        .sum();
    let gyro = recording.gyro.as_ref().and_then(|g| {
        let (mean, error, _) = gyro_noise.mean(&gathered(g, &draft.rows), recording);
        mean.iter().all(|m| m.is_finite()).then_some((mean, error))
    });
    let (rate, assumed) = recording.working_rate_hz();
    Rest {
        duration_s: (!assumed && count > 1).then(|| count as f64 / rate),
        recording: draft.recording,
        label: draft.label,
        mean: mean.map(|m| m + recording.zero_offset),
        standard_error,
        gyro,
        count,
        temperature_c: recording.mean_temperature_c(&draft.rows),
        clipped,
        rows: draft.rows,
    }
}

/// Takes drift and gain of the accepted channels off the means of the rests, as `apply` does row
/// by row: (raw − drift(T)) / (1 + gain(T)), held at the edges of the model's range.
pub(super) fn at_reference(
    calibration: &CalibrationFile,
    rests: &mut [Rest],
    findings: &mut Vec<Finding>,
) {
    let Some(model) = calibration.drift_model() else {
        return;
    };
    let without = rests.iter().filter(|r| r.temperature_c.is_none()).count();
    if without > 0 {
        let (all, cost) = (rests.len(), cost_text(model));
        let text = format!(
            "{without} of {all} static intervals have no temperature, so the calibration's drift with temperature is not taken off there: {cost}"
        );
        findings.push(Finding::new(FindingKind::TemperatureNotApplied, text));
    }
    for rest in rests {
        let Some(t_c) = rest.temperature_c else {
            continue;
        };
        for axis in 0..3 {
            rest.mean[axis] = model.at_reference(axis, t_c, rest.mean[axis]);
            if let Some((gyro, _)) = &mut rest.gyro {
                gyro[axis] = model.at_reference(3 + axis, t_c, gyro[axis]);
            }
        }
    }
}
