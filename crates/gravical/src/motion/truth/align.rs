//! The rotation that brings a reference closest to a result.

use gravical_core::strapdown;
use nalgebra::{Matrix4, SymmetricEigen, Vector4};

/// Two leading eigenvalues closer than this share of the first: the points lie
/// on a line, and turning about it changes nothing.
const LINE: f64 = 1e-3;

/// A rotation that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rotation {
    /// w, x, y, z: reference → result.
    pub quaternion: [f64; 4],
    /// The points leave a turn about one line open; the smallest one was taken.
    pub line: bool,
}

impl Rotation {
    /// The identity.
    pub fn none() -> Self {
        Rotation {
            quaternion: [1.0, 0.0, 0.0, 0.0],
            line: false,
        }
    }

    /// A reference's vector in the frame of the result.
    pub fn apply(&self, v: &[f64; 3]) -> [f64; 3] {
        strapdown::rotate(&self.quaternion, v)
    }

    /// As a rotation vector, degrees.
    pub fn vector_deg(&self) -> [f64; 3] {
        let [w, x, y, z] = self.quaternion;
        let sine = (x * x + y * y + z * z).sqrt();
        if sine == 0.0 {
            return [0.0; 3];
        }
        // The shorter way round.
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let angle = 2.0 * sine.atan2(w.abs()).to_degrees() * sign;
        [x, y, z].map(|v| v / sine * angle)
    }

    /// Angle between the two z axes, degrees.
    pub fn tilt_deg(&self) -> f64 {
        let z = self.apply(&[0.0, 0.0, 1.0]);
        z[0].hypot(z[1]).atan2(z[2]).to_degrees()
    }
}

/// The turn about z that brings the steps of `reference` closest to those of
/// `result`: ψ = atan2(Σ rₓpᵧ − rᵧpₓ, Σ rₓpₓ + rᵧpᵧ).
pub(super) fn yaw(reference: &[[f64; 3]], result: &[[f64; 3]]) -> Rotation {
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (r, p) in reference.iter().zip(result) {
        sine += r[0] * p[1] - r[1] * p[0];
        cosine += r[0] * p[0] + r[1] * p[1];
    }
    let half = 0.5 * f64::atan2(sine, cosine);
    if !half.is_finite() {
        return Rotation::none();
    }
    Rotation {
        quaternion: [half.cos(), 0.0, 0.0, half.sin()],
        line: false,
    }
}

/// The rotation that brings the steps of `reference` closest to those of
/// `result`: the eigenvector of the largest eigenvalue of Horn's matrix
/// (Horn 1987, Closed-form solution of absolute orientation using unit
/// quaternions).
pub(super) fn rotation(reference: &[[f64; 3]], result: &[[f64; 3]]) -> Rotation {
    let mut s = [[0.0; 3]; 3];
    for (r, p) in reference.iter().zip(result) {
        for i in 0..3 {
            for j in 0..3 {
                s[i][j] += r[i] * p[j];
            }
        }
    }
    if !s.iter().flatten().all(|v| v.is_finite()) {
        return Rotation::none();
    }
    let n = Matrix4::new(
        s[0][0] + s[1][1] + s[2][2],
        s[1][2] - s[2][1],
        s[2][0] - s[0][2],
        s[0][1] - s[1][0],
        s[1][2] - s[2][1],
        s[0][0] - s[1][1] - s[2][2],
        s[0][1] + s[1][0],
        s[2][0] + s[0][2],
        s[2][0] - s[0][2],
        s[0][1] + s[1][0],
        s[1][1] - s[0][0] - s[2][2],
        s[1][2] + s[2][1],
        s[0][1] - s[1][0],
        s[2][0] + s[0][2],
        s[1][2] + s[2][1],
        s[2][2] - s[0][0] - s[1][1],
    );
    let eigen = SymmetricEigen::new(n);
    let mut order = [0, 1, 2, 3];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [first, second, ..] = order.map(|k| eigen.eigenvalues[k]);
    if first <= 0.0 {
        return Rotation::none();
    }
    let line = first - second < LINE * first;
    let best: Vector4<f64> = eigen.eigenvectors.column(order[0]).into();
    let chosen = if line {
        // Of all rotations that fit, the one nearest to none at all.
        let other: Vector4<f64> = eigen.eigenvectors.column(order[1]).into();
        best * best[0] + other * other[0]
    } else {
        best
    };
    let length = chosen.norm();
    let q = if length > 1e-9 { chosen / length } else { best };
    Rotation {
        quaternion: [q[0], q[1], q[2], q[3]],
        line,
    }
}
