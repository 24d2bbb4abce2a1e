//! A move from a rest on, and whether it can have come to rest again.

use super::gate::{FAR, FLOOR_MPS, OpenNoise, angle};
use super::{Kept, MotionConfig, Propagator, Removal};
use crate::Real;
use crate::matrix3::{scaled, sub};
use crate::still::RestNoise;

/// What follows from one rest, integrated sample by sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<T> {
    pub forward: Propagator<T>,
    /// Bias of the gyroscope, rad/s.
    pub bias: [T; 3],
    /// Magnitude at the rest, m/s².
    pub gravity: T,
    /// Attitude there.
    pub departed: [T; 4],
    /// Since the rest, s; and how long that was.
    pub since_s: T,
    pub rested_s: T,
    steps: T,
    /// ∫ of the angle from the rest, rad s.
    turned: T,
    /// Where it began to be quiet, if it is: time, velocity and position then.
    quiet: Option<(T, [T; 3], [T; 3])>,
}

impl<T: Real> Course<T> {
    pub fn new(forward: Propagator<T>) -> Self {
        Course {
            bias: [T::zero(); 3],
            gravity: T::zero(),
            departed: forward.attitude(),
            since_s: T::zero(),
            rested_s: T::zero(),
            steps: T::zero(),
            turned: T::zero(),
            quiet: None,
            forward,
        }
    }

    /// The rest ends here, after `rested_s`.
    pub fn depart(&mut self, rested_s: T) {
        self.rested_s = rested_s;
        self.since_s = T::zero();
        self.steps = T::zero();
        self.turned = T::zero();
        self.quiet = None;
        self.departed = self.forward.attitude();
        self.forward.level(self.departed, self.forward.gravity());
    }

    /// Integrates a sample; `turns` where the angle from the rest counts.
    #[inline]
    pub fn advance(&mut self, now: &Kept<T>, turns: bool) {
        self.since_s = self.since_s + now.h_s;
        self.steps = self.steps + T::one();
        let rate = sub(&now.rate, &self.bias);
        self.forward.update(now.force, rate, now.h_s);
        if turns {
            let angle = angle(&self.departed, &self.forward.attitude());
            self.turned = self.turned + now.h_s * angle;
        }
    }

    /// Notes whether the sensor is quiet, and gives for how long it has been, s.
    pub fn note(&mut self, is_quiet: bool) -> T {
        if !is_quiet {
            self.quiet = None;
            return T::zero();
        }
        let now = (
            self.since_s,
            self.forward.velocity(),
            self.forward.position(),
        );
        self.since_s - self.quiet.get_or_insert(now).0
    }

    /// It rests: the velocity is zero, and what was left of it comes off the position, as if
    /// it had grown evenly. Where it was `quiet` for long before that was believed, it
    /// had grown until then, and has not moved since.
    pub fn arrive(&mut self, after_quiet: bool) {
        let now = (
            self.since_s,
            self.forward.velocity(),
            self.forward.position(),
        );
        let (since_s, left, position) = self.quiet.filter(|_| after_quiet).unwrap_or(now);
        let half = T::from_f64(0.5) * since_s;
        self.forward
            .set_velocity_position([T::zero(); 3], sub(&position, &scaled(&left, half)));
    }

    /// True where the velocity is as near to zero as it can be known.
    pub fn may_rest(&self, config: &MotionConfig<T>, noise: &RestNoise<T>) -> bool {
        let limit = T::from_f64(FAR) * self.sigma_velocity(config, noise);
        self.forward.velocity().iter().all(|v| v.abs() <= limit)
    }

    /// Standard uncertainty of a component of the velocity, m/s: noise since the rest
    /// ([`OpenNoise`]), and what the parameters make of the angle θ that the sensor is
    /// turned by, (g s + b) ∫θ dt: the scale s of the gyroscope leaves a tilt of s θ; a
    /// bias b that was levelled away comes back as b θ. A bound for each axis; the
    /// correlations between them are left out.
    fn sigma_velocity(&self, config: &MotionConfig<T>, noise: &RestNoise<T>) -> T {
        let step_s = self.since_s / self.steps.max(T::one());
        let density = |from: usize| {
            let axes = noise.mean_variance[0][from..from + 3].iter();
            axes.fold(T::zero(), |most, v| most.max(*v)) * step_s
        };
        let follows = config.removal == Removal::Strapdown;
        let only = |there: bool, value: T| if there { value } else { T::zero() };
        let rest_s = self.rested_s.max(step_s);
        let gyro = only(follows, density(3));
        let open = OpenNoise {
            gyro,
            bias: gyro / rest_s,
            tilt_change: only(!follows, config.tilt_change_rad * config.tilt_change_rad),
            gravity: self.gravity,
            rest_s,
        };
        let [by_noise, by_tilt] = open.velocity(self.since_s);
        let share = self.gravity * config.gyro_scale + config.bias_mps2;
        let parameters = only(follows, share * self.turned);
        let floor = T::from_f64(FLOOR_MPS * FLOOR_MPS);
        (density(0) * by_noise + by_tilt + parameters * parameters + floor).sqrt()
    }
}
