//! Drift of a recording in which nothing moves.

use gravical_core::strapdown::level;

use super::anchors::Anchors;
use super::leg::{Forward, Removal};
use super::parameters::{Direction, STEP};
use super::result::{DriftTrack, StaticDrift};
use super::setup::Setup;

/// Points that a drift is kept by, at the most.
const KEPT: usize = 4000;

/// Gravity is taken from so many seconds at the start, s, or from half of the
/// recording where it is shorter.
const LEVELLED_OVER_S: f64 = 5.0;

/// Open-loop drift after the first seconds, and the way of it; none for fewer than four
/// samples.
///
/// With the zero-velocity correction it would be zero by construction, which is
/// why it is computed without.
pub(super) fn static_drift(setup: &Setup<'_>) -> Option<(StaticDrift, DriftTrack)> {
    let samples = setup.view.samples;
    let last = samples.breaks.first().map_or(samples.len(), |b| *b) - 1;
    let t = &samples.t_s;
    let over = LEVELLED_OVER_S.min(0.5 * (t[last] - t[0]));
    let near = t[..=last]
        .partition_point(|s| s - t[0] <= over)
        .checked_sub(1)?;
    if near < 2 || last < near + 2 {
        return None;
    }
    let start = Anchors::new(setup.view, setup.walk).over(0..near + 1);
    let mut leg = setup.leg(near, last, start, None, level(start.force, 0.0));
    if let Removal::Mean(_) = leg.removal {
        leg.removal = Removal::Mean(start.force);
    }
    let count = leg.len();
    let step = count.div_ceil(KEPT).max(1);
    // The end belongs to it.
    let is_kept = |k: usize| k.is_multiple_of(step) || k + 1 == count;

    let mut nominal = Forward::new(&leg, Direction::NONE);
    let mean_tau = t[near..=last].iter().map(|s| s - t[near]).sum::<f64>() / count as f64;
    let mut track = DriftTrack::default();
    let (mut sum, mut along, mut spread) = ([0.0; 3], [0.0; 3], 0.0);
    for k in 0..count {
        let tau = nominal.advance();
        let a = nominal.propagator.acceleration();
        for i in 0..3 {
            sum[i] += a[i];
            along[i] += a[i] * (tau - mean_tau);
        }
        spread += (tau - mean_tau).powi(2);
        if is_kept(k) {
            track.t_s.push(tau);
            track.position_m.push(nominal.propagator.position());
        }
    }
    let (velocity, position) = (nominal.propagator.velocity(), nominal.propagator.position());
    let tau = t[last] - t[near];

    let mut by_parameters = vec![[0.0; 3]; track.t_s.len()];
    for direction in setup.directions {
        let mut changed = Forward::new(&leg, direction.times(STEP));
        let mut kept = by_parameters.iter_mut().zip(&track.position_m);
        for k in 0..count {
            changed.advance();
            if is_kept(k)
                && let Some((sum, p)) = kept.next()
            {
                let other = changed.propagator.position();
                (0..3).for_each(|i| sum[i] += ((other[i] - p[i]) / STEP).powi(2));
            }
        }
    }
    // Nothing moves, so nothing tilts.
    let mut noise = setup.noise(&leg);
    (noise.open.tilt_change, noise.open.rest_s) = (0.0, start.seconds);
    track.sigma_m = track
        .t_s
        .iter()
        .zip(&by_parameters)
        .map(|(tau, sum)| {
            let (_, own) = noise.open(*tau);
            std::array::from_fn(|i| (own.noise[i] + own.tilt[i] + sum[i]).sqrt())
        })
        .collect();

    // a = b + c τ, fitted to the acceleration.
    let slope = along.map(|a| a / spread);
    let bias: [f64; 3] = std::array::from_fn(|i| sum[i] / count as f64 - slope[i] * mean_tau);
    let drift = StaticDrift {
        levelled_over_s: t[near] - t[0],
        duration_s: tau,
        velocity_mps: velocity,
        position_m: position,
        predicted_sigma_m: track.sigma_m.last().copied().unwrap_or([f64::NAN; 3]),
        bias_mps2: bias,
        slope_mps3: slope,
        unexplained_m: std::array::from_fn(|i| {
            position[i] - bias[i] * tau * tau / 2.0 - slope[i] * tau.powi(3) / 6.0
        }),
    };
    Some((drift, track))
}
