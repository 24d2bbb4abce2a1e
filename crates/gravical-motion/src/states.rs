//! The motion at every sample, between the nodes of the path.
//!
//! In a move the samples are integrated from the node before; what is then missing at the node after
//! (biases, calibration, smoothing) is spread over the interval: of the attitude as a rotation that grows
//! linearly, of the velocity as a constant acceleration, of the position as a cubic.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::result::{Motion, PathNode};
use crate::transition::{mean_over_step, turn};
use gravical_signal::Samples;

/// Standard gravity, m/s²: what another one differs from it is missing at the nodes.
const GRAVITY_MPS2: f64 = 9.80665;

/// State of the motion at a sample; world axes, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleState {
    /// True in a rest.
    pub at_rest: bool,
    /// Sensor → world, quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Standard deviations of its rotation about x, y and z of the world, rad.
    pub attitude_sd_rad: [f64; 3],
    /// Mean acceleration without gravity over the step before, m/s².
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
        attitude_sd_rad: [f64::NAN; 3],
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
    /// At a node of the path it is the node's. The acceleration is the mean over the step before the sample, by which a
    /// move gains its velocity, and the position follows the velocity to what the interval between two nodes leaves of
    /// noise. In a rest, and between the nodes around a gap, velocity, position and attitude are interpolated, and the
    /// mean acceleration is that of the velocity; standard deviations are linear between nodes. Without a path of two
    /// nodes all numbers are NaN.
    pub fn states<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = SampleState> + 'a {
        let covered = self.path.last().is_some_and(|n| n.sample < samples.len());
        let path = if covered { &self.path[..] } else { &[][..] };
        let pairs = path.windows(2).filter(|p| p[0].sample < p[1].sample);
        let known = pairs.flat_map(move |pair| {
            let states = between(self, samples, [&pair[0], &pair[1]]);
            // Its first one is the last of the interval before.
            states.skip(usize::from(pair[0].sample > 0))
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

/// The states from a node to the next, both included.
fn between<'a>(
    motion: &Motion,
    samples: &'a Samples,
    [from, to]: [&'a PathNode; 2],
) -> impl Iterator<Item = SampleState> + use<'a> {
    let (span, last) = (from.sample..=to.sample, to.sample - from.sample);
    let (time_s, force) = (
        &samples.time_s[span.clone()],
        &samples.force_mps2[span.clone()],
    );
    let seconds = time_s[last] - time_s[0];
    let step_s = |i: usize| time_s[i] - time_s[i - 1];
    let fraction = move |i: usize| (time_s[i] - time_s[0]) / seconds;
    let has_gap = samples.gaps(&(from.sample..to.sample)).next().is_some();
    let next = motion
        .moves
        .partition_point(|m| m.samples.end <= from.sample);
    let next = motion.moves.get(next);
    let is_integrated = !has_gap && next.is_some_and(|m| m.samples.start <= from.sample);

    // Attitudes by the gyroscope; where it is not integrated the first alone.
    let mut attitude = quaternion(&from.attitude);
    let mut turned = vec![attitude];
    let (rates, steps) = (
        samples.rate_rad_s.get(span),
        if is_integrated { last } else { 0 },
    );
    for i in 1..=steps {
        if let Some(rates) = rates {
            let rate = [Vector3::from(rates[i - 1]), Vector3::from(rates[i])];
            attitude *= UnitQuaternion::from_scaled_axis(turn(&rate, step_s(i), samples.period_s));
        }
        turned.push(attitude);
    }
    // Rotation vector that is missing at the end, world axes.
    let missing = (quaternion(&to.attitude) * attitude.inverse()).scaled_axis();
    // Attitude at a sample, and mean acceleration over the step before it, of the first that of itself, m/s².
    let measured = move |i: usize| -> (UnitQuaternion<f64>, Vector3<f64>) {
        let pair = [i.saturating_sub(1), i];
        let [before, attitude] = pair.map(|i| {
            let turned = turned.get(i).unwrap_or(&turned[0]);
            UnitQuaternion::from_scaled_axis(missing * fraction(i)) * turned
        });
        let mean = pair.map(|i| Vector3::from(force[i]));
        let mean = mean_over_step(&mean, step_s(i.max(1)), samples.period_s);
        let force = before.nlerp(&attitude, 0.5) * mean;
        (attitude, force - Vector3::new(0.0, 0.0, GRAVITY_MPS2))
    };

    let mut velocity = Vector3::from(from.velocity_mps);
    let gained: Vector3<f64> = (1..=last).map(|i| measured(i).1 * step_s(i)).sum();
    let correction = (Vector3::from(to.velocity_mps) - velocity - gained) / seconds;

    // Velocity by the accelerations, position by trapezoids; what is missing of it at the end is spread.
    let mut integrated = Vec::new();
    if is_integrated {
        let mut position = Vector3::from(from.position_m);
        integrated.push([velocity, position]);
        for i in 1..=last {
            let change = (measured(i).1 + correction) * step_s(i);
            position += (velocity + change * 0.5) * step_s(i);
            velocity += change;
            integrated.push([velocity, position]);
        }
        let missing = Vector3::from(to.position_m) - position;
        for (i, [_, position]) in integrated.iter_mut().enumerate() {
            let u = fraction(i);
            *position += missing * (u * u * (3.0 - 2.0 * u));
        }
        integrated[last] = [to.velocity_mps, to.position_m].map(Vector3::from);
    }

    (0..=last).map(move |i| {
        let (u, (attitude, measured)) = (fraction(i), measured(i));
        let linear =
            |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|c| a[c] * (1.0 - u) + b[c] * u);
        let [velocity_mps, position_m] = match integrated.get(i) {
            Some(integrated) => integrated.map(<[f64; 3]>::from),
            None => [
                linear(&from.velocity_mps, &to.velocity_mps),
                linear(&from.position_m, &to.position_m),
            ],
        };
        SampleState {
            at_rest: false,
            attitude: [attitude.w, attitude.i, attitude.j, attitude.k],
            attitude_sd_rad: linear(&from.attitude_sd_rad, &to.attitude_sd_rad),
            acceleration_mps2: (measured + correction).into(),
            velocity_mps,
            velocity_sd_mps: linear(&from.velocity_sd_mps, &to.velocity_sd_mps),
            position_m,
            position_sd_m: linear(&from.position_sd_m, &to.position_sd_m),
        }
    })
}

fn quaternion(attitude: &[f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = *attitude;
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}
