//! The gyroscope from motions between rests.
//!
//! Gravity's direction is known at both ends of a motion from the calibrated accelerometer, so that the
//! integrated angular rate has to turn the one into the other:
//!
//! ```text
//! C(∫ω dt) v₀ − v₁ = 0,   ω = E (y − β)
//! ```
//!
//! for the nine elements of E and what the rests leave of the bias, β (Tedaldi, Pretto and Menegatti, "A
//! robust and easy to implement method for IMU calibration without external equipments", ICRA 2014). No
//! turn has to be known. It fails where the sensor never turns about one of its axes while that axis is
//! level: a turn about the vertical leaves gravity where it is.

use gravical_core::matrix3;
use gravical_core::strapdown::{matrix, normalize, quat_mul, step};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Nine elements of E, row-major, then β.
type Parameters = SVector<f64, 12>;
type Normal = SMatrix<f64, 12, 12>;

/// Rate in rad/s by the nominal scale, bias taken off, and the time to the next sample, s.
pub type Sample = [f64; 4];

/// A motion from one rest to the next.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// From a sample at rest to one at rest.
    pub samples: &'a [Sample],
    /// Unit vectors of specific force before and after, axes of the accelerometer.
    pub gravity: [[f64; 3]; 2],
    /// Standard deviation of each component of what is left, rad: directions of gravity, noise, drift.
    pub sd: f64,
}

/// E, β and how well they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFit {
    /// E, near the identity where the nominal scale is right.
    pub matrix: [[f64; 3]; 3],
    /// β, rad/s.
    pub bias: [f64; 3],
    /// Covariance of E, row-major, and β.
    pub covariance: [[f64; 12]; 12],
    /// Which motions were used; the others contradict them.
    pub used: Vec<bool>,
    /// Length of what is left of each motion, rad.
    pub residuals: Vec<f64>,
    /// The same of each used motion by a fit without it; none with fewer than seven.
    pub left_out: Option<Vec<f64>>,
}

/// A residual this many times the usual one contradicts the others.
const OUTLIER: f64 = 6.0;
/// … unless the others predict it within so many standard deviations.
const SURPRISE: f64 = 5.0;
/// Median length of two normal components of unit variance.
const RAYLEIGH_MEDIAN: f64 = 1.1774;
/// Width of Cauchy's loss, 95 % as efficient as least squares on normal residuals.
const CAUCHY: f64 = 2.385;
/// Passes over the samples; three are usual.
const MAX_PASSES: usize = 15;
/// A pass that moves no residual by more than this fraction of the usual one is the last.
const SETTLED: f64 = 0.01;
/// No direction and no turn is known better, rad: 0.00006°.
const FLOOR: f64 = 1e-6;

/// One motion at a state: gravity as it was, turned into the sensor after the motion, less gravity as it
/// is there; and its derivatives.
struct Linear {
    residual: Vector3<f64>,
    jacobian: SMatrix<f64, 3, 12>,
}

impl Linear {
    /// A small change of the parameters turns the result by ψ = Σ w A (δE (y − β) − E δβ), seen from the
    /// start, w being the weights of the trapezoid and A the attitudes: dr = C (v₀ × ψ).
    fn new(motion: &Motion<'_>, x: &Parameters) -> Linear {
        let e: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| x[3 * r + c]));
        let (attitude, sums) = turned(motion.samples, &e, [x[9], x[10], x[11]]);
        // nalgebra's arrays are columns: this is the transpose already.
        let rotation = Matrix3::from(attitude);
        let before = Vector3::from(motion.gravity[0]);
        let by_turn = rotation * before.cross_matrix();
        let by_bias = matrix3::mul(&sums.map(|row| row.map(|s| s[3])), &e);
        let jacobian = SMatrix::from_fn(|i, p| match p {
            0..9 => (0..3)
                .map(|k| by_turn[(i, k)] * sums[k][p / 3][p % 3])
                .sum(),
            _ => -(0..3)
                .map(|k| by_turn[(i, k)] * by_bias[k][p - 9])
                .sum::<f64>(),
        });
        Linear {
            residual: rotation * before - Vector3::from(motion.gravity[1]),
            jacobian,
        }
    }

    fn after(&self, step: &Parameters) -> Vector3<f64> {
        self.residual + self.jacobian * step
    }
}

