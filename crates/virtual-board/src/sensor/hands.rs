//! Virtual hands: somebody types where the sensor is to lie, and there it lies.

use std::cell::RefCell;
use std::rc::Rc;
use std::str::FromStr;

use gravical::poses::face::Face;
use gravical::simulate::{InteractiveSensor, LineOptions, SimulateOptions, Truth};
use gravical::{Error, Result};

use super::source::{Reading, Source};

/// One thing that hands do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// Lays it down with that face up.
    Lay(Face),
    /// Holds it with that direction up.
    Hold([f64; 3]),
    /// Pushes it that far along its y, m.
    Push(f64),
}

/// What can be typed.
pub const COMMANDS: &str = "+x -x +y -y +z -z: that axis up; \
                            0.3 0.5 -0.8: that direction up; push, push 0.5: along y, m";

impl FromStr for Command {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let cannot = || {
            Error::usage("hands", format!("{text:?} is nothing that hands do")).with_hint(COMMANDS)
        };
        let text = text.trim();
        if let Some(face) = Face::all().into_iter().find(|f| f.name() == text) {
            return Ok(Command::Lay(face));
        }
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        if word == "push" {
            let way_m = match rest.trim() {
                "" => LineOptions::default().distance_m,
                way => way.parse().map_err(|_| cannot())?,
            };
            return Ok(Command::Push(way_m));
        }
        let numbers: Vec<f64> = text
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| cannot()))
            .collect::<Result<_>>()?;
        match *numbers {
            [x, y, z] => Ok(Command::Hold([x, y, z])),
            _ => Err(cannot()),
        }
    }
}

/// A sensor in hand, as a source of readings. The world goes on when the board is
/// reset, which is what the opening of a port does: readings do not begin again.
#[derive(Clone)]
pub struct Hands {
    world: Rc<RefCell<World>>,
}

struct World {
    sensor: InteractiveSensor,
    /// World's time at which the board's readings began.
    began_s: f64,
    last_s: f64,
}

impl Hands {
    /// Lying with z up.
    ///
    /// # Errors
    ///
    /// Those of [`InteractiveSensor::new`].
    pub fn new(options: &SimulateOptions) -> Result<Self> {
        let mut options = options.clone();
        // The counts are made by the model of the registers.
        options.sensor.quantise = false;
        Ok(Self {
            world: Rc::new(RefCell::new(World {
                sensor: InteractiveSensor::new(&options)?,
                began_s: 0.0,
                last_s: 0.0,
            })),
        })
    }

    /// Does it; gives the seconds until it rests.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage) for a direction or a way that cannot be.
    pub fn act(&self, command: Command) -> Result<f64> {
        let sensor = &mut self.world.borrow_mut().sensor;
        match command {
            Command::Lay(face) => Ok(sensor.lay(face)),
            Command::Hold(up) => sensor.hold(up),
            Command::Push(distance_m) => sensor.push(&LineOptions {
                distance_m,
                ..LineOptions::default()
            }),
        }
    }

    /// What the sensor is in truth.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.world.borrow().sensor.truth()
    }
}

impl Source for Hands {
    fn at(&mut self, time_s: f64) -> Reading {
        let mut world = self.world.borrow_mut();
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::simulate::{Scenario, StaticOptions};

    #[test]
    fn what_is_typed() {
        for face in Face::all() {
            let command: Command = format!(" {} ", face.name()).parse().unwrap();
            assert_eq!(command, Command::Lay(face));
        }
        assert_eq!("push".parse::<Command>().unwrap(), Command::Push(0.7));
        assert_eq!("push -0.5".parse::<Command>().unwrap(), Command::Push(-0.5));
        assert_eq!(
            "0.3 0.5 -0.8".parse::<Command>().unwrap(),
            Command::Hold([0.3, 0.5, -0.8])
        );
        for wrong in ["", "x", "+w", "push far", "1 2", "1 2 3 4", "1 2 z"] {
            let error = wrong.parse::<Command>().unwrap_err();
            assert_eq!(error.code(), "hands", "{wrong}");
            assert!(error.hint().unwrap().contains("push"));
        }
    }

    #[test]
    fn the_world_goes_on_when_readings_begin_again() {
        let options = SimulateOptions::new(Scenario::Static(StaticOptions::default()));
        let mut hands = Hands::new(&options).unwrap();
        assert!(hands.at(10.0).accel_mps2[2] > 8.0);
        hands.act(Command::Lay(Face::all()[0])).unwrap();
        assert!(hands.at(15.0).accel_mps2[0] > 8.0);
        // A reset: the sensor lies where it lay, and is as warm.
        let before_c = hands.at(100.0).temperature_c;
        let after = hands.at(0.0);
        assert!(after.accel_mps2[0] > 8.0);
        assert!((after.temperature_c - before_c).abs() < 0.2);
        hands.act(Command::Push(0.7)).unwrap();
        assert!(hands.act(Command::Hold([0.0; 3])).is_err());
        assert!(hands.act(Command::Push(1e9)).is_err());
    }
}
