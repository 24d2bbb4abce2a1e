//! The motion at every sample, between the nodes of the path.
//!
//! In a move the samples are integrated from the node before; what is then missing at the node after
//! (biases, calibration, smoothing) is spread over the interval: of the attitude as a rotation that grows
//! linearly, of the velocity as a constant acceleration, of the position as a cubic.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::result::{Motion, Move, PathNode, array};
use crate::samples::Samples;
use crate::transition::turn;

/// Standard gravity, m/s²: what another one differs from it is missing at the nodes.
const GRAVITY_MPS2: f64 = 9.80665;

/// State of the motion at a sample; world axes, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleState {
    /// True in a rest.
    pub at_rest: bool,
    /// Sensor → world, quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Acceleration without gravity, m/s².
    pub acceleration_mps2: [f64; 3],
    /// Velocity, m/s, and its standard deviations.
    pub velocity_mps: [f64; 3],
    /// See `velocity_mps`.
    pub velocity_sd_mps: [f64; 3],
    /// Position from the start of the recording, m, and its standard deviations.
    pub position_m: [f64; 3],
    /// See `position_m`.
    pub position_sd_m: [f64; 3],
}

impl SampleState {
    /// Nothing is known.
    pub const UNKNOWN: SampleState = SampleState {
        at_rest: false,
        attitude: [f64::NAN; 4],
        acceleration_mps2: [f64::NAN; 3],
        velocity_mps: [f64::NAN; 3],
        velocity_sd_mps: [f64::NAN; 3],
        position_m: [f64::NAN; 3],
        position_sd_m: [f64::NAN; 3],
    };
}

impl Motion {
    /// The state at each of the `samples` that this is the motion of, in order.
    ///
    /// At a node of the path it is the node's. The trapezoid of the accelerations of a move is its velocity
    /// (short of moves in which every sample is a node), and the position follows the velocity to what the
    /// interval between two nodes leaves of noise. In a rest, and between the nodes around a gap, velocity,
    /// position and attitude are interpolated, and the mean acceleration is that of the velocity; standard
    /// deviations are linear between nodes. Without a path of two nodes all numbers are NaN.
    pub fn states<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = SampleState> + 'a {
        let covered = self.path.last().is_some_and(|n| n.sample < samples.len());
        let path = if covered { &self.path[..] } else { &[][..] };
        let mut follower = Follower {
            motion: self,
            samples,
            correction: Vector3::zeros(),
            last_acceleration: None,
            single: false,
        };
        let mut next = 0;
        let pairs = path.windows(2).filter(|p| p[0].sample < p[1].sample);
        let known = pairs.flat_map(move |pair| {
            let first = std::mem::replace(&mut next, pair[1].sample + 1);
            follower.states(Interval::new(samples, &pair[0], &pair[1]), first)
        });
        let unknown = std::iter::repeat(SampleState::UNKNOWN);
        let mut rests = self.rests.iter().peekable();
        let states = known.chain(unknown).take(samples.len()).enumerate();
        states.map(move |(i, mut state)| {
            while rests.next_if(|r| r.end <= i).is_some() {}
            state.at_rest = !self.path.is_empty() && rests.peek().is_some_and(|r| r.contains(&i));
            state
        })
    }
}

/// Goes from interval to interval.
struct Follower<'a> {
    motion: &'a Motion,
    samples: &'a Samples,
    /// What the samples before lack, and the acceleration of the last of them with it, m/s².
    correction: Vector3<f64>,
    last_acceleration: Option<Vector3<f64>>,
    /// True if the interval before had one step.
    single: bool,
}

