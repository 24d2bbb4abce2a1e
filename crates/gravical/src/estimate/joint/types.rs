//! What goes into the joint fit, and what comes out.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Elements, Role, Source};
use crate::calibration_file::TiltSource;
use crate::estimate::reliability::Reliability;
use crate::predicted;
use crate::segment::face::Face;
use crate::uncertainty::freedom_of_sum;

/// A mean reading at rest, in axes of the board.
#[derive(Debug, Clone, Copy)]
pub struct JointPose {
    /// Mean, input unit.
    pub mean: [f64; 3],
    /// Standard error of each component, input unit, above 0.
    pub standard_error: [f64; 3],
    /// What is known of its direction.
    pub role: Role,
    /// Mean temperature, °C; a pose without one counts as one at the mean of all.
    pub temperature_c: Option<f64>,
}

/// What is known beside the poses.
#[derive(Debug, Clone, Copy)]
pub struct JointOptions {
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Nominal scale, input unit per m/s²; none where the range is not known.
    pub nominal: Option<f64>,
    /// Use the data-sheet prior (needs the nominal scale).
    pub prior: bool,
    /// σ_tilt in rad; none: estimated.
    pub tilt: Option<f64>,
    /// What of the standard errors rounding makes, input unit; it only parts the
    /// sources of the covariance.
    pub quantisation: [f64; 3],
    /// M at the start, for a board that does not sit straight.
    pub start: Option<[[f64; 3]; 3]>,
    /// Which parameters are fitted; none: all, or what poses on too few faces determine.
    pub elements: Option<Elements>,
    /// Leave out poses that do not fit.
    pub find_bad: bool,
    /// Fit the drift of the bias with temperature, an offset per °C on each axis; M and b are
    /// then those at the mean temperature of the poses.
    pub drift: bool,
}

impl Default for JointOptions {
    /// Standard gravity, everything found out; no range is known.
    fn default() -> Self {
        JointOptions {
            gravity: STANDARD_GRAVITY_MPS2,
            nominal: None,
            prior: true,
            tilt: None,
            quantisation: [0.0; 3],
            start: None,
            elements: None,
            find_bad: true,
            drift: false,
        }
    }
}

/// What became of a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedPose {
    /// The face it was fitted as.
    pub face: Option<Face>,
    /// Unit vector of specific force, board axes.
    pub direction: [f64; 3],
    /// Fitted tilt and its standard deviation, rad, of a face.
    pub tilt: Option<(f64, f64)>,
    /// Left out as a bad one: the probability that a good one misses as much.
    pub bad: Option<f64>,
    /// ‖a‖ − g when it and its neighbours within 25° are left out, m/s².
    pub left_out_error: Option<f64>,
    /// Standard deviation that this error should have, by the fit without them
    /// and the noise of the mean, m/s².
    pub left_out_sd: Option<f64>,
}

/// Drift of the bias with temperature, fitted with M and b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasDrift {
    /// Temperature at which M and b are valid, °C: the mean of the poses.
    pub reference_c: f64,
    /// Input unit per °C.
    pub per_c: [f64; 3],
    /// Standard deviation of these.
    pub sd: [f64; 3],
}

/// The fitted accelerometer.
#[derive(Debug, Clone)]
pub struct JointFit {
    /// M of u = M a + b, axes of the board, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// b, input unit.
    pub bias: [f64; 3],
    /// Drift of b, where it was fitted.
    pub drift: Option<BiasDrift>,
    /// Of M (row-major) and b, directions marginalised.
    pub covariance: [[f64; 12]; 12],
    /// The covariance by what it comes from.
    pub sources: Vec<(Source, [[f64; 12]; 12])>,
    /// What it could hide; none where the readings leave less than one degree of
    /// freedom.
    pub reliability: Option<Reliability>,
    /// For every pose.
    pub poses: Vec<FittedPose>,
    /// Of each disputed direction the poses that contradict each other, on two sides: nothing
    /// tells which are right, and all of them count.
    pub disputed: Vec<[Vec<usize>; 2]>,
    /// σ_tilt, rad.
    pub tilt: f64,
    /// How it is known.
    pub tilt_from: TiltSource,
    /// Well-determined tilt components (degrees of freedom of σ_tilt).
    pub gamma: f64,
    /// Standard deviation added to every mean, input unit.
    pub model_error: f64,
    /// χ² of the readings by their standard errors alone, over its degrees of
    /// freedom; none without any.
    pub chi2_per_freedom: Option<f64>,
    /// Degrees of freedom of the readings.
    pub freedom: f64,
    /// Condition of what the magnitudes alone say of their nine parameters
    /// (M Mᵀ and b), columns of length one; infinite for fewer than nine poses.
    pub condition: f64,
    /// False when too few faces tell how the frame lies: M is upper triangular
    /// then.
    pub oriented: bool,
    /// Repeats of faces lay the same way and were fitted with one tilt.
    pub shared_tilts: bool,
}

/// Two-sided 95 % quantile of the normal distribution.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

impl JointFit {
    /// So many standard deviations of hᵀ(M, b) make a 95 % interval. An estimated
    /// tilt is known by γ components only: Student's t for the part of the
    /// variance that follows from it, by the effective degrees of freedom of
    /// Welch and Satterthwaite (JCGM 100:2008, G.4); the normal quantile else.
    #[must_use]
    pub fn coverage_factor_95(&self, h: &[f64; 12]) -> f64 {
        if self.tilt_from != TiltSource::Estimated {
            return NORMAL_95;
        }
        let (mut tilt, mut all) = (0.0, 0.0);
        for (source, part) in &self.sources {
            let variance = predicted::variance(part, h);
            all += variance;
            if *source == Source::Tilt {
                tilt = variance;
            }
        }
        let share: f64 = tilt / all;
        let freedom = self.gamma / (share * share);
        if freedom.is_nan() || freedom > 1e6 {
            return NORMAL_95;
        }
        StudentsT::new(0.0, 1.0, freedom).map_or(NORMAL_95, |t| t.inverse_cdf(0.975))
    }

    /// How much wider an interval for hᵀ(M, b), of the variance `whole`, has to be than
    /// one of a variance that is known: tilt and model error were estimated, from γ
    /// components and from what the readings leave over.
    #[must_use]
    pub fn widening(&self, h: &[f64; 12], whole: f64) -> f64 {
        let parts: Vec<(f64, Option<f64>)> = self
            .sources
            .iter()
            .map(|(source, part)| {
                let known_by = match source {
                    Source::Tilt if self.tilt_from == TiltSource::Estimated => Some(self.gamma),
                    Source::ModelError => Some(self.freedom.max(1.0)),
                    _ => None,
                };
                (predicted::variance(part, h), known_by)
            })
            .collect();
        let known: f64 = parts.iter().map(|(variance, _)| variance).sum();
        let rest = [((whole - known).max(0.0), None)];
        let all: Vec<_> = parts.into_iter().chain(rest).collect();
        freedom_of_sum(&all)
            .filter(|nu| *nu < 1e6)
            .and_then(|nu| StudentsT::new(0.0, 1.0, nu).ok())
            .map_or(1.0, |t| t.inverse_cdf(0.975) / NORMAL_95)
    }
}

/// Why there is no fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointError {
    /// No pose, or a mean that is no number.
    NoPoses,
    /// Poses leave parameters open: along this direction (board axes) ‖a‖ is
    /// known to no better than `sd` m/s² (infinite without a prior).
    Undetermined {
        /// The direction that is known least.
        direction: [f64; 3],
        /// Standard deviation of ‖a‖ there.
        sd: f64,
    },
    /// The search did not end at a minimum.
    NotConverged,
}
