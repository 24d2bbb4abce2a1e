//! Does the calibration fit the recording it is applied to? At rest the calibrated magnitude is
//! gravity, to what its covariance and the noise of the mean allow. Where it is not, the
//! parameters are off by more than the covariance says, in directions that rests in one attitude
//! do not show: the bands then allow for an error of that size in each of them.

use std::ops::Range;

use gravical_core::matrix3::{dot, norm};
use serde::Serialize;

use super::anchors::{Anchors, RandomWalk, Side};
use super::parameters::{self, Assumed, Direction};
use super::samples::View;

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
    /// Of `rests`, the one at which gravity is off most; none without a rest.
    pub(super) fn worst(
        view: View<'_>,
        rests: &[Range<usize>],
        walk: RandomWalk,
        directions: &[Direction],
        gravity_mps2: f64,
    ) -> Option<Self> {
        let anchors = Anchors::new(view, walk);
        // The largest of many differences is larger by chance alone.
        let limit = (CONTRADICTS * CONTRADICTS + 2.0 * (rests.len().max(1) as f64).ln()).sqrt();
        (0..rests.len())
            .map(|k| {
                let rest = anchors.at(rests, k, Side::Last);
                let measured_mps2 = norm(&rest.force);
                let up = rest.force.map(|f| f / measured_mps2);
                let unstable = UNSTABLE * gravity_mps2;
                let variance: f64 = directions
                    .iter()
                    .map(|d| dot(&d.force(&rest.force), &up).powi(2))
                    .sum::<f64>()
                    .max(unstable * unstable)
                    + walk.accel_mean() / rest.seconds;
                let mut one = GravityMisfit {
                    rest_s: view.t_s()[rests[k].start],
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
    pub(super) fn directions(&self) -> Vec<Direction> {
        let off = UNSEEN * (self.measured_mps2 - self.gravity_mps2).abs();
        let relative = off / self.gravity_mps2;
        parameters::by_class(&Assumed {
            scale: relative,
            cross: relative,
            bias_mps2: off,
        })
    }
}
