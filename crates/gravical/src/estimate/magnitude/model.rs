//! The lengths as a least-squares problem.

use gravical_core::matrix3;

use super::Kind;
use crate::estimate::solve::{Jacobian, Problem, Shape};

/// Elements of (A row-major, b) that are fitted.
const NINE: [usize; 9] = [0, 1, 2, 4, 5, 8, 9, 10, 11];
const SIX: [usize; 6] = [0, 4, 8, 9, 10, 11];

/// Readings and what is held while A and b are fitted.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub readings: Vec<[f64; 3]>,
    /// Standard deviation of each length, m/s².
    pub sd: Vec<f64>,
    pub gravity: f64,
    pub kind: Kind,
}

/// A and b.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub a: [[f64; 3]; 3],
    pub b: [f64; 3],
}

impl State {
    pub fn calibrated(&self, u: [f64; 3]) -> [f64; 3] {
        matrix3::mul_vec(&self.a, &matrix3::sub(&u, &self.b))
    }

    /// Aᵀ A(u − b)/‖A(u − b)‖: how the length follows the reading.
    fn along(&self, u: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let force = self.calibrated(u);
        let length = matrix3::norm(&force);
        let unit = force.map(|v| v / length);
        (unit, matrix3::mul_vec(&matrix3::transpose(&self.a), &unit))
    }

    /// The same lengths with a positive diagonal: a row may change its sign.
    pub fn upright(mut self) -> State {
        for i in 0..3 {
            if self.a[i][i] < 0.0 {
                self.a[i] = self.a[i].map(|v| -v);
            }
        }
        self
    }

    pub fn finite(&self) -> bool {
        matrix3::is_finite(&self.a) && self.b.iter().all(|v| v.is_finite())
    }
}

impl Model {
    pub fn elements(&self) -> &'static [usize] {
        match self.kind {
            Kind::Nine => &NINE,
            Kind::Six => &SIX,
        }
    }

    /// Derivative of the length by the fitted elements, at a reading.
    pub fn row(&self, state: &State, u: [f64; 3]) -> Vec<f64> {
        let (unit, w) = state.along(u);
        let v = matrix3::sub(&u, &state.b);
        self.elements()
            .iter()
            .map(|&e| {
                if e < 9 {
                    unit[e / 3] * v[e % 3]
                } else {
                    -w[e - 9]
                }
            })
            .collect()
    }

    /// Standard deviations of the lengths from those of the readings.
    pub fn weigh(&mut self, state: &State, errors: &[[f64; 3]]) {
        for ((sd, u), s) in self.sd.iter_mut().zip(&self.readings).zip(errors) {
            let (_, w) = state.along(*u);
            *sd = (0..3).map(|i| (w[i] * s[i]).powi(2)).sum::<f64>().sqrt();
        }
    }

    /// Covariance of row-major M = A⁻¹ and b from that of the fitted elements,
    /// times `factor`: dM = −M dA M.
    pub fn twelve(
        &self,
        covariance: &[Vec<f64>],
        factor: f64,
        m: &[[f64; 3]; 3],
    ) -> [[f64; 12]; 12] {
        let elements = self.elements();
        let p = elements.len();
        let mut to = [[0.0; 12]; 12];
        for (column, &e) in elements.iter().enumerate() {
            if e >= 9 {
                to[e][column] = 1.0;
                continue;
            }
            for i in 0..3 {
                for j in 0..3 {
                    to[3 * i + j][column] = -m[i][e / 3] * m[e % 3][j];
                }
            }
        }
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let sum: f64 = (0..p)
                    .map(|k| to[i][k] * (0..p).map(|l| covariance[k][l] * to[j][l]).sum::<f64>())
                    .sum();
                factor * sum
            })
        })
    }
}

impl Problem for Model {
    type State = State;

    fn shared(&self) -> usize {
        self.elements().len()
    }

    fn blocks(&self) -> usize {
        self.readings.len()
    }

    fn shape(&self, _block: usize) -> Shape {
        Shape {
            residuals: 1,
            local: 0,
        }
    }

    fn evaluate(&self, state: &State, k: usize, r: &mut [f64], jacobian: Option<Jacobian<'_>>) {
        let u = self.readings[k];
        r[0] = (matrix3::norm(&state.calibrated(u)) - self.gravity) / self.sd[k];
        if let Some(j) = jacobian {
            for (slot, value) in j.shared.iter_mut().zip(self.row(state, u)) {
                *slot = value / self.sd[k];
            }
        }
    }

    fn moved(&self, state: &State, shared: &[f64], _local: &[f64]) -> State {
        let mut out = *state;
        for (step, &element) in shared.iter().zip(self.elements()) {
            if element < 9 {
                out.a[element / 3][element % 3] += step;
            } else {
                out.b[element - 9] += step;
            }
        }
        out
    }
}
