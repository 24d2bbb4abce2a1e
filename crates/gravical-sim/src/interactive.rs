//! A virtual sensor that is moved interactively.

use nalgebra::Vector3;

use crate::options::{LINE_OFFSET_M, LineOptions, Scenario, SimulateOptions};
use crate::problem::Problem;
use crate::record::{INSIDE_HZ, warmer_c};
use crate::scenario::{Draws, Plan, Z_UP, attitude_of};
use crate::sensor::{Part, Reading};
use crate::truth::Truth;
use gravical_fit::Face;
use gravical_judge::Result;

/// Pause of the hand between two commands given at once, s.
const PAUSE_S: f64 = 2.0;

/// A virtual sensor that rests until a command moves it.
///
/// [`simulate`](crate::simulate) computes complete recordings from a scenario. This type has no
/// scenario: a program that emulates a board, or that guides a user through a calibration,
/// queries readings as time passes, and lays down or pushes the sensor on command. The part, its
/// noise and the hand are those of [`simulate`](crate::simulate) with the same seed.
///
/// ```
/// # mod gravical { pub use gravical_judge::Error; pub use gravical_sim as simulate; pub mod poses { pub mod face { pub use gravical_fit::Face; } } }
/// use gravical::poses::face::Face;
/// use gravical::simulate::{InteractiveSensor, SimulateOptions};
///
/// let mut sensor = InteractiveSensor::new(&SimulateOptions::default())?;
/// assert!((sensor.at(1.0).accel_mps2[2] - 9.8).abs() < 1.0);
/// sensor.lay(Face::all()[1]);
/// assert!((sensor.at(5.0).accel_mps2[0] + 9.8).abs() < 1.0, "-x is up");
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct InteractiveSensor {
    part: Part,
    plan: Plan,
    draws: Draws,
    /// Number of completed internal time steps.
    steps: u64,
    last: Reading,
}

impl InteractiveSensor {
    /// Starts with z up and a random tilt.
    ///
    /// Of `options` only seed, gravity, tilt and sensor are used. The sensor is read when
    /// [`at`](Self::at) is called, so that options about rate, rows and stamps have no effect.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage) for an option out of its range.
    pub fn new(options: &SimulateOptions) -> Result<Self> {
        options.validate()?;
        let mut draws = Draws::new(options.seed, options.tilt_sd_deg);
        let (nominal, up) = draws.face_pose(Z_UP);
        let mut plan = Plan::new(options, "", up);
        plan.rest(nominal, 1.0 / INSIDE_HZ);
        let mut part = Part::new(options, 1.0 / INSIDE_HZ, 0, &plan, 0.0);
        let last = part.read(&plan, 0.0, 0.0);
        Ok(Self {
            part,
            plan,
            draws,
            steps: 0,
            last,
        })
    }

    /// The reading `t_s` seconds after the start, updated every millisecond. For a time before
    /// the latest reading, the latest one is returned.
    pub fn at(&mut self, t_s: f64) -> Reading {
        // Tolerance for rounding, so that 10 ms are ten steps.
        let due = (t_s * INSIDE_HZ + 1e-6).floor();
        while (self.steps as f64) < due {
            self.steps += 1;
            let now_s = self.now_s();
            let warm_c = warmer_c(&self.part.truth.options, now_s);
            if (self.steps as f64) < due {
                self.part.update(&self.plan, now_s, warm_c);
            } else {
                self.last = self.part.read(&self.plan, now_s, warm_c);
            }
        }
        self.last
    }

    /// Time of the latest reading, s.
    fn now_s(&self) -> f64 {
        self.steps as f64 / INSIDE_HZ
    }

    /// Moves the sensor by hand and lays it down with `face` up and a new random tilt. Returns
    /// the seconds until it rests.
    pub fn lay(&mut self, face_up: Face) -> f64 {
        let (_, up) = self.draws.face_pose(face_up);
        self.carry(up)
    }

    /// Moves the sensor to any direction up, of any length, without a tilt.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage) for a vector without direction.
    pub fn hold(&mut self, up: [f64; 3]) -> Result<f64> {
        let up = Vector3::from(up);
        // The norm can overflow although the components are finite.
        let up = up
            .try_normalize(1e-9)
            .filter(|_| up.norm().is_finite())
            .ok_or_else(|| Problem::NoDirection.error())?;
        Ok(self.carry(up))
    }

    /// Pushes the sensor across the table, as in the scenario `line`, along its own y (along its
    /// z if y is up or down). `rest_s` is not used: the move starts at once. Returns the seconds
    /// until it rests.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage) for an option out of its range.
    pub fn push(&mut self, line: &LineOptions) -> Result<f64> {
        Scenario::Line(*line).validate()?;
        self.begin();
        let attitude = self.plan.attitude;
        let up = attitude.inverse_transform_vector(&Vector3::z());
        // From the frame of the scenario to the world.
        let turned = attitude * attitude_of(up).inverse();
        let displacement = turned * Vector3::new(LINE_OFFSET_M, line.distance_m, 0.0);
        self.plan
            .go(Vector3::zeros(), displacement, line.move_time_s);
        Ok(self.plan.duration_s() - self.now_s())
    }

    /// The true parameters; without recordings.
    pub fn truth(&self) -> Truth {
        self.part.truth.clone()
    }

    fn carry(&mut self, up: Vector3<f64>) -> f64 {
        self.begin();
        self.plan.move_to(up);
        self.plan.duration_s() - self.now_s()
    }

    /// The next move starts now, or after a pause if another one is in progress.
    fn begin(&mut self) {
        let now_s = self.now_s();
        let free_s = self.plan.duration_s();
        let begins_s = if free_s > now_s {
            free_s + PAUSE_S
        } else {
            now_s
        };
        if begins_s > free_s {
            self.plan
                .rest(Vector3::from(Z_UP.direction()), begins_s - free_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_given_at_once_are_executed_in_order() {
        let mut sensor = InteractiveSensor::new(&SimulateOptions::default()).unwrap();
        let first_s = sensor.lay(Face::all()[0]);
        let second_s = sensor.lay(Face::all()[3]);
        assert!(second_s > first_s + PAUSE_S);
        assert!(sensor.at(first_s + 0.5 * PAUSE_S).accel_mps2[0] > 8.0);
        assert!(sensor.at(second_s + 1.0).accel_mps2[1] < -8.0);
        // Time does not run backwards.
        let now = sensor.at(second_s + 1.0);
        assert_eq!(sensor.at(0.0), now);
        for up in [[0.0; 3], [f64::NAN, 0.0, 1.0], [1e300; 3]] {
            assert!(sensor.hold(up).is_err());
        }
    }
}
