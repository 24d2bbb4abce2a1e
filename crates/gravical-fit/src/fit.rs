//! Poses in, M and b with their covariance out.

use gravical_core::matrix3;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::model::{BIAS, DRIFT, NONLINEARITY, Parameters, matrix, median};
use crate::pose::{Face, Pose};
use crate::rows::{Hyperparameters, Linear, PoseState};
use crate::search::{
    Found, MAX_SESSION, Search, USUAL_NONLINEARITY, USUAL_TILT_DEG, assign_first_roles, least_known,
};
use crate::sensor::{Gravity, Sensor};
use crate::sphere::centre;

/// What is known beside the poses.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Its standard uncertainty, m/s².
    pub gravity_sd: f64,
    /// Nominal scale, input unit per m/s²; none if the range is not known.
    pub nominal: Option<f64>,
    /// Use what a data sheet says of scale, cross-axis sensitivity and zero-g offset; needs the nominal
    /// scale.
    pub prior: bool,
    /// Standard deviation of each of the two components of a face's tilt, rad; none: estimated.
    pub tilt: Option<f64>,
    /// M to start with, input unit per m/s²: how the board sits in its case. None: straight.
    pub start: Option<[[f64; 3]; 3]>,
    /// Fit a drift of the bias with temperature; M and b are then those at the mean temperature.
    pub drift: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            gravity: gravical_core::unit::STANDARD_GRAVITY_MPS2,
            gravity_sd: 0.0,
            nominal: None,
            prior: true,
            tilt: None,
            start: None,
            drift: false,
        }
    }
}

/// The poses leave some direction open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undetermined {
    /// Direction in which ‖a‖ is known least, axes of the case.
    pub direction: [f64; 3],
    /// Its standard deviation there, m/s²; infinite if nothing limits it.
    pub sd_mps2: f64,
}

/// What became of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FittedPose {
    /// The face that it was fitted as.
    pub face: Option<Face>,
    /// Angle to its face and the standard deviation of its components, rad.
    pub tilt: Option<(f64, f64)>,
    /// Left out since it contradicts the others: the probability that any good pose misses as much.
    pub bad: Option<f64>,
}

/// Drift of the bias with temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasDrift {
    /// Temperature for which M and b hold, °C: the mean of the poses.
    pub reference_c: f64,
    /// Input unit per °C.
    pub per_c: [f64; 3],
    /// Standard deviations of these.
    pub sd: [f64; 3],
}

/// Quality of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FitQuality {
    /// χ² of the readings with the noise of their means, over its degrees of freedom; null
    /// without any. Above 1 the sensor deviates from the model by more than noise.
    pub chi2_per_freedom: Option<f64>,
    /// Degrees of freedom of the readings.
    pub freedom: f64,
    /// Standard deviation added to every mean so that χ² equals its expected value, m/s²;
    /// included in the covariance.
    pub model_error_mps2: f64,
    /// False if too few faces determine the orientation of the sensor frame in the case; the
    /// matrix is then triangular by convention.
    pub oriented: bool,
    /// Components of the tilts that the data determine.
    pub tilt_degrees_of_freedom: f64,
    /// The data sheet was used.
    pub prior: bool,
}

/// The fitted accelerometer.
#[derive(Debug, Clone)]
pub struct Fit {
    pub(crate) search: Search,
    /// The problem at the solution.
    pub(crate) linear: Linear,
    /// The calibration as numbers, working units.
    pub(crate) working_sensor: Sensor,
    /// How well the poses suit the model.
    pub quality: FitQuality,
}

/// σ(‖a‖) above this fraction of g in some direction counts as undetermined: the data sheet alone says
/// as much.
const UNDETERMINED: f64 = 0.028;
/// Readings closer than this, as an angle or as a share of g, are those of a sensor that was not moved.
const SAME_PLACEMENT: f64 = 0.3 * std::f64::consts::PI / 180.0;

