//! Covariances of M and b in files, and what they say of numbers that no mounting changes.

use gravical_core::matrix3;

use crate::calibration_file::AccelerometerSection;

/// Accelerometer parameters: M row by row, then b.
pub type Covariance12 = [[f64; 12]; 12];

/// What turning the board in its case leaves alone: the lengths of the rows of M
/// (scale), the cosines between them (xy, yz, zx), and b.
pub(crate) fn invariants(m: &[[f64; 3]; 3], b: &[f64; 3]) -> [f64; 9] {
    let k = matrix3::row_norms(m);
    let cosine = |p: usize, q: usize| matrix3::dot(&m[p], &m[q]) / (k[p] * k[q]);
    [
        k[0],
        k[1],
        k[2],
        cosine(0, 1),
        cosine(1, 2),
        cosine(2, 0),
        b[0],
        b[1],
        b[2],
    ]
}

/// Derivatives of [`invariants`] by row-major M and b. That of a cosine is also
/// the derivative of the angle, in rad, but for its sign.
pub(crate) fn invariant_derivatives(m: &[[f64; 3]; 3]) -> [[f64; 12]; 9] {
    let k = matrix3::row_norms(m);
    let r = matrix3::scale_rows(m, &k.map(|k| 1.0 / k));
    let mut out = [[0.0; 12]; 9];
    for i in 0..3 {
        out[i][3 * i..3 * i + 3].copy_from_slice(&r[i]);
        let (p, q) = (i, (i + 1) % 3);
        let cosine = matrix3::dot(&r[p], &r[q]);
        for a in 0..3 {
            out[3 + i][3 * p + a] = (r[q][a] - cosine * r[p][a]) / k[p];
            out[3 + i][3 * q + a] = (r[p][a] - cosine * r[q][a]) / k[q];
        }
        out[6 + i][9 + i] = 1.0;
    }
    out
}

/// What gravity that is known to `sd_mps2` only does to the parameters: M is
/// fitted in proportion to 1/g and b does not depend on it, so (σ/g)² times the
/// outer product of M's elements. No placement can lower it.
pub(crate) fn of_gravity(model: &[[f64; 3]; 3], sd_mps2: f64, gravity: f64) -> Covariance12 {
    let share = (sd_mps2 / gravity).powi(2);
    let element = |i: usize| if i < 9 { model[i / 3][i % 3] } else { 0.0 };
    std::array::from_fn(|i| std::array::from_fn(|j| share * element(i) * element(j)))
}

/// The sum of two covariances, element by element.
pub(crate) fn sum(a: &Covariance12, b: &Covariance12) -> Covariance12 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// The covariance of a file by its readings alone: without what the gravity of
/// the session adds. For what happens in the same place, with the same error of
/// gravity.
pub(crate) fn covariance_at_its_gravity(
    section: &AccelerometerSection,
    gravity: f64,
) -> Option<Covariance12> {
    let all = covariance_of(section)?;
    let model = matrix3::inverse(&section.matrix)?;
    let own = of_gravity(&model, section.gravity_sd_mps2, gravity);
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| all[i][j] - own[i][j])
    }))
}

/// The covariance of M and b in a file as numbers; none where it is absent, of another
/// size, not finite or zero throughout.
pub fn covariance_of(section: &AccelerometerSection) -> Option<Covariance12> {
    let values = &section.covariance.as_ref()?.values;
    if values.len() < 12 || values.iter().any(|row| row.len() < 12) {
        return None;
    }
    let all = || values.iter().flatten();
    let usable = all().all(|v| v.is_finite()) && all().any(|v| *v != 0.0);
    usable.then(|| std::array::from_fn(|r| std::array::from_fn(|c| values[r][c])))
}
