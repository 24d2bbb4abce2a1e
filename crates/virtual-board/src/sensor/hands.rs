//! Virtual hands: somebody types where the sensor is to lie, and there it lies.

use std::cell::RefCell;
use std::rc::Rc;

use gravical::poses::face::Face;
use gravical::simulate::{
    InteractiveSensor, LineOptions, Scenario, SimulateOptions, StaticOptions, Truth,
};
use gravical::{Error, Result};

use super::Reading;

/// What can be typed.
pub const COMMANDS: &str = "+x -x +y -y +z -z: that axis up; \
                            0.3 0.5 -0.8: that direction up; push, push 0.5: along y, m";

/// A sensor in hand. The world goes on when the board is reset, which is what the opening of a
/// port does: the sensor lies where it lay.
#[derive(Clone)]
pub struct Hands(Rc<RefCell<World>>);

struct World {
    sensor: InteractiveSensor,
    /// World's time at which the board's readings began.
    began_s: f64,
    last_s: f64,
}

impl Hands {
    /// The sensor of a seed, lying with z up; each pose on a face is tilted at random, by this
    /// standard deviation of each of two components.
    ///
    /// # Errors
    ///
    /// Those of [`InteractiveSensor::new`].
    pub fn new(seed: u64, tilt_sd_deg: f64) -> Result<Self> {
        let mut options = SimulateOptions::new(Scenario::Static(StaticOptions::default()));
        (options.seed, options.tilt_sd_deg) = (seed, tilt_sd_deg);
        // The counts are made by the model of the registers.
        options.sensor.quantise = false;
        Ok(Self(Rc::new(RefCell::new(World {
            sensor: InteractiveSensor::new(&options)?,
            began_s: 0.0,
            last_s: 0.0,
        }))))
    }

    /// Does what was typed; gives the seconds until it rests.
    ///
    /// # Errors
    ///
    /// `hands` (usage) for another word, `simulate-option` for a direction or a distance that
    /// cannot be.
    pub fn act(&self, line: &str) -> Result<f64> {
        let sensor = &mut self.0.borrow_mut().sensor;
        let unknown =
            || Error::usage("hands", format!("{line:?} is no command")).with_hint(COMMANDS);
        let number = |word: &str| word.parse::<f64>().map_err(|_| unknown());
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["push"] => sensor.push(&LineOptions::default()),
            ["push", distance] => sensor.push(&LineOptions {
                distance_m: number(distance)?,
                ..LineOptions::default()
            }),
            [x, y, z] => sensor.hold([number(x)?, number(y)?, number(z)?]),
            [name] => {
                let face = Face::all().into_iter().find(|f| f.name() == name);
                Ok(sensor.lay(face.ok_or_else(unknown)?))
            }
            _ => Err(unknown()),
        }
    }

    /// The reading `time_s` seconds after the start or the last reset.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Reading {
        let mut world = self.0.borrow_mut();
        if time_s < world.last_s {
            world.began_s += world.last_s;
        }
        world.last_s = time_s;
        let now_s = world.began_s + time_s;
        let reading = world.sensor.at(now_s);
        Reading {
            accel_mps2: reading.accel_mps2,
            gyro_deg_s: reading.gyro_rad_s.map(f64::to_degrees),
            temperature_c: reading.temperature_c,
        }
    }

    /// What the sensor is in truth.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.0.borrow().sensor.truth()
    }
}
