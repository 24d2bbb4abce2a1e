//! Drift of a recording in which nothing moves.

use super::anchors::Anchors;
use super::bands::LegNoise;
use super::leg::{Ran, Removal};
use super::parameters::Direction;
use super::path::Setup;
use super::result::{DriftTrack, StaticDrift};

/// Points that a drift is kept by, at the most.
const KEPT: usize = 4000;

/// Gravity is taken from so many seconds at the start, s, or from half of the
/// recording where it is shorter.
const LEVELLED_OVER_S: f64 = 5.0;

/// Open-loop drift after the first seconds; none for fewer than four samples.
///
/// With the zero-velocity correction it would be zero by construction, which is
/// why it is computed without.
pub(super) fn static_drift(setup: &Setup<'_>) -> Option<StaticDrift> {
    Some(drift(setup, false)?.0)
}

/// The same, with the way of it.
pub(super) fn static_track(setup: &Setup<'_>) -> Option<DriftTrack> {
    Some(drift(setup, true)?.1)
}

fn drift(setup: &Setup<'_>, keep: bool) -> Option<(StaticDrift, DriftTrack)> {
    let samples = setup.samples;
    let last = samples.breaks.first().map_or(samples.len(), |b| *b) - 1;
    let t = &samples.t_s;
    let over = LEVELLED_OVER_S.min(0.5 * (t[last] - t[0]));
    let near = t[..=last]
        .partition_point(|s| s - t[0] <= over)
        .checked_sub(1)?;
    if near < 2 || last < near + 2 {
        return None;
    }
    let rest = 0..near + 1;
    let anchors = Anchors::new(samples, setup.walk);
    let start = anchors.over(rest.clone());
    let mut leg = setup.leg(
        near,
        last,
        start,
        None,
        gravical_core::strapdown::level(start.force, 0.0),
    );
    if let Removal::Mean(_) = leg.removal {
        leg.removal = Removal::Mean(start.force);
    }
    let mut ran = Ran::default();
    leg.run(&Direction::NONE, false, &mut ran);
    let count = ran.tau.len() - 1;
    let (velocity, position) = (ran.velocity[count], ran.position[count]);
    let tau = ran.tau[count];

    // Nothing moves, so nothing tilts.
    let noise = LegNoise {
        wobble: 0.0,
        rest: start.seconds,
        ..setup.noise(&leg)
    };
    let by_noise = noise.open(tau).1;
    let step = ran.tau.len().div_ceil(KEPT).max(1);
    let places: Vec<usize> = match keep {
        // The end belongs to it.
        true => (0..count).step_by(step).chain([count]).collect(),
        false => Vec::new(),
    };
    let mut along = vec![[0.0; 3]; places.len()];
    let mut parameters = [0.0; 3];
    let mut changed = Ran::default();
    const STEP: f64 = 1e-3;
    for direction in setup.directions {
        leg.run(&direction.times(STEP), false, &mut changed);
        for i in 0..3 {
            parameters[i] += ((changed.position[count][i] - position[i]) / STEP).powi(2);
        }
        for (sum, &k) in along.iter_mut().zip(&places) {
            for i in 0..3 {
                sum[i] += ((changed.position[k][i] - ran.position[k][i]) / STEP).powi(2);
            }
        }
    }
    let predicted_sigma_m =
        std::array::from_fn(|i| (by_noise.noise[i] + by_noise.tilt[i] + parameters[i]).sqrt());
    let sigma_at = |(&k, by_parameters): (&usize, &[f64; 3])| -> [f64; 3] {
        let own = noise.open(ran.tau[k]).1;
        std::array::from_fn(|i| (own.noise[i] + own.tilt[i] + by_parameters[i]).sqrt())
    };
    let track = DriftTrack {
        t_s: places.iter().map(|&k| ran.tau[k]).collect(),
        position_m: places.iter().map(|&k| ran.position[k]).collect(),
        sigma_m: places.iter().zip(&along).map(sigma_at).collect(),
        uncalibrated_m: Vec::new(),
    };

    // a = b + c τ, fitted to the acceleration.
    let n = ran.tau.len() as f64;
    let mean_tau = ran.tau.iter().sum::<f64>() / n;
    let spread: f64 = ran.tau.iter().map(|s| (s - mean_tau).powi(2)).sum();
    let mut bias = [0.0; 3];
    let mut slope = [0.0; 3];
    for i in 0..3 {
        let mean = ran.acceleration.iter().map(|a| a[i]).sum::<f64>() / n;
        let along: f64 = ran
            .acceleration
            .iter()
            .zip(&ran.tau)
            .map(|(a, s)| (a[i] - mean) * (s - mean_tau))
            .sum();
        slope[i] = along / spread;
        bias[i] = mean - slope[i] * mean_tau;
    }
    let told = StaticDrift {
        levelled_over_s: t[near] - t[0],
        duration_s: tau,
        velocity_mps: velocity,
        position_m: position,
        predicted_sigma_m,
        bias_mps2: bias,
        slope_mps3: slope,
        unexplained_m: std::array::from_fn(|i| {
            position[i] - bias[i] * tau * tau / 2.0 - slope[i] * tau.powi(3) / 6.0
        }),
    };
    Some((told, track))
}
