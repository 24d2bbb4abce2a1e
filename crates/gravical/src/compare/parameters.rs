//! The twelve parameters in a form that a rotation of the frame leaves alone,
//! nine numbers that change ‖a‖, and the rotation, three that do not.
//!
//! With u = M a + b, a turned frame is M → M Q. Lengths k_i of the rows of M,
//! angles between them and b stay as they are (they are M Mᵀ and b), and ‖a‖
//! depends on nothing else. What is left is Q: the polar factor of M_A⁻¹ M_B.

use gravical_core::matrix3::{dot, inverse, mul};
use nalgebra::{DMatrix, Matrix3, Rotation3, SMatrix, UnitQuaternion, Vector3};

use super::unit::NominalModel;

/// Derivatives by M (row by row) and b.
pub(super) type Jacobian<const N: usize> = SMatrix<f64, N, 12>;

/// The pairs of axes, in the order of the angles.
pub(super) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Bias (m/s²), scale (share of nominal) and angle beyond 90° between the
/// sensor's axes (rad), with their derivatives.
pub(super) fn invariants(side: &NominalModel) -> ([f64; 9], Jacobian<9>) {
    invariants_of(&side.model, &side.bias)
}

fn invariants_of(model: &[[f64; 3]; 3], bias: &[f64; 3]) -> ([f64; 9], Jacobian<9>) {
    let mut values = [0.0; 9];
    let mut jacobian = Jacobian::<9>::zeros();
    let k = gravical_core::matrix3::row_norms(model);
    let r: [[f64; 3]; 3] = std::array::from_fn(|i| model[i].map(|v| v / k[i]));
    for i in 0..3 {
        values[i] = bias[i];
        jacobian[(i, 9 + i)] = 1.0;
        values[3 + i] = k[i];
        for c in 0..3 {
            jacobian[(3 + i, 3 * i + c)] = r[i][c];
        }
    }
    for (at, (i, j)) in PAIRS.into_iter().enumerate() {
        let cosine = dot(&r[i], &r[j]);
        values[6 + at] = cosine.acos() - std::f64::consts::FRAC_PI_2;
        let sine = (1.0 - cosine * cosine).sqrt().max(f64::MIN_POSITIVE);
        for c in 0..3 {
            jacobian[(6 + at, 3 * i + c)] = -(r[j][c] - cosine * r[i][c]) / k[i] / sine;
            jacobian[(6 + at, 3 * j + c)] = -(r[i][c] - cosine * r[j][c]) / k[j] / sine;
        }
    }
    (values, jacobian)
}

/// The rotation between two frames.
pub(super) struct Rotation {
    /// Rotation vector of Q, rad: a_A = Q a_B but for what changes ‖a‖.
    pub vector: [f64; 3],
    /// Derivatives by the parameters of the first and the second calibration.
    pub jacobians: [Jacobian<3>; 2],
}

/// Polar decomposition T = M_A⁻¹ M_B = Q P. From T + dT follows Q (1 + \[ω\]) with
/// (tr P − P) ω = vee(Qᵀ dT − dTᵀ Q). None when one frame is the mirror image of
/// the other: no rotation leads from one to the other.
pub(super) fn rotation(a: &NominalModel, b: &NominalModel) -> Option<Rotation> {
    let to_matrix = |m: &[[f64; 3]; 3]| Matrix3::from_fn(|r, c| m[r][c]);
    let t = to_matrix(&mul(&a.matrix, &b.model));
    // The decomposition may never end on what is not finite.
    if t.determinant() <= 0.0 || t.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let svd = t.svd(true, true);
    let q = svd.u? * svd.v_t?;
    let p = q.transpose() * t;
    let lever = Matrix3::identity() * p.trace() - p;
    let lever: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| lever[(r, c)]));
    let solve = to_matrix(&inverse(&lever)?);
    let m_a_inverse = to_matrix(&a.matrix);
    let mut jacobians = [Jacobian::<3>::zeros(), Jacobian::<3>::zeros()];
    for element in 0..9 {
        let mut unit = Matrix3::zeros();
        unit[(element / 3, element % 3)] = 1.0;
        let changes = [-m_a_inverse * unit * t, m_a_inverse * unit];
        for (jacobian, change) in jacobians.iter_mut().zip(changes) {
            let x = q.transpose() * change - change.transpose() * q;
            let omega = solve * Vector3::new(x[(2, 1)], x[(0, 2)], x[(1, 0)]);
            (0..3).for_each(|i| jacobian[(i, element)] = omega[i]);
        }
    }
    // By the quaternion: exact for the smallest turns, where a cosine is not.
    let vector =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(q)).scaled_axis();
    Some(Rotation {
        vector: vector.into(),
        jacobians,
    })
}

