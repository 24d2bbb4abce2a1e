//! Temperature drift: which part of it is predictable.
//!
//! # Overview
//!
//! A sensor at rest whose temperature falls and rises shows its drift. [`study`] computes means
//! of short static blocks (`rests`) and tests every channel: does a slope that is fitted to one
//! direction predict the other, in both cases ([`gravical_fit::temperature`])? Only such a drift
//! is subtracted.
//!
//! Where hundreds of poses lie at many temperatures, as in days of wear, no pose has to last: the
//! joint fit tests and fits the drift of the bias with its other parameters.
//!
//! The result is a [`TemperatureModel`]; [`for_calibration`] adds it to the parameters of a session.
//!
//! # Example
//!
//! ```
//! # use gravical_calibrate as gravical;
//! use gravical::recording::{ReadOptions, read_bytes};
//! use gravical::temperature::study;
//!
//! // Ten minutes from 20 °C to 50 °C and back; ax drifts by 2 mm/s² per °C.
//! let mut csv = String::from("t_s,ax,ay,az,temp\n");
//! for i in 0..6000 {
//!     let t_c = 50.0 - 30.0 * (f64::from(i) / 3000.0 - 1.0).abs();
//!     let noise = 0.004 * (f64::from(i) * 2.4).sin();
//!     let ax = 0.1 + 0.002 * t_c + noise;
//!     csv += &format!("{:.1},{ax:.5},{:.5},{:.5},{t_c:.2}\n", 0.1 * f64::from(i), noise, 9.81 - noise);
//! }
//! let soak = read_bytes(csv.as_bytes(), "soak.csv", &ReadOptions::default())?;
//! let model = study(&[soak])?;
//! let ax = model.channel("ax").unwrap();
//! assert!(ax.is_corrected() && (ax.per_c.unwrap() - 0.002).abs() < 1e-5);
//! assert!(!model.channel("ay").unwrap().is_corrected());
//! # Ok::<(), gravical::Error>(())
//! ```

mod rests;
use gravical_judge::numfmt::milli_g;
use rests::RestBlock;
#[cfg(test)]
mod tests;

use std::path::Path;

use gravical_fit::temperature::{Block, Direction, detect_directions, fit_drift};
use gravical_fit::{BiasDrift, DriftTest};

use crate::Result;
use crate::calibration_file::{
    CHANNELS, ChannelDrift, DriftVerdict, TemperatureModel, TemperatureRange,
};
#[doc(hidden)]
pub use crate::finding::NoTemperature;
use crate::finding::{Case, Finding};
use crate::poses::rests::MANY_POSES;
use crate::poses::{Pose, Segmentation, check_units};
use crate::problem::Problem;
use crate::recording::{GyroUnit, Recording};

/// The temperature must span more than this at rest, °C, for a meaningful result.
pub const MIN_SPAN_C: f64 = 5.0;

/// Rests that span less than this are not used, °C.
const MIN_REST_SPAN_C: f64 = 2.0;
/// The direction changes where the temperature comes back by this share of its range …
const TURN_SHARE: f64 = 0.1;
/// … and by this many °C, since thermometers are noisy and chambers oscillate.
const MIN_TURN_C: f64 = 1.0;

