//! Does the calibration fit the recording it is applied to? At rest the calibrated magnitude is
//! gravity, to what its covariance and the noise of the mean allow. Where it is not, the
//! parameters are off by more than the covariance says, in directions that rests in one attitude
//! do not show: the bands then allow for an error of that size in each of them.

use gravical_core::matrix3::norm;
use gravical_motion::{ElementErrors, ForceDirection, Samples};
use serde::Serialize;

use super::estimate::Estimate;
use super::uncertainty::variance_of_magnitude;

/// Standard deviations beyond which one rest contradicts the calibration: one in 16,000.
const CONTRADICTS: f64 = 4.0;

/// What a calibration of a cheap part drifts by within hours, relative to gravity.
const UNSTABLE: f64 = 1e-3;

/// A rest shows one of six directions in which the parameters may be off; in the others it may
/// be more.
const UNSEEN: f64 = 2.0;

/// Gravity as it is measured at a rest: that of all rests at which it is off most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GravityMisfit {
    /// Start of the rest, s.
    pub rest_s: f64,
    /// Magnitude of the mean calibrated specific force at the rest, m/s².
    pub measured_mps2: f64,
    /// Local gravity, m/s².
    pub gravity_mps2: f64,
    /// Standard uncertainty of the difference that calibration and noise allow, m/s².
    pub sigma_mps2: f64,
    /// The difference contradicts the calibration, which no longer describes this sensor; the
    /// bands are widened by it.
    pub contradicts: bool,
}

impl GravityMisfit {
    /// Of the rests of `estimate`, the one at which gravity is off most, as `estimate` was calibrated or,
    /// with other `samples` of the same rows, in those; none without a rest.
    pub(super) fn worst(
        estimate: &Estimate,
        samples: &Samples,
        directions: &[ForceDirection],
        gravity_mps2: f64,
    ) -> Option<Self> {
        let rests = &estimate.rests_in(samples);
        let noise = estimate.motion.noise?;
        let noise = noise
            .force_mps2_sqrt_s
            .iter()
            .fold(0.0, |most: f64, n| most.max(*n));
        let t = samples.time_s();
        // The largest of many differences is larger by chance alone.
        let limit = (CONTRADICTS * CONTRADICTS + 2.0 * (rests.len().max(1) as f64).ln()).sqrt();
        let channels = samples.channels();
        rests
            .iter()
            .map(|rest| {
                let [x, y, z, ..] = channels.mean(rest);
                let measured_mps2 = norm(&[x, y, z]);
                let seconds = (t[rest.end - 1] - t[rest.start]).max(f64::MIN_POSITIVE);
                let unstable = UNSTABLE * gravity_mps2;
                let variance = variance_of_magnitude(directions, &[x, y, z])
                    .max(unstable * unstable)
                    + noise * noise / seconds;
                let mut one = GravityMisfit {
                    rest_s: t[rest.start],
                    measured_mps2,
                    gravity_mps2,
                    sigma_mps2: variance.sqrt(),
                    contradicts: false,
                };
                one.contradicts = one.sigmas() > limit;
                one
            })
            .max_by(|a, b| a.sigmas().total_cmp(&b.sigmas()))
    }

    /// The difference, in standard uncertainties.
    #[must_use]
    pub fn sigmas(&self) -> f64 {
        (self.measured_mps2 - self.gravity_mps2).abs() / self.sigma_mps2
    }

    /// Errors of every parameter that are as likely as what the rest shows.
    pub(super) fn directions(&self) -> Vec<ForceDirection> {
        let off = UNSEEN * (self.measured_mps2 - self.gravity_mps2).abs();
        let relative = off / self.gravity_mps2;
        ElementErrors {
            scale: relative,
            cross: relative,
            bias_mps2: off,
        }
        .directions()
    }
}
