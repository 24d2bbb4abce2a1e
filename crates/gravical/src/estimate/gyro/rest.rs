//! The gyroscope at rest: bias, reaction to gravity, noise.

use gravical_core::rounding;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::Still;
use crate::segment::hold::pooled_noise;
use crate::segment::sum_of_rows;
use crate::stats::mean_of_finite;

/// What the stills say about the gyroscope, in units of the file.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    /// Reading at rest without gravity's part.
    pub bias: [f64; 3],
    /// Its standard error.
    pub bias_error: [f64; 3],
    /// Row = gyroscope, column = accelerometer axis, per m/s²; zero where the
    /// stills show none.
    pub g_sensitivity: [[f64; 3]; 3],
    /// How far the bias of each still is off, shrunk by what is noise.
    pub local: Vec<[f64; 3]>,
    /// What is left of that uncertain, sd; mean over the stills.
    pub local_sd: [f64; 3],
    /// Low-frequency noise, Allan N: units of the file times √s.
    pub noise: [f64; 3],
}

/// A still that the gyroscope was read in.
pub(super) struct Rested<'a> {
    pub still: &'a Still,
    /// The gyroscope of its recording.
    pub gyro: &'a [Vec<f64>; 3],
    /// Time from row to row of its recording, s.
    pub period_s: f64,
    /// Calibrated acceleration, m/s².
    pub accel: [f64; 3],
}

impl Rested<'_> {
    /// Readings of the gyroscope in it.
    fn rates(&self) -> [&[f64]; 3] {
        self.gyro.each_ref().map(|c| &c[self.still.rows.clone()])
    }
}

/// Mean of the gyroscope over one still.
struct PoseMean {
    rate: [f64; 3],
    seconds: f64,
    /// Calibrated acceleration, m/s².
    accel: [f64; 3],
}

/// Length of the blocks that the noise is taken from, s: longer than the
/// correlation behind any low-pass in use, shorter than a still.
const BLOCK_S: f64 = 0.25;

/// Fewer stills than these say nothing about the reaction to gravity.
const LEAST_STILLS: usize = 8;

/// Chance of a reaction to gravity where there is none.
const CHANCE: f64 = 1e-3;

