//! Which of the quiet spans are rests.
//!
//! A sensor that moves at constant velocity is as quiet as one that lies still. But the velocity
//! integrated from a rest comes back to zero at the next one and stays there, and a force that no turn
//! explains is an acceleration.

use std::ops::Range;

use crate::closure::REST_SPEED_MPS;
use crate::filter::{Filter, Innovation, Recorder};
use gravical_signal::Samples;

use crate::transition::Model;
use crate::unusable::{Unusable, unusable};

/// Rests further apart, s, say nothing of each other: the velocity is off by metres per second.
const MAX_MOVE_S: f64 = 120.0;
/// Spans after the first that agrees which are still tried: of two false ones the second may be true.
const MAX_AGREED: usize = 3;
/// … and none where the first that agrees has a velocity that is known better than this, m/s: a cruise is
/// faster.
const MAX_SURE_MPS: f64 = 0.03;
/// Times after the start of a span at which its velocity has to be zero, s.
const TRIED_S: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 5.0, 10.0];
/// χ² that a rest may have: of the velocity (3), and with the tilt (5). Chance exceeds either once in
/// 1,000; what is wrong with a calibration is in their covariance.
const MAX_VELOCITY_CHI2: f64 = 16.0;
const MAX_CHI2: f64 = 20.0;
/// Excess of χ² that a rest is worth: an e-fold less likely for each 2, of the velocity at six times.
const COST_OF_VELOCITY: f64 = 1.0 / 7.0;
const COST_OF_BOTH: f64 = 0.5;
/// A gyroscope is off by this fraction of the angle that it turned: 1 % of scale.
const TILT_PER_TURN: f64 = 0.01;
/// Duration of a rest that counts in full, s; longer ones count by the next factor.
const FULL_WEIGHT_S: f64 = 2.0;
const LONG_WEIGHT_PER_S: f64 = 1e-3;
/// The first span of a recording is a rest rather than the second: people start at rest.
const FIRST_WEIGHT: f64 = 0.25;
/// A bump changes the velocity by less, m/s: a lift at full speed has bumps, and is quiet between them, and
/// that is no more evidence than one long quiet.
const MAX_BUMP_MPS: f64 = 0.2;
/// A weight that only decides where nothing else does.
const TIE: f64 = 1e-3;
/// Rests of one pose, closer than this, s, whose means differ by less, m/s², are one.
const MAX_PAUSE_S: f64 = 1.0;
const SAME_FORCE_MPS2: f64 = 0.02;
/// Rows that are lost while the sensor rests, s, are lost to the recorder: a hand takes longer.
const MAX_HOLE_S: f64 = 2.0;
/// … if what is between has no more power than noise: two standard deviations of it.
const MAX_PAUSE_SD: f64 = 2.0;
/// Samples between the nodes of an integration whose path nobody sees, s.
const NODE_S: f64 = 0.1;

/// What a rest says to the filter.
fn innovation(filter: &Filter<'_>, rest: &Range<usize>) -> Innovation {
    let slack = TILT_PER_TURN * filter.nominal.gravity * filter.turned_rad;
    let mut innovation = filter.rest_innovation(rest, REST_SPEED_MPS);
    (3..5).for_each(|c| innovation.s[(c, c)] += slack.powi(2));
    innovation
}

/// The chain of spans that agree best as neighbouring rests (longest path); what is left out is quiet
/// at a speed.
pub(crate) fn chain(model: &Model<'_>, spans: &[Range<usize>]) -> Vec<Range<usize>> {
    let samples = model.samples;
    let seconds: Vec<f64> = spans.iter().map(|s| samples.duration_s(s)).collect();
    let rested = |s: f64| s.min(FULL_WEIGHT_S) / FULL_WEIGHT_S + LONG_WEIGHT_PER_S * s;
    let weight: Vec<f64> = (0..spans.len())
        .map(|k| 1.0 + rested(seconds[k]) + if k == 0 { FIRST_WEIGHT } else { 0.0 })
        .collect();
    let mut best = weight.clone();
    let mut before = vec![None; spans.len()];
    // Quiet time up to the end of each span in which nothing sped up: it counts once.
    let mut together_s = seconds.clone();
    for k in 0..spans.len() {
        let costs = costs(model, spans, k);
        // Those that agree, or where none does the least contradiction.
        let least = costs.iter().map(|c| c.1).fold(f64::MAX, f64::min);
        let none_agrees = costs.iter().all(|(next, cost)| *cost >= weight[*next]);
        for (next, cost) in costs {
            let one = !speeds_up(samples, &spans[k], &spans[next]);
            let together = seconds[next] + if one { together_s[k] } else { 0.0 };
            let gain = if none_agrees && cost > least {
                continue;
            } else if none_agrees {
                TIE / (1.0 + cost)
            } else if one {
                rested(together) - rested(together_s[k]) - cost
            } else {
                weight[next] - cost
            };
            if best[k] + gain > best[next] {
                (best[next], before[next]) = (best[k] + gain, Some(k));
                together_s[next] = together;
            }
        }
    }
    let mut chain = Vec::new();
    let mut at = (0..spans.len()).max_by(|a, b| best[*a].total_cmp(&best[*b]));
    while let Some(k) = at {
        chain.push(spans[k].clone());
        at = before[k];
    }
    chain.reverse();
    joined(model, chain)
}