/// Determines the drift of a sensor from recordings in one unit.
///
/// # Errors
///
/// All of them input errors: `missing-temperature` without temperatures, `never-static`, and
/// `temperature-span` if the temperature at rest spans [`MIN_SPAN_C`] or less; for several
/// recordings `unit-unknown` and `units-differ`. An unpredictable drift is not an error: the
/// channel is refused.
pub fn study(recordings: &[Recording]) -> Result<TemperatureModel> {
    if recordings.len() > 1 {
        check_units(recordings)?;
    }
    let refuse = |problem: Problem| {
        let name = recordings.first().map_or("", |r| r.name.as_str());
        problem.error().at(Path::new(name), None)
    };
    let too_narrow = |span_c: f64| {
        let least_c = MIN_SPAN_C;
        refuse(Problem::TooNarrow { span_c, least_c })
    };
    let wide = |range: TemperatureRange| match range.span_c() {
        span_c if span_c > MIN_SPAN_C => Ok(range),
        span_c => Err(too_narrow(span_c)),
    };
    let ranges = recordings.iter().filter_map(Recording::temperature_range_c);
    let recorded = TemperatureRange::of(ranges.flatten())
        .ok_or_else(|| refuse(Problem::NoTemperature).advise("columns", ""))?;
    wide(recorded)?;
    let mut rests: Vec<_> = recordings.iter().map(rests::detect_rests).collect();
    if rests.iter().all(Vec::is_empty) {
        return Err(refuse(Problem::NoneOfSoak));
    }
    let span_c = |rest: &Vec<RestBlock>| {
        TemperatureRange::of(rest.iter().map(|b| b.t_c)).map_or(0.0, |range| range.span_c())
    };
    let widest_c = rests.iter().flatten().map(span_c).fold(0.0, f64::max);
    for rests in &mut rests {
        rests.retain(|rest| span_c(rest) > MIN_REST_SPAN_C);
    }
    let used = TemperatureRange::of(rests.iter().flatten().flatten().map(|b| b.t_c));
    let used = wide(used.ok_or_else(|| too_narrow(widest_c))?)?;
    let mut range_c = [used.min, used.max];
    let turn_c = (TURN_SHARE * used.span_c()).max(MIN_TURN_C);
    let mut blocks = direct_blocks(&rests, turn_c);
    let shared = shared_range(&blocks);
    // Temperatures that only one direction reached were not tested and are left out.
    if let Ok(shared) = &shared {
        range_c = *shared;
        blocks.retain(|(_, _, b)| (range_c[0]..=range_c[1]).contains(&b.t_c));
    }
    let mut rates = blocks.iter().flat_map(|(_, _, b)| &b.readings[3..]);
    let count = if rates.any(|v| v.is_finite()) { 6 } else { 3 };
    let test = |channel: usize| {
        let block = |(rest, direction, block): &DirectedBlock| Block {
            rest: *rest,
            direction: *direction,
            t_c: block.t_c,
            reading: block.readings[channel],
        };
        let fit = shared
            .as_ref()
            .ok()
            .and_then(|_| fit_drift(blocks.iter().map(block)));
        let per_c = fit.and_then(|fit| fit.per_c);
        let reason = match (&shared, fit) {
            (Err(why), _) => why,
            (_, None) => "its means determine no slope, or do not vary",
            _ if per_c.is_some() => "each direction predicts the other",
            _ => {
                "one direction does not predict the other: hysteresis or drift with time, or no drift beyond the noise"
            }
        };
        ChannelDrift {
            r2_cooling_to_warming: fit.map(|fit| fit.r2_cooling_to_warming),
            r2_warming_to_cooling: fit.map(|fit| fit.r2_warming_to_cooling),
            ..channel_drift(recordings, channel, per_c, reason)
        }
    };
    Ok(TemperatureModel {
        reference_c: 0.5 * (range_c[0] + range_c[1]),
        range_c,
        channels: (0..count).map(test).collect(),
    })
}

/// A block with the number of its rest and the direction of its temperature.
type DirectedBlock = (usize, Direction, RestBlock);

/// The blocks of all rests with the direction of their temperature; none of a recording where it never
/// turns by `turn_c`. The direction stays the same while the sensor is moved to another pose.
fn direct_blocks(recordings: &[Vec<Vec<RestBlock>>], turn_c: f64) -> Vec<DirectedBlock> {
    let mut numbers = 0..;
    let directed = recordings.iter().flat_map(|rests| {
        let of_rest = |(blocks, n): (&Vec<RestBlock>, usize)| vec![n; blocks.len()];
        let numbers: Vec<usize> = rests.iter().zip(&mut numbers).flat_map(of_rest).collect();
        let t_c: Vec<f64> = rests.iter().flatten().map(|b| b.t_c).collect();
        let directed = numbers.into_iter().zip(detect_directions(&t_c, turn_c));
        let each = directed.zip(rests.iter().flatten());
        each.map(|((rest, direction), block)| (rest, direction, *block))
            .collect::<Vec<_>>()
    });
    directed.collect()
}

