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
use crate::numfmt::milli_g;
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
    let ranges = recordings.iter().filter_map(Recording::temperature_range_c);
    let Some(recorded) = TemperatureRange::of(ranges.flatten()) else {
        return Err(refuse(Problem::NoTemperature).advise("columns", ""));
    };
    let span_c = recorded.span_c();
    if span_c <= MIN_SPAN_C {
        return Err(refuse(Problem::TooNarrow {
            span_c,
            least_c: MIN_SPAN_C,
        }));
    }
    let mut rests: Vec<_> = recordings.iter().map(rests::detect_rests).collect();
    if rests.iter().all(Vec::is_empty) {
        return Err(refuse(Problem::NoneOfSoak));
    }
    let range = |rest: &Vec<RestBlock>| TemperatureRange::of(rest.iter().map(|b| b.t_c));
    let span_c = |rest: &Vec<RestBlock>| range(rest).map_or(0.0, |range| range.span_c());
    let widest_c = rests.iter().flatten().map(span_c).fold(0.0, f64::max);
    for rests in &mut rests {
        rests.retain(|rest| span_c(rest) > MIN_REST_SPAN_C);
    }
    let used = range(&rests.iter().flatten().flatten().copied().collect());
    match used {
        Some(used) if used.span_c() > MIN_SPAN_C => {
            Ok(fit_model(recordings, &rests, [used.min, used.max]))
        }
        used => {
            let span_c = used.map_or(widest_c, |used| used.span_c());
            Err(refuse(Problem::TooNarrow {
                span_c,
                least_c: MIN_SPAN_C,
            }))
        }
    }
}

/// The blocks of all rests with the direction of their temperature; none of a recording where it never
/// turns by `turn_c`.
fn direct_blocks(recordings: &[Vec<Vec<RestBlock>>], turn_c: f64) -> Vec<Block> {
    let mut out = Vec::new();
    let mut number = 0..;
    for rests in recordings {
        // The direction stays the same while the sensor is moved to another pose.
        let t_c: Vec<f64> = rests.iter().flatten().map(|b| b.t_c).collect();
        let mut directions = detect_directions(&t_c, turn_c).into_iter();
        for (blocks, rest) in rests.iter().zip(&mut number) {
            let directed = blocks.iter().zip(&mut directions);
            out.extend(directed.map(|(block, direction)| Block {
                rest,
                direction,
                t_c: block.t_c,
                readings: block.readings,
            }));
        }
    }
    out
}

/// The temperatures that both directions reached, or why they cannot test each other.
fn shared_range(blocks: &[Block]) -> std::result::Result<[f64; 2], String> {
    let range = |direction| {
        let of_direction = blocks.iter().filter(|b| b.direction == direction);
        TemperatureRange::of(of_direction.map(|b| b.t_c))
    };
    let only = |verb: &str| {
        format!(
            "the temperature only {verb}: with one direction the drift cannot be tested; also record the opposite one"
        )
    };
    let cooling = range(Direction::Cooling).ok_or_else(|| only("rose"))?;
    let warming = range(Direction::Warming).ok_or_else(|| only("fell"))?;
    let shared = [cooling.min.max(warming.min), cooling.max.min(warming.max)];
    let shared_c = (shared[1] - shared[0]).max(0.0);
    if shared_c <= MIN_SPAN_C {
        return Err(format!(
            "cooling and warming share only {shared_c:.1} °C; more than {MIN_SPAN_C:.0} °C are needed to test one with the other"
        ));
    }
    Ok(shared)
}

/// The model from the `rests` of each recording, which span `range_c`.
fn fit_model(
    recordings: &[Recording],
    rests: &[Vec<Vec<RestBlock>>],
    range_c: [f64; 2],
) -> TemperatureModel {
    let turn_c = (TURN_SHARE * (range_c[1] - range_c[0])).max(MIN_TURN_C);
    let mut blocks = direct_blocks(rests, turn_c);
    let shared = shared_range(&blocks);
    let range_c = shared.clone().unwrap_or(range_c);
    let reference_c = 0.5 * (range_c[0] + range_c[1]);
    // Temperatures that only one direction reached were not tested and are left out.
    blocks.retain(|b| (range_c[0]..=range_c[1]).contains(&b.t_c));
    let mut rates = blocks.iter().flat_map(|b| &b.readings[3..]);
    let count = if rates.any(|v| v.is_finite()) { 6 } else { 3 };
    let channel = |channel: usize| {
        let drift = match &shared {
            Ok(_) => test_channel(&blocks, channel),
            Err(reason) => refuse(reason),
        };
        named(recordings, channel, drift)
    };
    TemperatureModel {
        reference_c,
        range_c,
        channels: (0..count).map(channel).collect(),
    }
}

