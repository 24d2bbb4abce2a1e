//! E and β from motions: first by Cauchy's loss, then by least squares of the motions that agree.

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

use super::rest::unexplained;
use super::{FittedMotion, GyroRest, MotionFit};
use crate::model::median;

/// Nine elements of E, row-major, then β.
pub(super) type Parameters = SVector<f64, 12>;
/// A covariance of these, or its inverse.
pub(super) type Square = SMatrix<f64, 12, 12>;

/// A motion from one rest to the next.
pub(super) struct Path {
    /// Rate in rad/s by the nominal scale, bias taken off, and the time to the next sample, s.
    pub samples: Vec<(Vector3<f64>, f64)>,
    /// Unit vectors of specific force before and after, axes of the accelerometer.
    pub gravity: [Vector3<f64>; 2],
    /// Standard deviation of each component of what is left, rad: directions of gravity, noise, drift.
    pub sd: f64,
}

/// A residual this many times the usual one contradicts the others.
const OUTLIER: f64 = 6.0;
/// … unless the others predict it within so many standard deviations.
const PREDICTED: f64 = 5.0;
/// Median length of two normal components of unit variance.
const RAYLEIGH_MEDIAN: f64 = 1.1774;
/// Width of Cauchy's loss, 95 % as efficient as least squares on normal residuals.
const CAUCHY: f64 = 2.385;
/// Passes over the samples; three are usual.
const MAX_PASSES: usize = 15;
/// A pass that moves no residual by more than this fraction of the usual one is the last.
const SETTLED: f64 = 0.01;
/// No direction and no turn is known better, rad: 0.00006°.
pub(super) const FLOOR: f64 = 1e-6;

/// One motion at a state: gravity as it was, turned into the sensor after the motion, less gravity as it
/// is there; and its derivatives.
struct Linear {
    residual: Vector3<f64>,
    jacobian: SMatrix<f64, 3, 12>,
}

impl Linear {
    /// A small change of the parameters turns the result by ψ = Σ w A (δE (y − β) − E δβ), seen from the
    /// start, w being the weights of the trapezoid and A the attitudes: dr = C (v₀ × ψ).
    fn new(motion: &Path, x: &Parameters) -> Linear {
        let e = Matrix3::from_fn(|r, c| x[3 * r + c]);
        let (attitude, sums) = turned(&motion.samples, &e, Vector3::new(x[9], x[10], x[11]));
        let rotation = attitude.transpose();
        let [before, after] = motion.gravity;
        let by_turn = rotation * before.cross_matrix();
        let by_bias = Matrix3::from_fn(|k, r| sums[(3 * r + k, 3)]) * e;
        let jacobian = SMatrix::from_fn(|i, p| {
            let each = (0..3).map(|k| match p {
                0..9 => by_turn[(i, k)] * sums[(3 * (p / 3) + k, p % 3)],
                _ => -by_turn[(i, k)] * by_bias[(k, p - 9)],
            });
            each.sum::<f64>()
        });
        Linear {
            residual: rotation * before - after,
            jacobian,
        }
    }

    fn after(&self, step: &Parameters) -> Vector3<f64> {
        self.residual + self.jacobian * step
    }
}

/// Attitude (sensor at the end to sensor at the start) and Σ w A ⊗ (y − β, 1): a row for each element of A,
/// column by column. Over one sample the rate is a straight line: it turns by h (ω₀ + ω₁)/2 + h²/12 ω₀ × ω₁
/// (Magnus' series).
fn turned(
    samples: &[(Vector3<f64>, f64)],
    e: &Matrix3<f64>,
    bias: Vector3<f64>,
) -> (Matrix3<f64>, SMatrix<f64, 9, 4>) {
    let mut sums = SMatrix::<f64, 9, 4>::zeros();
    let mut q = UnitQuaternion::identity();
    let mut attitude = Matrix3::identity();
    let mut before: Option<(Vector3<f64>, f64)> = None;
    for &(reading, to_next) in samples {
        let y = reading - bias;
        let rate = e * y;
        let mut weight = 0.5 * to_next; // 0 in the last sample
        if let Some((last, h)) = before {
            let turn = 0.5 * h * (last + rate) + h * h / 12.0 * last.cross(&rate);
            q *= UnitQuaternion::from_scaled_axis(turn);
            attitude = q.to_rotation_matrix().into_inner();
            weight += 0.5 * h;
        }
        let elements = SVector::<f64, 9>::from_column_slice(attitude.as_slice());
        sums += elements * (weight * y.push(1.0)).transpose();
        before = Some((rate, to_next));
    }
    q.renormalize();
    (q.to_rotation_matrix().into_inner(), sums)
}

/// The motions at one state.
pub(super) struct At {
    x: Parameters,
    linear: Vec<Linear>,
    /// Median length of the residuals, rad.
    pub typical: f64,
}

impl At {
    /// Lengths of the residuals after a step, rad.
    fn lengths(&self, step: &Parameters) -> Vec<f64> {
        self.linear.iter().map(|l| l.after(step).norm()).collect()
    }

