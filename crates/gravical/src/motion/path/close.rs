//! What the uncertainties of a leg add up to at its end.

use gravical_core::matrix3::mul_vec;

use super::super::bands::{LegNoise, Variances};
use super::super::result::PositionBudget;
use super::setup::Setup;
use super::state::State;

/// The end of a leg that began with the mean that was taken off.
pub(in crate::motion) struct AfterMean {
    /// Standard uncertainty of the displacement, m.
    pub sigma_move_m: [f64; 3],
    /// Standard uncertainty of the position, m.
    pub sigma_m: [f64; 3],
    pub budget: PositionBudget,
}

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

    /// The end of the only leg, `way` from its start after `tau` s, without the
    /// samples in between: all that the parameters change grows with the way.
    pub(in crate::motion) fn after_mean(
        &self,
        noise: &LegNoise,
        tau: f64,
        way: &[f64; 3],
    ) -> AfterMean {
        let mut state = State::new([1.0, 0.0, 0.0, 0.0], self.p0, self.directions.len());
        let mut end = noise.after_mean(tau).1;
        let rotation = self.rotation(noise, tau, way, &[0.0; 3]);
        let here = std::array::from_fn(|a| self.p0[a] + way[a]);
        let own = self.shift(&mut state, way);
        let fresh = State::new(state.attitude, self.p0, 0);
        let total = self.total(&fresh, &end, &rotation, &own, &here);
        (0..3).for_each(|a| end.tilt[a] += rotation[a]);
        let sigma_move_m = self.arrive(&mut state, &end, &own, way);
        state.position = here;
        AfterMean {
            sigma_move_m,
            sigma_m: total.map(f64::sqrt),
            budget: self.budget(&state),
        }
    }
}
