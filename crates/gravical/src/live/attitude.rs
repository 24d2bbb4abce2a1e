//! Attitude for the drawing: the gyroscope turns it, gravity levels it.

use nalgebra::{UnitQuaternion, Vector3};

/// Share of the angle to gravity that is corrected, 1/s, with a gyroscope.
const LEVELLING_PER_S: f64 = 2.0;

/// Attitude from the sensor to the world, whose z is up.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Attitude {
    q: UnitQuaternion<f64>,
    last_s: Option<f64>,
}

impl Attitude {
    /// Takes a sample: specific force, and angular rate without bias, rad/s. Without a gyroscope the heading
    /// stays as it is.
    pub fn update(&mut self, t_s: f64, force: [f64; 3], rate_rad_s: Option<[f64; 3]>) {
        let step_s = self.last_s.map_or(0.0, |last| (t_s - last).clamp(0.0, 0.2));
        let is_first = self.last_s.replace(t_s).is_none();
        let mut share = 1.0;
        if let Some(rate) = rate_rad_s.filter(|r| r.iter().all(|v| v.is_finite()) && !is_first) {
            self.q *= UnitQuaternion::from_scaled_axis(Vector3::from(rate) * step_s);
            share = 1.0 - (-LEVELLING_PER_S * step_s).exp();
        }
        let up = self.q * Vector3::from(force);
        if up.norm() > 0.0 && up.norm().is_finite() {
            // Upside down: any horizontal axis.
            let half_turn =
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let level = UnitQuaternion::rotation_between(&up, &Vector3::z()).unwrap_or(half_turn);
            self.q = level.powf(share) * self.q;
        }
    }

    /// Quaternion w, x, y, z.
    pub fn wxyz(&self) -> [f64; 4] {
        [self.q.w, self.q.i, self.q.j, self.q.k]
    }
}
