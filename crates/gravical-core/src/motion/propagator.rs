//! The forward pass of one sample.

use crate::Real;
use crate::integrate::Trapezoid;
use crate::matrix3::{mul_vec, sub};
use crate::strapdown::{Strapdown, matrix};

/// Attitude, velocity and position, carried on sample by sample: the attitude by the
/// gyroscope or as it is, the specific force turned into the frame, gravity off, the
/// trapezoid twice.
///
/// ```
/// use gravical_core::motion::Propagator;
///
/// let level = [1.0, 0.0, 0.0, 0.0];
/// let mut forward = Propagator::new(level, true, [0.0, 0.0, 9.81]);
/// for i in 0..=100 {
///     forward.update([1.0, 0.0, 9.81], [0.0; 3], if i == 0 { 0.0 } else { 0.01 });
/// }
/// assert!((forward.velocity()[0] - 1.0_f64).abs() < 1e-12);
/// assert!((forward.position()[0] - 0.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Propagator<T> {
    /// None where the attitude stays as it is.
    strapdown: Option<Strapdown<T>>,
    attitude: [T; 4],
    rotation: [[T; 3]; 3],
    gravity: [T; 3],
    acceleration: [T; 3],
    integral: Trapezoid<T>,
}

impl<T: Real> Propagator<T> {
    /// At rest, position zero, at the first sample to come. `follows` says whether the
    /// attitude is followed; `gravity` is what is taken off in the frame, m/s².
    #[must_use]
    pub fn new(attitude: [T; 4], follows: bool, gravity: [T; 3]) -> Self {
        let zero = [T::zero(); 3];
        Propagator {
            strapdown: follows.then(|| Strapdown::new(attitude)),
            attitude,
            rotation: matrix(&attitude),
            gravity,
            acceleration: zero,
            integral: Trapezoid::new(zero, zero),
        }
    }

    /// Takes specific force, m/s², and angular rate without its bias, rad/s, `h_s`
    /// seconds after the sample before; of the first one the step counts nothing.
    #[inline]
    pub fn update(&mut self, force: [T; 3], rate: [T; 3], h_s: T) {
        if let Some(strapdown) = &mut self.strapdown {
            self.attitude = strapdown.update(rate, h_s);
            self.rotation = matrix(&self.attitude);
        }
        self.acceleration = sub(&mul_vec(&self.rotation, &force), &self.gravity);
        self.integral.update(self.acceleration, h_s);
    }

    /// Starts anew at the next sample with an attitude and gravity; velocity and
    /// position stay.
    pub fn level(&mut self, attitude: [T; 4], gravity: [T; 3]) {
        self.attitude = attitude;
        self.rotation = matrix(&attitude);
        self.gravity = gravity;
        if let Some(strapdown) = &mut self.strapdown {
            strapdown.reset(attitude);
        }
    }

    /// Starts anew at the next sample with a velocity, m/s, and a position, m.
    pub fn set_velocity_position(&mut self, velocity: [T; 3], position: [T; 3]) {
        self.acceleration = [T::zero(); 3];
        self.integral.reset(velocity, position);
    }

    /// Attitude at the last sample, sensor → frame.
    #[must_use]
    pub fn attitude(&self) -> [T; 4] {
        self.attitude
    }

    /// What is taken off in the frame, m/s².
    #[must_use]
    pub fn gravity(&self) -> [T; 3] {
        self.gravity
    }

    /// Acceleration of the last sample in the frame, without gravity, m/s².
    #[must_use]
    pub fn acceleration(&self) -> [T; 3] {
        self.acceleration
    }

    /// Velocity at the last sample, m/s.
    #[must_use]
    pub fn velocity(&self) -> [T; 3] {
        self.integral.velocity()
    }

    /// Position at the last sample, m.
    #[must_use]
    pub fn position(&self) -> [T; 3] {
        self.integral.position()
    }
}
