//! Which of the quiet spans are rests.
//!
//! A sensor that moves at constant velocity, or turns evenly, is as quiet as one that lies still. But at a
//! rest the velocity that is integrated from the one before is zero, the force is gravity in the attitude
//! that the filter has, and the rate is the bias of the gyroscope: χ² of nine means, with the covariance
//! of the filter.

use std::ops::Range;

use gravical_signal::Samples;

use crate::closure::REST_SPEED_MPS;
use crate::filter::{Filter, Innovation, Recorder};
use crate::result::hidden_displacement_m;
use crate::transition::Model;
use crate::unusable::{Unusable, unusable};

/// Rests further apart, s, say nothing of each other: the velocity is off by metres per second.
const MAX_MOVE_S: f64 = 120.0;
/// Spans that are tried from the first that agrees on: of two false ones the second may be true.
const MAX_AGREED: usize = 5;
/// χ² of the nine means of a rest: chance exceeds it once in 2,000. What is beyond it costs this fraction of a rest
/// for each 1; at 50 it is none.
const MAX_CHI2: f64 = 30.0;
const COST: f64 = 0.05;
/// χ² of six means, without the velocity, of a cruise, over which the filter coasts: one in 20 has more. What speeds up
/// evenly may not pass for it. Three have more once in 200.
const MAX_COASTING_CHI2: f64 = 13.0;
/// The bias of a gyroscope may jump by so much, rad/s: 3 °/s.
const MAX_BIAS_STEP_RAD_S: f64 = 0.05;
/// The bias of a gyroscope walks by so much, rad/s/√s, as it warms up (an MPU-6050: 0.01 °/s in a second, 0.1 °/s
/// in a minute), and differs by so much between poses, rad/s for each m/s²: 0.1 °/s/g.
const RATE_WALK: f64 = 2e-4;
const RATE_PER_FORCE: f64 = 1.8e-4;
/// A velocity that is more than this fraction of the highest one since the rest was not braked: it is a cruise, and
/// no error of a rest that contradicts.
const MAX_UNBRAKED: f64 = 0.7;
/// A gyroscope is off by this fraction of the angle that it turned, 1 % of scale: rough turns that it does not resolve
/// count.
const TILT_PER_TURN: f64 = 0.01;
/// Duration of a rest that counts in full, s; longer ones count by the next factor.
const FULL_WEIGHT_S: f64 = 2.0;
const LONG_WEIGHT_PER_S: f64 = 1e-3;
/// The first span of a recording is a rest rather than the second: people start at rest.
const FIRST_WEIGHT: f64 = 0.25;
/// A bump changes the velocity by less, m/s: a lift at full speed has bumps, and is quiet between them, and
/// that is no more evidence than one long quiet.
const MAX_BUMP_MPS: f64 = 0.2;
/// What a rest costs that contradicts the one before, in rests: of two chains that weigh the same the one without
/// contradictions is used.
const CONTRADICTION: f64 = 1e-3;
/// What a chain costs that ends before such a rest, or begins there, in rests: more than any two weigh.
const ABANDONED: f64 = 5.0;
/// Rests of one pose, closer than this, s, whose means differ by less, m/s², are one.
const MAX_PAUSE_S: f64 = 1.0;
const SAME_FORCE_MPS2: f64 = 0.02;
/// Rows are missing for so long, s, between two rests of one pose: a hand that moves the sensor takes longer.
const MAX_HOLE_S: f64 = 2.0;
/// Rests are one if what is between has no more power than noise, by two standard deviations of it, or if it is
/// a knock: the sensor moves less than a smooth move of that time, and of at least this one, s, could hide.
const MAX_PAUSE_SD: f64 = 2.0;
const SHORTEST_MOVE_S: f64 = 0.35;
/// Time between the nodes of an integration whose path nobody sees, s.
const NODE_S: f64 = 0.1;

