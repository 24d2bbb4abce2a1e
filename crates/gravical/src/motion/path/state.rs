//! Where the sensor is after the legs so far, and how far that may be off.

use gravical_core::matrix3::{norm, sub};

use super::super::parameters::Kind;
use super::super::result::PositionBudget;
use super::setup::Setup;

/// Where the sensor is after the legs so far, and how far that may be off.
pub(super) struct State {
    pub attitude: [f64; 4],
    pub position: [f64; 3],
    /// False after a move that cannot be known.
    pub known: bool,
    pub noise: [f64; 3],
    pub tilt: [f64; 3],
    /// By direction: what one standard deviation of it has moved the position.
    pub offsets: Vec<[f64; 3]>,
    /// … and what it has turned the heading by, rad.
    pub yaw_offsets: Vec<f64>,
    pub yaw: Yaw,
}

/// Errors of yaw: each that a leg adds turns all that comes after it about the
/// place where it arose.
#[derive(Clone, Copy, Default)]
pub(super) struct Yaw {
    pub variance: f64,
    first: [f64; 2],
    second: [f64; 2],
}

impl Yaw {
    pub fn add(&mut self, variance: f64, at: &[f64; 3]) {
        self.variance += variance;
        for i in 0..2 {
            self.first[i] += variance * at[i];
            self.second[i] += variance * at[i] * at[i];
        }
    }

    /// Σ σ² (p − p_k)², x by the distance in y and the other way round.
    pub fn at(&self, p: &[f64; 3]) -> [f64; 3] {
        let off = |i: usize| {
            (self.variance * p[i] * p[i] - 2.0 * self.first[i] * p[i] + self.second[i]).max(0.0)
        };
        [off(1), off(0), 0.0]
    }
}

impl State {
    /// At the start, with so many directions of the parameters.
    pub fn new(attitude: [f64; 4], position: [f64; 3], directions: usize) -> Self {
        State {
            attitude,
            position,
            known: true,
            noise: [0.0; 3],
            tilt: [0.0; 3],
            offsets: vec![[0.0; 3]; directions],
            yaw_offsets: vec![0.0; directions],
            yaw: Yaw::default(),
        }
    }
}

impl Setup<'_> {
    /// Standard uncertainty of the position after the legs so far.
    pub(super) fn sigma(&self, state: &State, position: &[f64; 3]) -> [f64; 3] {
        let yaw = state.yaw.at(position);
        std::array::from_fn(|i| {
            let parameters: f64 = state.offsets.iter().map(|o| o[i] * o[i]).sum();
            let clock = (2.0 * self.clock_error * (position[i] - self.p0[i])).powi(2);
            (state.noise[i] + state.tilt[i] + parameters + clock + yaw[i]).sqrt()
        })
    }

    pub(super) fn budget(&self, state: &State) -> PositionBudget {
        let root = |v: [f64; 3]| v.iter().sum::<f64>().sqrt();
        let of = |kind: Kind| -> f64 {
            self.directions
                .iter()
                .zip(&state.offsets)
                .filter(|(d, _)| d.kind == kind)
                .map(|(_, o)| o.iter().map(|v| v * v).sum::<f64>())
                .sum::<f64>()
        };
        let yaw = state.yaw.at(&state.position);
        PositionBudget {
            noise: root(state.noise),
            bias: of(Kind::Bias).sqrt(),
            scale: of(Kind::Scale).sqrt(),
            clock: 2.0 * self.clock_error * norm(&sub(&state.position, &self.p0)),
            tilt: (state.tilt.iter().chain(&yaw).sum::<f64>() + of(Kind::Gyro)).sqrt(),
        }
    }
}
