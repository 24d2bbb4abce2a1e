//! The joint model as a least-squares problem.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::solve::{Jacobian, Problem, Shape};
use crate::segment::face::Face;

/// Relative standard deviation of a scale by the data sheet (MPU6050: ±3 %).
const SCALE_SD: f64 = 0.03;
/// Standard deviation of the cosine between two sensitive axes: cross-axis
/// sensitivity of 2 % in either axis.
const ANGLE_SD: f64 = 0.02 * std::f64::consts::SQRT_2;
/// Standard deviation of a zero-g offset, m/s² (±60 mg).
const BIAS_SD_MPS2: f64 = 0.6;

/// Step of differences: their error is its square, and rounding over it.
const DIFFERENCE: f64 = 1e-4;

/// One mean reading as the model sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub mean: [f64; 3],
    /// Standard deviation of each component: noise, model error, and across the
    /// face the scatter of placements that share a tilt.
    pub sd: [f64; 3],
    /// Temperature above the reference, °C.
    pub warmer_c: f64,
}

/// A direction in space and the readings that share it.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// The face it is meant to be, or none for a free pose.
    pub face: Option<Face>,
    pub readings: Vec<Reading>,
}

/// Everything that is held while M, b and the tilts are fitted.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub places: Vec<Place>,
    pub gravity: f64,
    /// sd of each component of a placement's tilt, rad.
    pub tilt: f64,
    /// Nominal scale (input unit per m/s²), for the prior; none switches it
    /// off.
    pub prior: Option<f64>,
    /// Which of the twelve parameters are fitted.
    pub elements: Elements,
    /// The drift of the bias with temperature is fitted, too.
    pub drift: bool,
}

/// M, b, the drift of b and the direction of every place.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub m: [[f64; 3]; 3],
    pub b: [f64; 3],
    /// Input unit per °C; 0 where it is not fitted.
    pub drift: [f64; 3],
    pub at: Vec<Direction>,
}

/// Direction of specific force at a place.
#[derive(Debug, Clone, Copy)]
pub(super) enum Direction {
    /// Two angles off the face, rad, in its tangent plane.
    Tilted([f64; 2]),
    /// Any unit vector.
    Any([f64; 3]),
}

/// Elements of (M, b) that are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elements {
    /// All twelve.
    All,
    /// The orientation is free: M is kept upper triangular.
    Triangular,
    /// Scales and biases.
    Diagonal,
}

impl Elements {
    /// Their places in row-major M and b.
    pub fn list(self) -> &'static [usize] {
        let all = self.with_drift();
        &all[..all.len() - 3]
    }

    /// The same in row-major M, b and the drift of b.
    fn with_drift(self) -> &'static [usize] {
        match self {
            Elements::All => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14],
            Elements::Triangular => &[0, 1, 2, 4, 5, 8, 9, 10, 11, 12, 13, 14],
            Elements::Diagonal => &[0, 4, 8, 9, 10, 11, 12, 13, 14],
        }
    }
}

/// Derivatives by row-major M and b, and those by the drift of b that follow from them.
pub(super) fn by_drift(h: &[f64; 12], warmer_c: f64) -> [f64; 15] {
    std::array::from_fn(|i| match i {
        0..12 => h[i],
        _ => h[i - 3] * warmer_c,
    })
}

/// A block of the problem, linearised: residuals, and their derivatives by the
/// shared parameters and by the block's own.
pub(super) struct Rows {
    pub residuals: DVector<f64>,
    pub shared: DMatrix<f64>,
    pub local: DMatrix<f64>,
}

/// Two unit vectors that make a right-handed frame with `n`.
pub(super) fn tangents(n: [f64; 3]) -> [[f64; 3]; 2] {
    // The axis that n leans on least is never parallel to it.
    let axis = (0..3).fold(
        0,
        |best, i| {
            if n[i].abs() < n[best].abs() { i } else { best }
        },
    );
    let mut a = [0.0; 3];
    a[axis] = 1.0;
    let along = n[axis];
    let t = matrix3::unit(&std::array::from_fn(|i| a[i] - along * n[i]));
    [t, matrix3::cross(&n, &t)]
}

