//! One leg, forwards or from its far end: samples, closure, and the effect of each parameter.

use std::ops::Range;

use gravical_core::matrix3::{mul_vec, sub};
use gravical_core::strapdown::{conjugate, quat_mul};

use super::bands::{LegNoise, Steps, Unmodelled};
use super::leg::{Closure, Columns, Forward, Leg, Removal};
use super::parameters::{Direction, STEP};
use super::setup::Setup;
use crate::recording::Meter;

/// Samples of a leg that are computed at a time where nothing is known of its end.
const CHUNK: usize = 4096;

/// What the parameters have done before a leg begins.
pub(super) struct Carried {
    /// By direction: displacement of the position by one standard deviation, m.
    pub offsets: Vec<[f64; 3]>,
    /// … and rotation of the heading, rad.
    pub yaw_offsets: Vec<f64>,
}

/// One leg, computed some samples at a time, with the effect of the parameters on them.
pub(super) struct Course<'a> {
    pub leg: &'a Leg<'a>,
    pub noise: &'a LegNoise,
    pub steps: Option<Steps>,
    /// Those of the parameters; none without bands.
    pub directions: &'a [Direction],
    meter: Option<&'a Meter>,
    nominal: Forward<'a>,
    /// A pass for each direction; none where its effect is in proportion to the way.
    changed: Vec<Forward<'a>>,
    pub done: usize,
    pub columns: Columns,
    other: Columns,
    pub closure: Option<Closure>,
    /// Variance of the closure's velocity, (m/s)², and of the tilt missing there, rad², by
    /// the parameters.
    pub closure_by_parameters: [[f64; 3]; 2],
    /// What the closure shows beside the model.
    pub unmodelled: Unmodelled,
    /// Variances of velocity and position by the parameters, those of the legs before
    /// included.
    pub by_velocity: Vec<[f64; 3]>,
    pub by_position: Vec<[f64; 3]>,
    /// By direction: what it makes of the way so far, m, and of the heading, rad.
    pub off: Vec<([f64; 3], f64)>,
}

impl<'a> Course<'a> {
    pub fn new(setup: &Setup<'a>, leg: &'a Leg<'a>, noise: &'a LegNoise) -> Self {
        let directions = if setup.bands { setup.directions } else { &[] };
        // Without rotation all that the parameters change grows with the way.
        let in_proportion =
            matches!(leg.removal, Removal::Mean(_)) && leg.stances.is_empty() && leg.v0 == [0.0; 3];
        Course {
            leg,
            noise,
            steps: None,
            directions,
            meter: setup.meter,
            nominal: Forward::new(leg, Direction::NONE),
            changed: match in_proportion {
                true => Vec::new(),
                false => directions
                    .iter()
                    .map(|d| Forward::new(leg, d.times(STEP)))
                    .collect(),
            },
            done: 0,
            columns: Columns::default(),
            other: Columns::default(),
            closure: None,
            closure_by_parameters: [[0.0; 3]; 2],
            unmodelled: Unmodelled::default(),
            by_velocity: Vec::new(),
            by_position: Vec::new(),
            off: vec![([0.0; 3], 0.0); directions.len()],
        }
    }

    /// Takes the next samples, all of them where they are corrected from the far end on.
    /// What the parameters make of each is computed `along` them, else of the last.
    pub fn advance(&mut self, before: &Carried, along: bool) {
        let leg = self.leg;
        let n = match leg.is_corrected() {
            true => leg.len(),
            false => CHUNK.min(leg.len() - self.done),
        };
        self.done += n;
        self.nominal.run(n, along, &mut self.columns);
        if leg.is_corrected() {
            self.closure = Some(leg.close(&self.nominal, &mut self.columns));
        }
        self.steps =
            (!leg.stances.is_empty()).then(|| Steps::new(leg, &self.columns.tau, self.noise));
        let places = match along {
            true => 0..n,
            false => self.end()..self.end() + 1,
        };
        for sums in [&mut self.by_velocity, &mut self.by_position] {
            sums.clear();
            sums.resize(n, [0.0; 3]);
        }
        for k in 0..self.directions.len() {
            if self.meter.is_some_and(Meter::is_stopped) {
                break;
            }
            self.add_direction(k, places.clone(), before);
        }
    }

    /// Adds what one direction makes of the samples at `places`.
    fn add_direction(&mut self, k: usize, places: Range<usize>, before: &Carried) {
        let (leg, columns) = (self.leg, &self.columns);
        let (before, turned) = (before.offsets[k], before.yaw_offsets[k]);
        let mut attitude = None;
        if let Some(one) = self.changed.get_mut(k) {
            one.run(columns.tau.len(), false, &mut self.other);
            attitude = Some(match self.closure {
                Some(nominal) => {
                    let other = leg.close(one, &mut self.other);
                    for i in 0..3 {
                        let off = (other.velocity[i] - nominal.velocity[i]) / STEP;
                        self.closure_by_parameters[0][i] += off * off;
                        let off = (other.missing[i] - nominal.missing[i]) / STEP;
                        self.closure_by_parameters[1][i] += off * off;
                    }
                    other.attitude
                }
                None => one.propagator.attitude(),
            });
        }
        let (other, matrix) = (&self.other, self.directions[k].matrix());
        let off_at = |k: usize| -> ([f64; 3], [f64; 3]) {
            let (v, p) = (&columns.velocity[k], &columns.position[k]);
            if attitude.is_none() {
                return (mul_vec(matrix, v), mul_vec(matrix, p));
            }
            // The heading that the legs before have lost turns this one.
            let aside = [-turned * p[1], turned * p[0], 0.0];
            (
                std::array::from_fn(|i| (other.velocity[k][i] - v[i]) / STEP),
                std::array::from_fn(|i| (other.position[k][i] - p[i]) / STEP + aside[i]),
            )
        };
        let far = off_at(columns.tau.len() - 1).1;
        let base = if leg.is_backwards() { far } else { [0.0; 3] };
        for k in places {
            let (v, p) = off_at(k);
            for i in 0..3 {
                self.by_velocity[k][i] += v[i] * v[i];
                self.by_position[k][i] += (before[i] + p[i] - base[i]).powi(2);
            }
        }
        self.off[k] = match attitude {
            _ if leg.is_backwards() => (far.map(|v| -v), 0.0),
            Some(attitude) => (far, heading(&attitude, &self.attitude()) / STEP),
            None => (far, 0.0),
        };
    }

    /// The place of the last sample in time.
    pub fn end(&self) -> usize {
        match self.leg.is_backwards() {
            true => 0,
            false => self.columns.tau.len() - 1,
        }
    }

    /// From the first sample of the leg in time to place `k`, m.
    pub fn position(&self, k: usize) -> [f64; 3] {
        let all = &self.columns.position;
        match self.leg.is_backwards() {
            true => sub(&all[k], &all[all.len() - 1]),
            false => all[k],
        }
    }

    /// At the last sample that was taken.
    pub fn attitude(&self) -> [f64; 4] {
        self.closure
            .map_or(self.nominal.propagator.attitude(), |c| c.attitude)
    }
}

/// How far the first attitude is turned about the vertical against the second,
/// rad; small.
fn heading(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    2.0 * quat_mul(a, &conjugate(b))[3]
}