    /// How far a step moves a residual at most, rad.
    fn largest_move(&self, step: &Parameters) -> f64 {
        let moves = self.linear.iter().map(|l| (l.jacobian * step).norm());
        moves.fold(0.0, f64::max)
    }
}

/// What is fitted.
pub(super) struct Problem<'a> {
    pub motions: Vec<Path>,
    pub rest: &'a GyroRest,
    /// Rad/s per input unit.
    pub unit: f64,
}

/// Least squares at one state.
pub(super) struct Solved {
    step: Parameters,
    pub covariance: Square,
}

impl Problem<'_> {
    pub fn start(&self, e: &Matrix3<f64>) -> At {
        self.at(Parameters::from_fn(|i, _| {
            if i < 9 { e[(i / 3, i % 3)] } else { 0.0 }
        }))
    }

    fn at(&self, x: Parameters) -> At {
        let linear: Vec<Linear> = self.motions.iter().map(|m| Linear::new(m, &x)).collect();
        let typical = median(linear.iter().map(|l| l.residual.norm()).collect());
        At { x, linear, typical }
    }

    /// Least squares with a weight for each motion; β is held to the rests.
    pub fn solve(&self, at: &At, weights: &[f64]) -> Option<Solved> {
        // Directions that nothing shows stay where they are.
        let mut normal = Square::from_diagonal_element(1e-4);
        let mut gradient = Parameters::zeros();
        for i in 0..3 {
            let sd = self.rest.noise_sd[i] * self.unit.abs();
            let weight = sd.max(1e-9).powi(-2);
            normal[(9 + i, 9 + i)] += weight;
            gradient[9 + i] += weight * at.x[9 + i];
        }
        for (linear, weight) in at.linear.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            normal += *weight * linear.jacobian.tr_mul(&linear.jacobian);
            gradient += *weight * linear.jacobian.tr_mul(&linear.residual);
        }
        let covariance = inverse(&normal)?;
        Some(Solved {
            step: -(covariance * gradient),
            covariance,
        })
    }

    /// Of the motions that are `used`, with a variance beside that of noise; 0 for the others.
    pub fn weights(&self, used: &[bool], more: f64) -> Vec<f64> {
        let weight = |(motion, used): (&Path, &bool)| {
            f64::from(u8::from(*used)) / (motion.sd * motion.sd + more)
        };
        self.motions.iter().zip(used).map(weight).collect()
    }

    /// Median of the residuals in their standard deviations over that of noise, at least 1.
    fn excess(&self, lengths: &[f64]) -> f64 {
        let whitened = lengths.iter().zip(&self.motions).map(|(l, m)| l / m.sd);
        (median(whitened.collect()) / RAYLEIGH_MEDIAN).max(1.0)
    }

    /// Minimises Cauchy's loss, its width following the residuals.
    pub fn robust(&self, start: At) -> Option<At> {
        let mut best = start;
        let mut share = 1.0;
        for _ in 0..MAX_PASSES {
            let step = share * self.robust_step(&best)?;
            let moves = best.largest_move(&step);
            let next = self.at(best.x + step);
            // Far from the answer a linear step may lead astray.
            if next.typical.is_nan() || next.typical > 1.5 * best.typical {
                share *= 0.3;
                if share < 0.01 {
                    break;
                }
                continue;
            }
            share = 1.0;
            best = next;
            if moves < SETTLED * best.typical.max(FLOOR) {
                break;
            }
        }
        Some(best)
    }

    /// Weights and step in turn, on the linear problem.
    fn robust_step(&self, at: &At) -> Option<Parameters> {
        let mut step = Parameters::zeros();
        for _ in 0..10 {
            let lengths = at.lengths(&step);
            let width = CAUCHY * self.excess(&lengths);
            let weight = |(length, motion): (&f64, &Path)| {
                let whitened = length / motion.sd;
                motion.sd.powi(-2) / (1.0 + (whitened / width).powi(2))
            };
            let weights: Vec<f64> = lengths.iter().zip(&self.motions).map(weight).collect();
            step = self.solve(at, &weights)?.step;
        }
        Some(step)
    }

    /// Motions that agree. Where too few or too many do not, none can be called wrong.
    fn judge(&self, lengths: &[f64]) -> Vec<bool> {
        let count = lengths.len();
        // Nine parameters take up part of few residuals.
        let taken_up = (2.0 * count as f64 / (2.0 * count as f64 - 9.0).max(1.0)).sqrt();
        let limit = OUTLIER * taken_up * self.excess(lengths);
        let agrees = |(length, motion): (&f64, &Path)| *length <= limit * motion.sd;
        let used: Vec<bool> = lengths.iter().zip(&self.motions).map(agrees).collect();
        let kept = used.iter().filter(|u| **u).count();
        if 2 * kept < 9 + 6 || (count - kept) * 5 > count {
            return vec![true; count];
        }
        used
    }

    /// Least squares of the motions that agree. Where motions are few, a robust fit may follow some of them
    /// too closely: a motion that it rejected is admitted again if the others predict it. The covariance is that
    /// of E and β.
    pub fn settle(&self, robust: At) -> Option<(Square, MotionFit)> {
        let typical = robust.typical;
        let mut used = self.judge(&robust.lengths(&Parameters::zeros()));
        let mut at = robust;
        for pass in 1.. {
            let count = used.iter().filter(|u| **u).count();
            let freedom = 2.0 * count as f64 - 9.0;
            if freedom < 3.0 {
                break;
            }
            let step = self.solve(&at, &self.weights(&used, 0.0))?.step;
            // What noise does not explain, the same for every motion: a hand that trembles, a gyroscope that
            // is not linear.
            let squares: Vec<f64> = at.lengths(&step).iter().map(|l| l * l).collect();
            let more = unexplained(freedom, squares.iter().sum(), |more| {
                let weights = self.weights(&used, more);
                Some(weights.iter().zip(&squares).map(|(w, l)| w * l).sum())
            })?;
            let weights = self.weights(&used, more);
            let solved = self.solve(&at, &weights)?;
            let again: Vec<bool> = (0..used.len())
                .map(|m| used[m] || self.deviation(&at, &solved, m, more) < PREDICTED)
                .collect();
            let usual = median(at.lengths(&solved.step));
            let settled = at.largest_move(&solved.step) < SETTLED * usual.max(FLOOR);
            if !(pass == MAX_PASSES || (settled && again == used)) {
                used = again;
                at = self.at(at.x + solved.step);
                continue;
            }
            // Few residuals say badly how large they are: the variance of Student's t.
            let wider = if more > 0.0 {
                freedom / (freedom - 2.0)
            } else {
                1.0
            };
            // A motion's residual if it takes no part is (I − H)⁻¹ r, H = w J C Jᵀ.
            let motion = |m: usize| {
                let jacobian = at.linear[m].jacobian;
                let residual = at.linear[m].after(&solved.step);
                let hat = weights[m] * jacobian * solved.covariance * jacobian.transpose();
                let without = (Matrix3::identity() - hat).try_inverse();
                FittedMotion {
                    used: used[m],
                    residual: residual.norm(),
                    left_out: without
                        .filter(|_| used[m] && 2 * count >= 9 + 4)
                        .map(|inverse| (inverse * residual).norm()),
                }
            };
            let covariance = solved.covariance * wider;
            let motions = (0..used.len()).map(motion).collect();
            let fit = self.result(at.x + solved.step, covariance, motions, typical)?;
            return Some((covariance, fit));
        }
        None
    }

    /// In input units: δM = −E⁻¹ δE E⁻¹ / unit, δb = δβ / unit. None where a number is none.
    fn result(
        &self,
        x: Parameters,
        covariance: Square,
        motions: Vec<FittedMotion>,
        typical_rad: f64,
    ) -> Option<MotionFit> {
        let (rest, unit) = (self.rest, self.unit);
        let e = Matrix3::from_row_slice(&x.as_slice()[..9]);
        let inverse = e.try_inverse()?;
        let to_model = Square::from_fn(|to, from| match (to, from) {
            (0..9, 0..9) => -inverse[(to / 3, from / 3)] * inverse[(from % 3, to % 3)] / unit,
            _ => f64::from(to == from) / unit,
        });
        let mut covariance = to_model * covariance * to_model.transpose();
        for i in 0..3 {
            let drift = rest.bias_sd[i].powi(2) - rest.noise_sd[i].powi(2);
            covariance[(9 + i, 9 + i)] += drift.max(0.0);
        }
        let covariance = 0.5 * (covariance + covariance.transpose());
        let numbers = covariance.iter().chain(&x);
        let is_finite = numbers.chain(&inverse).all(|v| v.is_finite());
        is_finite.then(|| MotionFit {
            matrix: (e * unit).transpose().into(),
            bias: std::array::from_fn(|i| rest.bias[i] + x[9 + i] / unit),
            covariance: covariance.into(),
            motions,
            typical_rad,
        })
    }

    /// How many standard deviations a motion is off what the others predict for it.
    fn deviation(&self, at: &At, solved: &Solved, m: usize, more: f64) -> f64 {
        let linear = &at.linear[m];
        let known = linear.jacobian * solved.covariance * linear.jacobian.transpose();
        let own = self.motions[m].sd.powi(2) + more;
        let residual = linear.after(&solved.step);
        let root = (known + Matrix3::from_diagonal_element(own)).cholesky();
        root.map_or(f64::INFINITY, |c| c.solve(&residual).dot(&residual).sqrt())
    }
}

/// Inverse by columns of length one: parameters differ in unit.
fn inverse(normal: &Square) -> Option<Square> {
    let scale = Parameters::from_fn(|i, _| normal[(i, i)].sqrt().recip());
    let scales = scale * scale.transpose();
    let inverse = normal.component_mul(&scales).cholesky()?.inverse();
    let unscaled = inverse.component_mul(&scales);
    unscaled.iter().all(|v| v.is_finite()).then_some(unscaled)
}
