//! What a fit could hide: the smallest error of one placement that shows, and what one
//! that does not show makes of ‖a‖.
//!
//! Baarda's internal and external reliability (A testing procedure for use in geodetic
//! networks, 1968), for an error of a mean along gravity, which is what ‖a‖ follows. With
//! d the whitened change of a placement's rows by an error of 1 m/s² (directions and
//! tilts eliminated), A their derivatives by the parameters and C the covariance:
//!
//! - the residuals show d with the redundancy λ = dᵀd − dᵀA C Aᵀd, so that
//!   w = dᵀr/√λ has unit variance and a mean of √λ for each m/s²;
//! - it moves the parameters by C Aᵀd, and ‖a‖ along n by h(n)ᵀ C Aᵀd.
//!
//! The scale of the residuals is not known, so w is held against Student's t, with the
//! scale of the *other* residuals, and with what is known of sensors before any residual
//! is seen (as bad poses are judged): an error of one placement cannot hide in the model
//! error that it makes itself.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::predicted::{self, sensitivity, sphere};
use crate::segment::face::angle_deg;
use crate::uncertainty::Covariance12;

/// What is known of χ² per degree of freedom before any residual is seen: about
/// 4 (real sensors miss the model by more than their noise; 8.8 was seen on 38
/// poses), worth as much as so many residuals. Few poses could say nothing else.
pub const USUAL_CHI2: f64 = 4.0;
/// … so many.
pub const USUAL_FREEDOM: f64 = 4.0;
/// A test is wrong so often at most, over all placements of a session; seldom in fact,
/// since few sensors scatter as much as is known before.
const CHANCE: f64 = 0.05;
/// Normal quantile of the power: an error that is shown in 90 of 100 sessions.
const POWER_90: f64 = 1.281_551_565_544_6;
/// Directions that are looked at.
const DIRECTIONS: usize = 400;
/// … and among which the next pose is chosen.
const CANDIDATES: usize = 100;
/// A pose closer than this to another is no new one, degrees: what a guided session calls the
/// same, and what a hand is off.
const APART_DEG: f64 = 33.0;
/// Residuals tell nothing of an error whose redundancy is less than this share of it:
/// rounding of a difference.
const NO_REDUNDANCY: f64 = 1e-9;

/// What the fit knows of one placement's error along gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseTest {
    /// Which placement.
    pub pose: usize,
    /// Aᵀd, by row-major M and b.
    pub influence: [f64; 12],
    /// dᵀd.
    pub weight: f64,
    /// dᵀr, r the whitened residuals of the fit.
    pub misfit: f64,
}

/// The placements of a fit, each to be tested against the others.
#[derive(Debug, Clone)]
pub struct Reliability {
    /// Covariance of M and b by the linearised fit.
    pub covariance: Covariance12,
    /// The placements that took part.
    pub tests: Vec<PoseTest>,
    /// Degrees of freedom of the residuals.
    pub freedom: f64,
    /// χ² of them by noise alone, over that.
    pub chi2_per_freedom: f64,
}

/// The error of one placement that does most harm unseen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undetected {
    /// Which placement.
    pub pose: usize,
    /// The smallest error of its mean along gravity that shows with 90 %, m/s².
    pub reading_mps2: f64,
    /// What it does to ‖a‖ in the worst direction, m/s².
    pub effect_mps2: f64,
    /// That direction.
    pub direction: [f64; 3],
}

impl Reliability {
    /// Squares of the whitened residuals, and what is known before them in the same
    /// units: a model error that was added to the noise shrinks both.
    fn squares(&self) -> (f64, f64) {
        let scale = self.chi2_per_freedom.max(1.0);
        let residuals = self.freedom * self.chi2_per_freedom / scale;
        (residuals, USUAL_FREEDOM * USUAL_CHI2 / scale)
    }

    /// Degrees of freedom of a scale without one residual, with those known before.
    fn known_by(&self) -> f64 {
        (self.freedom - 1.0).max(0.0) + USUAL_FREEDOM
    }

