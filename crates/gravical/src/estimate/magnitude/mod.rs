//! From the length of gravity alone: `magnitude9` and `magnitude6`.
//!
//! # The model
//!
//! At rest ‖A(u − b)‖ = g, however the sensor lies. Nine parameters: A upper
//! triangular with a positive diagonal, and b. A full matrix would have three
//! more that no length can tell, those of a rotation; the triangle fixes them by
//! the convention that z is the sensor's own z axis and y lies in its y–z plane.
//! Six parameters: A diagonal. Fitted is
//!
//! ```text
//! Σ ((‖A(u_k − b)‖ − g)/σ_k)²
//! ```
//!
//! with σ_k the standard error of the mean seen along gravity, σ_k² = Σ_i w_i²
//! s_ki², w = Aᵀ A(u − b)/‖A(u − b)‖, or all alike.
//!
//! Source: Tedaldi, Pretto and Menegatti, ICRA 2014, eq. 4–10 (program imu_tk,
//! which weighs all alike and whose A is T·K, T with a diagonal of one). Its
//! cost is the difference of squares; this is the difference of lengths, whose
//! minimum is the same but for terms of the size of the residual over g.
//!
//! It fails where poses leave parameters open; the error names poses that would
//! not.

mod leave_out;
mod model;
#[cfg(test)]
mod tests;

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::solve::{Factor, Options, Problem, solve};
use crate::estimate::{Reading, reading, undetermined, wanted};
use crate::stats::median;
use crate::validate::predicted;
use crate::{Error, Result};

pub use leave_out::{LeftOut, NEIGHBOUR_DEG, leave_out};
use model::{Model, State};

/// Which elements of A are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Upper triangle: with b nine parameters.
    Nine,
    /// Diagonal: with b six parameters.
    Six,
}

/// How much a pose counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// All alike, as imu_tk does; right where sensor and model differ by more
    /// than the noise of the means.
    Alike,
    /// One over the variance of the mean; all alike when a reading has no
    /// standard error.
    StandardErrors,
}

/// What is known beside the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MagnitudeOptions {
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Nominal scale, input unit per m/s²; none where the range is not known.
    /// It is only a start.
    pub nominal: Option<f64>,
    /// Which parameters are fitted.
    pub kind: Kind,
    /// How much a pose counts.
    pub weights: Weights,
}

/// The fitted accelerometer.
#[derive(Debug, Clone, PartialEq)]
pub struct MagnitudeFit {
    /// A of a = A(u − b), m/s² per input unit.
    pub matrix: [[f64; 3]; 3],
    /// b, input unit.
    pub bias: [f64; 3],
    /// M = A⁻¹ of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// ‖A(u − b)‖ − g of every pose, m/s².
    pub residuals_mps2: Vec<f64>,
    /// Σ of the squared residuals over their variances; none where all count
    /// alike.
    pub chi2: Option<f64>,
    /// Poses less parameters.
    pub freedom: usize,
    /// Covariance of row-major M and b, zero for the elements that are fixed.
    /// By the standard errors, times χ²/freedom where that exceeds 1; by the
    /// scatter of the residuals where all count alike. None when there is
    /// neither.
    pub covariance: Option<[[f64; 12]; 12]>,
    /// Largest over smallest singular value of the Jacobian, columns of length
    /// one. Above 30 a few poses carry the result.
    pub condition: f64,
}

impl MagnitudeFit {
    /// Root of the mean square of the residuals, m/s².
    #[must_use]
    pub fn rms_mps2(&self) -> f64 {
        let n = self.residuals_mps2.len() as f64;
        (self.residuals_mps2.iter().map(|r| r * r).sum::<f64>() / n).sqrt()
    }

    /// ‖A(u − b)‖ of a reading, m/s².
    #[must_use]
    pub fn length_mps2(&self, reading: [f64; 3]) -> f64 {
        matrix3::norm(&self.calibrated(reading))
    }

    /// A(u − b), m/s².
    #[must_use]
    pub fn calibrated(&self, reading: [f64; 3]) -> [f64; 3] {
        matrix3::mul_vec(&self.matrix, &matrix3::sub(&reading, &self.bias))
    }
}

/// An error of a mean is not enlarged more than this: a tenth of a mm/s² in the
/// poses would be a m/s² elsewhere. What is enlarged less may still be too much;
/// that depends on the noise.
const MOST_ENLARGED: f64 = 1e4;
/// ‖a‖ that is less well known than this share of gravity in some direction is
/// not known: the data sheet alone says as much.
const UNKNOWN: f64 = 0.035;

