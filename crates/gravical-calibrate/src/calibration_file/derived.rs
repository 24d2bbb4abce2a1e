//! What follows from the numbers of a file: a sensor as the estimators take it, nominal scales, drifts, and what
//! of a result needs attention.

use std::collections::BTreeSet;

use gravical_core::matrix3;
use gravical_fit::consistency::Placements;
use gravical_fit::model::{
    BIAS, Covariance as ParameterCovariance, DRIFT, NONLINEARITY, Parameters,
};
use gravical_fit::{
    Deviations, Face, Gravity, Mounting, Sensor, covariance_by_gravity, deviations,
};
use gravical_judge::numfmt::COVERAGE;
use gravical_signal::stats::rms;

use super::{
    Accelerometer, Budget, CHANNELS, Calibration, ChannelDrift, Covariance, DriftVerdict,
    Gyroscope, NextPose, PoseKind, PoseResult, Reliability, TemperatureModel, TiltSource,
};
use crate::problem::Problem;
use crate::recording::units::{AccelScale, AccelUnit, GyroUnit, Origin};

/// Model error of real sensors when a fit cannot tell, m/s²: 1.1 to 1.9 rms on three MPU-9150 and
/// an MTi, some 40 poses each.
const USUAL_MODEL_ERROR_MPS2: f64 = 0.002;
/// The value of zero in unsigned 16-bit counts.
const UNSIGNED_OFFSET: f64 = 32768.0;
/// Poses are proposed if all of them together bring an error below this share.
const MATTERS: f64 = 0.8;

/// None where the matrix is singular.
fn parameters(
    matrix: &[[f64; 3]; 3],
    bias: &[f64; 3],
    nonlinearity: [f64; 6],
) -> Option<Parameters> {
    let model = matrix3::inverse(matrix)?;
    Some(Parameters::from_fn(|i, _| match i {
        0..BIAS => model[i / 3][i % 3],
        BIAS..DRIFT => bias[i - BIAS],
        NONLINEARITY.. => nonlinearity[i - NONLINEARITY],
        _ => 0.0,
    }))
}