/// Looks at the stills, of one recording or of several: that each recording has a
/// bias of its own is drift. None without stills, and when one has no reading.
///
/// Model: mean of still k = b + S a_k + e_k + noise, e_k the slow drift of the
/// bias with variance τ² (Paule and Mandel 1982 for its estimate), noise of
/// variance N²/T_k. S is kept on an axis when an F test finds it at 1e-3. What rounding leaves
/// of b may be the same in all stills: their number does not average it away.
pub(super) fn at_rest(stills: &[Rested<'_>], step: [f64; 3]) -> Option<Rest> {
    if stills.is_empty() {
        return None;
    }
    let noise = allan_noise(stills, step);
    let left = left_by_rounding(stills, step);
    let means: Vec<PoseMean> = stills
        .iter()
        .map(|rested| {
            let (sum, rows) = sum_of_rows(rested.gyro, rested.still.rows.clone())?;
            Some(PoseMean {
                rate: sum.map(|s| s / rows as f64),
                seconds: rows as f64 * rested.period_s,
                accel: rested.accel,
            })
        })
        .collect::<Option<_>>()?;
    let mut rest = Rest {
        bias: [0.0; 3],
        bias_error: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
        local: vec![[0.0; 3]; means.len()],
        local_sd: [0.0; 3],
        noise,
    };
    let directions = spread(&means);
    for axis in 0..3 {
        let y = DVector::from_iterator(means.len(), means.iter().map(|m| m.rate[axis]));
        let own: Vec<f64> = means
            .iter()
            .map(|m| noise[axis].powi(2) / m.seconds)
            .collect();
        let constant = DMatrix::from_element(means.len(), 1, 1.0);
        let mut fit = mixed(&constant, &y, &own)?;
        if directions && means.len() >= LEAST_STILLS {
            let with = DMatrix::from_fn(means.len(), 4, |k, j| {
                if j == 0 { 1.0 } else { means[k].accel[j - 1] }
            });
            // Both models with the weights of the plain one.
            let weights: Vec<f64> = own.iter().map(|v| 1.0 / (v + fit.drift)).collect();
            let squares =
                |r: &DVector<f64>| -> f64 { r.iter().zip(&weights).map(|(r, w)| w * r * r).sum() };
            let (_, residuals, _) = weighted(&with, &y, &weights)?;
            let freedom = (means.len() - 4) as f64;
            let (plain, full) = (squares(&fit.residuals), squares(&residuals));
            let f = (plain - full) / 3.0 / (full / freedom).max(f64::MIN_POSITIVE);
            let by_chance = FisherSnedecor::new(3.0, freedom).map_or(1.0, |d| d.sf(f));
            if by_chance < CHANCE {
                fit = mixed(&with, &y, &own)?;
                rest.g_sensitivity[axis] =
                    [fit.parameters[1], fit.parameters[2], fit.parameters[3]];
            }
        }
        rest.bias[axis] = fit.parameters[0];
        let variance = fit.variance * correlation(&fit.residuals);
        rest.bias_error[axis] = (variance + left[axis]).sqrt();
        let mut local_variance = 0.0;
        for (k, local) in rest.local.iter_mut().enumerate() {
            let known = own[k] + left[axis];
            let total = fit.drift + known;
            if total > 0.0 {
                local[axis] = fit.drift / total * fit.residuals[k];
                local_variance += fit.drift * known / total;
            }
        }
        rest.local_sd[axis] = (local_variance / means.len() as f64).sqrt();
    }
    Some(rest)
}

/// Variance that rounding to `step` leaves in the mean of a still, each axis.
fn left_by_rounding(stills: &[Rested<'_>], step: [f64; 3]) -> [f64; 3] {
    let holds: Vec<[&[f64]; 3]> = stills.iter().map(Rested::rates).collect();
    pooled_noise(&holds, step).rounding.map(|r| r * r)
}

/// Allan deviation at [`BLOCK_S`], as a density: N = σ(τ)·√τ. Rounding counts as
/// noise too, since at rest it may hide all other.
fn allan_noise(stills: &[Rested<'_>], step: [f64; 3]) -> [f64; 3] {
    let longest_s = stills.iter().map(|s| s.period_s).fold(0.0, f64::max);
    std::array::from_fn(|axis| {
        let (mut squares, mut pairs) = (0.0, 0.0);
        for rested in stills {
            let width = ((BLOCK_S / rested.period_s).round() as usize).max(1);
            let block_s = width as f64 * rested.period_s;
            let mut before = f64::NAN;
            for block in rested.rates()[axis].chunks_exact(width) {
                let now = mean_of_finite(block);
                if (now - before).is_finite() {
                    squares += 0.5 * (now - before).powi(2) * block_s;
                    pairs += 1.0;
                }
                before = now;
            }
        }
        let white = if pairs > 0.0 { squares / pairs } else { 0.0 };
        white.max(rounding::floor(step[axis]) * longest_s).sqrt()
    })
}

/// True when gravity points far enough apart in the stills to see a reaction
/// to each of its components.
fn spread(means: &[PoseMean]) -> bool {
    let n = means.len() as f64;
    let length = means
        .iter()
        .map(|m| gravical_core::matrix3::norm(&m.accel))
        .sum::<f64>()
        / n;
    let centre: [f64; 3] =
        std::array::from_fn(|i| means.iter().map(|m| m.accel[i]).sum::<f64>() / n);
    let scatter = nalgebra::Matrix3::from_fn(|i, j| {
        means
            .iter()
            .map(|m| (m.accel[i] - centre[i]) * (m.accel[j] - centre[j]))
            .sum::<f64>()
            / (n * length * length)
    });
    // 1/3 for directions spread evenly; 0.05 is a cone of 13° about a plane.
    scatter.symmetric_eigenvalues().min() > 0.05
}

/// A linear model with known noise and a drift of unknown variance.
struct Mixed {
    parameters: Vec<f64>,
    residuals: DVector<f64>,
    /// τ².
    drift: f64,
    /// Variance of the first parameter.
    variance: f64,
}

/// Finds τ² so that the weighted squares of the residuals are what their
/// number lets expect; zero when the noise explains them.
fn mixed(design: &DMatrix<f64>, y: &DVector<f64>, own: &[f64]) -> Option<Mixed> {
    let freedom = y.len() as f64 - design.ncols() as f64;
    let fit = |drift: f64| {
        // Noise-free readings weigh alike.
        let weights: Vec<f64> = own
            .iter()
            .map(|v| 1.0 / (v + drift).max(f64::MIN_POSITIVE.sqrt()))
            .collect();
        let (parameters, residuals, variance) = weighted(design, y, &weights)?;
        let squares: f64 = residuals.iter().zip(&weights).map(|(r, w)| w * r * r).sum();
        Some((parameters, residuals, variance, squares))
    };
    let (_, residuals, _, squares) = fit(0.0)?;
    let mut drift = 0.0;
    if freedom > 0.0 && squares > freedom {
        let (mut low, mut high) = (0.0, 2.0 * residuals.norm_squared());
        for _ in 0..40 {
            drift = 0.5 * (low + high);
            if fit(drift)?.3 > freedom {
                low = drift;
            } else {
                high = drift;
            }
        }
    }
    let (parameters, residuals, variance, _) = fit(drift)?;
    Some(Mixed {
        parameters,
        residuals,
        drift,
        variance,
    })
}

/// Weighted least squares: parameters, residuals, variance of the first.
fn weighted(
    design: &DMatrix<f64>,
    y: &DVector<f64>,
    weights: &[f64],
) -> Option<(Vec<f64>, DVector<f64>, f64)> {
    let root = DVector::from_iterator(weights.len(), weights.iter().map(|w| w.sqrt()));
    let a = DMatrix::from_fn(design.nrows(), design.ncols(), |i, j| {
        root[i] * design[(i, j)]
    });
    let qr = a.qr();
    let upper = qr.r();
    let right = qr.q().tr_mul(&y.component_mul(&root));
    let parameters = upper.solve_upper_triangular(&right)?;
    let inverse = upper.solve_upper_triangular(&DMatrix::identity(upper.nrows(), upper.ncols()))?;
    let variance = inverse.row(0).norm_squared();
    let residuals = y - design * &parameters;
    Some((parameters.as_slice().to_vec(), residuals, variance))
}

/// How much wider a mean scatters because one still resembles the next: the
/// drift of a bias is slow. (1 + r)/(1 − r) of a first-order process.
fn correlation(residuals: &DVector<f64>) -> f64 {
    let all = residuals.norm_squared();
    if residuals.len() < 6 || all <= 0.0 {
        return 1.0;
    }
    let pairs: f64 = (1..residuals.len())
        .map(|k| residuals[k] * residuals[k - 1])
        .sum();
    let r = (pairs / all).clamp(0.0, 0.9);
    (1.0 + r) / (1.0 - r)
}