/// Attitude (sensor at the end to sensor at the start) and Σ w A_kr (y − β)_c, with Σ w A_kr as the fourth
/// c. Over one sample the rate is a straight line.
fn turned(
    samples: &[Sample],
    e: &[[f64; 3]; 3],
    bias: [f64; 3],
) -> ([[f64; 3]; 3], [[[f64; 4]; 3]; 3]) {
    let mut sums = [[[0.0; 4]; 3]; 3];
    let mut q = [1.0, 0.0, 0.0, 0.0];
    let mut attitude = matrix3::identity();
    let mut before: Option<([f64; 3], f64)> = None;
    for (i, sample) in samples.iter().enumerate() {
        let y = [
            sample[0] - bias[0],
            sample[1] - bias[1],
            sample[2] - bias[2],
        ];
        let rate = matrix3::mul_vec(e, &y);
        let to_next = if i + 1 < samples.len() {
            sample[3]
        } else {
            0.0
        };
        let from_last = before.map_or(0.0, |(_, h)| h);
        if let Some((last, h)) = before {
            q = quat_mul(&q, &step(&last, &rate, h));
            attitude = matrix(&q);
        }
        let weight = 0.5 * (from_last + to_next);
        let weighted = [weight * y[0], weight * y[1], weight * y[2], weight];
        for k in 0..3 {
            for r in 0..3 {
                for c in 0..4 {
                    sums[k][r][c] += attitude[k][r] * weighted[c];
                }
            }
        }
        before = Some((rate, to_next));
    }
    (matrix(&normalize(&q)), sums)
}

/// The motions at one state.
struct At {
    x: Parameters,
    linear: Vec<Linear>,
    /// Median length of the residuals, rad.
    typical: f64,
}

/// What is fitted.
struct Problem<'a> {
    motions: &'a [Motion<'a>],
    bias_sd: [f64; 3],
}