impl Covariance {
    /// Of M, b and, if they were fitted, the nonlinearity coefficients; none of another size, not finite or zero throughout.
    #[doc(hidden)]
    pub fn of_parameters(&self) -> Option<ParameterCovariance> {
        let values = &self.values;
        let size = values.len();
        if !matches!(size, 12 | 18) || values.iter().any(|row| row.len() != size) {
            return None;
        }
        let place = |i: usize| {
            if i < DRIFT {
                i
            } else {
                i - DRIFT + NONLINEARITY
            }
        };
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

impl Calibration {
    /// How the sensor is turned in its case; none where no faces, or those of one axis, show it.
    pub fn mounting(&self) -> Option<Mounting> {
        let a = &self.accelerometer;
        let faces = self.poses.iter();
        let faces = faces.filter(|p| p.fitted && p.kind == PoseKind::Face);
        let axes: BTreeSet<usize> = faces.map(|p| Face::nearest(p.expected).0.axis).collect();
        let is_shown = axes.len() > 1;
        gravical_fit::mounting(&a.parameters()?, &a.covariance_of_parameters()?)
            .filter(|_| is_shown)
    }

    /// The accelerometer with the covariance by its readings alone, in the input unit; none where the
    /// matrix is singular or the file has no covariance.
    #[doc(hidden)]
    pub fn sensor(&self) -> Option<Sensor> {
        let all = self.accelerometer.covariance_of_parameters()?;
        // What the fit says of itself, or what is usual where none can tell.
        let model_error_mps2 = match self.reliability.fit {
            Some(fit) if fit.freedom >= 1.0 => fit.model_error_mps2,
            Some(fit) => fit.model_error_mps2.max(USUAL_MODEL_ERROR_MPS2),
            None => USUAL_MODEL_ERROR_MPS2,
        };
        let mut sensor = self.sensor_with(all, model_error_mps2)?;
        let relative_sd = sensor.gravity.relative_sd();
        sensor.covariance -= covariance_by_gravity(&sensor.parameters, relative_sd);
        Some(sensor)
    }

    /// The accelerometer with this covariance by its readings; none where the matrix is singular.
    pub(crate) fn sensor_with(
        &self,
        covariance: ParameterCovariance,
        model_error_mps2: f64,
    ) -> Option<Sensor> {
        Some(Sensor {
            parameters: self.accelerometer.parameters()?,
            covariance,
            gravity: Gravity {
                value_mps2: self.gravity_mps2,
                sd_mps2: self.gravity_sd_mps2,
            },
            model_error_mps2,
        })
    }

    /// The placements on faces, and how well their tilts are known where these hold the frame.
    pub(crate) fn placements(&self) -> Placements {
        let poses = self.poses.iter();
        let faces = poses.filter(|p| p.kind == PoseKind::Face && p.fitted);
        let fit = self.reliability.fit.filter(|fit| fit.oriented);
        let tilt = self.reliability.pose_tilt_deg;
        let estimated = tilt.filter(|tilt| tilt.source == TiltSource::Estimated);
        Placements {
            forces: faces.map(|p| p.calibrated).collect(),
            tilt_rad: tilt.map_or(0.0, |tilt| tilt.value.to_radians()),
            freedom: estimated
                .zip(fit)
                .map_or(f64::INFINITY, |(_, fit)| fit.tilt_degrees_of_freedom),
        }
    }

    /// The drift with temperature, if a channel is corrected.
    #[doc(hidden)]
    pub fn drift_model(&self) -> Option<&TemperatureModel> {
        self.drift.as_ref().filter(|m| m.any_corrected())
    }

    /// The number of the pose that the others contradict most, if one is beyond what chance explains, and how many of
    /// its standard deviations it is off.
    pub fn contradiction(&self) -> Option<(usize, f64)> {
        let ratio = |p: &PoseResult| Some(p.left_out_error_mps2?.abs() / p.left_out_sd_mps2?);
        let each = self.poses.iter().enumerate();
        let each = each.filter_map(|(i, p)| Some((i, ratio(p)?)));
        each.filter(|(_, z)| *z > gravical_fit::CONTRADICTION)
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// RMS of ‖a‖ − g over free poses that took no part in the fit, m/s², and their number.
    pub(crate) fn free_norm_error(&self) -> Option<(f64, usize)> {
        let free = self.poses.iter();
        let free = free.filter(|p| p.kind == PoseKind::Free && !p.fitted);
        let errors: Vec<f64> = free.filter_map(|p| p.magnitude_error_mps2).collect();
        (!errors.is_empty()).then(|| (rms(errors.iter().copied()), errors.len()))
    }
}

impl Reliability {
    /// The next poses, if they improve the result by more than a fifth: its predicted error, or,
    /// where that is above 5 mg, the error that one pose can cause undetected.
    pub fn proposed_poses(&self) -> &[NextPose] {
        let (now, next) = (self.predicted_mps2, &self.next_poses);
        let then = next.last().map(|p| p.predicted_mps2);
        let both = now.zip(then);
        let lowers_error = both.is_some_and(|(now, then)| then < MATTERS * now);
        let now = self.undetected.map(|u| u.effect_mps2);
        let then = next.iter().filter_map(|p| p.undetected_effect_mps2);
        let tests_more = then.min_by(f64::total_cmp).is_some_and(|least| {
            now.is_none_or(|now| now > gravical_fit::GOOD_MPS2 && least < MATTERS * now)
        });
        if lowers_error || tests_more {
            next
        } else {
            &[]
        }
    }
}

impl Accelerometer {
    /// M, b and nonlinearity, in the input unit; none where the matrix is singular.
    #[doc(hidden)]
    pub fn parameters(&self) -> Option<Parameters> {
        parameters(
            &self.matrix,
            &self.bias,
            self.nonlinearity.unwrap_or_default(),
        )
    }

    /// Covariance of these, the error of gravity included; none where it is absent, of another size,
    /// not finite or zero throughout.
    #[doc(hidden)]
    pub fn covariance_of_parameters(&self) -> Option<ParameterCovariance> {
        self.covariance.as_ref()?.of_parameters()
    }

    /// K of raw = K R a + b, input unit per m/s²; not a number where the matrix is singular.
    pub fn scale(&self) -> [f64; 3] {
        scale_and_orientation(&self.matrix).0
    }

    /// R: rows of length one, in general not orthogonal.
    pub fn orientation(&self) -> [[f64; 3]; 3] {
        scale_and_orientation(&self.matrix).1
    }

    /// Standard deviations of bias, scale and the angles between the axes; none without a covariance.
    pub fn deviations(&self) -> Option<Deviations> {
        Some(deviations(
            &self.parameters()?,
            &self.covariance_of_parameters()?,
        ))
    }

    /// Deviation of the scale from nominal, %; none if the nominal scale is unknown.
    pub fn scale_deviation_percent(&self) -> Option<[f64; 3]> {
        let nominal = self.nominal_scale?;
        Some(self.scale().map(|k| 100.0 * (k / nominal - 1.0)))
    }

    /// Unit of calibrated values.
    pub fn output_unit(&self) -> AccelUnit {
        AccelUnit::MetrePerSecondSquared
    }

    /// Input units per m/s², mean of the axes.
    #[doc(hidden)]
    pub fn mean_scale(&self) -> f64 {
        self.scale().iter().sum::<f64>() / 3.0
    }

    /// Input units per m/s² by definition, or by the nominal scale of the session.
    #[doc(hidden)]
    pub fn nominal_per_mps2(&self) -> Option<f64> {
        let by_definition = AccelScale {
            unit: self.input_unit,
            lsb_per_g: None,
            origin: Origin::Given,
        };
        by_definition.nominal().or(self.nominal_scale)
    }

    /// The offset of unsigned counts, where the bias shows that it contains one.
    #[doc(hidden)]
    pub fn zero_offset(&self) -> f64 {
        unsigned_offset(self.bias, self.input_unit == AccelUnit::Counts)
    }

    /// A raw reading in m/s² without the calibration, by the nominal scale. None if that is
    /// unknown, or zero is: a bias beyond 4 g is an offset of the counts.
    #[doc(hidden)]
    pub fn nominally(&self, raw: [f64; 3]) -> Option<[f64; 3]> {
        let (nominal, offset) = (self.nominal_per_mps2()?, self.zero_offset());
        let values = |v: [f64; 3]| v.map(|v| (v - offset) / nominal);
        let zero_known = values(self.bias).iter().all(|b| b.abs() < 40.0);
        zero_known.then(|| values(raw))
    }
}

impl PoseResult {
    /// calibrated − expected, m/s².
    pub fn error(&self) -> [f64; 3] {
        matrix3::sub(&self.calibrated, &self.expected)
    }

    /// Its length.
    pub fn error_norm(&self) -> f64 {
        matrix3::norm(&self.error())
    }
}

impl Budget {
    /// Root of the sum of the squares of all contributions, m/s².
    pub fn combined_mps2(&self) -> f64 {
        let known = self.contributions.iter().filter_map(|c| c.norm_mps2);
        known.map(|n| n * n).sum::<f64>().sqrt()
    }

    /// k.
    pub fn coverage_factor(&self) -> f64 {
        COVERAGE
    }

    /// k times the combined uncertainty, m/s².
    pub fn expanded_mps2(&self) -> f64 {
        COVERAGE * self.combined_mps2()
    }
}

/// K and R of the matrix (K R)⁻¹.
fn scale_and_orientation(matrix: &[[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let model = matrix3::inverse(matrix).unwrap_or([[f64::NAN; 3]; 3]);
    let scale = matrix3::row_norms(&model);
    (scale, matrix3::scale_rows(&model, &scale.map(f64::recip)))
}

fn unsigned_offset(bias: [f64; 3], counts: bool) -> f64 {
    let around = |b: f64| (b / UNSIGNED_OFFSET - 1.0).abs() < 0.25;
    if counts && bias.into_iter().all(around) {
        UNSIGNED_OFFSET
    } else {
        0.0
    }
}

impl Gyroscope {
    /// K of raw = K R ω + b, input unit per rad/s; not a number where the matrix is singular.
    pub fn scale(&self) -> [f64; 3] {
        scale_and_orientation(&self.matrix).0
    }

    /// R: rows of length one, in general not orthogonal.
    pub fn orientation(&self) -> [[f64; 3]; 3] {
        scale_and_orientation(&self.matrix).1
    }

    /// Standard deviations of bias and scale; the scale has none where only the bias was estimated.
    pub fn deviations(&self) -> Option<([f64; 3], Option<[f64; 3]>)> {
        let covariance = self.covariance.as_ref()?;
        if let [x, y, z] = &covariance.values[..] {
            return Some(([*x.first()?, *y.get(1)?, *z.get(2)?].map(f64::sqrt), None));
        }
        let parameters = parameters(&self.matrix, &self.bias, [0.0; 6])?;
        let sd = deviations(&parameters, &covariance.of_parameters()?);
        Some((sd.bias, Some(sd.scale)))
    }

    /// Unit of calibrated values.
    pub fn output_unit(&self) -> GyroUnit {
        GyroUnit::RadianPerSecond
    }

    /// Input units per °/s, mean of the axes.
    #[doc(hidden)]
    pub fn mean_per_deg_s(&self) -> f64 {
        self.scale().iter().sum::<f64>() / 3.0 * 1_f64.to_radians()
    }

    /// The offset of unsigned counts, where the bias shows that it contains one.
    #[doc(hidden)]
    pub fn zero_offset(&self) -> f64 {
        let counts = matches!(self.input_unit, GyroUnit::Counts | GyroUnit::Unknown);
        unsigned_offset(self.bias, counts)
    }
}

impl ChannelDrift {
    /// True if its drift is subtracted.
    pub fn is_corrected(&self) -> bool {
        self.verdict == DriftVerdict::Corrected
    }
}

impl TemperatureModel {
    /// The channel with this name.
    pub fn channel(&self, name: &str) -> Option<&ChannelDrift> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// True if at least one channel is corrected.
    pub fn any_corrected(&self) -> bool {
        self.channels.iter().any(ChannelDrift::is_corrected)
    }

    /// Drift of `ax` … `gz` at `t_c`, input unit; outside the range that at the nearer edge. Zero for
    /// a channel that is not corrected.
    pub fn drift_at(&self, t_c: f64) -> [f64; 6] {
        let x = t_c.clamp(self.range_c[0], self.range_c[1]) - self.reference_c;
        CHANNELS.map(|name| {
            let channel = self.channel(name).filter(|c| c.is_corrected());
            channel.and_then(|c| c.per_c).map_or(0.0, |per_c| per_c * x)
        })
    }

    /// Why it cannot be applied; `None` if it can.
    pub(super) fn fault(&self) -> Option<Problem> {
        let [low, high] = self.range_c;
        // Not where one is no number, either.
        if !(low <= high && self.reference_c.is_finite()) {
            let range_c = self.range_c;
            return Some(Problem::DriftRange { range_c });
        }
        let is_faulty = |c: &&ChannelDrift| {
            let has_slope = c.per_c.is_some_and(f64::is_finite);
            c.is_corrected() && !has_slope || !CHANNELS.contains(&c.channel.as_str())
        };
        let channel = self.channels.iter().find(is_faulty)?.channel.clone();
        Some(Problem::DriftChannel { channel })
    }
}
