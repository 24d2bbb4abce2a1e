//! The nominal scale of a channel: what a value means before calibration.

use gravical_core::matrix3;
use gravical_core::unit::{RADIANS_PER_DEGREE, STANDARD_GRAVITY_MPS2};

use super::{AccelerometerSection, GyroscopeSection};
use crate::recording::units::{AccelUnit, GyroUnit};

/// The value of zero in unsigned 16-bit counts.
const UNSIGNED_OFFSET: f64 = 32768.0;

impl AccelerometerSection {
    /// Input units per m/s², mean of the axes.
    pub(crate) fn mean_scale(&self) -> f64 {
        self.scale.iter().sum::<f64>() / 3.0
    }

    /// Input units per m/s² by definition, or by the deviation that the file gives.
    #[doc(hidden)]
    #[must_use]
    pub fn nominal_per_mps2(&self) -> Option<f64> {
        match self.input_unit {
            AccelUnit::MetrePerSecondSquared => Some(1.0),
            AccelUnit::StandardGravity => Some(1.0 / STANDARD_GRAVITY_MPS2),
            AccelUnit::MilliGravity => Some(1000.0 / STANDARD_GRAVITY_MPS2),
            AccelUnit::Counts | AccelUnit::Unknown => {
                let deviation = self.scale_deviation_percent?[0];
                let nominal = self.scale[0] / (1.0 + deviation / 100.0);
                (nominal.is_finite() && nominal > 0.0).then_some(nominal)
            }
        }
    }

    /// The offset of unsigned counts, where the bias shows that it contains one.
    #[doc(hidden)]
    #[must_use]
    pub fn zero_offset(&self) -> f64 {
        let counts = self.input_unit == AccelUnit::Counts;
        unsigned_offset(self.bias, counts)
    }

    /// A raw reading in m/s² without the calibration, by the nominal scale. None if that is
    /// unknown, or zero is: a bias beyond 4 g is an offset of the counts.
    #[doc(hidden)]
    #[must_use]
    pub fn nominally(&self, raw: [f64; 3]) -> Option<[f64; 3]> {
        let (nominal, offset) = (self.nominal_per_mps2()?, self.zero_offset());
        let values = |v: [f64; 3]| v.map(|v| (v - offset) / nominal);
        let zero_known = values(self.bias).iter().all(|b| b.abs() < 40.0);
        zero_known.then(|| values(raw))
    }
}

fn unsigned_offset(bias: [f64; 3], counts: bool) -> f64 {
    let around = |b: f64| (b / UNSIGNED_OFFSET - 1.0).abs() < 0.25;
    if counts && bias.into_iter().all(around) {
        UNSIGNED_OFFSET
    } else {
        0.0
    }
}

impl GyroscopeSection {
    /// Input units per °/s, mean of the axes.
    pub(crate) fn mean_per_deg_s(&self) -> f64 {
        self.scale.iter().sum::<f64>() / 3.0 * 1_f64.to_radians()
    }

    /// The offset of unsigned counts, where the bias shows that it contains one.
    pub(crate) fn zero_offset(&self) -> f64 {
        let counts = matches!(self.input_unit, GyroUnit::Counts | GyroUnit::Unknown);
        unsigned_offset(self.bias, counts)
    }

    /// Input units per rad/s by definition; the file does not give that of counts.
    pub(crate) fn nominal_per_rad_s(&self) -> Option<f64> {
        match self.input_unit {
            GyroUnit::RadianPerSecond => Some(1.0),
            GyroUnit::DegreePerSecond => Some(1.0 / RADIANS_PER_DEGREE),
            GyroUnit::Counts | GyroUnit::Unknown => None,
        }
    }

    /// The bias as an angular rate about the axes of the case, °/s, without the offset of
    /// unsigned counts.
    pub(crate) fn bias_deg_s(&self) -> [f64; 3] {
        let offset = self.zero_offset();
        matrix3::mul_vec(&self.matrix, &self.bias.map(|b| b - offset)).map(f64::to_degrees)
    }
}
