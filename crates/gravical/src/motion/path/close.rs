//! What the uncertainties of a leg add up to at its end.

use gravical_core::matrix3::mul_vec;

use super::super::bands::Variances;
use super::setup::Setup;
use super::state::State;

impl Setup<'_> {
    /// Variance of the position `here`: what the legs before have left, noise and tilt
    /// of this one, what its own rotation and the parameters make of it, the clock.
    pub(super) fn total(
        &self,
        state: &State,
        p: &Variances,
        rotation: &[f64; 3],
        parameters: &[f64; 3],
        here: &[f64; 3],
    ) -> [f64; 3] {
        let yaw = state.yaw.at(here);
        std::array::from_fn(|a| {
            let clock = 2.0 * self.clock_error * (here[a] - self.p0[a]);
            state.noise[a]
                + state.tilt[a]
                + p.noise[a]
                + p.tilt[a]
                + rotation[a]
                + parameters[a]
                + yaw[a]
                + clock * clock
        })
    }

    /// What each direction of the parameters makes of a way without rotation goes to
    /// the state; its variance.
    pub(super) fn shift(&self, state: &mut State, way: &[f64; 3]) -> [f64; 3] {
        let mut own = [0.0; 3];
        for (direction, offset) in self.directions.iter().zip(&mut state.offsets) {
            let moved = mul_vec(direction.matrix(), way);
            for i in 0..3 {
                own[i] += moved[i] * moved[i];
                offset[i] += moved[i];
            }
        }
        own
    }

    /// Takes the state's noise and tilt to the end of a leg; standard uncertainty of
    /// its displacement, m.
    pub(super) fn arrive(
        &self,
        state: &mut State,
        end: &Variances,
        own: &[f64; 3],
        way: &[f64; 3],
    ) -> [f64; 3] {
        let across = [way[1], way[0], 0.0];
        let sigma = std::array::from_fn(|a| {
            let clock = 2.0 * self.clock_error * way[a];
            let yaw = state.yaw.variance * across[a] * across[a];
            (end.noise[a] + end.tilt[a] + own[a] + clock * clock + yaw).sqrt()
        });
        for a in 0..3 {
            state.noise[a] += end.noise[a];
            state.tilt[a] += end.tilt[a];
        }
        sigma
    }
}
