//! Whether the rows of a hold are a pose, and what is wrong if not.

use gravical_core::matrix3::{norm, sub};

use crate::poses::face::{AXES, Face};
use crate::recording::units::AccelScale;
use crate::stats::moments;
use crate::stats::standard_deviation;
use gravical_recording::full_scale::clipped_count;

use super::event::Rejection;
use super::{LiveOptions, Pose, mg};
use crate::poses::MAX_FACE_ANGLE_DEG;
use gravical_recording::Sample;

/// Share of the rows of a capture that may be missing.
const MAX_MISSING: f64 = 0.05;
/// A magnitude further from gravity than these factors is another unit, or another scale.
const OTHER_UNIT: f64 = 2.0;
const MAX_OFF: f64 = 0.35;
/// Scale from two opposite faces: the bias is not in it.
const MAX_SCALE_OFF: f64 = 0.2;
/// A mean angular rate that differs from that of the other poses by more is a steady turn, °/s.
const MAX_TURNING_DEG_S: f64 = 5.0;
/// Most difference of the temperature from the first pose, °C.
const MAX_WARMING_C: f64 = 3.0;
/// An axis that repeats a value while gravity turns by more than this is frozen, g.
const TURNED_G: f64 = 0.3;
/// … while each of the others takes as many values.
const LIVELY: usize = 4;

/// The remedy for what moved.
pub(super) const LET_GO: &str = "lay it down, take the hand off, and wait";

/// Why a hold is no pose.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    pub reason: Rejection,
    pub message: String,
    pub remedy: String,
    /// The command `capture` overrules it.
    pub soft: bool,
}

impl Fault {
    pub fn new(reason: Rejection, message: String, remedy: impl Into<String>) -> Self {
        Fault {
            reason,
            message,
            remedy: remedy.into(),
            soft: false,
        }
    }

    pub fn soft(self) -> Self {
        Fault { soft: true, ..self }
    }
}

/// What is known of the units once the noise is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// Subtracted from the counts of the accelerometer.
    pub zero_offset: f64,
    /// Units of the recording per m/s².
    pub nominal: f64,
    pub scale: AccelScale,
    /// Units of the gyroscope per rad/s.
    pub gyro_nominal: Option<f64>,
}

impl Units {
    /// What is wrong with the magnitude of a rest in local `gravity`, m/s².
    pub fn fault(&self, accel: [f64; 3], gravity: f64) -> Option<Fault> {
        let norm = norm(&accel) / self.nominal;
        let ratio = norm / gravity;
        if !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
            return Some(Fault::new(
                Rejection::Units,
                format!("‖a‖ is {norm:.2} m/s² at rest: the unit or the range has changed"),
                "set the range of the sensor as it was, or begin anew",
            ));
        }
        ((ratio - 1.0).abs() > MAX_OFF).then(|| {
            other_scale(format!(
                "‖a‖ is {norm:.2} m/s² at rest, {:.0} % from gravity",
                100.0 * (ratio - 1.0)
            ))
        })
    }
}

fn other_scale(message: String) -> Fault {
    let remedy = "check that the sensor is raw and at the range that the sketch converts with";
    Fault::new(Rejection::Scale, message, remedy)
}

/// An accepted pose, and its mean angular rate.
#[derive(Debug, Clone)]
pub(super) struct Accepted {
    pub pose: Pose,
    pub gyro: [f64; 3],
}

/// A capture that is judged.
pub(super) struct Capture<'a> {
    pub samples: &'a [Sample],
    pub rate_hz: f64,
    /// Rows that it should have.
    pub rows: usize,
    pub units: Units,
    pub poses: &'a [Accepted],
    pub options: &'a LiveOptions,
}

/// Means of a capture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means {
    pub accel: [f64; 3],
    pub gyro: [f64; 3],
    /// Standard deviation of a sample, root of the sum over the axes.
    pub sigma: f64,
    /// The same of the gyroscope; NaN without one.
    pub gyro_sigma: f64,
    pub temperature_c: Option<f64>,
}

impl Means {
    pub fn of(samples: &[Sample]) -> Self {
        let (accel, variance) = moments_of(samples, |s| s.accel);
        let (gyro, gyro_variance) = moments_of(samples, |s| s.gyro);
        let warm: Vec<f64> = samples
            .iter()
            .map(|s| s.temperature_c)
            .filter(|t| t.is_finite())
            .collect();
        Means {
            accel,
            gyro,
            sigma: variance.sqrt(),
            gyro_sigma: gyro_variance.sqrt(),
            temperature_c: (!warm.is_empty()).then(|| warm.iter().sum::<f64>() / warm.len() as f64),
        }
    }
}

pub(super) fn warmer_or_colder(change_c: f64) -> &'static str {
    if change_c > 0.0 { "warmer" } else { "colder" }
}

fn columns(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|i| samples.iter().map(|s| of(s)[i]).collect())
}