/// Direction that is turned from `face` by the angles `d` (exponential map), and
/// its derivatives.
pub(super) fn tilted(face: Face, d: [f64; 2]) -> ([f64; 3], [[f64; 3]; 2]) {
    let e = face.direction();
    let t = tangents(e);
    let angle = d[0].hypot(d[1]);
    // sin θ/θ, and its derivative over θ; the series where they lose digits.
    let (sinc, slope) = if angle < 1e-3 {
        let s = angle * angle;
        (1.0 - s / 6.0, -1.0 / 3.0 + s / 30.0)
    } else {
        let (sine, cosine) = angle.sin_cos();
        (
            sine / angle,
            (angle * cosine - sine) / (angle * angle * angle),
        )
    };
    let cosine = angle.cos();
    let aside: [f64; 3] = std::array::from_fn(|i| d[0] * t[0][i] + d[1] * t[1][i]);
    let n = std::array::from_fn(|i| cosine * e[i] + sinc * aside[i]);
    let derivative = [0, 1].map(|k| {
        std::array::from_fn(|i| -sinc * d[k] * e[i] + sinc * t[k][i] + slope * d[k] * aside[i])
    });
    (n, derivative)
}

/// Second derivatives of [`tilted`], by differences of the first.
fn tilted_second(face: Face, d: [f64; 2]) -> [[[f64; 3]; 2]; 2] {
    let at = |b: usize, step: f64| {
        let mut moved = d;
        moved[b] += step;
        tilted(face, moved).1
    };
    let by = [0, 1].map(|b| (at(b, DIFFERENCE), at(b, -DIFFERENCE)));
    [0, 1].map(|a| {
        [0, 1]
            .map(|b| std::array::from_fn(|i| (by[b].0[a][i] - by[b].1[a][i]) / (2.0 * DIFFERENCE)))
    })
}

impl State {
    /// What is read without specific force at so many °C above the reference.
    pub fn offset(&self, warmer_c: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.b[i] + self.drift[i] * warmer_c)
    }
}

