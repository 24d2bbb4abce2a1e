//! How sure the six placements are of the accelerometer's parameters.

use super::{SixPositionMeans, own_pair};
use crate::Real;

/// The 12 × 12 covariance of the parameters that
/// [`ferraris_accelerometer`](super::ferraris_accelerometer) gives, in closed form.
///
/// The parameters are those of u = M a + b, a in m/s²: M row-major (0 to 8, raw
/// unit per m/s²), then b (9 to 11, raw unit).
///
/// - `standard_errors`: of each component of each mean, raw unit, independent.
/// - `gravity_mps2`: in m/s².
/// - `tilt_sd_rad`: the standard deviation σ_tilt, in rad, of each of the two
///   components by which a placement's direction is off; independent between
///   all six placements. A table that is not level is not that: turn the sensor
///   by 180° between two placements of each face.
///
/// Placement j± points along ±(e_j + δ), and m_k is column k of M. To first
/// order u_j± has the covariance C_j± = diag(s²) + g²σ_tilt² Σ_{k≠j} m_k m_kᵀ; from
/// m_j = (u_j+ − u_j−)/2g and b_i = (u_i+ + u_i−)_i/2 follow
///
/// - Cov(m_j) = (C_j+ + C_j−)/4g²; nothing between different columns,
/// - Var(b_i) = (C_i+ + C_i−)_ii/4, different axes independent,
/// - Cov(b_i, M_ri) = (C_i+ − C_i−)_ir/4g, other columns independent.
///
/// Where the sensor sits turned in the frame of the placements, the bias of
/// channel i comes from the pair j along which it points: read j for the index
/// of C and of the column there, i for the element.
///
/// To second order a tilted placement reads g|δ|²/2 short along m_j. That
/// shortens every column by σ_tilt² on average, a bias of the estimate, and scatters
/// it by σ_tilt²/√2. Both enter as the mean square error that they make: σ_tilt⁴ m_j m_kᵀ
/// between any two columns, 0.5 σ_tilt⁴ m_j m_jᵀ more in Cov(m_j) (1.5 together), and
/// g²σ_tilt⁴M_jj²/2 in Var(b_j).
///
/// Without noise and with c the root mean square of the two cross-axis terms of
/// a row of M, the bias is then known to g√(σ_tilt⁴/2 + c²σ_tilt²), for a scale near 1.
///
/// Nothing is checked: the means are those that Ferraris has accepted, the
/// others finite and not negative; what is not, shows in the result. Simulated
/// sensors scatter as it says up to a tilt of 3°; at 10° the orders that are
/// left out make the true variances of scale and bias up to 20 % larger.
///
/// ```
/// use gravical_core::six_position::{SixPositionMeans, ferraris_covariance};
///
/// let g = 9.81_f64;
/// let up = [[g, 0.0, 0.0], [0.0, g, 0.0], [0.0, 0.0, g]];
/// let means = SixPositionMeans { plus: up, minus: up.map(|row| row.map(|x| -x)) };
/// let errors = SixPositionMeans { plus: [[0.001; 3]; 3], minus: [[0.001; 3]; 3] };
/// let covariance = ferraris_covariance(&means, &errors, g, 0.0);
/// // Each bias is the mean of two readings.
/// assert!((covariance[9][9].sqrt() - 0.001 * 0.5_f64.sqrt()).abs() < 1e-15);
/// ```
#[must_use]
pub fn ferraris_covariance<T: Real>(
    means: &SixPositionMeans<T>,
    standard_errors: &SixPositionMeans<T>,
    gravity_mps2: T,
    tilt_sd_rad: T,
) -> [[T; 12]; 12] {
    let g = gravity_mps2;
    let four = T::from_f64(4.0);
    let model = means.half_difference(g);
    let tilt_square = tilt_sd_rad * tilt_sd_rad;
    let tilt_fourth = tilt_square * tilt_square;
    let mut covariance = [[T::zero(); 12]; 12];

    for j in 0..3 {
        // g²σ_tilt² Σ m_k m_kᵀ over the two columns that a tilt mixes in.
        let tilted = |r: usize, c: usize| {
            let mixed = (0..3)
                .filter(|&k| k != j)
                .fold(T::zero(), |sum, k| sum + model[r][k] * model[c][k]);
            g * g * tilt_square * mixed
        };
        let noise = |errors: &[[T; 3]; 3], r: usize, c: usize| {
            if r == c {
                errors[j][r] * errors[j][r]
            } else {
                T::zero()
            }
        };
        let up = |r, c| noise(&standard_errors.plus, r, c) + tilted(r, c);
        let down = |r, c| noise(&standard_errors.minus, r, c) + tilted(r, c);

        let scattered = tilt_fourth / T::from_f64(2.0);
        for r in 0..3 {
            for c in 0..3 {
                let first_order = (up(r, c) + down(r, c)) / (four * g * g);
                covariance[3 * r + j][3 * c + j] =
                    first_order + scattered * model[r][j] * model[c][j];
            }
        }
        let here = |i: usize| own_pair(&model, i) == j;
        for i in (0..3).filter(|&i| here(i)) {
            for r in 0..3 {
                let crossed = (up(i, r) - down(i, r)) / (four * g);
                covariance[9 + i][3 * r + j] = crossed;
                covariance[3 * r + j][9 + i] = crossed;
            }
            for k in (0..3).filter(|&k| here(k)) {
                let short = g * g * scattered * model[i][j] * model[k][j];
                covariance[9 + i][9 + k] = (up(i, k) + down(i, k)) / four + short;
            }
        }
    }
    // Every reading is short, never long: the columns err the same way.
    for p in 0..9 {
        for q in 0..9 {
            let shared = model[p / 3][p % 3] * model[q / 3][q % 3];
            covariance[p][q] = covariance[p][q] + tilt_fourth * shared;
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix3;
    use crate::six_position::ferraris_accelerometer;
    use crate::six_position::tests::{MODEL, placements};

    const GRAVITY: f64 = 9.81;
    const DEGREE: f64 = core::f64::consts::PI / 180.0;
    const BIAS: [f64; 3] = [0.385, -0.13, 0.44];

    /// Normal deviates: Knuth's 64-bit linear congruence, Box and Muller.
    struct Normal(u64);

    impl Normal {
        fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            // The high bits; the low ones of such a generator are poor.
            ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        }

        fn draw(&mut self) -> f64 {
            let radius = (-2.0 * self.uniform().ln()).sqrt();
            radius * (core::f64::consts::TAU * self.uniform()).cos()
        }
    }

    /// One mean reading: axis `axis` up (`sign` 1) or down (−1), off by a tilt.
    fn reading(
        normal: &mut Normal,
        model: &[[f64; 3]; 3],
        axis: usize,
        sign: f64,
        tilt: f64,
        errors: &[f64; 3],
    ) -> [f64; 3] {
        let (first, second) = (tilt * normal.draw(), tilt * normal.draw());
        let mut accel = [0.0; 3];
        accel[axis] = sign * GRAVITY * (1.0 - first * first - second * second).sqrt();
        accel[(axis + 1) % 3] = GRAVITY * first;
        accel[(axis + 2) % 3] = GRAVITY * second;
        core::array::from_fn(|r| {
            BIAS[r] + matrix3::dot(&model[r], &accel) + errors[r] * normal.draw()
        })
    }

    fn flat(model: &[[f64; 3]; 3], bias: &[f64; 3]) -> [f64; 12] {
        core::array::from_fn(|i| {
            if i < 9 {
                model[i / 3][i % 3]
            } else {
                bias[i - 9]
            }
        })
    }

    /// The mean square errors about the truth, from `draws` simulated sensors.
    fn simulate(
        model: &[[f64; 3]; 3],
        errors: &SixPositionMeans<f64>,
        tilt: f64,
        draws: usize,
    ) -> [[f64; 12]; 12] {
        let mut normal = Normal(20_250_501);
        let truth = flat(model, &BIAS);
        let mut sum = [[0.0; 12]; 12];
        for _ in 0..draws {
            let mut hold = |axis: usize, sign, errors: &[[f64; 3]; 3]| {
                reading(&mut normal, model, axis, sign, tilt, &errors[axis])
            };
            let means = SixPositionMeans {
                plus: core::array::from_fn(|axis| hold(axis, 1.0, &errors.plus)),
                minus: core::array::from_fn(|axis| hold(axis, -1.0, &errors.minus)),
            };
            let estimate = ferraris_accelerometer(&means, GRAVITY).unwrap();
            let got = flat(&estimate.model(), &estimate.bias);
            let error: [f64; 12] = core::array::from_fn(|i| got[i] - truth[i]);
            for (row, a) in sum.iter_mut().zip(error) {
                for (cell, b) in row.iter_mut().zip(error) {
                    *cell += a * b / draws as f64;
                }
            }
        }
        sum
    }

    /// `left_out` is what the higher orders may add, relative to the variance.
    fn compare(errors: &SixPositionMeans<f64>, tilt: f64, left_out: f64) {
        compare_of(MODEL, errors, tilt, left_out);
    }

    fn compare_of(model: [[f64; 3]; 3], errors: &SixPositionMeans<f64>, tilt: f64, left_out: f64) {
        const DRAWS: usize = 40_000;
        let means = placements(model, BIAS, GRAVITY);
        let predicted = ferraris_covariance(&means, errors, GRAVITY, tilt);
        let observed = simulate(&model, errors, tilt, DRAWS);
        // The relative standard deviation of a mean square of N draws is
        // √((κ − 1)/N): 0.7 % for a normal error (kurtosis κ = 3), 1.1 % for the
        // bias under a pure tilt (a Laplace difference, κ = 6). Five of those.
        let relative = 5.0 * (5.0 / DRAWS as f64).sqrt();
        for i in 0..12 {
            for k in 0..12 {
                let size = (predicted[i][i] * predicted[k][k]).sqrt();
                let difference = (observed[i][k] - predicted[i][k]) / size;
                assert!(
                    difference.abs() < relative + left_out,
                    "[{i}][{k}]: {difference}"
                );
            }
        }
    }

    #[test]
    fn simulated_sensors_scatter_as_predicted() {
        // Standard errors of unlike size, so that bias and matrix correlate.
        let errors = SixPositionMeans {
            plus: [[0.03, 0.01, 0.02], [0.01, 0.04, 0.01], [0.02, 0.01, 0.03]],
            minus: [[0.01, 0.02, 0.01], [0.02, 0.01, 0.03], [0.01, 0.02, 0.01]],
        };
        compare(&errors, 0.0, 0.0);
        compare(&errors, DEGREE, 0.0);
    }

    #[test]
    fn the_bias_under_tilt_follows_the_rule() {
        // c = 0.02 in every row, scale 1: g√(σ_tilt⁴/2 + c²σ_tilt²).
        let c = 0.02;
        let model = [[1.0, c, -c], [c, 1.0, c], [-c, c, 1.0]];
        let none = SixPositionMeans {
            plus: [[0.0; 3]; 3],
            minus: [[0.0; 3]; 3],
        };
        let means = placements(model, BIAS, GRAVITY);
        for tilt in [0.1 * DEGREE, DEGREE, 3.0 * DEGREE] {
            let rule = GRAVITY * (tilt.powi(4) / 2.0 + c * c * tilt * tilt).sqrt();
            let predicted = ferraris_covariance(&means, &none, GRAVITY, tilt);
            let observed = simulate(&model, &none, tilt, 20_000);
            for i in 9..12 {
                assert!((predicted[i][i].sqrt() / rule - 1.0).abs() < 1e-12);
                // Half of 5 √(5/N): a root varies half as much as its square.
                let ratio = observed[i][i].sqrt() / rule;
                assert!((ratio - 1.0).abs() < 0.04, "{tilt} {i}: {ratio}");
            }
        }
    }

    #[test]
    fn single_precision_agrees() {
        let errors = SixPositionMeans {
            plus: [[0.003; 3]; 3],
            minus: [[0.002; 3]; 3],
        };
        let narrow = |m: SixPositionMeans<f64>| SixPositionMeans {
            plus: m.plus.map(|row| row.map(|x| x as f32)),
            minus: m.minus.map(|row| row.map(|x| x as f32)),
        };
        let means = placements(MODEL, BIAS, GRAVITY);
        let double = ferraris_covariance(&means, &errors, GRAVITY, DEGREE);
        let single = ferraris_covariance(
            &narrow(means),
            &narrow(errors),
            GRAVITY as f32,
            DEGREE as f32,
        );
        for i in 0..12 {
            for k in 0..12 {
                let size = (double[i][i] * double[k][k]).sqrt();
                assert!((f64::from(single[i][k]) - double[i][k]).abs() < 1e-5 * size);
            }
        }
    }
}
