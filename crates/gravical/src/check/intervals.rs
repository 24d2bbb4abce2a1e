//! Static intervals to hold a calibration against, and what their means are worth.

use crate::calibration_file::CalibrationFile;
use crate::finding::finding;
use crate::poses::mean::pooled_noise;
use crate::poses::rests::{find_rests, why_never_static};
use crate::poses::{
    Interval, Measured, Pose, SegmentOptions, check_units, cut_recordings, intervals_of,
    leave_out_empty, measure_intervals, slices,
};
use crate::recording::{Finding, Recording};
use crate::stats::mean_of_finite;
use crate::temperature::{bring_to_reference, not_applied};
use crate::{Error, Result};

use super::CheckOptions;

/// A recording faster than this is averaged down to it when the correlation of
/// its noise is looked at, Hz: after setting down a sensor rocks for a while,
/// at 5 to 20 Hz, and 20 lags of a fast recording do not see that.
const SLOW_RATE_HZ: f64 = 100.0;

/// All static intervals of all recordings. Means are in the numbers of the file, zero offset
/// added back.
///
/// # Errors
///
/// `no-recordings`; `never-static` when no recording has one.
pub(super) fn static_intervals(
    recordings: &[Recording],
    options: &CheckOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Pose>> {
    let Some(first) = recordings.first() else {
        return Err(Error::input("no-recordings", "there is no recording"));
    };
    let mut intervals = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let found = in_one(index, recording);
        if found.is_empty() {
            findings.push(
                finding!(
                    NoStaticInterval,
                    "never at rest: {}; not used",
                    why_never_static(recording)
                )
                .in_file(&recording.name),
            );
        }
        intervals.extend(found);
    }
    let Measured {
        poses: mut intervals,
        held,
        ..
    } = measure_intervals(recordings, intervals, &options.axes, findings);
    include_slow_noise(recordings, &held, &mut intervals);
    for interval in &mut intervals {
        let offset = recordings[interval.recording].zero_offset;
        interval.mean = interval.mean.map(|m| m + offset);
    }
    leave_out_empty(&mut intervals, findings);
    if intervals.is_empty() {
        return Err(Error::input(
            "never-static",
            "never at rest long enough to compare with gravity",
        )
        .at(first.name.as_ref(), None)
        .with_hint("lay the sensor down for 3 s or more, in any pose, better in several"));
    }
    Ok(intervals)
}

fn in_one(index: usize, recording: &Recording) -> Vec<Interval> {
    let found = find_rests(recording);
    if !found.is_empty() {
        return intervals_of(index, found, None);
    }
    // A table of means, or poses that somebody named: the intervals are given.
    let one = std::slice::from_ref(recording);
    if check_units(one).is_err() || recording.labels.is_none() && recording.rows() >= 40 {
        return Vec::new();
    }
    let given = cut_recordings(one, &SegmentOptions::default(), &mut Vec::new());
    let mut intervals = given.unwrap_or_default();
    intervals.retain(|interval| !interval.is_turn());
    intervals.iter_mut().for_each(|i| i.recording = index);
    intervals
}

/// Raises standard errors of means to what averages of the samples, `held`, say of them.
fn include_slow_noise(recordings: &[Recording], held: &[[Vec<f64>; 3]], intervals: &mut [Pose]) {
    let group = |interval: &Pose| {
        let rate_hz = recordings[interval.recording].working_rate_hz();
        ((rate_hz / SLOW_RATE_HZ) as usize).max(1)
    };
    let average = |(interval, held): (&Pose, &[Vec<f64>; 3])| {
        let size = group(interval);
        held.each_ref()
            .map(|values| values.chunks_exact(size).map(mean_of_finite).collect())
    };
    let averages: Vec<[Vec<f64>; 3]> = intervals.iter().zip(held).map(average).collect();
    let slices: Vec<[&[f64]; 3]> = averages.iter().map(slices).collect();
    // Averages come in no steps.
    let slow = pooled_noise(&slices, [0.0; 3], 1.0);
    for interval in intervals {
        let groups = (interval.count / group(interval)).max(1) as f64;
        if let Some(error) = &mut interval.standard_error {
            let widening = (slow.vif / groups).sqrt();
            *error = std::array::from_fn(|i| error[i].max(slow.sigma[i] * widening));
        }
    }
}

/// Takes the drift of the accepted channels off the means of static intervals, as `apply` does
/// row by row, held at the edges of the model's range.
pub(super) fn at_reference(
    calibration: &CalibrationFile,
    intervals: &mut [Pose],
    findings: &mut Vec<Finding>,
) {
    let Some(model) = calibration.drift_model() else {
        return;
    };
    let temperatures = intervals.iter().map(|p| p.temperature_c);
    let without = temperatures.filter(Option::is_none).count();
    if without > 0 {
        let all = intervals.len();
        let why = format!("{without} of {all} static intervals have no temperature");
        findings.push(not_applied(model, &why));
    }
    bring_to_reference(intervals, model);
}