impl Problem<'_> {
    fn at(&self, x: Parameters) -> At {
        let linear: Vec<Linear> = self.motions.iter().map(|m| Linear::new(m, &x)).collect();
        let typical = median(linear.iter().map(|l| l.residual.norm()).collect());
        At { x, linear, typical }
    }

    /// Normal equations with a weight for each motion; β is held to the rests.
    fn normal(&self, at: &At, weights: &[f64]) -> (Normal, Parameters) {
        let (mut normal, mut gradient) = (Normal::zeros(), Parameters::zeros());
        for i in 0..3 {
            let weight = self.bias_sd[i].max(1e-9).powi(-2);
            normal[(9 + i, 9 + i)] += weight;
            gradient[9 + i] += weight * at.x[9 + i];
        }
        for (linear, weight) in at.linear.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            normal += *weight * linear.jacobian.tr_mul(&linear.jacobian);
            gradient += *weight * linear.jacobian.tr_mul(&linear.residual);
        }
        (normal, gradient)
    }

    /// Median of the residuals in their standard deviations over that of noise, at least 1.
    fn excess(&self, lengths: impl Iterator<Item = f64>) -> f64 {
        let whitened = lengths.zip(self.motions).map(|(l, m)| l / m.sd);
        (median(whitened.collect()) / RAYLEIGH_MEDIAN).max(1.0)
    }

    /// Minimises Cauchy's loss, its width following the residuals.
    fn robust(&self, start: Parameters) -> Option<At> {
        let mut best = self.at(start);
        let mut share = 1.0;
        for _ in 0..MAX_PASSES {
            let step = share * self.robust_step(&best)?;
            let moves = largest_move(&best.linear, &step);
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
            let lengths: Vec<f64> = at.linear.iter().map(|l| l.after(&step).norm()).collect();
            let width = CAUCHY * self.excess(lengths.iter().copied());
            let weight = |(length, motion): (&f64, &Motion<'_>)| {
                let whitened = length / motion.sd;
                motion.sd.powi(-2) / (1.0 + (whitened / width).powi(2))
            };
            let weights: Vec<f64> = lengths.iter().zip(self.motions).map(weight).collect();
            let (normal, gradient) = self.normal(at, &weights);
            step = -(inverse(&normal)? * gradient);
        }
        Some(step)
    }

    /// Motions that agree. Where too few or too many do not, none can be called wrong.
    fn judge(&self, lengths: &[f64]) -> Vec<bool> {
        let count = lengths.len();
        // Nine parameters swallow part of few residuals.
        let swallowed = (2.0 * count as f64 / (2.0 * count as f64 - 9.0).max(1.0)).sqrt();
        let limit = OUTLIER * swallowed * self.excess(lengths.iter().copied());
        let agrees = |(length, motion): (&f64, &Motion<'_>)| *length <= limit * motion.sd;
        let used: Vec<bool> = lengths.iter().zip(self.motions).map(agrees).collect();
        let kept = used.iter().filter(|u| **u).count();
        if 2 * kept < 9 + 6 || (count - kept) * 5 > count {
            return vec![true; count];
        }
        used
    }

    /// Variance per component that noise does not explain, the same for every motion (a hand that trembles,
    /// a gyroscope that is not linear): so that the weighted squares are what their number lets expect
    /// (Paule and Mandel, J. Res. NBS 87 (1982) 377).
    fn unexplained(&self, lengths: &[f64], used: &[bool], freedom: f64) -> f64 {
        let each = || lengths.iter().zip(self.motions).zip(used);
        let squares = |more: f64| -> f64 {
            let used = each().filter(|(_, used)| **used);
            used.map(|((l, m), _)| l * l / (m.sd * m.sd + more)).sum()
        };
        if squares(0.0) <= freedom {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, lengths.iter().map(|l| l * l).sum::<f64>());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if squares(middle) > freedom {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Least squares of the motions that agree. Where motions are few, a robust fit may follow some of them
    /// too closely: what it calls an outlier is heard again, against what the others predict for it.
    fn settle(&self, robust: At) -> Option<MotionFit> {
        let lengths: Vec<f64> = robust.linear.iter().map(|l| l.residual.norm()).collect();
        let mut used = self.judge(&lengths);
        let mut at = robust;
        for pass in 1.. {
            let freedom = 2.0 * used.iter().filter(|u| **u).count() as f64 - 9.0;
            if freedom < 3.0 {
                return None;
            }
            let (step, _, _) = self.least_squares(&at, &used, 0.0)?;
            let lengths: Vec<f64> = at.linear.iter().map(|l| l.after(&step).norm()).collect();
            let more = self.unexplained(&lengths, &used, freedom);
            let (step, covariance, weights) = self.least_squares(&at, &used, more)?;
            let surprise = |m: usize| {
                let linear = &at.linear[m];
                let known = linear.jacobian * covariance * linear.jacobian.transpose();
                let sd2 = self.motions[m].sd.powi(2) + more;
                let left = linear.after(&step);
                let root = (known + Matrix3::from_diagonal_element(sd2)).cholesky();
                root.map_or(f64::INFINITY, |c| c.solve(&left).dot(&left).sqrt())
            };
            let again: Vec<bool> = (0..used.len())
                .map(|m| used[m] || surprise(m) < SURPRISE)
                .collect();
            let usual = median(at.linear.iter().map(|l| l.after(&step).norm()).collect());
            let rests = largest_move(&at.linear, &step) < SETTLED * usual.max(FLOOR);
            if pass == MAX_PASSES || (rests && again == used) {
                return Some(self.result(&at, step, covariance, used, &weights));
            }
            used = again;
            at = self.at(at.x + step);
        }
        None
    }

    fn least_squares(
        &self,
        at: &At,
        used: &[bool],
        more: f64,
    ) -> Option<(Parameters, Normal, Vec<f64>)> {
        let weight = |(motion, used): (&Motion<'_>, &bool)| {
            f64::from(u8::from(*used)) / (motion.sd * motion.sd + more)
        };
        let weights: Vec<f64> = self.motions.iter().zip(used).map(weight).collect();
        let (normal, gradient) = self.normal(at, &weights);
        let covariance = inverse(&normal)?;
        Some((-(covariance * gradient), covariance, weights))
    }

    fn result(
        &self,
        at: &At,
        step: Parameters,
        covariance: Normal,
        used: Vec<bool>,
        weights: &[f64],
    ) -> MotionFit {
        let x = at.x + step;
        let count = used.iter().filter(|u| **u).count();
        let left_out = || -> Option<Vec<f64>> {
            let (normal, gradient) = self.normal(at, weights);
            let without = |m: usize| {
                let linear = &at.linear[m];
                let taken = weights[m] * linear.jacobian.tr_mul(&linear.jacobian);
                let pull = weights[m] * linear.jacobian.tr_mul(&linear.residual);
                let step = -(inverse(&(normal - taken))? * (gradient - pull));
                Some(linear.after(&step).norm())
            };
            (0..used.len()).filter(|m| used[*m]).map(without).collect()
        };
        MotionFit {
            matrix: std::array::from_fn(|r| std::array::from_fn(|c| x[3 * r + c])),
            bias: [x[9], x[10], x[11]],
            covariance: std::array::from_fn(|i| std::array::from_fn(|k| covariance[(i, k)])),
            residuals: at.linear.iter().map(|l| l.after(&step).norm()).collect(),
            left_out: (2 * count >= 9 + 4).then(left_out).flatten(),
            used,
        }
    }
}

/// Median length of what is left of the motions at a state, rad; NaN without motions.
#[must_use]
pub fn typical_residual(motions: &[Motion<'_>], matrix: [[f64; 3]; 3]) -> f64 {
    let problem = Problem {
        motions,
        bias_sd: [1.0; 3],
    };
    problem.at(start(matrix)).typical
}

/// Covariance of E, row-major, and β by noise alone, if E is `matrix`: what the motions can determine at
/// best. None if they leave a parameter open.
#[must_use]
pub fn expected_covariance(
    motions: &[Motion<'_>],
    bias_sd: [f64; 3],
    matrix: [[f64; 3]; 3],
) -> Option<[[f64; 12]; 12]> {
    let problem = Problem { motions, bias_sd };
    let at = problem.at(start(matrix));
    let used = vec![true; motions.len()];
    let (_, covariance, _) = problem.least_squares(&at, &used, 0.0)?;
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|k| covariance[(i, k)])
    }))
}

