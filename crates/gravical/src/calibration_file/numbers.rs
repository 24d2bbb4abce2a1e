//! The parameters of a file as the estimators take them.

use gravical_core::matrix3;
use gravical_fit::model::{BENDS, BIAS, Covariance as ParameterCovariance, DRIFT, Parameters};
use gravical_fit::{Gravity, Sensor, covariance_by_gravity, deviations};

use super::{AccelerometerSection, CalibrationFile, Covariance, GyroscopeSection, TiltSource};

/// Model error of real sensors when a fit cannot tell, m/s²: 1.1 to 1.9 rms on three MPU-9150 and
/// an MTi, some 40 poses each.
const USUAL_MODEL_ERROR_MPS2: f64 = 0.002;

/// None where the matrix is singular.
fn parameters(matrix: &[[f64; 3]; 3], bias: &[f64; 3], bends: [f64; 6]) -> Option<Parameters> {
    let model = matrix3::inverse(matrix)?;
    Some(Parameters::from_fn(|i, _| match i {
        0..BIAS => model[i / 3][i % 3],
        BIAS..DRIFT => bias[i - BIAS],
        BENDS.. => bends[i - BENDS],
        _ => 0.0,
    }))
}

impl Covariance {
    /// Of M, b and, if they were fitted, bends; none of another size, not finite or zero throughout.
    fn of_parameters(&self) -> Option<ParameterCovariance> {
        let values = &self.values;
        let size = values.len();
        if !matches!(size, 12 | 18) || values.iter().any(|row| row.len() != size) {
            return None;
        }
        let place = |i: usize| if i < DRIFT { i } else { i - DRIFT + BENDS };
        let mut covariance = ParameterCovariance::zeros();
        for (i, row) in values.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                covariance[(place(i), place(k))] = *value;
            }
        }
        let is_finite = covariance.iter().all(|v| v.is_finite());
        (is_finite && covariance.iter().any(|v| *v != 0.0)).then_some(covariance)
    }
}

impl GyroscopeSection {
    /// Standard deviations of bias and scale; the scale has none where only the bias was estimated.
    #[must_use]
    pub fn deviations(&self) -> Option<([f64; 3], Option<[f64; 3]>)> {
        let covariance = self.covariance.as_ref()?;
        if let [x, y, z] = &covariance.values[..] {
            return Some(([*x.first()?, *y.get(1)?, *z.get(2)?].map(f64::sqrt), None));
        }
        let parameters = parameters(&self.matrix, &self.bias, [0.0; 6])?;
        let sd = deviations(&parameters, &covariance.of_parameters()?);
        Some((sd.bias, Some(sd.scale)))
    }
}

impl AccelerometerSection {
    /// M, b and bends, in the input unit; none where the matrix is singular.
    #[must_use]
    pub fn parameters(&self) -> Option<Parameters> {
        parameters(&self.matrix, &self.bias, self.bends.unwrap_or_default())
    }

    /// Covariance of these, the error of gravity included; none where it is absent, of another size,
    /// not finite or zero throughout.
    #[must_use]
    pub fn covariance_of_parameters(&self) -> Option<ParameterCovariance> {
        self.covariance.as_ref()?.of_parameters()
    }

    /// What readings miss the model by, m/s²: what the fit says of itself, or what is usual where none
    /// can tell.
    fn model_error_mps2(&self) -> f64 {
        match self.fit {
            Some(fit) if fit.freedom >= 1.0 => fit.model_error_mps2,
            Some(fit) => fit.model_error_mps2.max(USUAL_MODEL_ERROR_MPS2),
            None => USUAL_MODEL_ERROR_MPS2,
        }
    }

    /// Tilts that σ_tilt was estimated from.
    fn tilt_freedom(&self) -> f64 {
        let tilt = self.pose_tilt_deg.as_ref();
        let is_estimated = tilt.is_some_and(|t| t.source == TiltSource::Estimated);
        let fit = self.fit.filter(|_| is_estimated);
        fit.map_or(f64::INFINITY, |fit| fit.tilt_degrees_of_freedom)
    }
}

impl CalibrationFile {
    /// The accelerometer with the covariance by its readings alone, in the input unit; none where the
    /// matrix is singular or the file has no covariance.
    #[must_use]
    pub fn sensor(&self) -> Option<Sensor> {
        let section = &self.accelerometer;
        let parameters = section.parameters()?;
        let gravity = Gravity {
            value_mps2: self.gravity_mps2,
            sd_mps2: section.gravity_sd_mps2,
        };
        let by_gravity = covariance_by_gravity(&parameters, gravity.relative_sd());
        Some(Sensor {
            parameters,
            covariance: section.covariance_of_parameters()? - by_gravity,
            gravity,
            model_error_mps2: section.model_error_mps2(),
            tilt_freedom: section.tilt_freedom(),
        })
    }
}
