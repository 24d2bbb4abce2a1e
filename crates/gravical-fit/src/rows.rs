//! What the poses say of the parameters, linearised: the rows of the least squares.
//!
//! With a = M⁻¹(u − b) a free pose has one row, ‖a‖ − g. A face has two more, the angles between a and
//! its axis, whose deviation is that of the tilt. The direction of a pose is thus eliminated in closed
//! form: one residual or three, and no local parameters.
//!
//! Everything that the search and the judgement need follows from these rows and one linear solution:
//! variances by their likelihood, poses left out, covariance by source. Near the solution the rows
//! are linear enough: an error of 1 % in M leaves 1e-4 of g.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

use crate::model::{
    BIAS, Covariance, DRIFT, NONLINEARITY, PARAMETERS, Parameters, bias, jacobian, matrix,
    nonlinear_error, tangents,
};
use crate::pose::{Face, Hint};

/// A pose in working units (M is about 1), and what the search found out about it.
#[derive(Debug, Clone, Default)]
pub(crate) struct PoseState {
    pub mean: Vector3<f64>,
    pub sd: Vector3<f64>,
    /// °C above the temperature of reference.
    pub warmer_c: f64,
    pub hint: Hint,
    pub face: Option<Face>,
    /// Left out since it contradicts the others: the probability that any good pose misses as much.
    pub bad: Option<f64>,
    /// Shortfall of ‖a‖ by tilts that the fit takes for misalignment, m/s².
    pub shortfall: f64,
    /// Standard deviation of an error of its length if it is taken for an outlier, m/s².
    pub outlier_sd: f64,
}

/// What is held while the parameters are fitted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hyperparameters {
    pub gravity: f64,
    /// Standard deviation of each of the two components of a face's tilt, rad.
    pub tilt: f64,
    /// Standard deviation of what the model misses of a reading, m/s².
    pub model_error: f64,
    /// Standard deviation of a nonlinearity coefficient, share of g at 1 g; 0: none.
    pub nonlinearity_sd: f64,
    /// The data sheet counts.
    pub prior: bool,
    /// The bias drifts with temperature, or moved.
    pub drift: bool,
    /// Standard deviation of that before any pose, m/s² for a `warmer_c` of 1; infinite if nothing is known.
    pub drift_sd: f64,
}

impl Hyperparameters {
    /// Without model error and nonlinearity: what noise alone explains.
    pub fn noise_only(&self) -> Hyperparameters {
        Hyperparameters {
            model_error: 0.0,
            nonlinearity_sd: 0.0,
            ..*self
        }
    }
}

/// M and its inverse at one point of the search.
struct Point {
    x: Parameters,
    inverse: Matrix3<f64>,
}

impl Point {
    fn new(x: &Parameters) -> Option<Point> {
        let inverse = matrix(x).try_inverse()?;
        let is_finite = inverse.iter().all(|v| v.is_finite());
        is_finite.then_some(Point { x: *x, inverse })
    }

    fn force(&self, pose: &PoseState) -> Vector3<f64> {
        self.inverse * (pose.mean - bias(&self.x, pose.warmer_c))
    }

    /// Length beyond g in m/s², and of a face the two angles off its axis in rad.
    fn residual(&self, pose: &PoseState, face: Option<Face>, gravity: f64) -> Vector3<f64> {
        let force = self.force(pose);
        let norm = force.norm();
        let long =
            norm + pose.shortfall - gravity * (1.0 + nonlinear_error(&self.x, &(force / norm)));
        let Some(face) = face else {
            return Vector3::new(long, 0.0, 0.0);
        };
        let axis = Vector3::from(face.direction());
        let off = axis.cross(&force).norm().atan2(axis.dot(&force));
        let stretch = if off > 1e-9 { off / off.sin() } else { 1.0 };
        let [first, second] = tangents(&axis).map(|t| stretch * t.dot(&force) / norm);
        Vector3::new(long, first, second)
    }

