//! Whether the rows of a capture are a pose, and what is wrong if not.

use gravical_core::matrix3::{norm, sub};
use gravical_recording::Sample;
use gravical_recording::full_scale::clipped_count;

use super::event::{Pose, Rejection};
use super::mg;
use super::rest::{Fault, LET_GO, Means, Units, columns, other_scale, warming};
use super::session::Session;
use crate::poses::MAX_FACE_ANGLE_DEG;
use crate::poses::face::{AXES, Face};

/// Share of the rows of a capture that may be missing.
const MAX_MISSING: f64 = 0.05;
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

impl Session {
    /// What is wrong with a capture that should have so many `rows`, the gravest fault first. `forced`:
    /// the user wants it.
    pub(super) fn fault(
        &self,
        samples: &[Sample],
        rows: usize,
        units: &Units,
        forced: bool,
    ) -> Option<Fault> {
        let means = Means::of(samples);
        let gravity = self.options.gravity.value_mps2;
        let columns = columns(samples, |s| s.accel);
        self.gaps(samples, rows)
            .or_else(|| self.frozen(&columns, &means, units))
            .or_else(|| clipped(&columns, units))
            .or_else(|| units.fault(means.accel, gravity))
            .or_else(|| self.opposite(&means, units))
            .or_else(|| self.turning(&means, units))
            .or_else(|| self.temperature(&means).filter(|_| !forced))
    }

    fn gaps(&self, samples: &[Sample], rows: usize) -> Option<Fault> {
        let read = samples.iter().filter(|s| norm(&s.accel).is_finite());
        let (first, last) = (samples.first()?, samples.last()?);
        let by_time = (last.time_s - first.time_s) * self.rate_hz + 1.0;
        let wanted = by_time.max(rows as f64);
        let missing = wanted - read.count() as f64;
        (missing > MAX_MISSING * wanted).then(|| {
            let text = format!(
                "{missing:.0} of {wanted:.0} rows of the capture are missing. Hold it still once more; check the cable, or lower the rate, if it happens again."
            );
            (Rejection::Gaps, text)
        })
    }

    /// An axis that repeats its value although another pose should have changed it. Beside axes
    /// that repeat theirs, too, it may be coarse and quiet.
    fn frozen(&self, columns: &[Vec<f64>; 3], means: &Means, units: &Units) -> Option<Fault> {
        let values = columns.each_ref().map(|column| {
            let mut values: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
            values.sort_unstable_by(f64::total_cmp);
            values.dedup();
            values
        });
        let is_frozen = |axis: &usize| {
            let [value] = values[*axis][..] else {
                return false;
            };
            let is_lively = (0..3).all(|beside| beside == *axis || values[beside].len() >= LIVELY);
            let turned = |p: &&Pose| {
                let mut turned = sub(&p.mean, &means.accel);
                turned[*axis] = 0.0;
                mg(norm(&turned) / units.nominal) > 1000.0 * TURNED_G
            };
            let mut others = self.poses().filter(turned).peekable();
            is_lively
                && others.peek().is_some()
                && others.all(|p| (p.mean[*axis] - value).abs() < 1e-9 * value.abs().max(1e-9))
        };
        let name = AXES[(0..3).find(is_frozen)?];
        let text = format!(
            "a{name} keeps one value in every pose while the others change. The sensor does not measure a{name}: check the wiring and the sketch, and begin anew."
        );
        Some((Rejection::Frozen, text))
    }

    /// The distance of two opposite faces is that of gravity.
    fn opposite(&self, means: &Means, units: &Units) -> Option<Fault> {
        let (face, tilt_deg) = Face::nearest(means.accel);
        let opposite = face.opposite();
        let name = Some(opposite.name()).filter(|_| tilt_deg <= MAX_FACE_ANGLE_DEG);
        let other = self.poses().find(|p| name.is_some() && p.face == name)?;
        let apart = (means.accel[face.axis] - other.mean[face.axis]).abs() / units.nominal;
        let off = (0.5 * apart / self.options.gravity.value_mps2 - 1.0).abs();
        (off > MAX_SCALE_OFF).then(|| {
            other_scale(&format!(
                "{} and {} show {:.2} m/s² without the bias, {:.0} % from gravity",
                face.name(),
                opposite.name(),
                0.5 * apart,
                100.0 * off
            ))
        })
    }

    /// A turn about the vertical leaves gravity where it is.
    fn turning(&self, means: &Means, units: &Units) -> Option<Fault> {
        // Its bias is only known from other poses: the first one is not tested.
        let n = self.poses.len() as f64;
        let usual: [f64; 3] =
            std::array::from_fn(|i| self.poses.iter().map(|(_, gyro)| gyro[i]).sum::<f64>() / n);
        let rate_deg_s = (norm(&sub(&means.gyro, &usual)) / units.gyro_nominal?).to_degrees();
        (rate_deg_s > MAX_TURNING_DEG_S).then(|| {
            let text = format!(
                "It turns steadily: {rate_deg_s:.0} °/s more than in the other poses. {LET_GO}"
            );
            (Rejection::Moved, text)
        })
    }

    fn temperature(&self, means: &Means) -> Option<Fault> {
        let change_c = means.temperature_c? - self.first_temperature_c()?;
        (change_c.abs() > MAX_WARMING_C && !self.options.any_pose).then(|| {
            let text = format!(
                "{}: its bias has drifted. Wait until it is as before; or take it all the same, or undo the old poses one by one.",
                warming(change_c)
            );
            (Rejection::Temperature, text)
        })
    }
}

fn clipped(columns: &[Vec<f64>; 3], units: &Units) -> Option<Fault> {
    let axis = (0..3).find(|&axis| clipped_count(&columns[axis], &units.scale) > 0)?;
    let text = format!(
        "a{} is at the end of its range. Set the sensor to a wider range (±4 g), and begin anew.",
        AXES[axis]
    );
    Some((Rejection::Clipped, text))
}
