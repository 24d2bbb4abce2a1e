//! u = M a + b, its parameters, and the derivatives of what follows from them.
//!
//! A pose reads u = M g n + b + noise. With A = M⁻¹ and a = A (u − b) it says ‖a‖ = g, whatever its
//! direction n.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};

/// Number of parameters: M row-major, b, drift of b per °C, nonlinearity of the axes (quadratic, cubic).
pub const PARAMETERS: usize = 21;
/// First element of b.
pub const BIAS: usize = 9;
/// First element of the drift.
pub const DRIFT: usize = 12;
/// First nonlinearity coefficient.
pub const NONLINEARITY: usize = 15;

/// M row-major; b; drift of b per °C; nonlinearity: quadratic, cubic, as a share of g at 1 g.
pub type Parameters = SVector<f64, PARAMETERS>;
/// Covariance of these.
pub type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// M.
pub fn matrix(x: &Parameters) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| x[3 * r + c])
}

/// M⁻¹; NaN where M is singular.
pub(crate) fn inverse(x: &Parameters) -> Matrix3<f64> {
    let inverse = matrix(x).try_inverse();
    inverse.unwrap_or_else(|| Matrix3::repeat(f64::NAN))
}

/// b at a temperature `warmer_c` above that of reference.
pub fn bias(x: &Parameters, warmer_c: f64) -> Vector3<f64> {
    Vector3::from_fn(|i, _| x[BIAS + i] + warmer_c * x[DRIFT + i])
}

/// Relative error of ‖a‖ along n by a nonlinear response of the axes, for each of the six nonlinearity coefficients:
/// Legendre's P₃ and P₄ (monic) of every component, the part of n² and n³ of an axis that no M and b
/// imitate. M and b are thus those that suit the nonlinear sensor best over the sphere.
pub fn nonlinearity(n: &Vector3<f64>) -> SVector<f64, 6> {
    SVector::from_fn(|i, _| {
        let c = n[i % 3];
        if i < 3 {
            c * c * c - 0.6 * c
        } else {
            c.powi(4) - 6.0 / 7.0 * c * c + 3.0 / 35.0
        }
    })
}

/// Relative error of ‖a‖ along n by all six.
pub fn nonlinear_error(x: &Parameters, n: &Vector3<f64>) -> f64 {
    nonlinearity(n).dot(&x.fixed_rows::<6>(NONLINEARITY))
}

/// h of ‖a‖ along n: an error d of the parameters moves the length of a calibrated reading by
/// −hᵀd. With w = M⁻ᵀ n it is [g w⊗n ; w], and g times [`nonlinearity`].
pub fn sensitivity(inverse: &Matrix3<f64>, n: &Vector3<f64>, gravity: f64) -> Parameters {
    let w = inverse.transpose() * n;
    let nonlinearity = nonlinearity(n);
    Parameters::from_fn(|i, _| match i {
        0..BIAS => gravity * w[i / 3] * n[i % 3],
        BIAS..DRIFT => w[i - BIAS],
        DRIFT..NONLINEARITY => 0.0,
        _ => gravity * nonlinearity[i - NONLINEARITY],
    })
}

/// What no turn of the board changes, and ‖a‖ depends on: b (unit of the readings), the lengths of the rows of M,
/// and the angles xy, xz, yz between them beyond 90° (rad).
pub fn invariants(x: &Parameters) -> DVector<f64> {
    let m = matrix(x);
    let row = |i: usize| m.row(i).transpose();
    let angle = |i: usize, j: usize| {
        let cosine = row(i).normalize().dot(&row(j).normalize());
        cosine.clamp(-1.0, 1.0).acos() - std::f64::consts::FRAC_PI_2
    };
    DVector::from_fn(9, |i, _| match i {
        0..3 => x[BIAS + i],
        3..6 => row(i - 3).norm(),
        6 => angle(0, 1),
        7 => angle(0, 2),
        _ => angle(1, 2),
    })
}

/// Derivatives of `f` by the parameters, central differences with a step of 1e-5: `x` has to be scaled so
/// that M is about 1. None where `f` has no value.
pub fn jacobian(
    x: &Parameters,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    const STEP: f64 = 1e-5;
    let column = |i: usize| {
        let (mut up, mut down) = (*x, *x);
        up[i] += STEP;
        down[i] -= STEP;
        Some((f(&up)? - f(&down)?) / (2.0 * STEP))
    };
    let columns: Option<Vec<_>> = (0..PARAMETERS).map(column).collect();
    Some(DMatrix::from_columns(&columns?))
}

/// Steps of a decomposition; it takes some tens, and never ends on some broken matrices.
pub(crate) const MAX_STEPS: usize = 10_000;

/// Directions over which ‖a‖ is looked at.
pub(crate) const DIRECTIONS: usize = 400;

/// `count` directions spread evenly over the sphere (Fibonacci lattice).
pub fn sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let radius = (1.0 - z * z).sqrt();
        let (sine, cosine) = (golden * i as f64).sin_cos();
        Vector3::new(radius * cosine, radius * sine, z)
    })
}

/// Two unit vectors that are perpendicular to n and to each other.
pub fn tangents(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let t = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    [t, n.cross(&t)]
}

/// The upper of two middle values; NaN of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
