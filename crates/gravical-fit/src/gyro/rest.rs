//! The gyroscope at rest: bias, g-sensitivity, drift.

use gravical_core::calibration::LinearCalibration;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use super::{GyroOptions, GyroRest, StaticInterval};

/// Fewer static intervals say nothing of g-sensitivity.
const MIN_INTERVALS: usize = 8;
/// Chance of a g-sensitivity where there is none.
const CHANCE: f64 = 1e-3;

/// Model: mean of static interval k = b + S a_k + e_k + noise; e_k, the drift of the bias, has the
/// variance τ², noise N²/T_k. S is kept on an axis if an F test finds it. What rounding leaves may be the
/// same in all of them.
pub(super) fn at_rest(
    intervals: &[StaticInterval],
    accelerometer: &LinearCalibration<f64>,
    options: &GyroOptions,
) -> Option<GyroRest> {
    let forces: Vec<Vector3<f64>> = intervals
        .iter()
        .map(|s| accelerometer.apply(s.accel).into())
        .collect();
    let positive = |v: f64| v.is_finite() && v > 0.0;
    let numbers = intervals
        .iter()
        .flat_map(|s| s.rate.iter().chain(&s.accel_sd));
    let numbers = numbers.chain(options.noise.iter().chain(&options.rounding));
    if !(numbers.clone().all(|v| v.is_finite())
        && intervals.iter().all(|s| positive(s.seconds))
        && forces.iter().all(|a| positive(a.norm())))
    {
        return None;
    }
    let constant = DMatrix::from_element(intervals.len(), 1, 1.0);
    let with = DMatrix::from_fn(intervals.len(), 4, |k, j| match j {
        0 => 1.0,
        _ => forces[k][j - 1],
    });
    let spread = intervals.len() >= MIN_INTERVALS && is_spread(&forces);
    let mut rest = GyroRest {
        local: vec![Vector3::zeros(); intervals.len()],
        ..GyroRest::default()
    };
    for i in 0..3 {
        let offset = intervals.first()?.rate[i];
        let y = DVector::from_iterator(
            intervals.len(),
            intervals.iter().map(|s| s.rate[i] - offset),
        );
        let noise = |s: &StaticInterval| (options.noise[i].powi(2) / s.seconds).max(1e-150);
        let own: Vec<f64> = intervals.iter().map(noise).collect();
        let mut fit = mixed(&constant, &y, &own)?;
        if spread && is_significant(&fit, &with, &y, &own) {
            fit = mixed(&with, &y, &own)?;
            rest.g_sensitivity[i] = std::array::from_fn(|j| fit.parameters[1 + j]);
        }
        let rounding = options.rounding[i].powi(2);
        rest.bias[i] = offset + fit.parameters[0];
        let noise = own.iter().map(|v| v.recip()).sum::<f64>().recip();
        rest.noise_sd[i] = (noise + rounding).sqrt();
        // Only drift resembles that of the static interval before, and has to be estimated.
        let mean_own = own.iter().sum::<f64>() / own.len() as f64;
        let share = fit.drift / (fit.drift + mean_own);
        let wider = 1.0 + share * (variance_inflation(&fit.residuals) - 1.0);
        let variance = fit.variance * wider;
        rest.bias_sd[i] = (variance + rounding).sqrt();
        let shrunk = |k: usize| fit.drift / (fit.drift + own[k] + rounding);
        (0..intervals.len()).for_each(|k| rest.local[k][i] = shrunk(k) * fit.residuals[k]);
        let left = (0..intervals.len()).map(|k| shrunk(k) * (own[k] + rounding));
        rest.local_sd[i] = (left.sum::<f64>() / intervals.len() as f64).sqrt();
    }
    Some(rest)
}

/// True if gravity points far enough apart to see a reaction to each of its components.
fn is_spread(forces: &[Vector3<f64>]) -> bool {
    let share = 1.0 / forces.len() as f64;
    let directions: Vec<Vector3<f64>> = forces.iter().map(|a| a.normalize()).collect();
    let centre = share * directions.iter().sum::<Vector3<f64>>();
    let off = directions.iter().map(|d| d - centre);
    let scatter: Matrix3<f64> = off.map(|d| d * d.transpose()).sum();
    // 1/3 for directions spread evenly; 0.05 is a cone of 13° about a plane.
    share * scatter.symmetric_eigenvalues().min() > 0.05
}

