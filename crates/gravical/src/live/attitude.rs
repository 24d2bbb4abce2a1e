//! Attitude for the drawing: the gyroscope turns it, gravity levels it.

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
            self.q = product(self.q, rotation(rate.map(|v| v * step_s)));
            share = 1.0 - (-LEVELLING_PER_S * step_s).exp();
        }
        let length = norm(&force);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let v = rotate(self.q, force.map(|f| f / length));
        // From v to (0, 0, 1): about v × z.
        let axis = [v[1], -v[0], 0.0];
        let sine = norm(&axis);
        let angle = sine.atan2(v[2]) * share;
        let turn = match sine > 1e-9 {
            true => axis.map(|a| a / sine * angle),
            // Upside down: any horizontal axis.
            false => [angle, 0.0, 0.0],
        };
        self.q = product(rotation(turn), self.q);
        let size = norm(&self.q);
        self.q = self.q.map(|c| c / size);
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The quaternion of a rotation vector, rad.
fn rotation(turn: [f64; 3]) -> [f64; 4] {
    let angle = norm(&turn);
    let k = if angle > 1e-12 {
        (0.5 * angle).sin() / angle
    } else {
        0.5
    };
    [(0.5 * angle).cos(), k * turn[0], k * turn[1], k * turn[2]]
}

fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let back = [q[0], -q[1], -q[2], -q[3]];
    let [_, x, y, z] = product(product(q, [0.0, v[0], v[1], v[2]]), back);
    [x, y, z]
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
            let v = rotate(attitude.q, up.map(|c| c / norm(&up)));
            assert!((v[2] - 1.0).abs() < 1e-12, "{v:?}");
        }
        // A quarter turn about the vertical in one second.
        let up = [0.3, -0.5, 0.8];
        let level = up.map(|c| c / norm(&up));
        let before = rotate(attitude.q, [1.0, 0.0, 0.0]);
        for i in 1..=100 {
            let rate = level.map(|c| c * std::f64::consts::FRAC_PI_2);
            attitude.update(0.01 * f64::from(i), up, Some(rate));
        }
        let after = rotate(attitude.q, [1.0, 0.0, 0.0]);
        assert!((after[0] + before[1]).abs() < 1e-9 && (after[1] - before[0]).abs() < 1e-9);
    }
}