impl Model {
    /// Places of the fitted parameters in row-major M, b and the drift of b.
    pub fn list(&self) -> &'static [usize] {
        match self.drift {
            true => self.elements.with_drift(),
            false => self.elements.list(),
        }
    }

    /// A block at a state.
    pub fn rows(&self, state: &State, block: usize) -> Rows {
        let Shape { residuals, local } = self.shape(block);
        let p = self.shared();
        let mut r = vec![0.0; residuals];
        let (mut by_shared, mut by_local) =
            (vec![0.0; residuals * p], vec![0.0; residuals * local]);
        let jacobian = Jacobian {
            shared: &mut by_shared,
            local: &mut by_local,
        };
        self.evaluate(state, block, &mut r, Some(jacobian));
        Rows {
            residuals: DVector::from_vec(r),
            shared: DMatrix::from_row_slice(residuals, p, &by_shared),
            local: DMatrix::from_row_slice(residuals, local, &by_local),
        }
    }

    /// A p × p matrix of the fitted parameters among all twelve, 0 for the others.
    pub fn twelve(&self, of: impl Fn(usize, usize) -> f64) -> [[f64; 12]; 12] {
        let mut out = [[0.0; 12]; 12];
        // M and b are first on the list.
        let elements = self.elements.list();
        for (i, &row) in elements.iter().enumerate() {
            for (j, &column) in elements.iter().enumerate() {
                out[row][column] = of(i, j);
            }
        }
        out
    }

    /// Direction of place `k`.
    pub fn direction(&self, state: &State, k: usize) -> [f64; 3] {
        match (state.at[k], self.places[k].face) {
            (Direction::Any(n), _) => n,
            (Direction::Tilted(d), Some(face)) => tilted(face, d).0,
            // A tilt belongs to a face; places are made that way.
            (Direction::Tilted(_), None) => [f64::NAN; 3],
        }
    }

    /// Second derivatives of every row of a block by (shared, local) parameters.
    pub fn second_derivatives(&self, state: &State, block: usize) -> Vec<DMatrix<f64>> {
        let elements = self.list();
        let p = elements.len();
        let Some(place) = self.places.get(block) else {
            return self.prior_second(state, block);
        };
        let (first, second) = match (state.at[block], place.face) {
            (Direction::Tilted(d), Some(face)) => (tilted(face, d).1, tilted_second(face, d)),
            (Direction::Any(n), _) => {
                let inwards = n.map(|v| -v);
                (tangents(n), [[inwards, [0.0; 3]], [[0.0; 3], inwards]])
            }
            (Direction::Tilted(_), None) => ([[f64::NAN; 3]; 2], [[[f64::NAN; 3]; 2]; 2]),
        };
        let mut out = vec![DMatrix::zeros(p + 2, p + 2); self.shape(block).residuals];
        for (row, h) in out.iter_mut().enumerate().take(3 * place.readings.len()) {
            let axis = row % 3;
            let weight = self.gravity / place.readings[row / 3].sd[axis];
            for a in 0..2 {
                for (i, element) in elements.iter().enumerate() {
                    if *element < 9 && element / 3 == axis {
                        let mixed = weight * first[a][element % 3];
                        (h[(i, p + a)], h[(p + a, i)]) = (mixed, mixed);
                    }
                }
                for b in 0..2 {
                    h[(p + a, p + b)] = weight * matrix3::dot(&state.m[axis], &second[a][b]);
                }
            }
        }
        out
    }

    /// … of the prior, by differences of its derivatives.
    fn prior_second(&self, state: &State, block: usize) -> Vec<DMatrix<f64>> {
        let p = self.shared();
        let m = self.shape(block).residuals;
        let step = DIFFERENCE * matrix3::norm(&state.m[0]);
        let slopes = |column: usize, sign: f64| {
            let mut shared = vec![0.0; p];
            shared[column] = sign * step;
            self.rows(&self.moved(state, &shared, &[]), block).shared
        };
        let mut out = vec![DMatrix::zeros(p, p); m];
        for column in 0..p {
            let (up, down) = (slopes(column, 1.0), slopes(column, -1.0));
            for (row, h) in out.iter_mut().enumerate() {
                for other in 0..p {
                    h[(other, column)] = (up[(row, other)] - down[(row, other)]) / (2.0 * step);
                }
            }
        }
        out
    }

    fn prior(&self, state: &State, nominal: f64, r: &mut [f64], jacobian: Option<Jacobian<'_>>) {
        let m = &state.m;
        let k = matrix3::row_norms(m);
        let mut d = [[0.0; 15]; 9];
        for i in 0..3 {
            r[i] = (k[i] / nominal - 1.0) / SCALE_SD;
            r[6 + i] = state.b[i] / (BIAS_SD_MPS2 * nominal);
            d[6 + i][9 + i] = 1.0 / (BIAS_SD_MPS2 * nominal);
            for c in 0..3 {
                d[i][3 * i + c] = m[i][c] / k[i] / nominal / SCALE_SD;
            }
            let (p, q) = (i, (i + 1) % 3);
            let cosine = matrix3::dot(&m[p], &m[q]) / (k[p] * k[q]);
            r[3 + i] = cosine / ANGLE_SD;
            for c in 0..3 {
                d[3 + i][3 * p + c] =
                    (m[q][c] / (k[p] * k[q]) - cosine * m[p][c] / (k[p] * k[p])) / ANGLE_SD;
                d[3 + i][3 * q + c] =
                    (m[p][c] / (k[p] * k[q]) - cosine * m[q][c] / (k[q] * k[q])) / ANGLE_SD;
            }
        }
        if let Some(j) = jacobian {
            let elements = self.list();
            for (row, all) in d.iter().enumerate() {
                for (column, &element) in elements.iter().enumerate() {
                    j.shared[row * elements.len() + column] = all[element];
                }
            }
        }
    }
}

