//! Temperature drift: which part of it is predictable.
//!
//! # Overview
//!
//! A sensor at rest whose temperature falls and rises shows its drift. [`study`] computes means
//! of short static blocks (`intervals`), separates cooling from warming (`sweeps`), and tests
//! every channel (`channel`): does a polynomial of the temperature that is fitted to one
//! direction predict the other, in both cases? Only such a drift is subtracted. Cross-validation
//! with random folds, or within one sweep, would not test this: neighbours in time agree whatever
//! the cause of their drift.
//!
//! Where hundreds of poses lie at many temperatures, as in days of wear, no pose has to last: the
//! joint fit tests and fits the drift of the bias with its other parameters, and [`from_poses()`]
//! takes it from there.
//!
//! The result is a [`TemperatureModel`]; [`for_calibration`] adds it to the parameters of a
//! session, [`crate::calibrate::soak_alone`] computes a calibration from it alone.
//!
//! # Example
//!
//! ```
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
//! assert!(ax.is_corrected() && (ax.slope.unwrap() - 0.002).abs() < 1e-5);
//! assert!(!model.channel("ay").unwrap().is_corrected());
//! # Ok::<(), gravical::Error>(())
//! ```

mod attach;
mod channel;
mod fit;
mod from_poses;
pub(crate) mod intervals;
mod reason;
mod sweeps;
mod tested;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::calibration_file::{
    CHANNELS, InputFile, ReferenceSource, SweepDirection, TemperatureModel,
};
use crate::recording::Recording;
use crate::segment::check_units;
use crate::stats::median;
use crate::{Error, Result};

pub use crate::polynomial::evaluate;
pub(crate) use attach::cost_text;
pub use attach::for_calibration;
pub use from_poses::enough_poses;
pub(crate) use from_poses::from_poses;
pub(crate) use reason::in_unit;
pub use reason::{r2_text, short};
pub use tested::LEAST_R2;

use channel::Common;
use fit::Frame;
use intervals::PoseInterval;

/// The temperature must span more than this at rest, °C, for a meaningful result.
pub const LEAST_SPAN_C: f64 = 5.0;

/// Poses that span less than this are not used, °C.
const LEAST_POSE_SPAN_C: f64 = 2.0;

/// Determines the drift of a sensor from recordings in one unit.
///
/// # Errors
///
/// All of them input errors: `missing-temperature` without temperatures, `never-static`, and
/// `temperature-span` if the temperature at rest spans [`LEAST_SPAN_C`] or less; for several
/// recordings `unit-unknown` and `units-differ`. An unpredictable drift is not an error: the
/// channel is refused.
pub fn study(recordings: &[Recording]) -> Result<TemperatureModel> {
    study_with_levels(recordings).map(|(model, _)| model)
}

/// The same, with the reading of each channel at the reference temperature (over all poses, so it
/// is meaningful only for a gyroscope).
pub(crate) fn study_with_levels(recordings: &[Recording]) -> Result<(TemperatureModel, [f64; 6])> {
    if recordings.len() > 1 {
        check_units(recordings)?;
    }
    let name = recordings.first().map_or("", |r| r.name.as_str());
    let input = |code, message: String| Error::input(code, message).at(Path::new(name), None);
    if recordings.iter().all(|r| r.temperature_range_c().is_none()) {
        return Err(
            input("missing-temperature", "the recording has no temperature".to_owned()).with_hint(
                "record the sensor's own temperature in a column called temperature, or name it with --columns",
            ),
        );
    }
    let found: Vec<PoseInterval> = recordings
        .iter()
        .enumerate()
        .flat_map(|(i, r)| intervals::intervals(r, i))
        .collect();
    // An excerpt has blocks only if its whole temperature range is wide enough.
    let ranges = || recordings.iter().filter_map(Recording::temperature_range_c);
    let too_narrow = recordings.iter().any(Recording::is_excerpt)
        && ranges().all(|[low, high]| high - low <= LEAST_SPAN_C);
    if found.is_empty() && !too_narrow {
        return Err(input(
            "never-static",
            "it is never static for some seconds".to_owned(),
        )
        .with_hint("leave the sensor untouched while its temperature changes"));
    }
    let widest = found
        .iter()
        .map(|s| s.range_c()[1] - s.range_c()[0])
        .fold(0.0, f64::max);
    let kept: Vec<PoseInterval> = found
        .into_iter()
        .filter(|s| s.range_c()[1] - s.range_c()[0] > LEAST_POSE_SPAN_C)
        .collect();
    let [low, high] = kept
        .iter()
        .map(PoseInterval::range_c)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], [a, b]| {
            [l.min(a), h.max(b)]
        });
    let span_c = if kept.is_empty() { widest } else { high - low };
    if kept.is_empty() || span_c <= LEAST_SPAN_C {
        return Err(input(
            "temperature-span",
            format!(
                "the temperature spans {span_c:.1} °C at rest; more than {LEAST_SPAN_C:.0} °C are needed"
            ),
        )
        .with_hint("cool the sensor and let it warm up again, untouched, over all temperatures at which it will be used"));
    }
    Ok(model(recordings, &kept, [low, high]))
}