/// Fits A and b to the length of gravity.
///
/// # Errors
///
/// `underdetermined` when the poses leave parameters open, naming poses that would
/// determine them; `reading-values` for numbers that are none; `not-converged`.
pub fn magnitude(readings: &[Reading], options: &MagnitudeOptions) -> Result<MagnitudeFit> {
    let fit = fit(readings, options)?;
    known(&fit, options, readings.len())?;
    Ok(fit)
}

/// The fit, however well it is known.
fn fit(readings: &[Reading], options: &MagnitudeOptions) -> Result<MagnitudeFit> {
    reading::check(readings)?;
    let first = start(readings, options)
        .ok_or_else(|| Error::input("no-poses", "there is no reading of gravity's length"))?;
    let mut problem = Model {
        readings: readings.iter().map(|r| r.mean).collect(),
        sd: vec![1.0; readings.len()],
        gravity: options.gravity,
        kind: options.kind,
    };
    determined(&problem, &first)?;
    let errors = match options.weights {
        Weights::StandardErrors => reading::standard_errors(readings),
        Weights::Alike => None,
    };
    let mut state = first;
    // The weights need A to a few percent: once is nearly enough, twice is.
    for _ in 0..if errors.is_some() { 2 } else { 1 } {
        if let Some(errors) = &errors {
            problem.weigh(&state, errors);
        }
        let (found, summary) = solve(&problem, state, &Options::default());
        if !summary.converged() || !found.finite() {
            return Err(no_minimum(readings.len(), summary.tried));
        }
        state = found.upright();
    }
    determined(&problem, &state)?;
    let freedom = readings.len() - problem.shared();
    let inverse = matrix3::inverse(&state.a).ok_or_else(|| no_minimum(readings.len(), 0))?;
    let factor = Factor::new(&problem, &state).ok_or_else(|| no_minimum(readings.len(), 0))?;
    let found = factor.covariance();
    let per_freedom = factor.cost() / freedom.max(1) as f64;
    let unit_covariance = match (&errors, freedom) {
        (Some(_), _) => found.values.map(|c| (c, per_freedom.max(1.0))),
        (None, 0) => by_errors_alone(&problem, &state, readings).map(|c| (c, 1.0)),
        (None, _) => found.values.map(|c| (c, per_freedom)),
    };
    Ok(MagnitudeFit {
        covariance: unit_covariance.map(|(c, factor)| problem.twelve(&c, factor, &inverse)),
        residuals_mps2: readings
            .iter()
            .map(|r| matrix3::norm(&state.calibrated(r.mean)) - options.gravity)
            .collect(),
        chi2: errors.is_some().then(|| factor.cost()),
        matrix: state.a,
        bias: state.b,
        model: inverse,
        freedom,
        condition: found.condition,
    })
}

/// No poses to spare: what the standard errors alone say, where there are any.
fn by_errors_alone(problem: &Model, state: &State, readings: &[Reading]) -> Option<Vec<Vec<f64>>> {
    let mut weighed = problem.clone();
    weighed.weigh(state, &reading::standard_errors(readings)?);
    Factor::new(&weighed, state)?.covariance().values
}

fn no_minimum(poses: usize, tried: usize) -> Error {
    Error::input(
        "not-converged",
        format!("the lengths of {poses} poses lead to no calibration ({tried} steps were tried)"),
    )
    .with_hint("is one of them moving, or in another unit? leave out the ones that differ")
}

/// The sphere nearest to the readings: ‖u‖² = 2 b·u + (s²g² − ‖b‖²) is linear in
/// b and the bracket. Where the poses do not carry it, the nominal scale.
fn start(readings: &[Reading], options: &MagnitudeOptions) -> Option<State> {
    let mut lengths: Vec<f64> = readings.iter().map(|r| matrix3::norm(&r.mean)).collect();
    let usual = median(&mut lengths).filter(|l| *l > 0.0)?;
    let sphere = || {
        if readings.len() < 4 {
            return None;
        }
        let rows = DMatrix::from_fn(readings.len(), 4, |k, j| {
            if j < 3 {
                2.0 * readings[k].mean[j] / usual
            } else {
                1.0
            }
        });
        let right = DVector::from_fn(readings.len(), |k, _| {
            (matrix3::norm(&readings[k].mean) / usual).powi(2)
        });
        // The decomposition may never end on what is not finite.
        if rows.iter().chain(&right).any(|v| !v.is_finite()) {
            return None;
        }
        let svd = rows.svd(true, true);
        if svd.singular_values.min() < svd.singular_values.max() / 100.0 {
            return None;
        }
        let x = svd.solve(&right, 0.0).ok()?;
        let b = [x[0], x[1], x[2]];
        let radius = x[3] + b.iter().map(|v| v * v).sum::<f64>();
        (radius > 0.0).then(|| {
            (
                radius.sqrt() * usual / options.gravity,
                b.map(|v| v * usual),
            )
        })
    };
    // A nominal scale that is far off is a wrong unit, not a start.
    let near = |s: f64, to: f64| (0.5..2.0).contains(&(s / to));
    let by_length = usual / options.gravity;
    let nominal = options.nominal.filter(|n| near(by_length, *n));
    let (scale, bias) = sphere()
        .filter(|(s, _)| nominal.is_none_or(|n| near(*s, n)))
        .unwrap_or((nominal.unwrap_or(by_length), [0.0; 3]));
    Some(State {
        a: matrix3::diagonal([1.0 / scale; 3]),
        b: bias,
    })
}

