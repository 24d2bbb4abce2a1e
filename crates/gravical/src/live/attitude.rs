//! Attitude for the drawing: the gyroscope turns it, gravity levels it.

use gravical_core::matrix3::norm;
use gravical_core::strapdown::{from_rotation_vector, normalize, quat_mul, rotate};

/// Share of the angle to gravity that is corrected, 1/s, with a gyroscope.
const LEVELLING_PER_S: f64 = 2.0;

/// Quaternion w, x, y, z from the sensor to the world, whose z is up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attitude {
    pub q: [f64; 4],
    last_s: Option<f64>,
}

impl Default for Attitude {
    fn default() -> Self {
        Attitude {
            q: [1.0, 0.0, 0.0, 0.0],
            last_s: None,
        }
    }
}

impl Attitude {
    /// Takes a sample: direction of specific force, and angular rate without bias, rad/s. Without
    /// a gyroscope the heading stays as it is.
    pub fn update(&mut self, t_s: f64, force: [f64; 3], rate_rad_s: Option<[f64; 3]>) {
        let step_s = self.last_s.map_or(0.0, |last| (t_s - last).clamp(0.0, 0.2));
        let first = self.last_s.replace(t_s).is_none();
        let mut share = 1.0;
        if let Some(rate) = rate_rad_s.filter(|r| r.iter().all(|v| v.is_finite()) && !first) {
            self.q = quat_mul(&self.q, &from_rotation_vector(&rate.map(|v| v * step_s)));
            share = 1.0 - (-LEVELLING_PER_S * step_s).exp();
        }
        let length = norm(&force);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let v = rotate(&self.q, &force.map(|f| f / length));
        // From v to (0, 0, 1): about v × z.
        let axis = [v[1], -v[0], 0.0];
        let sine = norm(&axis);
        let angle = sine.atan2(v[2]) * share;
        let level = if sine > 1e-9 {
            axis.map(|a| a / sine * angle)
        } else {
            // Upside down: any horizontal axis.
            [angle, 0.0, 0.0]
        };
        self.q = normalize(&quat_mul(&from_rotation_vector(&level), &self.q));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_is_up_and_the_gyroscope_turns_the_heading() {
        let mut attitude = Attitude::default();
        for up in [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.3, -0.5, 0.8]] {
            attitude = Attitude::default();
            attitude.update(0.0, up, None);
            let v = rotate(&attitude.q, &up.map(|c| c / norm(&up)));
            assert!((v[2] - 1.0).abs() < 1e-12, "{v:?}");
        }
        // A quarter turn about the vertical in one second.
        let up = [0.3, -0.5, 0.8];
        let level = up.map(|c| c / norm(&up));
        let before = rotate(&attitude.q, &[1.0, 0.0, 0.0]);
        for i in 1..=100 {
            let rate = level.map(|c| c * std::f64::consts::FRAC_PI_2);
            attitude.update(0.01 * f64::from(i), up, Some(rate));
        }
        let after = rotate(&attitude.q, &[1.0, 0.0, 0.0]);
        assert!((after[0] + before[1]).abs() < 1e-9 && (after[1] - before[0]).abs() < 1e-9);
    }
}