/// Between two spans the sensor has another velocity than in the first.
fn speeds_up(samples: &Samples, a: &Range<usize>, b: &Range<usize>) -> bool {
    let rest = samples.mean(a);
    let mut velocity = [0.0; 3];
    (a.end..b.start).any(|i| {
        let h = samples.time_s[i] - samples.time_s[i - 1];
        for c in 0..3 {
            velocity[c] += (samples.force_mps2[i][c] - rest[c]) * h;
        }
        velocity.iter().map(|v| v * v).sum::<f64>() > MAX_BUMP_MPS.powi(2)
    })
}

/// What it costs to take each of the spans after `k` for its next rest.
fn costs(model: &Model<'_>, spans: &[Range<usize>], k: usize) -> Vec<(usize, f64)> {
    let time_s = &model.samples.time_s;
    let off = &mut Recorder::default();
    let mut filter = Filter::new(*model, spans[k].start, &spans[k]);
    filter.rest(&spans[k], REST_SPEED_MPS, off);
    filter.halt(spans[k].end - 1, off);
    let node = model.samples.count_in(NODE_S).max(1);
    let has_gyro = model.samples.has_gyro();
    let (mut agreed, mut costs) = (0, Vec::new());
    for next in k + 1..spans.len() {
        let span = &spans[next];
        let move_s = time_s[span.start] - time_s[spans[k].end - 1];
        if model.options.is_stopped() || move_s > MAX_MOVE_S || agreed >= MAX_AGREED {
            break;
        }
        let (mut worst, mut is_sure) = (0.0, false);
        for into_s in TRIED_S {
            let to = model.samples.after_s(span.start, into_s).min(span.end - 1);
            if to > filter.at {
                let excess = model.noise.excess(filter.at, to);
                filter.propagate(to, node, &excess, off);
            }
            let innovation = innovation(&filter, span);
            let is_start = into_s == 0.0;
            is_sure |= is_start && (0..3).all(|c| innovation.s[(c, c)] < MAX_SURE_MPS.powi(2));
            let cost = if is_start && has_gyro {
                COST_OF_BOTH * excess_chi2(&innovation, true)
            } else {
                COST_OF_VELOCITY * excess_chi2(&innovation, false)
            };
            worst = f64::max(worst, cost);
        }
        costs.push((next, worst));
        agreed += usize::from(worst <= 0.0 || agreed > 0);
        if worst <= 0.0 && is_sure {
            break;
        }
    }
    costs
}

/// Touching rests of one pose are one.
fn joined(model: &Model<'_>, mut rests: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let samples = model.samples;
    let distance2 = |x: &[f64; 6], y: &[f64; 6]| (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>();
    rests.dedup_by(|next, last| {
        let (a, b) = (samples.mean(last), samples.mean(next));
        let between = last.end.min(next.start)..next.start;
        let variance = between
            .clone()
            .map(|i| distance2(&samples.sample(i), &a))
            .sum::<f64>()
            / between.len().max(1) as f64;
        let noise = model.noise.rest.force.sum();
        let chance = MAX_PAUSE_SD * (2.0 / (3 * between.len().max(1)) as f64).sqrt();
        let calm = variance * samples.period_s < noise * (1.0 + chance);
        let pause_s = samples.time_s[next.start] - samples.time_s[last.end - 1];
        let near = match unusable(samples, &(last.end - 1..next.start)) {
            None => pause_s < MAX_PAUSE_S,
            Some(Unusable::Gap { .. }) => between.is_empty() && pause_s < MAX_HOLE_S,
            Some(_) => false,
        };
        let same = near && distance2(&a, &b) < SAME_FORCE_MPS2.powi(2) && calm;
        if same {
            last.end = next.end;
        }
        same
    });
    rests
}

/// Excess of the χ² of a rest over what chance allows; negative if it agrees. With `tilt` the force counts
/// too.
fn excess_chi2(innovation: &Innovation, tilt: bool) -> f64 {
    if tilt {
        innovation.chi2::<5>(0, 0.0) - MAX_CHI2
    } else {
        innovation.chi2::<3>(0, 0.0) - MAX_VELOCITY_CHI2
    }
}