/// J C Jᵀ.
pub(super) fn propagate<const N: usize>(
    jacobian: &Jacobian<N>,
    covariance: &crate::uncertainty::Covariance12,
) -> DMatrix<f64> {
    let c = SMatrix::<f64, 12, 12>::from_fn(|r, k| covariance[r][k]);
    let product = jacobian * c * jacobian.transpose();
    DMatrix::from_fn(N, N, |r, k| product[(r, k)])
}

/// Step of the difference quotient of first derivatives; M is near 1.
const STEP: f64 = 1e-4;

/// What the second order adds to the covariance of the invariants: for normal
/// errors d of the parameters the parts dᵀQ_i d have the mean products
/// 2 tr(Q_i C Q_j C) + tr(Q_i C) tr(Q_j C).
///
/// A row of M that is known to 2° across itself is longer than it seems by
/// 0.06 %, many times what the first order says of its length.
pub(super) fn second_order(
    side: &NominalModel,
    covariance: &crate::uncertainty::Covariance12,
) -> DMatrix<f64> {
    let c = SMatrix::<f64, 12, 12>::from_fn(|r, k| covariance[r][k]);
    let slopes: Vec<Jacobian<9>> = (0..9)
        .map(|element| {
            let at = |by: f64| {
                let mut moved = side.model;
                moved[element / 3][element % 3] += by;
                invariants_of(&moved, &side.bias).1
            };
            (at(STEP) - at(-STEP)) / (2.0 * STEP)
        })
        .collect();
    let qc: Vec<SMatrix<f64, 12, 12>> =
        (0..9)
            .map(|i| {
                let q = SMatrix::<f64, 12, 12>::from_fn(|r, k| {
                    if r < 9 { 0.5 * slopes[r][(i, k)] } else { 0.0 }
                });
                q * c
            })
            .collect();
    DMatrix::from_fn(9, 9, |i, j| {
        let trace = qc[i].component_mul(&qc[j].transpose()).sum();
        2.0 * trace + qc[i].trace() * qc[j].trace()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(model: [[f64; 3]; 3], bias: [f64; 3]) -> NominalModel {
        NominalModel {
            model,
            matrix: inverse(&model).unwrap(),
            bias,
            covariance: None,
            gravity: 9.81,
            tilt_degrees_of_freedom: None,
        }
    }

    const M: [[f64; 3]; 3] = [[1.02, 0.01, -0.02], [0.03, 0.97, 0.03], [-0.01, 0.02, 1.01]];

    fn turned(by: Vector3<f64>) -> [[f64; 3]; 3] {
        let q = Rotation3::new(by);
        let m = Matrix3::from_fn(|r, c| M[r][c]) * q.matrix();
        std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
    }

    #[test]
    fn a_turn_of_the_frame_changes_the_turn_alone() {
        let by = Vector3::new(0.3, -0.9, 0.4);
        let (a, b) = (side(M, [0.1, 0.2, 0.3]), side(turned(by), [0.1, 0.2, 0.3]));
        let (va, vb) = (invariants(&a).0, invariants(&b).0);
        for (x, y) in va.iter().zip(vb) {
            assert!((x - y).abs() < 1e-12, "{va:?} {vb:?}");
        }
        let found = rotation(&a, &b).unwrap();
        for i in 0..3 {
            assert!(
                (found.vector[i] - by[i]).abs() < 1e-12,
                "{:?}",
                found.vector
            );
        }
    }

    #[test]
    fn a_mirrored_frame_is_seen() {
        let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let a = side(M, [0.0; 3]);
        let b = side(mul(&M, &mirror), [0.0; 3]);
        assert!(rotation(&a, &b).is_none());
    }
}