    /// How a residual follows the reading: the derivatives that its noise takes.
    fn by_reading(&self, pose: &PoseState, face: Option<Face>) -> Matrix3<f64> {
        let force = self.force(pose);
        let norm = force.norm();
        let aside = |face: Face| tangents(&face.direction().into()).map(|t| t / norm);
        let [first, second] = face.map_or_else(Default::default, aside);
        Matrix3::from_columns(&[force / norm, first, second]).transpose() * self.inverse
    }
}

/// Specific force of a pose in m/s², axes of the case.
pub(crate) fn force(x: &Parameters, pose: &PoseState) -> Option<Vector3<f64>> {
    Some(Point::new(x)?.force(pose))
}

/// Data sheet: scale ±3 %, cross-axis ±2 %, zero-g ±0.6 m/s². It speaks only of what a rotation of the
/// board in its case leaves alone.
fn data_sheet(x: &Parameters) -> DVector<f64> {
    let m = matrix(x);
    let row = |i: usize| m.row(i % 3).transpose();
    DVector::from_fn(9, |i, _| match i {
        0..3 => (row(i).norm() - 1.0) / 0.03,
        3..6 => row(i).normalize().dot(&row(i + 1).normalize()) / (0.02 * 2_f64.sqrt()),
        _ => x[BIAS + i - 6] / 0.6,
    })
}

/// The rows of one pose.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// The pose is not left out.
    pub counts: bool,
    pub residual: Vector3<f64>,
    pub jacobian: SMatrix<f64, 3, PARAMETERS>,
    /// The face that it is fitted as.
    pub face: Option<Face>,
    /// Covariance of the residual by the noise of the mean.
    pub noise: Matrix3<f64>,
    /// … by a model error of 1 m/s².
    pub error: Matrix3<f64>,
}

impl Row {
    /// Covariance by noise, model error and tilt.
    pub fn parts(&self, held: &Hyperparameters) -> [Matrix3<f64>; 3] {
        let tilt = held.tilt.powi(2);
        let tilts = Matrix3::from_diagonal(&Vector3::new(0.0, tilt, tilt));
        [self.noise, self.error * held.model_error.powi(2), tilts]
    }

    /// L⁻¹ of the covariance L Lᵀ; of a free pose only its first row counts.
    pub fn whitener(&self, held: &Hyperparameters) -> Option<Matrix3<f64>> {
        let [noise, error, tilt] = self.parts(held);
        if self.face.is_none() {
            let variance = noise[(0, 0)] + error[(0, 0)];
            let weight = 1.0 / variance.sqrt();
            let only = Matrix3::from_diagonal(&Vector3::new(weight, 0.0, 0.0));
            return weight.is_finite().then_some(only);
        }
        let root = (noise + error + tilt).cholesky()?.l();
        root.solve_lower_triangular(&Matrix3::identity())
    }
}

/// The problem linearised at `x`.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    pub x: Parameters,
    /// Which parameters are fitted.
    pub free: Vec<usize>,
    /// One for every pose.
    pub rows: Vec<Row>,
    /// Residuals of the data sheet and their derivatives.
    sheet: (DVector<f64>, DMatrix<f64>),
}

/// Sums of squares over poses: what a solution needs of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Normal {
    matrix: Covariance,
    gradient: Parameters,
    cost: f64,
    /// Logarithm of the determinant of the covariance of the rows.
    log_determinant: f64,
}

/// The least squares of a linearised problem.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    pub step: Parameters,
    /// Zero for what is not fitted.
    pub covariance: Covariance,
    /// Length of the step in its own standard deviations.
    pub decrement: f64,
    /// Restricted likelihood: parameters integrated out.
    pub log_likelihood: f64,
}

/// χ² of the lengths, and their degrees of freedom.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lengths {
    pub chi2: f64,
    pub freedom: f64,
}