/// The temperatures that both directions reached, or why they cannot test each other.
fn shared_range(blocks: &[DirectedBlock]) -> std::result::Result<[f64; 2], String> {
    let range = |direction: Direction, verb: &str| {
        let of_direction = blocks.iter().filter(|(_, d, _)| *d == direction);
        TemperatureRange::of(of_direction.map(|(_, _, b)| b.t_c)).ok_or_else(|| format!(
            "the temperature only {verb}: with one direction the drift cannot be tested; also record the opposite one"
        ))
    };
    let cooling = range(Direction::Cooling, "rose")?;
    let warming = range(Direction::Warming, "fell")?;
    let shared = [cooling.min.max(warming.min), cooling.max.min(warming.max)];
    let shared_c = (shared[1] - shared[0]).max(0.0);
    (shared_c > MIN_SPAN_C).then_some(shared).ok_or_else(|| format!(
        "cooling and warming share only {shared_c:.1} °C; more than {MIN_SPAN_C:.0} °C are needed to test one with the other"
    ))
}

/// The drift of a channel in the unit of the recordings: with a slope it is corrected.
fn channel_drift(
    recordings: &[Recording],
    channel: usize,
    per_c: Option<f64>,
    reason: &str,
) -> ChannelDrift {
    let unit = recordings.first().and_then(|first| match channel {
        0..3 => Some(first.units.accel.unit.name()),
        _ => Some(first.units.gyro?.unit.name()),
    });
    let corrected = per_c.map(|_| DriftVerdict::Corrected);
    ChannelDrift {
        channel: CHANNELS[channel].to_owned(),
        input_unit: unit.unwrap_or("unknown").to_owned(),
        verdict: corrected.unwrap_or_default(),
        reason: reason.to_owned(),
        per_c,
        ..ChannelDrift::default()
    }
}

/// The model for a session: from the soak recordings `thermal`, or, without any, from the session
/// itself if its static intervals span enough temperature. Its drift is zero at the mean
/// temperature of the poses, where bias and matrix are valid; the means of the poses are
/// converted to that temperature.
///
/// # Errors
///
/// With soak recordings: those of [`study`], `missing-temperature` for poses without, and `unit-unknown` and
/// `units-differ` if they are not in the unit of the session.
pub fn for_calibration(
    recordings: &[Recording],
    thermal: &[Recording],
    segmentation: &mut Segmentation,
) -> Result<Option<TemperatureModel>> {
    let session = temperatures(&segmentation.poses);
    let model = if thermal.is_empty() {
        study(recordings).ok()
    } else if session.is_none() {
        return Err(Problem::PosesWithout.error().advise("thermal", ""));
    } else {
        check_soak_units(recordings, thermal)?;
        Some(study(thermal)?)
    };
    let (Some(mut model), Some(session)) = (model, session) else {
        return Ok(None);
    };
    let (soak_c, poses_c) = (model.range_c, session.mean);
    let valid_c = poses_c.clamp(soak_c[0], soak_c[1]);
    // Where no drift is subtracted, the reference does not matter.
    if model.any_corrected() {
        model.reference_c = valid_c;
        let outside = Case::PosesOutside {
            poses_c,
            soak_c,
            valid_c,
        };
        let outside = (valid_c != poses_c).then(|| outside.finding());
        segmentation.findings.extend(outside);
    }
    adopt(&model, segmentation);
    Ok(Some(model))
}

/// Converts the means of the poses to the reference temperature, or says that no drift is predictable.
fn adopt(model: &TemperatureModel, segmentation: &mut Segmentation) {
    let range_c = model.range_c;
    let refused = (!model.any_corrected()).then(|| Case::TemperatureRefused { range_c }.finding());
    segmentation.findings.extend(refused);
    bring_to_reference(&mut segmentation.poses, model);
}

fn temperatures(poses: &[Pose]) -> Option<TemperatureRange> {
    TemperatureRange::of(poses.iter().filter_map(|p| p.temperature_c))
}

