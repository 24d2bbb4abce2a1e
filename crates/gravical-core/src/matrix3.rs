//! The few operations on 3 × 3 matrices that a calibration needs.
//!
//! Matrices are row-major, `matrix[row][column]`, and plain arrays, so that no
//! linear algebra crate shows in a signature. None of these functions checks
//! its input: a value that is not finite goes through, except in [`inverse`],
//! which has no result then.

use core::array::from_fn;

use crate::Real;

/// The identity matrix.
pub fn identity<T: Real>() -> [[T; 3]; 3] {
    diagonal([T::one(); 3])
}

/// The matrix with `values` on its diagonal and zero elsewhere.
pub fn diagonal<T: Real>(values: [T; 3]) -> [[T; 3]; 3] {
    from_fn(|r| from_fn(|c| if r == c { values[r] } else { T::zero() }))
}

/// The scalar product of two vectors.
pub fn dot<T: Real>(a: &[T; 3], b: &[T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The Euclidean norm of a vector, in the unit of its components.
///
/// The squares of components above about 1e19 overflow in `f32` (1e154 in
/// `f64`): the result is infinite then.
pub fn norm<T: Real>(v: &[T; 3]) -> T {
    dot(v, v).sqrt()
}

/// The vector brought to length one; NaN for a vector without length.
pub fn unit<T: Real>(v: &[T; 3]) -> [T; 3] {
    let length = norm(v);
    v.map(|x| x / length)
}

/// The Euclidean norms of the three rows of `m`.
pub fn row_norms<T: Real>(m: &[[T; 3]; 3]) -> [T; 3] {
    [norm(&m[0]), norm(&m[1]), norm(&m[2])]
}

/// The matrix with rows and columns exchanged.
pub fn transpose<T: Real>(m: &[[T; 3]; 3]) -> [[T; 3]; 3] {
    from_fn(|r| from_fn(|c| m[c][r]))
}

/// The product `a · b`.
///
/// ```
/// use gravical_core::matrix3::{mul, mul_vec};
///
/// let quarter_turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// assert_eq!(mul_vec(&quarter_turn, &[1.0, 0.0, 2.0]), [0.0, 1.0, 2.0]);
/// let half_turn = mul(&quarter_turn, &quarter_turn);
/// assert_eq!(mul_vec(&half_turn, &[1.0, 0.0, 2.0]), [-1.0, 0.0, 2.0]);
/// ```
pub fn mul<T: Real>(a: &[[T; 3]; 3], b: &[[T; 3]; 3]) -> [[T; 3]; 3] {
    let columns = transpose(b);
    from_fn(|r| from_fn(|c| dot(&a[r], &columns[c])))
}

/// The product `m · v`.
pub fn mul_vec<T: Real>(m: &[[T; 3]; 3], v: &[T; 3]) -> [T; 3] {
    [dot(&m[0], v), dot(&m[1], v), dot(&m[2], v)]
}

/// The difference `a − b`.
pub fn sub<T: Real>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The sum `a + b`.
pub fn add<T: Real>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Each row `r` of `m` multiplied by `factors[r]`: diag(factors) · m.
pub fn scale_rows<T: Real>(m: &[[T; 3]; 3], factors: &[T; 3]) -> [[T; 3]; 3] {
    from_fn(|r| m[r].map(|x| x * factors[r]))
}

/// The determinant, in the cubed unit of the elements.
pub fn det<T: Real>(m: &[[T; 3]; 3]) -> T {
    dot(&m[0], &cross(&m[1], &m[2]))
}

/// The inverse, from the adjugate of the matrix with its rows made unit vectors.
///
/// `None` when an element is not finite, or when |det m| is at most 8 machine
/// epsilons of the product of the row norms (the rounding error of the
/// determinant itself): the rows then lie in a plane, and an inverse would be
/// rounding error only. Because the test is relative, counts and m/s² fare alike.
///
/// ```
/// use gravical_core::matrix3::inverse;
///
/// let m = [[2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 0.0, 1.0]];
/// assert_eq!(inverse(&m), Some([[0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [-0.5, 0.0, 1.0]]));
/// assert_eq!(inverse(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]), None);
/// ```
pub fn inverse<T: Real>(m: &[[T; 3]; 3]) -> Option<[[T; 3]; 3]> {
    // Unit rows keep the products of three elements inside the range of f32.
    let reciprocal = row_norms(m).map(|n| n.recip());
    let unit = scale_rows(m, &reciprocal);
    let determinant = det(&unit);
    let rounding = T::from_f64(8.0) * T::epsilon();
    // A NaN or a row of zeros ends here as well: both make `unit` not finite.
    if !determinant.is_finite() || determinant.abs() <= rounding {
        return None;
    }
    // The columns of the adjugate are the cross products of the rows.
    let columns = [
        cross(&unit[1], &unit[2]),
        cross(&unit[2], &unit[0]),
        cross(&unit[0], &unit[1]),
    ];
    let inverse = from_fn(|r| from_fn(|c| columns[c][r] / determinant * reciprocal[c]));
    let mut elements = inverse.iter().flatten();
    elements.all(|x| x.is_finite()).then_some(inverse)
}

/// The cross product `a × b`.
pub fn cross<T: Real>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const M: [[f64; 3]; 3] = [[1.0, 2.0, 3.0], [0.0, 1.0, 4.0], [5.0, 6.0, 0.0]];

    fn is_identity(m: &[[f64; 3]; 3], tolerance: f64) -> bool {
        let identity = identity::<f64>();
        let mut pairs = m.iter().flatten().zip(identity.iter().flatten());
        pairs.all(|(x, one)| (x - one).abs() < tolerance)
    }

    #[test]
    fn an_inverse_that_rounding_decides_is_none() {
        let [mut not_a_number, mut infinite] = [M; 2];
        not_a_number[1][1] = f64::NAN;
        infinite[1][1] = f64::INFINITY;
        // Plain thirds: singular on paper, not in floating point.
        let thirds = [[1.0 / 3.0, 0.1, 0.7], [1.0, 0.3, 2.1], [0.2, 5.0, 1.0]];
        let twice = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for m in [[[0.0; 3]; 3], twice, not_a_number, infinite, thirds] {
            assert_eq!(inverse(&m), None, "{m:?}");
        }
    }

    #[test]
    fn the_unit_does_not_decide_what_is_singular() {
        // 1e-14 cubed is below the smallest f32, 1e14 cubed above the largest.
        for factor in [1e-14_f32, 1.0, 16384.0, 1e14] {
            let m = M.map(|row| row.map(|x| x as f32 * factor));
            let product = mul(&m, &inverse(&m).unwrap());
            let product = product.map(|row| row.map(f64::from));
            assert!(is_identity(&product, 1e-4), "{product:?}");
        }
    }
}