impl Linear {
    /// `oriented`: faces hold the frame and have rows of their own. `free` are the parameters that
    /// are fitted.
    pub fn new(
        poses: &[PoseState],
        x: &Parameters,
        (oriented, free): (bool, &[usize]),
        held: &Hyperparameters,
    ) -> Option<Linear> {
        let face = |pose: &PoseState| pose.face.filter(|_| oriented);
        let residuals = |x: &Parameters| {
            let point = Point::new(x)?;
            let mut stacked = DVector::zeros(3 * poses.len());
            for (k, pose) in poses.iter().enumerate() {
                let residual = point.residual(pose, face(pose), held.gravity);
                stacked.fixed_rows_mut::<3>(3 * k).copy_from(&residual);
            }
            Some(stacked)
        };
        let point = Point::new(x)?;
        let (value, derivatives) = (residuals(x)?, jacobian(x, residuals)?);
        let row = |(k, pose): (usize, &PoseState)| {
            let by_reading = point.by_reading(pose, face(pose));
            let variance = Matrix3::from_diagonal(&pose.sd.component_mul(&pose.sd));
            let mut noise = by_reading * variance * by_reading.transpose();
            noise[(0, 0)] += pose.outlier_sd.powi(2);
            Row {
                counts: pose.bad.is_none(),
                residual: value.fixed_rows::<3>(3 * k).into_owned(),
                jacobian: derivatives
                    .fixed_view::<3, PARAMETERS>(3 * k, 0)
                    .into_owned(),
                face: face(pose),
                noise,
                error: by_reading * by_reading.transpose(),
            }
        };
        Some(Linear {
            x: *x,
            free: free.to_vec(),
            rows: poses.iter().enumerate().map(row).collect(),
            sheet: (data_sheet(x), jacobian(x, |x| Some(data_sheet(x)))?),
        })
    }

    /// The rows of the poses that count and are to be `kept`.
    fn kept(&self, keep: impl Fn(usize) -> bool) -> impl Iterator<Item = &Row> {
        let each = self.rows.iter().enumerate();
        each.filter_map(move |(k, row)| (row.counts && keep(k)).then_some(row))
    }

    /// Sums over the poses that are `kept`.
    pub fn normal(&self, held: &Hyperparameters, keep: impl Fn(usize) -> bool) -> Option<Normal> {
        let mut sum = Normal::default();
        for row in self.kept(keep) {
            let whitener = row.whitener(held)?;
            let residual = whitener * row.residual;
            sum.cost += residual.norm_squared();
            if row.face.is_some() {
                let jacobian = whitener * row.jacobian;
                sum.matrix += jacobian.tr_mul(&jacobian);
                sum.gradient += jacobian.tr_mul(&residual);
                sum.log_determinant -= 2.0 * whitener.diagonal().map(f64::ln).sum();
            } else {
                let weighted = whitener[(0, 0)] * row.jacobian.row(0).transpose();
                sum.matrix.ger(1.0, &weighted, &weighted, 1.0);
                sum.gradient += weighted * residual[0];
                sum.log_determinant -= 2.0 * whitener[(0, 0)].ln();
            }
        }
        Some(sum)
    }

    /// The least squares with the data sheet and the nonlinearity as `held` has them. None where some
    /// parameter is not determined at all.
    pub fn solve(&self, normal: &Normal, held: &Hyperparameters) -> Option<Solution> {
        let mut normal = normal.clone();
        if held.prior {
            let (residual, derivatives) = &self.sheet;
            normal.matrix += derivatives.transpose() * derivatives;
            normal.gradient += derivatives.transpose() * residual;
            normal.cost += residual.norm_squared();
        }
        if held.nonlinearity_sd > 0.0 {
            let weight = held.nonlinearity_sd.powi(-2);
            for i in NONLINEARITY..PARAMETERS {
                normal.matrix[(i, i)] += weight;
                normal.gradient[i] += weight * self.x[i];
                normal.cost += weight * self.x[i].powi(2);
                normal.log_determinant += 2.0 * held.nonlinearity_sd.ln();
            }
        }
        if held.drift && held.drift_sd.is_finite() {
            let weight = held.drift_sd.powi(-2);
            for i in DRIFT..NONLINEARITY {
                normal.matrix[(i, i)] += weight;
                normal.gradient[i] += weight * self.x[i];
                normal.cost += weight * self.x[i].powi(2);
                normal.log_determinant += 2.0 * held.drift_sd.ln();
            }
        }
        let is_fitted = |i: &usize| *i < NONLINEARITY || held.nonlinearity_sd > 0.0;
        let fitted: Vec<usize> = self.free.iter().copied().filter(is_fitted).collect();
        // Columns of length one: units differ.
        let scale = DVector::from_fn(fitted.len(), |i, _| {
            normal.matrix[(fitted[i], fitted[i])].sqrt().recip()
        });
        let scaled = DMatrix::from_fn(fitted.len(), fitted.len(), |i, k| {
            scale[i] * normal.matrix[(fitted[i], fitted[k])] * scale[k]
        });
        let root = scaled.cholesky()?;
        let pivots = root.l_dirty().diagonal();
        if !pivots.iter().all(|p| p.is_finite() && *p > MIN_PIVOT) {
            return None;
        }
        let inverse = root.inverse();
        let (mut step, mut covariance) = (Parameters::zeros(), Covariance::zeros());
        for (i, &p) in fitted.iter().enumerate() {
            for (k, &q) in fitted.iter().enumerate() {
                covariance[(p, q)] = scale[i] * inverse[(i, k)] * scale[k];
                step[p] -= covariance[(p, q)] * normal.gradient[q];
            }
        }
        let gained = -step.dot(&normal.gradient);
        let cost = normal.cost - gained;
        let log_determinant = 2.0 * (pivots.map(f64::ln).sum() - scale.map(f64::ln).sum());
        Some(Solution {
            step,
            covariance,
            decrement: gained.max(0.0).sqrt(),
            log_likelihood: -0.5 * (normal.log_determinant + log_determinant + cost),
        })
    }