/// Means and the sum of the variances, as the detector and the journal calculate them.
fn moments_of(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> ([f64; 3], f64) {
    moments(&columns(samples, of), 0..samples.len())
}

/// Mean of each axis; empty cells are left out.
pub(super) fn mean(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> [f64; 3] {
    moments_of(samples, of).0
}

/// Standard deviation of each axis of the accelerometer; empty cells are left out.
pub(super) fn scatter(samples: &[Sample]) -> [f64; 3] {
    columns(samples, |s| s.accel).map(|mut axis| {
        axis.retain(|v| v.is_finite());
        standard_deviation(&axis)
    })
}

impl Capture<'_> {
    fn mg(&self, units: f64) -> f64 {
        mg(units / self.units.nominal)
    }

    /// The accepted poses.
    fn poses(&self) -> impl Iterator<Item = &Pose> {
        self.poses.iter().map(|p| &p.pose)
    }

    /// What is wrong with it, the gravest fault first.
    pub fn fault(&self, means: &Means) -> Option<Fault> {
        self.gaps()
            .or_else(|| self.frozen(means))
            .or_else(|| self.clipped())
            .or_else(|| self.magnitude(means))
            .or_else(|| self.turning(means))
            .or_else(|| self.temperature(means))
    }

    fn gaps(&self) -> Option<Fault> {
        let read = |s: &&Sample| norm(&s.accel).is_finite();
        let there = self.samples.iter().filter(read).count();
        let (first, last) = (self.samples.first()?, self.samples.last()?);
        let by_time = (last.time_s - first.time_s) * self.rate_hz + 1.0;
        let wanted = by_time.max(self.rows as f64);
        let broken = self.samples.iter().skip(1).any(|s| s.is_break);
        let missing = wanted - there as f64;
        (broken || missing > MAX_MISSING * wanted).then(|| {
            Fault::new(
                Rejection::Gaps,
                format!(
                    "{:.0} of {wanted:.0} rows of the capture are missing",
                    missing.max(1.0)
                ),
                "hold it still once more; check the cable, or lower the rate, if it happens again",
            )
        })
    }

    /// An axis that repeats its value although another pose should have changed it. Beside axes
    /// that repeat theirs, too, it may be coarse and quiet.
    fn frozen(&self, means: &Means) -> Option<Fault> {
        let values = |axis: usize| {
            let mut values: Vec<f64> = self.samples.iter().map(|s| s.accel[axis]).collect();
            values.retain(|v| v.is_finite());
            values.sort_unstable_by(f64::total_cmp);
            values.dedup();
            values
        };
        let axis = (0..3).find(|&axis| {
            let [value] = values(axis)[..] else {
                return false;
            };
            let is_lively = (0..3).all(|beside| beside == axis || values(beside).len() >= LIVELY);
            let others = self.poses().filter(|p| {
                let mut turned = sub(&p.mean, &means.accel);
                turned[axis] = 0.0;
                self.mg(norm(&turned)) > 1000.0 * TURNED_G
            });
            let mut others = others.peekable();
            is_lively
                && others.peek().is_some()
                && others.all(|p| (p.mean[axis] - value).abs() < 1e-9 * value.abs().max(1e-9))
        })?;
        let name = AXES[axis];
        Some(Fault::new(
            Rejection::Frozen,
            format!("a{name} keeps one value in every pose while the others change"),
            format!(
                "the sensor does not measure a{name}: check the wiring and the sketch, and begin anew"
            ),
        ))
    }

    fn clipped(&self) -> Option<Fault> {
        let axis = (0..3).find(|&axis| {
            let values: Vec<f64> = self.samples.iter().map(|s| s.accel[axis]).collect();
            clipped_count(&values, &self.units.scale) > 0
        })?;
        Some(Fault::new(
            Rejection::Clipped,
            format!("a{} is at the end of its range", AXES[axis]),
            "set the sensor to a wider range (±4 g), and begin anew",
        ))
    }

    fn magnitude(&self, means: &Means) -> Option<Fault> {
        let gravity = self.options.gravity.value_mps2;
        if let Some(fault) = self.units.fault(means.accel, gravity) {
            return Some(fault);
        }
        let (face, tilt_deg) = Face::nearest(means.accel);
        if tilt_deg > MAX_FACE_ANGLE_DEG {
            return None;
        }
        let opposite = face.opposite().name();
        let other = self
            .poses()
            .find(|p| p.face.as_deref() == Some(&opposite))?;
        let apart = (means.accel[face.axis] - other.mean[face.axis]).abs();
        let off = 0.5 * apart / self.units.nominal / gravity - 1.0;
        if off.abs() > MAX_SCALE_OFF {
            return Some(other_scale(format!(
                "{} and {opposite} are {:.0} % from gravity, without the bias",
                face.name(),
                100.0 * off
            )));
        }
        None
    }

    /// A turn about the vertical leaves gravity where it is.
    fn turning(&self, means: &Means) -> Option<Fault> {
        // Its bias is only known from other poses: the first one is not tested.
        let nominal = self.units.gyro_nominal?;
        let n = self.poses.len() as f64;
        let usual: [f64; 3] =
            std::array::from_fn(|i| self.poses.iter().map(|p| p.gyro[i]).sum::<f64>() / n);
        let rate_deg_s = (norm(&sub(&means.gyro, &usual)) / nominal).to_degrees();
        (rate_deg_s > MAX_TURNING_DEG_S).then(|| {
            Fault::new(
                Rejection::Moved,
                format!("it turns steadily: {rate_deg_s:.0} °/s more than in the other poses"),
                LET_GO,
            )
        })
    }

    fn temperature(&self, means: &Means) -> Option<Fault> {
        let first = self.poses().find_map(|p| p.temperature_c)?;
        let warmer = means.temperature_c? - first;
        (warmer.abs() > MAX_WARMING_C && !self.options.any_pose).then(|| {
            Fault::new(
                Rejection::Temperature,
                format!(
                    "the sensor is {:.1} °C {} than in the first pose: its bias has drifted",
                    warmer.abs(),
                    warmer_or_colder(warmer)
                ),
                "wait until it is as before; or take it all the same, or undo the old poses one by one",
            )
            .soft()
        })
    }
}