/// Fits E and β from `matrix`; `bias_sd` is what the rests leave of the bias, rad/s.
///
/// First by Cauchy's loss, then by least squares of the motions that agree, with a variance that is added
/// to all of them until χ² is its degrees of freedom. None with fewer than six motions that agree, or where
/// these leave a parameter open.
#[must_use]
pub fn fit_motions(
    motions: &[Motion<'_>],
    bias_sd: [f64; 3],
    matrix: [[f64; 3]; 3],
) -> Option<MotionFit> {
    let problem = Problem { motions, bias_sd };
    let fit = problem.settle(problem.robust(start(matrix))?)?;
    let numbers = fit.matrix.as_flattened().iter().chain(&fit.bias);
    numbers
        .chain(fit.covariance.as_flattened())
        .all(|v| v.is_finite())
        .then_some(fit)
}

fn start(matrix: [[f64; 3]; 3]) -> Parameters {
    Parameters::from_fn(|i, _| if i < 9 { matrix[i / 3][i % 3] } else { 0.0 })
}

fn largest_move(linear: &[Linear], step: &Parameters) -> f64 {
    let moves = linear.iter().map(|l| (l.jacobian * step).norm());
    moves.fold(0.0, f64::max)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Inverse by columns of length one: parameters differ in unit.
fn inverse(normal: &Normal) -> Option<Normal> {
    let scale = Parameters::from_fn(|i, _| normal[(i, i)].sqrt().recip());
    let scales = scale * scale.transpose();
    let inverse = normal.component_mul(&scales).cholesky()?.inverse();
    let unscaled = inverse.component_mul(&scales);
    unscaled.iter().all(|v| v.is_finite()).then_some(unscaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const H: f64 = 0.01;
    const NOISE: f64 = 2e-3;
    const DIRECTION: f64 = 4e-4;

    fn normal(rng: &mut impl Rng) -> f64 {
        rng.sample(StandardNormal)
    }

    /// Samples, and gravity before and after.
    type Recorded = (Vec<Sample>, [[f64; 3]; 2]);

    /// Motions of two seconds about axes of any direction, by 60 to 150°, and E of the sensor.
    fn session(seed: u64, count: usize) -> (Vec<Recorded>, Matrix3<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let e = Matrix3::from_fn(|r, c| f64::from(u8::from(r == c)) + 0.02 * normal(&mut rng));
        let back = e.try_inverse().unwrap();
        let bias = Vector3::from_fn(|_, _| 1e-4 * normal(&mut rng));
        let direction = |rng: &mut ChaCha8Rng| Vector3::from_fn(|_, _| normal(rng)).normalize();
        let mut up = direction(&mut rng);
        let mut motions = Vec::new();
        for _ in 0..count {
            let axis = direction(&mut rng);
            let angle: f64 = rng.random_range(1.0..2.6);
            let steps = 200;
            let mut now = up;
            let mut samples = Vec::new();
            for i in 0..=steps {
                let t = f64::from(i) / f64::from(steps);
                let rate =
                    axis * angle * std::f64::consts::PI / 4.0 * (std::f64::consts::PI * t).sin();
                let noise = Vector3::from_fn(|_, _| NOISE * normal(&mut rng));
                let y = back * rate + bias + noise;
                samples.push([y[0], y[1], y[2], H]);
                if i < steps {
                    let half = axis * angle * std::f64::consts::PI / 4.0
                        * (std::f64::consts::PI * (t + 0.5 / f64::from(steps))).sin();
                    now = Rotation3::new(-half * H) * now;
                }
            }
            let read = |n: Vector3<f64>, rng: &mut ChaCha8Rng| -> [f64; 3] {
                let off = Vector3::from_fn(|_, _| DIRECTION * normal(rng));
                (n + off).normalize().into()
            };
            let gravity = [read(up, &mut rng), read(now, &mut rng)];
            motions.push((samples, gravity));
            up = now;
        }
        (motions, e)
    }

    fn motions(session: &[Recorded]) -> Vec<Motion<'_>> {
        let sd =
            (2.0 * DIRECTION.powi(2) + NOISE.powi(2) * H * 2.0 + (1e-4_f64 * 2.0).powi(2)).sqrt();
        session
            .iter()
            .map(|(samples, gravity)| Motion {
                samples,
                gravity: *gravity,
                sd,
            })
            .collect()
    }

    #[test]
    fn intervals_hold_the_truth() {
        for count in [12, 36] {
            let (mut inside, mut all) = (0, 0);
            for seed in 0..60 {
                let (session, e) = session(seed, count);
                let fit = fit_motions(&motions(&session), [1e-4; 3], matrix3::identity()).unwrap();
                for i in 0..9 {
                    let sd = fit.covariance[i][i].sqrt();
                    inside += usize::from(
                        (fit.matrix[i / 3][i % 3] - e[(i / 3, i % 3)]).abs() < 1.96 * sd,
                    );
                    all += 1;
                }
            }
            let share = inside as f64 / all as f64;
            println!("{count} motions: {share:.3}");
            assert!((0.92..=0.98).contains(&share), "{count} motions: {share}");
        }
    }

    #[test]
    fn a_motion_that_was_bumped_is_left_out() {
        let (mut session, e) = session(3, 24);
        session[7].0.iter_mut().take(40).for_each(|s| s[0] += 1.0);
        let fit = fit_motions(&motions(&session), [1e-4; 3], matrix3::identity()).unwrap();
        assert!(!fit.used[7]);
        assert_eq!(fit.used.iter().filter(|u| **u).count(), 23);
        for i in 0..9 {
            assert!((fit.matrix[i / 3][i % 3] - e[(i / 3, i % 3)]).abs() < 5e-3);
        }
    }

    #[test]
    fn what_determines_nothing_gives_nothing() {
        let (session, _) = session(1, 24);
        let all = motions(&session);
        assert!(fit_motions(&all[..4], [1e-4; 3], matrix3::identity()).is_none());
        assert!(fit_motions(&[], [1e-4; 3], matrix3::identity()).is_none());
        let broken = [Motion {
            samples: &[[f64::NAN, 0.0, 0.0, 0.01]; 5],
            gravity: [[0.0, 0.0, 1.0]; 2],
            sd: 1e-3,
        }; 8];
        assert!(fit_motions(&broken, [1e-4; 3], matrix3::identity()).is_none());
    }
}
