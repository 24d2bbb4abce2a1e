//! The motion at every sample, between the nodes of the path.
//!
//! In a move the samples are integrated from the node before; what is then missing at the node after
//! (biases, calibration, smoothing) is spread over the interval: of the attitude as a rotation that grows
//! linearly, of the velocity as a constant acceleration, of the position as a cubic.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::result::{Motion, PathNode};
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
        let (mut next, mut before) = (0, Before::default());
        let pairs = path.windows(2).filter(|p| p[0].sample < p[1].sample);
        let known = pairs.flat_map(move |pair| {
            let first = std::mem::replace(&mut next, pair[1].sample + 1);
            let interval = Interval::new(self, samples, &pair[0], &pair[1], &mut before);
            (first..=pair[1].sample).map(move |i| interval.state(i))
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

/// What an interval takes over from that before it.
#[derive(Default)]
struct Before {
    /// What its samples lack, and the acceleration of the last of them with it, m/s².
    correction: Vector3<f64>,
    last_acceleration: Option<Vector3<f64>>,
    /// True if it had one step.
    is_single: bool,
}

/// Samples from a node to the next.
struct Interval<'a> {
    samples: &'a Samples,
    from: &'a PathNode,
    to: &'a PathNode,
    /// Attitudes by the gyroscope; where it is not integrated the first alone.
    turned: Vec<UnitQuaternion<f64>>,
    /// Rotation vector that is missing at the end, world axes.
    missing: Vector3<f64>,
    /// What the samples lack of acceleration, m/s².
    correction: Vector3<f64>,
    /// Velocity and position; empty where they are not integrated.
    integrated: Vec<[Vector3<f64>; 2]>,
}

impl<'a> Interval<'a> {
    fn new(
        motion: &Motion,
        samples: &'a Samples,
        from: &'a PathNode,
        to: &'a PathNode,
        before: &mut Before,
    ) -> Interval<'a> {
        let (first, last) = (from.sample, to.sample);
        let has_gap = samples.gaps(&(first..last)).next().is_some();
        let next = motion.moves.partition_point(|m| m.samples.end <= first);
        let next = motion.moves.get(next);
        let is_integrated = !has_gap && next.is_some_and(|m| m.samples.start <= first);
        let mut attitude = quaternion(&from.attitude);
        let mut turned = vec![attitude];
        if is_integrated {
            for i in first + 1..=last {
                if let Some(rate) = samples.rate.get(i - 1..=i) {
                    let rate = [Vector3::from(rate[0]), Vector3::from(rate[1])];
                    let h = samples.time_s[i] - samples.time_s[i - 1];
                    attitude *= UnitQuaternion::from_scaled_axis(turn(&rate, h));
                }
                turned.push(attitude);
            }
        }
        let mut interval = Interval {
            samples,
            from,
            to,
            turned,
            missing: (quaternion(&to.attitude) * attitude.inverse()).scaled_axis(),
            correction: before.correction,
            integrated: Vec::new(),
        };
        if !has_gap {
            interval.correct(before);
            before.is_single = last == first + 1;
        }
        if is_integrated {
            interval.integrate(before.last_acceleration);
        }
        before.correction = interval.correction;
        before.last_acceleration = Some(interval.acceleration(last));
        interval
    }

    fn step_s(&self, i: usize) -> f64 {
        self.samples.time_s[i] - self.samples.time_s[i - 1]
    }

    /// Fraction of its time that is past at a sample.
    fn fraction(&self, i: usize) -> f64 {
        let time_s = &self.samples.time_s;
        let from_s = time_s[self.from.sample];
        (time_s[i] - from_s) / (time_s[self.to.sample] - from_s)
    }

    fn attitude(&self, i: usize) -> UnitQuaternion<f64> {
        let turned = self.turned.get(i - self.from.sample);
        let turned = turned.unwrap_or(&self.turned[0]);
        UnitQuaternion::from_scaled_axis(self.missing * self.fraction(i)) * turned
    }

    /// Acceleration that a sample measures, m/s².
    fn measured(&self, i: usize) -> Vector3<f64> {
        let force = self.attitude(i) * Vector3::from(self.samples.force[i]);
        force - Vector3::new(0.0, 0.0, GRAVITY_MPS2)
    }

    fn acceleration(&self, i: usize) -> Vector3<f64> {
        self.measured(i) + self.correction
    }

    /// Takes the correction by which the trapezoid of the accelerations, the first as it was with the correction
    /// before, is the velocity.
    fn correct(&mut self, before: &Before) {
        let time_s = &self.samples.time_s;
        let (from, to) = (self.from.sample, self.to.sample);
        let mut sum = Vector3::zeros();
        for i in from + 1..=to {
            let after = time_s[(i + 1).min(to)];
            sum += self.measured(i) * (0.5 * (after - time_s[i - 1]));
        }
        let velocity = Vector3::from(self.to.velocity_mps) - Vector3::from(self.from.velocity_mps);
        let half_s = 0.5 * self.step_s(from + 1);
        let seconds = time_s[to] - time_s[from];
        self.correction = match before.last_acceleration {
            Some(last) if !(to == from + 1 && before.is_single) => {
                (velocity - sum - last * half_s) / (seconds - half_s)
            }
            // With one step after the other a correction that starts from the last one would swing.
            _ => (velocity - sum - self.measured(from) * half_s) / seconds,
        };
    }

    /// Trapezoids of the accelerations, the first one given; what is missing of the position at the end is spread.
    fn integrate(&mut self, first: Option<Vector3<f64>>) {
        let (from, to) = (self.from.sample, self.to.sample);
        let mut acceleration = first.unwrap_or_else(|| self.acceleration(from));
        let mut velocity = Vector3::from(self.from.velocity_mps);
        let mut position = Vector3::from(self.from.position_m);
        self.integrated.push([velocity, position]);
        for i in from + 1..=to {
            let (h, next) = (self.step_s(i), self.acceleration(i));
            let change = (acceleration + next) * (0.5 * h);
            position += (velocity + change * 0.5) * h;
            velocity += change;
            acceleration = next;
            self.integrated.push([velocity, position]);
        }
        let missing = Vector3::from(self.to.position_m) - position;
        for i in from..to {
            let u = self.fraction(i);
            self.integrated[i - from][1] += missing * (u * u * (3.0 - 2.0 * u));
        }
        let ends = [self.to.velocity_mps, self.to.position_m];
        self.integrated[to - from] = ends.map(Vector3::from);
    }

    fn state(&self, i: usize) -> SampleState {
        let (u, from, to) = (self.fraction(i), self.from, self.to);
        let linear =
            |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|c| a[c] * (1.0 - u) + b[c] * u);
        let [velocity_mps, position_m] = match self.integrated.get(i - from.sample) {
            Some(integrated) => integrated.map(<[f64; 3]>::from),
            None => [
                linear(&from.velocity_mps, &to.velocity_mps),
                linear(&from.position_m, &to.position_m),
            ],
        };
        let attitude = self.attitude(i);
        SampleState {
            at_rest: false,
            attitude: [attitude.w, attitude.i, attitude.j, attitude.k],
            acceleration_mps2: self.acceleration(i).into(),
            velocity_mps,
            velocity_sd_mps: linear(&from.velocity_sd_mps, &to.velocity_sd_mps),
            position_m,
            position_sd_m: linear(&from.position_sd_m, &to.position_sd_m),
        }
    }
}

fn quaternion(attitude: &[f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = *attitude;
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}