/// Result of [`study`]; `None` if it is an error.
#[must_use]
pub fn study_if_any(recordings: &[Recording]) -> Option<TemperatureModel> {
    // Fast rejection of recordings with a small temperature range.
    let spans = recordings.iter().filter_map(Recording::temperature_range_c);
    let [low, high] = spans.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], [a, b]| {
        [l.min(a), h.max(b)]
    });
    if high - low > LEAST_SPAN_C {
        study(recordings).ok()
    } else {
        None
    }
}

fn model(
    recordings: &[Recording],
    intervals: &[PoseInterval],
    span_c: [f64; 2],
) -> (TemperatureModel, [f64; 6]) {
    let (sweeps, mut bins) = sweeps::bins(intervals, span_c[1] - span_c[0]);
    // Temperatures that only one direction reached were not tested and are left out.
    let range = |direction: SweepDirection| {
        let own = bins.iter().filter(|b| b.direction == direction);
        own.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], b| {
            [l.min(b.range_c[0]), h.max(b.range_c[1])]
        })
    };
    let (cooling, warming) = (
        range(SweepDirection::Cooling),
        range(SweepDirection::Warming),
    );
    let overlap_c = [cooling[0].max(warming[0]), cooling[1].min(warming[1])];
    let shared = overlap_c[1] - overlap_c[0] > LEAST_SPAN_C;
    let range_c = if shared { overlap_c } else { span_c };
    bins.retain(|b| (range_c[0]..=range_c[1]).contains(&b.t_c));

    let mut norms: Vec<f64> = intervals
        .iter()
        .flat_map(|s| &s.blocks)
        .map(|b| b.values[..3].iter().map(|v| v * v).sum::<f64>().sqrt())
        .collect();
    let frame = Frame {
        centre_c: 0.5 * (range_c[0] + range_c[1]),
        half_c: 0.5 * (range_c[1] - range_c[0]),
        gravity: median(&mut norms).unwrap_or(1.0).max(f64::MIN_POSITIVE),
    };
    let first = recordings.first();
    let accel_unit = first.map_or("unknown", |r| r.accel_scale.unit.name());
    let gyro_unit = first
        .and_then(|r| r.gyro_scale)
        .map_or("unknown", |g| g.unit.name());
    let with_gyro = bins
        .iter()
        .any(|b| b.values[3..].iter().any(|v| v.is_finite()));
    let channels = if with_gyro { 6 } else { 3 };
    let zero_offset = first.map_or(0.0, |r| r.zero_offset);
    let model = TemperatureModel {
        reference_c: frame.centre_c,
        reference_source: ReferenceSource::Soak,
        range_c,
        poses: intervals.len() as u32,
        sweeps,
        channels: CHANNELS[..channels]
            .iter()
            .enumerate()
            .map(|(index, name)| {
                let common = Common {
                    bins: &bins,
                    frame,
                    overlap_c,
                    least_span_c: LEAST_SPAN_C,
                    unit: if index < 3 { accel_unit } else { gyro_unit },
                };
                let mut channel = channel::judge(&common, index, name);
                // The coefficients apply to the numbers of the file: a zero offset is not
                // multiplied by the scale.
                if index < 3 {
                    let scale = channel.scale_coefficients.iter();
                    for (c, s) in channel.coefficients.iter_mut().zip(scale) {
                        *c -= zero_offset * s;
                    }
                }
                channel
            })
            .collect(),
        inputs: InputFile::of(recordings),
    };
    let levels = std::array::from_fn(|index| {
        let name = CHANNELS[index];
        let own = bins.iter().filter(|b| b.values[index].is_finite());
        let (sum, n) = own.fold((0.0, 0.0), |(sum, n), b| {
            (
                sum + b.values[index] - model.drift_at(name, b.t_c).0,
                n + 1.0,
            )
        });
        sum / n
    });
    (model, levels)
}

impl TemperatureModel {
    /// The same model with drift and gain zero at `reference_c`.
    #[must_use]
    pub fn about(mut self, reference_c: f64) -> Self {
        let by = reference_c - self.reference_c;
        for channel in &mut self.channels {
            let (drift, gain) =
                crate::polynomial::about(&channel.coefficients, &channel.scale_coefficients, by);
            channel.coefficients = drift;
            channel.scale_coefficients = gain;
        }
        self.reference_c = reference_c;
        self
    }
}