    /// |w| of one placement over its scale that chance exceeds in 5 % of sessions at most.
    fn limit(&self) -> f64 {
        let one = 0.5 * CHANCE / self.tests.len().max(1) as f64;
        StudentsT::new(0.0, 1.0, self.known_by())
            .map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - one))
    }

    /// C Aᵀd and λ of a placement.
    fn response(&self, test: &PoseTest) -> ([f64; 12], f64) {
        let moved = predicted::times(&self.covariance, &test.influence);
        let seen: f64 = moved.iter().zip(test.influence).map(|(m, a)| m * a).sum();
        (moved, test.weight - seen)
    }

    /// The placement that contradicts the others most, by the scale that these have,
    /// when it does so by more than chance; with how many times more.
    #[must_use]
    pub fn contradiction(&self) -> Option<(usize, f64)> {
        let (residuals, before) = self.squares();
        let limit = self.limit();
        self.tests
            .iter()
            .filter_map(|test| {
                let (_, redundancy) = self.response(test);
                if redundancy <= NO_REDUNDANCY * test.weight {
                    return None;
                }
                let square = test.misfit * test.misfit / redundancy;
                let scale = ((residuals - square).max(0.0) + before) / self.known_by();
                Some((test.pose, (square / scale).sqrt() / limit))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, excess)| *excess > 1.0)
    }

    /// The error of one placement that does most harm to ‖a‖ in any direction and is not
    /// shown with 90 % by the others; infinite where a placement has no others to be held
    /// against. None without placements.
    #[must_use]
    pub fn undetected(&self, matrix: &[[f64; 3]; 3], gravity: f64) -> Option<Undetected> {
        let (residuals, before) = self.squares();
        let own = residuals / self.freedom.max(1.0);
        let scale = ((residuals - own).max(0.0) + before) / self.known_by();
        let shown = (self.limit() + POWER_90) * scale.sqrt();
        let directions: Vec<([f64; 3], [f64; 12])> = sphere(DIRECTIONS)
            .map(|n| (n, sensitivity(matrix, n, gravity)))
            .collect();
        self.tests
            .iter()
            .filter_map(|test| {
                let (moved, redundancy) = self.response(test);
                let reading_mps2 = if redundancy <= NO_REDUNDANCY * test.weight {
                    f64::INFINITY
                } else {
                    shown / redundancy.sqrt()
                };
                let along = |h: &[f64; 12]| -> f64 {
                    h.iter().zip(moved).map(|(h, m)| h * m).sum::<f64>().abs()
                };
                let (direction, gain) = directions
                    .iter()
                    .map(|(n, h)| (*n, along(h)))
                    .max_by(|a, b| a.1.total_cmp(&b.1))?;
                Some(Undetected {
                    pose: test.pose,
                    reading_mps2,
                    effect_mps2: gain * reading_mps2,
                    direction,
                })
            })
            .max_by(|a, b| a.effect_mps2.total_cmp(&b.effect_mps2))
    }

    /// The direction of the free pose after which an undetected error does least to ‖a‖, with
    /// `noise` as in [`with_pose`](Self::with_pose); more than 33° from all of
    /// `recorded`. None without such a direction, or where every one leaves the error unlimited.
    #[must_use]
    pub fn best_test(
        &self,
        matrix: &[[f64; 3]; 3],
        recorded: &[[f64; 3]],
        noise: f64,
        gravity: f64,
    ) -> Option<[f64; 3]> {
        let is_new = |n: &[f64; 3]| recorded.iter().all(|r| angle_deg(*r, *n) > APART_DEG);
        let after = |n: [f64; 3]| {
            let more = self.with_pose(matrix, n, noise, gravity);
            let left = more.undetected(matrix, gravity);
            (n, left.map_or(f64::INFINITY, |u| u.effect_mps2))
        };
        let least = sphere(CANDIDATES).filter(is_new).map(after);
        let best = least.min_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, left)| left.is_finite()).map(|(n, _)| n)
    }

    /// The same session with one free pose more, read along `n` with the standard
    /// deviation `noise` of its length, m/s².
    #[must_use]
    pub fn with_pose(
        &self,
        matrix: &[[f64; 3]; 3],
        n: [f64; 3],
        noise: f64,
        gravity: f64,
    ) -> Reliability {
        let h = sensitivity(matrix, n, gravity);
        let mut out = self.clone();
        predicted::read_along(&mut out.covariance, &h, noise);
        let pose = self.tests.iter().map(|t| t.pose + 1).max().unwrap_or(0);
        out.tests.push(PoseTest {
            pose,
            influence: h.map(|v| v / (noise * noise)),
            weight: 1.0 / (noise * noise),
            misfit: 0.0,
        });
        out.freedom += 1.0;
        out
    }
}
