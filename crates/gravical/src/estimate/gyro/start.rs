//! Where to start when nobody says what one count of the gyroscope is, or when
//! its axes are not those of the accelerometer.
//!
//! A motion about one fixed axis turns gravity so that
//!
//! ```text
//! v₁ − v₀ = f · (v₀ + v₁)/2 × ψ,   ψ = ∫ω dt,   f = tan(|ψ|/2) / (|ψ|/2)
//! ```
//!
//! which is exact, and linear in ψ but for f. The hand does not turn about one
//! axis, but it comes near enough for a start.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::motions::Motions;

type Matrix = [[f64; 3]; 3];

/// What the fixed-axis formula needs of a motion.
struct Chord {
    /// v₁ − v₀.
    change: Vector3<f64>,
    /// (v₀ + v₁)/2.
    middle: Vector3<f64>,
    /// ∫u dt, units of the file times s.
    integral: Vector3<f64>,
}

/// Gravity that turns by less says nothing over the noise; by more, the way is
/// not known.
const USABLE_DEG: std::ops::Range<f64> = 8.0..160.0;

fn chords(motions: &Motions) -> Vec<Chord> {
    motions
        .list
        .iter()
        .filter_map(|m| {
            let [from, to] = m.gravity.map(Vector3::from);
            let angle = from.cross(&to).norm().atan2(from.dot(&to)).to_degrees();
            let mut integral = Vector3::zeros();
            for s in &motions.samples[m.samples.clone()] {
                integral += Vector3::new(s[0], s[1], s[2]) * s[3];
            }
            USABLE_DEG.contains(&angle).then_some(Chord {
                change: to - from,
                middle: 0.5 * (from + to),
                integral,
            })
        })
        .collect()
}

/// Rad/s per unit of the file, negative for a gyroscope that counts the other
/// way round: the median over the motions, with axes as the accelerometer's.
/// None where no motion shows it.
pub(super) fn scale(motions: &Motions) -> Option<f64> {
    let mut found: Vec<f64> = chords(motions)
        .iter()
        .filter_map(|c| {
            let turned = c.middle.cross(&c.integral);
            let along = c.change.dot(&turned);
            // Only motions that the formula fits within 25°.
            let fits = along.abs() > 0.9 * c.change.norm() * turned.norm();
            let length = c.integral.norm();
            let half = along / turned.norm_squared() * 0.5 * length;
            fits.then(|| 2.0 * half.atan() / length)
        })
        .filter(|s| s.is_finite() && *s != 0.0)
        .collect();
    crate::stats::median(&mut found)
}

/// All nine elements of G, rad/s per unit of the file, by the fixed-axis
/// formula; far motions count little. None where they are too few.
pub(super) fn matrix(motions: &Motions) -> Option<Matrix> {
    let chords = chords(motions);
    if chords.len() < 6 {
        return None;
    }
    let size = chords.iter().map(|c| c.integral.norm()).fold(0.0, f64::max);
    if size <= 0.0 {
        return None;
    }
    let mut g = Matrix3::<f64>::zeros();
    let mut weights = vec![1.0; chords.len()];
    for round in 0..20 {
        let mut a = DMatrix::zeros(3 * chords.len(), 9);
        let mut b = DVector::zeros(3 * chords.len());
        for (n, c) in chords.iter().enumerate() {
            let half = 0.5 * (g * c.integral / size).norm().min(3.0);
            let f = if half > 1e-6 { half.tan() / half } else { 1.0 };
            let cross = c.middle.cross_matrix();
            for i in 0..3 {
                for r in 0..3 {
                    for k in 0..3 {
                        a[(3 * n + i, 3 * r + k)] =
                            weights[n] * cross[(i, r)] * c.integral[k] / size;
                    }
                }
                b[3 * n + i] = weights[n] * c.change[i] / f;
            }
        }
        // The decomposition may never end on what is not finite.
        if a.iter().chain(&b).any(|v| !v.is_finite()) {
            return None;
        }
        let solution = a.clone().svd(true, true).solve(&b, 1e-9).ok()?;
        g = Matrix3::from_row_slice(solution.as_slice());
        if round % 2 == 1 {
            let rest = &a * &solution - &b;
            let mut lengths: Vec<f64> = (0..chords.len())
                .map(|n| rest.rows(3 * n, 3).norm() / weights[n])
                .collect();
            let typical = crate::stats::median(&mut lengths.clone())?.max(1e-3);
            for (w, l) in weights.iter_mut().zip(lengths.drain(..)) {
                *w = 1.0 / (1.0 + (l / (2.0 * typical)).powi(2)).sqrt();
            }
        }
    }
    let rows: Matrix = (g / size).transpose().into();
    matrix3::is_finite(&rows).then_some(rows)
}
