//! Integration in time by the trapezoidal rule, with the real step of each sample.

use crate::Real;

/// Acceleration to velocity and position, sample by sample.
///
/// v += h (a₀ + a₁)/2, p += h (v₀ + v₁)/2. At 100 Hz an oscillation of 1 Hz
/// comes out 0.03 % too small. A constant error b of the acceleration grows to bt
/// and bt²/2: nothing here corrects it.
///
/// ```
/// use gravical_core::integrate::Trapezoid;
///
/// let mut integral = Trapezoid::new([0.0; 3], [0.0; 3]);
/// integral.update([2.0, 0.0, 0.0], 0.0);
/// for _ in 0..100 {
///     integral.update([2.0, 0.0, 0.0], 0.01);
/// }
/// assert!((integral.velocity()[0] - 2.0_f64).abs() < 1e-12);
/// assert!((integral.position()[0] - 1.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Trapezoid<T> {
    acceleration: [T; 3],
    velocity: [T; 3],
    position: [T; 3],
    started: bool,
}

impl<T: Real> Trapezoid<T> {
    /// Starts with a velocity, m/s, and a position, m.
    #[must_use]
    pub fn new(velocity: [T; 3], position: [T; 3]) -> Self {
        Trapezoid {
            acceleration: [T::zero(); 3],
            velocity,
            position,
            started: false,
        }
    }

    /// Takes the acceleration, m/s², `h_s` seconds after the sample before; of
    /// the first sample the step counts nothing.
    #[inline]
    pub fn update(&mut self, acceleration_mps2: [T; 3], h_s: T) {
        if self.started {
            let half = h_s * T::from_f64(0.5);
            for i in 0..3 {
                let before = self.velocity[i];
                let now = before + half * (self.acceleration[i] + acceleration_mps2[i]);
                self.velocity[i] = now;
                self.position[i] = self.position[i] + half * (before + now);
            }
        }
        self.started = true;
        self.acceleration = acceleration_mps2;
    }

    /// Velocity at the last sample, m/s.
    #[must_use]
    pub fn velocity(&self) -> [T; 3] {
        self.velocity
    }

    /// Position at the last sample, m.
    #[must_use]
    pub fn position(&self) -> [T; 3] {
        self.position
    }

    /// Starts anew.
    pub fn reset(&mut self, velocity: [T; 3], position: [T; 3]) {
        *self = Self::new(velocity, position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_steps_of_a_straight_line_are_exact() {
        // a = 6t: v = 3t², by trapezoids exactly.
        let mut integral = Trapezoid::new([0.0, 1.0, 0.0], [0.0; 3]);
        let mut t = 0.0_f64;
        integral.update([0.0; 3], 7.0);
        for i in 0..200 {
            let h = if i % 3 == 0 { 0.004 } else { 0.011 };
            t += h;
            integral.update([6.0 * t, 0.0, 0.0], h);
        }
        assert!((integral.velocity()[0] - 3.0 * t * t).abs() < 1e-12);
        assert!((integral.velocity()[1] - 1.0).abs() < 1e-15);
        assert!((integral.position()[1] - t).abs() < 1e-12);
        // Twice: off by h²/2 of the cubic's curvature at the most.
        assert!((integral.position()[0] - t.powi(3)).abs() < 3e-4);
    }

    #[test]
    fn the_gain_at_one_hertz() {
        let (w, h) = (core::f64::consts::TAU, 0.01_f64);
        let mut integral = Trapezoid::new([0.0; 3], [0.0; 3]);
        for i in 0..=25 {
            integral.update([(w * h * f64::from(i)).cos(), 0.0, 0.0], h);
        }
        let gain = integral.velocity()[0] * w - 1.0;
        assert!((gain + 0.00033).abs() < 1e-5, "{gain}");
    }
}