/// A linear model with known noise and a drift of unknown variance.
struct Mixed {
    parameters: DVector<f64>,
    residuals: DVector<f64>,
    /// τ².
    drift: f64,
    /// Of the first parameter.
    variance: f64,
    chi2: f64,
}

fn mixed(design: &DMatrix<f64>, y: &DVector<f64>, own: &[f64]) -> Option<Mixed> {
    let freedom = (y.len() - design.ncols()) as f64;
    let largest = 2.0 * y.norm_squared();
    let chi2 = |drift: f64| Some(weighted(design, y, own, drift)?.chi2);
    weighted(design, y, own, unexplained(freedom, largest, chi2)?)
}

fn weighted(design: &DMatrix<f64>, y: &DVector<f64>, own: &[f64], drift: f64) -> Option<Mixed> {
    let weights = DVector::from_iterator(own.len(), own.iter().map(|v| 1.0 / (v + drift)));
    // Only their ratios matter to the solution; noise-free readings would overflow it.
    let unit = weights.max();
    let weighed = DMatrix::from_fn(design.nrows(), design.ncols(), |k, j| {
        design[(k, j)] * weights[k] / unit
    });
    let inverse = (weighed.transpose() * design).try_inverse()?;
    let parameters = &inverse * weighed.tr_mul(y);
    let residuals = y - design * &parameters;
    Some(Mixed {
        chi2: residuals.component_mul(&residuals).dot(&weights),
        variance: inverse[(0, 0)] / unit,
        drift,
        parameters,
        residuals,
    })
}

/// The variance that makes χ² what its degrees of freedom let expect if every reading has it beside
/// its own, 0 if none is needed or nothing is left over (Paule and Mandel, J. Res. NBS 87, 1982).
pub(super) fn unexplained(
    freedom: f64,
    largest: f64,
    chi2: impl Fn(f64) -> Option<f64>,
) -> Option<f64> {
    if freedom <= 0.0 || chi2(0.0)? <= freedom {
        return Some(0.0);
    }
    let (mut low, mut high) = (0.0, largest);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if chi2(middle)? > freedom {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}

/// F test of the model with g-sensitivity, by the weights of that without.
fn is_significant(plain: &Mixed, with: &DMatrix<f64>, y: &DVector<f64>, own: &[f64]) -> bool {
    let Some(full) = weighted(with, y, own, plain.drift) else {
        return false;
    };
    let freedom = (y.len() - 4) as f64;
    let ratio = (plain.chi2 - full.chi2) / 3.0 / (full.chi2 / freedom).max(f64::MIN_POSITIVE);
    FisherSnedecor::new(3.0, freedom).is_ok_and(|f| f.sf(ratio.max(0.0)) < CHANCE)
}

/// How much wider than by independent static intervals the mean of a drifting bias scatters:
/// (1 + r)/(1 − r) of a first-order process, r without its bias (Marriott and Pope, Biometrika 41, 1954),
/// and Student's t of so many fewer intervals, less one for the mean and one for r.
fn variance_inflation(residuals: &DVector<f64>) -> f64 {
    let count = residuals.len() as f64;
    let squares = residuals.norm_squared();
    // Readings that do not differ do not resemble each other either.
    if count < 6.0 || squares <= 0.0 {
        return 1.0;
    }
    let lagged = residuals
        .rows(0, residuals.len() - 1)
        .dot(&residuals.rows(1, residuals.len() - 1));
    let r = lagged / squares;
    let r = ((count * r + 1.0) / (count - 4.0)).clamp(0.0, 0.9);
    let wider = (1.0 + r) / (1.0 - r);
    let student = StudentsT::new(0.0, 1.0, (count / wider - 2.0).max(2.0));
    wider * student.map_or(1.0, |t| (t.inverse_cdf(0.975) / 1.96).powi(2))
}