/// The search brought to rest, without the poses that contradict the others.
pub(crate) fn converged(
    mut search: Search,
    poses: &[Pose],
    options: &Options,
) -> Result<Fit, Undetermined> {
    let open = || Undetermined::of(poses);
    let mut found = search.converge().ok_or_else(open)?;
    let mut suspects = search.suspects();
    while suspects.iter().any(|(k, _)| search.is_outlier(*k, &found)) {
        for (k, chance) in suspects {
            search.poses[k].bad = Some(chance);
        }
        found = search.converge().ok_or_else(open)?;
        suspects = search.suspects();
    }
    let (direction, sd_mps2) = least_known(&found, options.gravity).ok_or_else(open)?;
    if sd_mps2.is_nan() || sd_mps2 > UNDETERMINED * options.gravity {
        return Err(Undetermined {
            direction: direction.into(),
            sd_mps2,
        });
    }
    let Found { linear, solution } = &found;
    let lengths = linear.lengths(&search.held, solution, |_| true);
    let bare = search.held.noise_only();
    let alone = search.fit(&bare).ok_or_else(open)?;
    let noise = alone.linear.lengths(&bare, &alone.solution, |_| true);
    Ok(Fit {
        working_sensor: Sensor {
            parameters: linear.x,
            covariance: found.solution.covariance,
            gravity: Gravity {
                value_mps2: options.gravity,
                sd_mps2: options.gravity_sd,
            },
            model_error_mps2: search.held.model_error,
        },
        quality: FitQuality {
            chi2_per_freedom: (noise.freedom >= 1.0).then(|| noise.chi2 / noise.freedom),
            freedom: lengths.freedom,
            model_error_mps2: search.held.model_error,
            oriented: search.is_oriented(),
            tilt_degrees_of_freedom: tilt_freedom(&search, &found),
            prior: search.held.prior,
        },
        search,
        linear: found.linear,
    })
}

/// The search with the poses in working units, repeats merged, and their first roles.
pub(crate) fn prepare(poses: &[Pose], options: &Options) -> Option<Search> {
    let is_finite = |pose: &Pose| {
        matrix3::norm(&pose.mean).is_finite()
            && pose.sd.iter().all(|s| s.is_finite() && *s > 0.0)
            && pose.temperature_c.is_none_or(f64::is_finite)
    };
    if poses.is_empty() || !poses.iter().all(is_finite) {
        return None;
    }
    let centre = centre(poses.iter().map(|p| &p.mean));
    let lengths = poses
        .iter()
        .map(|p| matrix3::norm(&matrix3::sub(&p.mean, &centre)));
    let usual = median(lengths.collect()) / options.gravity;
    if usual.is_nan() || usual <= 0.0 {
        return None;
    }
    // A nominal scale that gravity contradicts is a wrong unit or range: no knowledge.
    let nominal = options
        .nominal
        .filter(|n| (0.8..1.25).contains(&(usual / n)));
    let scale = nominal.unwrap_or(usual);
    let known = poses.iter().filter_map(|p| p.temperature_c);
    let reference_c = known.clone().sum::<f64>() / known.count() as f64;
    let start = options.start.map_or_else(Matrix3::identity, |rows| {
        Matrix3::from(rows).transpose() / scale
    });
    let mut placed = Vec::new();
    let mut place_of = Vec::new();
    for pose in poses {
        let one = PoseState {
            mean: Vector3::from(pose.mean) / scale,
            sd: Vector3::from(pose.sd) / scale,
            warmer_c: pose.temperature_c.map_or(0.0, |t| t - reference_c),
            hint: pose.hint,
            ..PoseState::default()
        };
        place_of.push(place(&mut placed, one, poses.len(), options.gravity));
    }
    let mut search = Search {
        poses: placed.into_iter().map(|(pose, _)| pose).collect(),
        place_of,
        scale,
        reference_c,
        held: Hyperparameters {
            gravity: options.gravity,
            // Exact faces; a tilt of zero would divide by it.
            tilt: options
                .tilt
                .unwrap_or(USUAL_TILT_DEG.to_radians())
                .max(1e-7),
            model_error: 0.0,
            nonlinearity_sd: USUAL_NONLINEARITY.0,
            prior: options.prior && nominal.is_some(),
            drift: options.drift,
            drift_sd: f64::INFINITY,
        },
        typical_nonlinearity: USUAL_NONLINEARITY.0,
        is_linear: false,
        tilt: options.tilt,
        channel_of: std::array::from_fn(|axis| start.column(axis).iamax()),
        x: Parameters::from_fn(|i, _| match i {
            0..BIAS => start[(i / 3, i % 3)],
            BIAS..DRIFT => centre[i - BIAS] / scale,
            _ => 0.0,
        }),
    };
    assign_first_roles(&mut search.poses, &search.x);
    Some(search)
}