/// Converts the means of the poses to the reference temperature.
pub(crate) fn bring_to_reference(poses: &mut [Pose], model: &TemperatureModel) {
    for pose in poses {
        let drift = pose
            .temperature_c
            .map_or([0.0; 6], |t_c| model.drift_at(t_c));
        pose.mean = [0, 1, 2].map(|i| pose.mean[i] - drift[i]);
    }
}

/// True where the poses are enough, and at temperatures far enough apart, to fit the drift of the
/// accelerometer with its other parameters: rests in which the temperature changes, which [`study`]
/// needs, are then not needed.
pub fn enough_poses(poses: &[Pose]) -> bool {
    let span_c = temperatures(poses).map_or(0.0, |range| range.span_c());
    let complete = poses.iter().all(|p| p.temperature_c.is_some());
    complete && poses.len() >= MANY_POSES && span_c > MIN_SPAN_C
}

/// The drift of the accelerometer as the poses of the session were `fitted` and tested, and that of the
/// gyroscope from its static intervals. The means of the poses are converted to the temperature at
/// which bias and matrix are valid. None without temperatures.
pub(crate) fn from_poses(
    recordings: &[Recording],
    test: DriftTest,
    fitted: Option<BiasDrift>,
    segmentation: &mut Segmentation,
) -> Option<TemperatureModel> {
    let range = temperatures(&segmentation.poses)?;
    let ending = fitted.map_or(": not by more than chance", |_| "");
    let reason = format!(
        "fitted with the poses; with a drift the mean error of ‖a‖ at poses left out, an eighth of the session at a time, goes from {:.2} to {:.2} mg{ending}",
        milli_g(test.without_mps2),
        milli_g(test.with_mps2),
    );
    let channel = |axis: usize| {
        let per_c = fitted.map(|drift| drift.per_c[axis]);
        channel_drift(recordings, axis, per_c, &reason)
    };
    let mut model = TemperatureModel {
        reference_c: range.mean,
        range_c: [range.min, range.max],
        channels: (0..3).map(channel).collect(),
    };
    if let Ok(study) = study(recordings) {
        let gyro = study.channels.into_iter().skip(3);
        if gyro.clone().any(|c| c.is_corrected()) {
            model.range_c = study.range_c;
        }
        model.channels.extend(gyro);
    }
    adopt(&model, segmentation);
    Some(model)
}

/// That a drift is not taken off because of `why`: what it makes of a reading at the ends of its range.
#[doc(hidden)]
pub fn not_applied(model: &TemperatureModel, why: NoTemperature) -> Finding {
    let farthest = model.range_c.map(|end| (end - model.reference_c).abs());
    let farthest_c = farthest[0].max(farthest[1]);
    let change = |c: &ChannelDrift| {
        let is_known = c.input_unit != "unknown";
        let unit = if is_known {
            &c.input_unit
        } else {
            "of an unknown unit"
        };
        let most = farthest_c * c.per_c.unwrap_or(0.0).abs();
        (c.channel.clone(), most, unit.to_owned())
    };
    let corrected = model.channels.iter().filter(|c| c.is_corrected());
    Case::DriftNotApplied {
        why,
        range_c: model.range_c,
        changes: corrected.map(change).collect(),
    }
    .finding()
}

/// Checks that session and soak are in one unit; one of a gyroscope that is not known is taken as the same.
fn check_soak_units(recordings: &[Recording], thermal: &[Recording]) -> Result<()> {
    check_units(recordings.iter().take(1).chain(thermal))?;
    let unit = |recordings: &[Recording]| {
        let unit = recordings.first()?.units.gyro?.unit;
        (unit != GyroUnit::Unknown).then_some(unit)
    };
    match unit(recordings).zip(unit(thermal)) {
        Some((session, soak)) if session != soak => {
            let differ = Problem::SoakDiffers { session, soak }.error();
            Err(differ.at(thermal[0].name.as_ref(), None))
        }
        _ => Ok(()),
    }
}