    /// The least squares of the poses that are `kept`.
    pub fn solve_poses(
        &self,
        held: &Hyperparameters,
        keep: impl Fn(usize) -> bool,
    ) -> Option<Solution> {
        self.solve(&self.normal(held, keep)?, held)
    }

    /// Lengths alone show what the model misses: the angles of a face have a deviation of their own.
    pub fn lengths(
        &self,
        held: &Hyperparameters,
        solution: &Solution,
        keep: impl Fn(usize) -> bool,
    ) -> Lengths {
        let mut sum = Lengths::default();
        for row in self.kept(keep) {
            let variance = row.noise[(0, 0)] + row.error[(0, 0)] * held.model_error.powi(2);
            let derivative = row.jacobian.row(0);
            let residual = row.residual[0] + (derivative * solution.step)[0];
            let taken = (derivative * solution.covariance * derivative.transpose())[0];
            sum.chi2 += residual * residual / variance;
            sum.freedom += 1.0 - taken / variance;
        }
        sum
    }

    /// Sum of squares at another point, weights as at this one; none where it is not finite.
    pub fn cost_at(
        &self,
        poses: &[PoseState],
        x: &Parameters,
        held: &Hyperparameters,
    ) -> Option<f64> {
        let point = Point::new(x)?;
        let mut sum = 0.0;
        for (pose, row) in poses.iter().zip(&self.rows).filter(|(_, r)| r.counts) {
            let residual = point.residual(pose, row.face, held.gravity);
            sum += (row.whitener(held)? * residual).norm_squared();
        }
        if held.prior {
            sum += data_sheet(x).norm_squared();
        }
        if held.nonlinearity_sd > 0.0 {
            sum += x.fixed_rows::<6>(NONLINEARITY).norm_squared() / held.nonlinearity_sd.powi(2);
        }
        if held.drift {
            sum += x.fixed_rows::<3>(DRIFT).norm_squared() / held.drift_sd.powi(2);
        }
        sum.is_finite().then_some(sum)
    }
}

/// Pivots of the scaled normal equations below this are rounding: the direction is undetermined.
const MIN_PIVOT: f64 = 1e-7;

/// Which parameters are fitted: without faces on two axes the frame of the case is open, and M is
/// upper triangular in the axes of the channels (`channel_of` names that of each axis of the case).
pub(crate) fn free_parameters(
    oriented: bool,
    channel_of: [usize; 3],
    held: &Hyperparameters,
) -> Vec<usize> {
    let is_free = |i: &usize| match *i {
        0..BIAS => oriented || i / 3 <= channel_of[i % 3],
        DRIFT..NONLINEARITY => held.drift,
        NONLINEARITY.. => held.nonlinearity_sd > 0.0,
        _ => true,
    };
    (0..PARAMETERS).filter(is_free).collect()
}
