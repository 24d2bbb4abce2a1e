//! What the parameters make of a way without rotation, in closed form.

use gravical_core::matrix3::{dot, mul_vec};

use super::super::parameters::Direction;

/// Σ (o + F p)² over the directions, per axis, as a polynomial of p: o is what the
/// legs before have come to.
pub(super) struct Linear {
    /// Σ F_iᵀF_i, F_i the row of axis i.
    squares: [[[f64; 3]; 3]; 3],
    /// Σ o_i F_i.
    mixed: [[f64; 3]; 3],
    constant: [f64; 3],
}

impl Linear {
    pub fn new(directions: &[Direction], offsets: &[[f64; 3]]) -> Self {
        let mut out = Linear {
            squares: [[[0.0; 3]; 3]; 3],
            mixed: [[0.0; 3]; 3],
            constant: [0.0; 3],
        };
        for (direction, offset) in directions.iter().zip(offsets) {
            for (i, row) in direction.matrix().iter().enumerate() {
                for a in 0..3 {
                    for b in 0..3 {
                        out.squares[i][a][b] += row[a] * row[b];
                    }
                    out.mixed[i][a] += offset[i] * row[a];
                }
                out.constant[i] += offset[i] * offset[i];
            }
        }
        out
    }

    pub fn of_velocity(&self, v: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| dot(v, &mul_vec(&self.squares[i], v)).max(0.0))
    }

    pub fn of_position(&self, p: &[f64; 3]) -> [f64; 3] {
        let own = self.of_velocity(p);
        std::array::from_fn(|i| (self.constant[i] + 2.0 * dot(&self.mixed[i], p) + own[i]).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::anchors::{Anchors, Walk};
    use crate::motion::leg::Ran;
    use crate::motion::options::GravityRemoval;
    use crate::motion::parameters::{DATA_SHEET, by_class};
    use crate::motion::path::Setup;
    use crate::motion::samples::Samples;

    const STEP: f64 = 1e-3;

    #[test]
    fn without_rotation_the_effect_of_the_parameters_is_linear() {
        // Two seconds along a curve, 100 Hz, the mean of gravity taken off.
        let mean = [0.3, -0.2, 9.8];
        let rows = 200;
        let force = |i: usize, c: usize| mean[c] + (0.05 * (i * (c + 1)) as f64).sin();
        let samples = Samples {
            t_s: (0..rows).map(|i| 0.01 * i as f64).collect(),
            force_mps2: std::array::from_fn(|c| (0..rows).map(|i| force(i, c)).collect()),
            rate_rad_s: None,
            row: (0..rows).collect(),
            breaks: Vec::new(),
            resolution: [0.0; 6],
        };
        let directions = by_class(&DATA_SHEET);
        let setup = Setup {
            stances: &[],
            samples: &samples,
            walk: Walk::default(),
            directions: &directions,
            removal: GravityRemoval::StillMean,
            mean: Some((mean, 5.0)),
            wobble: 0.0,
            clock_error: 0.0,
            v0: [0.0; 3],
            p0: [0.0; 3],
            bands: true,
        };
        let start = Anchors::new(&samples, setup.walk).over(0..10);
        let leg = setup.leg(0, rows - 1, start, None, [1.0, 0.0, 0.0, 0.0]);
        let (mut ran, mut changed) = (Ran::default(), Ran::default());
        leg.run(&Direction::NONE, false, &mut ran);
        let offsets: Vec<[f64; 3]> = (0..directions.len())
            .map(|d| [0.01 * d as f64, -0.02, 0.005 * d as f64])
            .collect();
        let effect = Linear::new(&directions, &offsets);
        for k in [1, 50, 199] {
            let (mut v2, mut p2) = ([0.0; 3], [0.0; 3]);
            for (direction, offset) in directions.iter().zip(&offsets) {
                leg.run(&direction.times(STEP), false, &mut changed);
                for i in 0..3 {
                    let v = (changed.velocity[k][i] - ran.velocity[k][i]) / STEP;
                    let p = (changed.position[k][i] - ran.position[k][i]) / STEP;
                    v2[i] += v * v;
                    p2[i] += (offset[i] + p).powi(2);
                }
            }
            let (v, p) = (
                effect.of_velocity(&ran.velocity[k]),
                effect.of_position(&ran.position[k]),
            );
            for i in 0..3 {
                // The difference of two runs keeps nine digits or so.
                assert!(
                    (v[i] - v2[i]).abs() < 1e-7 * v2[i].max(1e-9),
                    "{v:?} {v2:?}"
                );
                assert!(
                    (p[i] - p2[i]).abs() < 1e-7 * p2[i].max(1e-9),
                    "{p:?} {p2:?}"
                );
            }
        }
    }
}