/// The chain of spans that agree best as neighbouring rests (longest path); what is left out is quiet
/// at a speed.
pub(crate) fn chain(model: &Model<'_>, spans: &[Range<usize>]) -> Vec<Range<usize>> {
    let samples = model.samples;
    let seconds: Vec<f64> = spans.iter().map(|s| samples.duration_s(s)).collect();
    let rested = |s: f64| s.min(FULL_WEIGHT_S) / FULL_WEIGHT_S + LONG_WEIGHT_PER_S * s;
    let weight: Vec<f64> = (0..spans.len())
        .map(|k| 1.0 + rested(seconds[k]) + if k == 0 { FIRST_WEIGHT } else { 0.0 })
        .collect();
    let neighbours: Vec<_> = (0..spans.len())
        .map(|k| neighbours(model, spans, k))
        .collect();
    // Where nothing agrees the first that may be a rest is believed.
    let believed: Vec<Option<usize>> = neighbours
        .iter()
        .map(|next| {
            let none_agrees = next.iter().all(|n| !n.agrees);
            let first = next.iter().find(|n| n.is_doubtful && none_agrees);
            first.map(|n| n.span)
        })
        .collect();
    // To begin or to end beside a rest that may be believed costs more than to believe it.
    let abandoned = |is_beside: bool| if is_beside { ABANDONED } else { 0.0 };
    let mut best: Vec<f64> = (0..spans.len())
        .map(|k| weight[k] - abandoned(believed.contains(&Some(k))))
        .collect();
    let mut before = vec![None; spans.len()];
    // Quiet time up to the end of each span in which nothing sped up: it counts once.
    let mut together_s = seconds.clone();
    for k in 0..spans.len() {
        for n in &neighbours[k] {
            let next = n.span;
            let one = !speeds_up(samples, &spans[k], &spans[next]);
            let together = seconds[next] + if one { together_s[k] } else { 0.0 };
            let gain = if believed[k] == Some(next) {
                -CONTRADICTION
            } else if !n.agrees {
                continue;
            } else if one {
                rested(together) - rested(together_s[k]) - n.cost
            } else {
                weight[next] - n.cost
            };
            let score = best[k] + gain;
            if score > best[next] {
                (best[next], before[next]) = (score, Some(k));
                together_s[next] = together;
            }
        }
    }
    let mut chain = Vec::new();
    let end = |k: &usize| best[*k] - abandoned(believed[*k].is_some());
    let mut at = (0..spans.len()).max_by(|a, b| end(a).total_cmp(&end(b)));
    while let Some(k) = at {
        chain.push(spans[k].clone());
        at = before[k];
    }
    chain.reverse();
    merge_rests(model, chain)
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

/// A quiet span after a rest.
struct Neighbour {
    span: usize,
    cost: f64,
    /// It is a rest.
    agrees: bool,
    /// The filter may be wrong here, so the span may still be a rest.
    is_doubtful: bool,
}

/// What each of the spans after `k` is to a filter that comes from there.
fn neighbours(model: &Model<'_>, spans: &[Range<usize>], k: usize) -> Vec<Neighbour> {
    let samples = model.samples;
    let off = &mut Recorder::default();
    let mut filter = Filter::new(*model, spans[k].start, &spans[k]);
    filter.rest(&spans[k], REST_SPEED_MPS, off);
    filter.apply_zero_velocity(spans[k].end - 1, off);
    let before = samples.mean(&spans[k]);
    let node = samples.count_in(NODE_S).max(1);
    let (mut agreed, mut out) = (0, Vec::new());
    // Where the filter may be wrong: rough, interpolated or missing rows, or turns without a gyroscope.
    let mut is_wrong = false;
    for (next, span) in spans.iter().enumerate().skip(k + 1) {
        let move_s = samples.time_s[span.start] - samples.time_s[spans[k].end - 1];
        if model.options.is_stopped() || move_s > MAX_MOVE_S || agreed >= MAX_AGREED {
            break;
        }
        let added_noise = model
            .noise
            .added_noise(filter.at, span.start.max(filter.at));
        let way = spans[k].end - 1..span.start;
        is_wrong |= added_noise.force.norm() > 0.0
            || unusable(samples, &way).is_some()
            || samples.interpolated_in(&way).next().is_some();
        filter.propagate_levelled(span.start, node, &added_noise, off);
        let innovation = innovation(&filter, &before, span);
        let chi2 = innovation.chi2::<9>(0, 0.0);
        // Before the span itself is integrated, in which a wrong filter speeds up.
        let is_braked = innovation.y.fixed_rows::<3>(0).norm() <= MAX_UNBRAKED * filter.top_mps;
        let cost = COST * (chi2 - MAX_CHI2).max(0.0);
        let agrees = COST * (chi2 - MAX_CHI2) < 1.0;
        agreed += usize::from(agrees || agreed > 0);
        let is_cruise = !agrees && innovation.chi2::<6>(3, 0.0) < MAX_COASTING_CHI2;
        if is_cruise {
            filter.coast(span, innovation.clone());
        } else {
            filter.propagate_levelled(span.end - 1, node, &added_noise, off);
        }
        is_wrong |= !samples.has_gyro() && innovation.chi2::<3>(3, 0.0) > MAX_COASTING_CHI2;
        let is_doubtful =
            innovation.y.fixed_rows::<3>(6).norm() < MAX_BIAS_STEP_RAD_S && (is_braked || is_wrong);
        out.push(Neighbour {
            span: next,
            cost,
            agrees,
            is_doubtful,
        });
    }
    out
}

/// What a rest that begins where the filter is says to it, which comes from a rest with the means `before`.
fn innovation(filter: &Filter<'_>, before: &[f64; 6], rest: &Range<usize>) -> Innovation {
    let samples = filter.model.samples;
    let mut innovation = filter.rest_innovation(rest, REST_SPEED_MPS);
    let tilt = TILT_PER_TURN * filter.nominal.gravity * filter.turned_rad;
    let seconds = samples.time_s[rest.start.max(filter.at)] - filter.rest_s;
    let mean = samples.mean(rest);
    let apart = (0..3).map(|c| (mean[c] - before[c]).powi(2)).sum::<f64>();
    let rate = RATE_WALK.powi(2) * seconds.max(0.0) + RATE_PER_FORCE.powi(2) * apart;
    for c in 0..3 {
        innovation.s[(3 + c, 3 + c)] += tilt.powi(2);
        innovation.s[(6 + c, 6 + c)] += rate;
    }
    innovation
}

/// Touching rests of one pose are one.
fn merge_rests(model: &Model<'_>, mut rests: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let samples = model.samples;
    let is_pause = |last: &Range<usize>, next: &Range<usize>| {
        let (a, b) = (samples.mean(last), samples.mean(next));
        let apart = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
        let between = last.end.min(next.start)..next.start;
        let pause_s = samples.time_s[next.start] - samples.time_s[last.end - 1];
        let near = match unusable(samples, &(last.end - 1..next.start)) {
            None => pause_s < MAX_PAUSE_S,
            Some(Unusable::Gap { .. }) => between.is_empty() && pause_s < MAX_HOLE_S,
            Some(_) => false,
        };
        if !near || apart > SAME_FORCE_MPS2.powi(2) {
            return false;
        }
        let noise = model.noise.rest.force.sum();
        let count = between.len().max(1) as f64;
        let (mut square, mut velocity, mut moved) = (0.0, [0.0; 3], [0.0; 3]);
        for i in between {
            let h = samples.time_s[i] - samples.time_s[i - 1];
            for c in 0..3 {
                let x = samples.force_mps2[i][c] - a[c];
                square += x * x;
                velocity[c] += x * h;
                moved[c] += velocity[c] * h;
            }
        }
        let chance = 1.0 + MAX_PAUSE_SD * (2.0 / (3.0 * count)).sqrt();
        let is_calm = square / count * samples.period_s < noise * chance;
        let seconds = pause_s.max(SHORTEST_MOVE_S);
        let hidden_m = hidden_displacement_m((noise / 3.0).sqrt(), seconds);
        is_calm || moved.iter().map(|p| p * p).sum::<f64>() < hidden_m.powi(2)
    };
    rests.dedup_by(|next, last| {
        let is_one = is_pause(last, next);
        if is_one {
            last.end = next.end;
        }
        is_one
    });
    rests
}