impl<'a> Follower<'a> {
    /// From sample `first` to the end of the interval.
    fn states(
        &mut self,
        interval: Interval<'a>,
        first: usize,
    ) -> Box<dyn Iterator<Item = SampleState> + 'a> {
        let span = interval.from.sample..interval.to.sample;
        let moves = &self.motion.moves;
        let next = moves.partition_point(|m| m.samples.end <= span.start);
        let is_begun = |m: &Move| m.samples.start <= span.start;
        let moving = moves.get(next).is_some_and(is_begun);
        if self.samples.gaps(&span).next().is_some() {
            let last = interval.acceleration(span.end, &interval.attitude(span.end));
            self.last_acceleration = Some(last + self.correction);
        } else if moving {
            let states = self.integrate(&interval).into_iter();
            return Box::new(states.skip(first - span.start));
        } else {
            self.correct(&interval, |i| interval.attitude(i));
        }
        let correction = self.correction;
        let state = move |i| interval.state(i, &interval.attitude(i), &correction);
        Box::new((first..=span.end).map(state))
    }

    /// Takes the correction of an interval by which the trapezoid of the accelerations, the first as it
    /// was with the correction before, is the velocity.
    fn correct(
        &mut self,
        interval: &Interval<'_>,
        attitude: impl Fn(usize) -> UnitQuaternion<f64>,
    ) {
        let time_s = &self.samples.time_s;
        let (from, to) = (interval.from.sample, interval.to.sample);
        let raw = |i: usize| interval.acceleration(i, &attitude(i));
        let mut sum = Vector3::zeros();
        for i in from + 1..=to {
            let after = time_s[(i + 1).min(to)];
            sum += raw(i) * (0.5 * (after - time_s[i - 1]));
        }
        let velocity =
            Vector3::from(interval.to.velocity_mps) - Vector3::from(interval.from.velocity_mps);
        let half_s = 0.5 * (time_s[from + 1] - time_s[from]);
        let seconds = time_s[to] - time_s[from];
        let single = to == from + 1;
        self.correction = match self.last_acceleration {
            Some(last) if !(single && self.single) => {
                (velocity - sum - last * half_s) / (seconds - half_s)
            }
            // With one step after the other a correction that starts from the last one would swing.
            _ => (velocity - sum - raw(from) * half_s) / seconds,
        };
        self.single = single;
        self.last_acceleration = Some(raw(to) + self.correction);
    }

    /// All samples of the interval, both ends included.
    fn integrate(&mut self, interval: &Interval<'_>) -> Vec<SampleState> {
        let samples = self.samples;
        let time_s = &samples.time_s;
        let (from, to) = (interval.from.sample, interval.to.sample);
        let mut attitudes = vec![quaternion(&interval.from.attitude)];
        for i in from..to {
            let turn = samples
                .rate
                .get(i..i + 2)
                .map_or(UnitQuaternion::identity(), |rate| {
                    let rate = [Vector3::from(rate[0]), Vector3::from(rate[1])];
                    UnitQuaternion::from_scaled_axis(turn(&rate, time_s[i + 1] - time_s[i]))
                });
            attitudes.push(attitudes[i - from] * turn);
        }
        let missing = quaternion(&interval.to.attitude) * attitudes[to - from].inverse();
        let missing = missing.scaled_axis();
        for (i, attitude) in (from..).zip(&mut attitudes) {
            *attitude =
                UnitQuaternion::from_scaled_axis(missing * interval.fraction(i)) * *attitude;
        }
        let first = self.last_acceleration;
        self.correct(interval, |i| attitudes[i - from]);
        let raw = |i: usize| interval.acceleration(i, &attitudes[i - from]);
        let mut acceleration = first.unwrap_or_else(|| raw(from) + self.correction);
        let mut velocity = Vector3::from(interval.from.velocity_mps);
        let mut position = Vector3::from(interval.from.position_m);
        let mut states = Vec::with_capacity(attitudes.len());
        for i in from..=to {
            if i > from {
                let h = time_s[i] - time_s[i - 1];
                let next = raw(i) + self.correction;
                let change = (acceleration + next) * (0.5 * h);
                position += (velocity + change * 0.5) * h;
                velocity += change;
                acceleration = next;
            }
            states.push(SampleState {
                acceleration_mps2: array(&acceleration),
                velocity_mps: array(&velocity),
                position_m: array(&position),
                ..interval.state(i, &attitudes[i - from], &self.correction)
            });
        }
        let missing = Vector3::from(interval.to.position_m) - position;
        for (i, state) in (from..).zip(&mut states) {
            let u = interval.fraction(i);
            let part = missing * (u * u * (3.0 - 2.0 * u));
            state.position_m = array(&(Vector3::from(state.position_m) + part));
        }
        if let Some(last) = states.last_mut() {
            last.velocity_mps = interval.to.velocity_mps;
            last.position_m = interval.to.position_m;
        }
        states
    }
}

/// Samples from a node to the next.
#[derive(Clone, Copy)]
struct Interval<'a> {
    samples: &'a Samples,
    from: &'a PathNode,
    to: &'a PathNode,
    /// Rotation vector from the attitude of the one to that of the other, world axes.
    turn: Vector3<f64>,
}

impl<'a> Interval<'a> {
    fn new(samples: &'a Samples, from: &'a PathNode, to: &'a PathNode) -> Interval<'a> {
        let turn = quaternion(&to.attitude) * quaternion(&from.attitude).inverse();
        Interval {
            samples,
            from,
            to,
            turn: turn.scaled_axis(),
        }
    }

    /// Fraction of its time that is past at a sample.
    fn fraction(&self, i: usize) -> f64 {
        let time_s = &self.samples.time_s;
        let (from_s, to_s) = (time_s[self.from.sample], time_s[self.to.sample]);
        if to_s > from_s {
            (time_s[i] - from_s) / (to_s - from_s)
        } else {
            1.0
        }
    }

    fn attitude(&self, i: usize) -> UnitQuaternion<f64> {
        let turn = UnitQuaternion::from_scaled_axis(self.turn * self.fraction(i));
        turn * quaternion(&self.from.attitude)
    }

    /// Acceleration that a sample measures, m/s².
    fn acceleration(&self, i: usize, attitude: &UnitQuaternion<f64>) -> Vector3<f64> {
        attitude * Vector3::from(self.samples.force[i]) - Vector3::new(0.0, 0.0, GRAVITY_MPS2)
    }

    /// Between the nodes, with this attitude and what samples lack of acceleration.
    fn state(
        &self,
        i: usize,
        attitude: &UnitQuaternion<f64>,
        correction: &Vector3<f64>,
    ) -> SampleState {
        let (u, from, to) = (self.fraction(i), self.from, self.to);
        let linear =
            |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|c| a[c] * (1.0 - u) + b[c] * u);
        SampleState {
            at_rest: false,
            attitude: [attitude.w, attitude.i, attitude.j, attitude.k],
            acceleration_mps2: array(&(self.acceleration(i, attitude) + correction)),
            velocity_mps: linear(&from.velocity_mps, &to.velocity_mps),
            velocity_sd_mps: linear(&from.velocity_sd_mps, &to.velocity_sd_mps),
            position_m: linear(&from.position_m, &to.position_m),
            position_sd_m: linear(&from.position_sd_m, &to.position_sd_m),
        }
    }
}

fn quaternion(attitude: &[f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = *attitude;
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}