impl Problem for Model {
    type State = State;

    fn shared(&self) -> usize {
        self.list().len()
    }

    fn blocks(&self) -> usize {
        self.places.len() + usize::from(self.prior.is_some())
    }

    fn shape(&self, block: usize) -> Shape {
        match self.places.get(block) {
            Some(place) => Shape {
                residuals: 3 * place.readings.len() + if place.face.is_some() { 2 } else { 0 },
                local: 2,
            },
            None => Shape {
                residuals: 9,
                local: 0,
            },
        }
    }

    fn evaluate(
        &self,
        state: &State,
        block: usize,
        r: &mut [f64],
        mut jacobian: Option<Jacobian<'_>>,
    ) {
        let Some(place) = self.places.get(block) else {
            if let Some(nominal) = self.prior {
                self.prior(state, nominal, r, jacobian);
            }
            return;
        };
        let g = self.gravity;
        let (n, derivative) = match (state.at[block], place.face) {
            (Direction::Tilted(d), Some(face)) => tilted(face, d),
            (Direction::Any(n), _) => (n, tangents(n)),
            (Direction::Tilted(_), None) => ([f64::NAN; 3], [[f64::NAN; 3]; 2]),
        };
        let elements = self.list();
        let force = [0, 1, 2].map(|i| g * matrix3::dot(&state.m[i], &n));
        let along = derivative.map(|d| [0, 1, 2].map(|i| g * matrix3::dot(&state.m[i], &d)));
        for (at, reading) in place.readings.iter().enumerate() {
            let offset = state.offset(reading.warmer_c);
            for i in 0..3 {
                let row = 3 * at + i;
                let s = reading.sd[i];
                r[row] = (force[i] + offset[i] - reading.mean[i]) / s;
                let Some(j) = jacobian.as_mut() else { continue };
                let shared = &mut j.shared[row * elements.len()..][..elements.len()];
                for (slot, &element) in shared.iter_mut().zip(elements) {
                    *slot = if element == 9 + i {
                        1.0 / s
                    } else if element == 12 + i {
                        reading.warmer_c / s
                    } else if element < 9 && element / 3 == i {
                        g * n[element % 3] / s
                    } else {
                        0.0
                    };
                }
                j.local[2 * row] = along[0][i] / s;
                j.local[2 * row + 1] = along[1][i] / s;
            }
        }
        if let Direction::Tilted(d) = state.at[block] {
            let row = 3 * place.readings.len();
            for i in 0..2 {
                r[row + i] = d[i] / self.tilt;
                if let Some(j) = jacobian.as_mut() {
                    j.local[2 * (row + i) + i] = 1.0 / self.tilt;
                }
            }
        }
    }

    fn moved(&self, state: &State, shared: &[f64], local: &[f64]) -> State {
        let mut out = state.clone();
        for (step, &element) in shared.iter().zip(self.list()) {
            match element {
                0..9 => out.m[element / 3][element % 3] += step,
                9..12 => out.b[element - 9] += step,
                _ => out.drift[element - 12] += step,
            }
        }
        for (at, step) in out.at.iter_mut().zip(local.chunks_exact(2)) {
            match at {
                Direction::Tilted(d) => {
                    d[0] += step[0];
                    d[1] += step[1];
                }
                Direction::Any(n) => {
                    let t = tangents(*n);
                    *n = matrix3::unit(&std::array::from_fn(|i| {
                        n[i] + step[0] * t[0][i] + step[1] * t[1][i]
                    }));
                }
            }
        }
        out
    }
}