/// A drift with the name of its channel and the unit of the recordings.
fn named(recordings: &[Recording], channel: usize, drift: ChannelDrift) -> ChannelDrift {
    let first = recordings.first();
    let gyro_scale = first.and_then(|r| r.units.gyro);
    let unit = match channel {
        0..3 => first.map(|r| r.units.accel.unit.name()),
        _ => gyro_scale.map(|g| g.unit.name()),
    };
    ChannelDrift {
        channel: CHANNELS[channel].to_owned(),
        input_unit: unit.unwrap_or("unknown").to_owned(),
        ..drift
    }
}

fn refuse(reason: &str) -> ChannelDrift {
    ChannelDrift {
        reason: reason.to_owned(),
        ..ChannelDrift::default()
    }
}

/// Slope and verdict of a channel.
fn test_channel(blocks: &[Block], channel: usize) -> ChannelDrift {
    let Some(fit) = fit_drift(blocks, channel) else {
        return refuse("its means determine no slope, or do not vary");
    };
    let (verdict, reason) = match fit.per_c {
        Some(_) => (DriftVerdict::Corrected, "each direction predicts the other"),
        None => (
            DriftVerdict::NotCorrected,
            "one direction does not predict the other: hysteresis or drift with time, or no drift beyond the noise",
        ),
    };
    ChannelDrift {
        verdict,
        r2_cooling_to_warming: Some(fit.r2_cooling_to_warming),
        r2_warming_to_cooling: Some(fit.r2_warming_to_cooling),
        per_c: fit.per_c,
        ..refuse(reason)
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
    segmentation.findings.extend(refused(&model));
    // Where no drift is subtracted, the reference does not matter.
    if model.any_corrected() {
        let (soak_c, poses_c) = (model.range_c, session.mean);
        let valid_c = poses_c.clamp(soak_c[0], soak_c[1]);
        if valid_c != poses_c {
            let outside = Case::PosesOutside {
                poses_c,
                soak_c,
                valid_c,
            };
            segmentation.findings.push(outside.finding());
        }
        model.reference_c = valid_c;
        bring_to_reference(&mut segmentation.poses, &model);
    }
    Ok(Some(model))
}

fn temperatures(poses: &[Pose]) -> Option<TemperatureRange> {
    TemperatureRange::of(poses.iter().filter_map(|p| p.temperature_c))
}

/// Converts the means of the poses to the reference temperature.
pub(crate) fn bring_to_reference(poses: &mut [Pose], model: &TemperatureModel) {
    for pose in poses {
        let Some(t_c) = pose.temperature_c else {
            continue;
        };
        for (mean, drift) in pose.mean.iter_mut().zip(model.drift_at(t_c)) {
            *mean -= drift;
        }
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
    let reference_c = range.mean;
    let (verdict, ending) = match fitted {
        Some(_) => (DriftVerdict::Corrected, ""),
        None => (DriftVerdict::NotCorrected, ": not by more than chance"),
    };
    let reason = format!(
        "fitted with the poses; with a drift the mean error of ‖a‖ at poses left out, an eighth of the session at a time, goes from {:.2} to {:.2} mg{ending}",
        milli_g(test.without_mps2),
        milli_g(test.with_mps2),
    );
    let channel = |axis: usize| {
        let drift = ChannelDrift {
            verdict,
            per_c: fitted.map(|d| d.per_c[axis]),
            ..refuse(&reason)
        };
        named(recordings, axis, drift)
    };
    let mut model = TemperatureModel {
        reference_c,
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
    segmentation.findings.extend(refused(&model));
    bring_to_reference(&mut segmentation.poses, &model);
    Some(model)
}

/// A finding where the drift of no channel is predictable.
fn refused(model: &TemperatureModel) -> Option<Finding> {
    let range_c = model.range_c;
    (!model.any_corrected()).then(|| Case::TemperatureRefused { range_c }.finding())
}

/// That a drift is not taken off because of `why`: what it makes of a reading at the ends of its range.
#[doc(hidden)]
pub fn not_applied(model: &TemperatureModel, why: NoTemperature) -> Finding {
    let [low, high] = model.range_c;
    let change = |c: &ChannelDrift| {
        let farthest_c = (low - model.reference_c)
            .abs()
            .max((high - model.reference_c).abs());
        let most = farthest_c * c.per_c.unwrap_or(0.0).abs();
        let unit = match c.input_unit.as_str() {
            "unknown" => "of an unknown unit",
            unit => unit,
        };
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
    match (unit(recordings), unit(thermal)) {
        (Some(session), Some(soak)) if session != soak => {
            let differ = Problem::SoakDiffers { session, soak }.error();
            Err(differ.at(thermal[0].name.as_ref(), None))
        }
        _ => Ok(()),
    }
}
