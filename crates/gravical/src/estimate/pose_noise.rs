//! How far the mean of a placement may be off: noise and steps of the converter.

use std::f64::consts::PI;

use crate::recording::Recording;
use crate::segment::{Placement, Segmentation};
use crate::stats::median;

/// Standard error that is taken for means whose scatter nobody knows, m/s²: a
/// second of an MPU6050 at 100 Hz with its 44 Hz low-pass.
const ASSUMED_MPS2: f64 = 4e-3;
/// Values that the step of the converter is looked for in.
const MOST_VALUES: usize = 3000;

/// Uncertainty of the means, input unit.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseNoise {
    /// For every placement: by noise.
    pub noise: Vec<[f64; 3]>,
    /// By the steps of the converter, which noise smooths.
    pub quantisation: [f64; 3],
    /// Some standard errors were assumed: a row was a mean itself.
    pub assumed: bool,
}

/// The uncertainty of every placement's mean. `scale` is about one m/s² in the
/// input unit.
///
/// A mean of steps q over noise σ is off by no more than
/// (q/√12)·exp(−2π²σ²/q²): noise of half a step makes steps vanish (Widrow and
/// Kollár, Quantization Noise, 2008, chapter 4).
#[must_use]
pub fn pose_noise(session: &Segmentation, recordings: &[Recording], scale: f64) -> PoseNoise {
    let least = 1e-7 * scale;
    let mut assumed = false;
    let noise = session
        .placements
        .iter()
        .map(|p| match p.standard_error {
            Some(error) => error.map(|e| e.max(least)),
            None => {
                assumed = true;
                [ASSUMED_MPS2 * scale; 3]
            }
        })
        .collect();
    let quantisation = std::array::from_fn(|axis| {
        let step = step(&session.placements, recordings, axis);
        let ratio = session.noise.sigma[axis] / step;
        let left = if ratio.is_finite() {
            (-2.0 * (PI * ratio).powi(2)).exp()
        } else {
            0.0
        };
        step / 12_f64.sqrt() * left
    });
    PoseNoise {
        noise,
        quantisation,
        assumed,
    }
}

/// The step between the values of a channel at rest: the median distance
/// between neighbours among the values that occur.
fn step(placements: &[Placement], recordings: &[Recording], axis: usize) -> f64 {
    let mut values: Vec<f64> = Vec::new();
    for placement in placements {
        let channel = &recordings[placement.recording].accel[axis];
        let share = MOST_VALUES / placements.len().max(1) + 1;
        let rows = placement.rows.iter().flat_map(Clone::clone).take(share);
        values.extend(rows.map(|row| channel[row]).filter(|v| v.is_finite()));
    }
    if values.len() <= placements.len() {
        return decimal_step(&values);
    }
    values.sort_unstable_by(f64::total_cmp);
    let tiny = 1e-9 * values.last().map_or(0.0, |v| v.abs());
    let mut steps: Vec<f64> = values
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > tiny)
        .collect();
    // Placements are far apart; the steps between their values are not meant.
    steps.sort_unstable_by(f64::total_cmp);
    steps.truncate(steps.len().saturating_sub(placements.len()).max(1));
    median(&mut steps).unwrap_or(0.0)
}

/// The last decimal place that values were written with.
fn decimal_step(values: &[f64]) -> f64 {
    (0..=9)
        .map(|places| 10_f64.powi(places))
        .find(|p| {
            values
                .iter()
                .all(|v| ((v * p).round() - v * p).abs() < 1e-4)
        })
        .map_or(0.0, |p| 1.0 / p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_that_values_were_written_with() {
        assert_eq!(decimal_step(&[9.43, -0.27, 10.2]), 0.01);
        assert_eq!(decimal_step(&[16384.0, -512.0]), 1.0);
        assert_eq!(decimal_step(&[1.0 / 3.0]), 0.0);
    }
}
