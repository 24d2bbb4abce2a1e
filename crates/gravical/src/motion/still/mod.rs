//! Where the sensor rested, found from the recording's own noise, to the sample.
//!
//! # Overview
//!
//! 1. Coarse rests: quiet blocks ([`crate::segment::still`]). From them the noise
//!    of both sensors (`noise`).
//! 2. Seeds: five means of 0.2 s that agree. From each forwards, and the whole
//!    recording backwards likewise: where the mean over 0.2, 0.5 or 1 s leaves
//!    that of the seconds before ([`gravical_core::still::Statistic`]), the
//!    rest has ended (`run`). When it ended, a ramp in all channels says
//!    ([`gravical_core::still::onset`]).
//! 3. What either direction saw moving parts the rests (`join`).
//! 4. Rests that only a knock parts are one; stretches of constant acceleration
//!    between two rests are none (`merge`, `agree`).
//! 5. Moves of 1.25 to 20 s, by the whole of them (`slow`).
//!
//! Constant velocity looks like rest to every accelerometer: what is found is a
//! candidate until the velocity has been looked at.

mod agree;
mod given;
mod join;
mod levels;
mod merge;
mod noise;
mod run;
mod slow;
mod view;

#[cfg(test)]
mod tests;

use std::ops::Range;

use gravical_core::still::Plan;

use super::samples::Samples;
use crate::still::{self as blocks, Channels, StillOptions};

pub use given::Intervals;
pub(super) use given::{check_inside, check_intervals};
pub use slow::SlowMove;
pub(super) use slow::may_hide_m;

/// Noise of the samples at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a sample, each axis: m/s² or rad/s.
    pub sigma: [f64; 3],
    /// Variance inflation factor: Var(mean of n) = σ²·VIF/n.
    pub vif: f64,
    /// Standard deviation that rounding leaves in a mean, however many samples it is
    /// over.
    pub rounding: [f64; 3],
}

/// Rests of a recording and the noise they were found with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rests {
    /// Samples of each rest, in order; none spans a break.
    pub spans: Vec<Range<usize>>,
    /// Noise of the accelerometer, m/s²; none without any rest.
    pub accel: Option<Noise>,
    /// Noise of the gyroscope, rad/s.
    pub gyro: Option<Noise>,
    /// What may have been a move within a rest, and is not certain enough.
    pub doubts: Vec<SlowMove>,
}

/// Blocks that a rest has to last, as 0.15 s of 0.2 s.
const LEAST_REST: f64 = 0.75;

/// Finds the rests, or takes those that are `given`, s.
///
/// Without any rest the list is empty and there is no noise.
#[must_use]
pub fn find_rests(samples: &Samples, given: Option<&[(f64, f64)]>) -> Rests {
    let Some(plan) = plan(samples) else {
        return Rests::default();
    };
    let (spans, doubts) = match given {
        Some(given) => (given::spans(samples, given), Vec::new()),
        None => search(samples, &plan),
    };
    if spans.is_empty() {
        return Rests::default();
    }
    let pooled = noise::pooled(samples, &spans, &plan);
    Rests {
        spans,
        accel: Some(pooled.accel()),
        gyro: samples.rate_rad_s.is_some().then(|| pooled.gyro()),
        doubts,
    }
}

/// Window lengths by the median step; none for fewer than two samples or no time.
fn plan(samples: &Samples) -> Option<Plan> {
    if samples.is_empty() {
        return None;
    }
    let step_s = samples.median_step_s();
    Some(Plan::new(if step_s > 0.0 { 1.0 / step_s } else { 0.0 }))
}

fn search(samples: &Samples, plan: &Plan) -> (Vec<Range<usize>>, Vec<SlowMove>) {
    let coarse = coarse(samples, plan);
    let levels = levels::Levels::new(samples, &coarse, plan);
    if levels.rests.is_empty() {
        return Default::default();
    }
    let least = (LEAST_REST * plan.block as f64).ceil() as usize;
    let context = merge::Context {
        samples,
        levels: &levels,
        plan,
    };
    let (mut spans, mut doubts) = (Vec::new(), Vec::new());
    for piece in samples.pieces() {
        let ahead = view::View::new(samples, &piece, false);
        let back = view::View::new(samples, &piece, true);
        let forwards = run::runs(&ahead, plan, &levels);
        let backwards = run::runs(&back, plan, &levels);
        let mut rests = join::join((&ahead, &forwards), (&back, &backwards));
        rests.retain(|r| r.len() >= least);
        let mut rests = context.merge(rests, &piece);
        doubts.extend(slow::take_out(samples, &levels, plan, &piece, &mut rests));
        spans.extend(rests);
    }
    (spans, doubts)
}

/// Quiet stretches, short ones included.
fn coarse(samples: &Samples, plan: &Plan) -> Vec<Range<usize>> {
    let channels = Channels {
        accel: &samples.force_mps2,
        gyro: samples.rate_rad_s.as_ref(),
        rate_hz: plan.block as f64 / Plan::BLOCK_S,
        segments: samples.pieces(),
        resolution: samples.resolution,
    };
    blocks::find_stills(&channels, &StillOptions::short_rests()).spans
}