/// Merges a pose into one that it repeats, or adds it; its place.
fn place(placed: &mut Vec<(PoseState, f64)>, pose: PoseState, count: usize, gravity: f64) -> usize {
    let same = |(other, _): &(PoseState, f64)| {
        other.hint == pose.hint
            && (other.mean - pose.mean).norm() < SAME_PLACEMENT * gravity
            && count <= MAX_SESSION
    };
    let Some(k) = placed.iter().position(same) else {
        placed.push((pose, 1.0));
        return placed.len() - 1;
    };
    let (other, times) = &mut placed[k];
    let sum = *times + 1.0;
    other.mean = (other.mean * *times + pose.mean) / sum;
    other.warmer_c = (other.warmer_c * *times + pose.warmer_c) / sum;
    other.sd = other
        .sd
        .zip_map(&pose.sd, |a, b| (a * *times).hypot(b) / sum);
    *times = sum;
    k
}

impl Undetermined {
    /// Where nothing limits the direction that the readings cover least.
    pub(crate) fn of(poses: &[Pose]) -> Undetermined {
        let means = poses.iter().map(|p| Vector3::from(p.mean));
        let means = means.filter(|mean| mean.norm().is_finite());
        let directions = means.map(|mean| mean.try_normalize(0.0).unwrap_or_default());
        let spread: Matrix3<f64> = directions.map(|n| n * n.transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        Undetermined {
            direction: eigen.eigenvectors.column(least).into_owned().into(),
            sd_mps2: f64::INFINITY,
        }
    }
}

/// Degrees of freedom of the angles of faces, less what the parameters take of them.
fn tilt_freedom(search: &Search, found: &Found) -> f64 {
    let mut freedom = 0.0;
    let rows = found.linear.rows.iter();
    for row in rows.filter(|row| row.face.is_some() && row.counts) {
        if let Some(whitener) = row.whitener(&search.held) {
            let jacobian = whitener * row.jacobian;
            let taken = jacobian * found.solution.covariance * jacobian.transpose();
            freedom += 2.0 - taken[(1, 1)] - taken[(2, 2)];
        }
    }
    freedom
}

impl Fit {
    /// M of u = M a + b, input unit per m/s², row-major.
    pub fn model(&self) -> [[f64; 3]; 3] {
        let m = matrix(&self.linear.x) * self.search.scale;
        std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
    }

    /// b, input unit.
    pub fn bias(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.linear.x[BIAS + i] * self.search.scale)
    }

    /// Drift of b, if it was fitted.
    pub fn drift(&self) -> Option<BiasDrift> {
        let sd = |i: usize| self.working_sensor.covariance[(DRIFT + i, DRIFT + i)].sqrt();
        self.search.held.drift.then(|| BiasDrift {
            reference_c: self.search.reference_c,
            per_c: std::array::from_fn(|i| self.linear.x[DRIFT + i] * self.search.scale),
            sd: std::array::from_fn(|i| sd(i) * self.search.scale),
        })
    }

    /// Nonlinearity of the axes: what a nonlinear response adds to ‖a‖ in units of g at 1 g, quadratic then
    /// cubic, x y z each. They are shown and not applied.
    pub fn nonlinearity(&self) -> [f64; 6] {
        std::array::from_fn(|i| self.linear.x[NONLINEARITY + i])
    }

    /// Covariance of row-major M, b and the nonlinearity, gravity's uncertainty included, units as those.
    pub fn covariance(&self) -> [[f64; 18]; 18] {
        let of = |i: usize| {
            if i < DRIFT {
                i
            } else {
                i + NONLINEARITY - DRIFT
            }
        };
        let all = self.sensor(1.0).covariance_with_gravity();
        std::array::from_fn(|i| std::array::from_fn(|k| all[(of(i), of(k))]))
    }

    /// The calibration as numbers, for readings in units of `unit`.
    pub fn sensor(&self, unit: f64) -> Sensor {
        self.working_sensor
            .clone()
            .rescaled(unit / self.search.scale)
    }

    /// Standard deviation of each component of a face's tilt, rad.
    pub fn tilt(&self) -> f64 {
        self.search.held.tilt
    }

    /// What became of each pose.
    pub fn poses(&self) -> Vec<FittedPose> {
        let fitted = |&k: &usize| {
            let row = &self.linear.rows[k];
            let variance = row.jacobian * self.working_sensor.covariance * row.jacobian.transpose();
            let sd = (0.5 * (variance[(1, 1)] + variance[(2, 2)]))
                .max(0.0)
                .sqrt();
            let angle = row.residual[1].hypot(row.residual[2]);
            FittedPose {
                face: row.face,
                tilt: row.face.map(|_| (angle, sd)),
                bad: self.search.poses[k].bad,
            }
        };
        self.search.place_of.iter().map(fitted).collect()
    }
}