/// Says which poses are missing when the present ones leave parameters open.
///
/// Columns are in natural units (shares of the scale, and of gravity), in which
/// all are of the size of one: a small one means a small angle, not a unit.
fn determined(problem: &Model, state: &State) -> Result<()> {
    let (poses, p) = (problem.readings.len(), problem.shared());
    let scale = matrix3::row_norms(&state.a).iter().sum::<f64>() / 3.0;
    let g = problem.gravity;
    let natural = |u: [f64; 3]| {
        let mut row = problem.row(state, u);
        for (value, element) in row.iter_mut().zip(problem.elements()) {
            *value *= if *element < 9 { scale / g } else { 1.0 / scale };
        }
        DVector::from_vec(row)
    };
    let mut rows = DMatrix::zeros(poses.max(p), p);
    for (k, u) in problem.readings.iter().enumerate() {
        rows.set_row(k, &natural(*u).transpose());
    }
    if rows.iter().any(|v| !v.is_finite()) {
        return Err(no_minimum(poses, 0));
    }
    let svd = rows.svd(false, true);
    let limit = (poses as f64).sqrt() / MOST_ENLARGED;
    let open: Vec<Vec<f64>> = svd.v_t.as_ref().map_or_else(Vec::new, |v_t| {
        (0..p)
            .filter(|&i| svd.singular_values[i] < limit)
            .map(|i| v_t.row(i).iter().copied().collect())
            .collect()
    });
    if open.is_empty() {
        return Ok(());
    }
    let inverse = matrix3::inverse(&state.a).ok_or_else(|| no_minimum(poses, 0))?;
    let wanted = wanted::wanted(&open, false, |n| {
        let at = matrix3::mul_vec(&inverse, &n.map(|v| v * g));
        natural([0, 1, 2].map(|i| at[i] + state.b[i]))
    });
    let directions: Vec<[f64; 3]> = problem
        .readings
        .iter()
        .map(|u| leave_out::direction(&state.calibrated(*u)))
        .collect();
    Err(Error::input(
        "underdetermined",
        format!(
            "{poses} poses span {} of 3 directions and determine {} of the {p} parameters",
            undetermined::span(&directions).0,
            p - open.len()
        ),
    )
    .with_hint(hint(problem.kind, &wanted)))
}

fn hint(kind: Kind, wanted: &[String]) -> String {
    let needs = match kind {
        Kind::Nine => "nine parameters need 9 poses or more, between the axes too",
        Kind::Six => "six parameters need 6 poses or more, about one for each side",
    };
    if wanted.is_empty() {
        needs.to_owned()
    } else {
        format!("{needs}; record it with {}", wanted.join("; with "))
    }
}

/// Refuses a fit that leaves ‖a‖ open in some direction.
fn known(fit: &MagnitudeFit, options: &MagnitudeOptions, poses: usize) -> Result<()> {
    let Some(covariance) = &fit.covariance else {
        return Ok(());
    };
    let (n, sd) = predicted::weakest(&fit.matrix, covariance, options.gravity);
    if sd <= UNKNOWN * options.gravity {
        return Ok(());
    }
    Err(Error::input(
        "underdetermined",
        format!(
            "{poses} poses leave |a| open to ±{:.0} mg along ({:.2}, {:.2}, {:.2})",
            1000.0 * sd / options.gravity,
            n[0],
            n[1],
            n[2]
        ),
    )
    .with_hint(
        "record it with that direction up, and leave out poses that moved or are in another unit",
    ))
}
