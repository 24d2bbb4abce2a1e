//! A simulated board for a guided session: its sensor is moved by commands, and its rows have no clock but
//! their own.

use gravical_calibrate::calibration_file::Calibration;
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::poses::face::Face;
use gravical_core::matrix3::{add, mul_vec, norm};
use gravical_fit::model::sphere;
use gravical_judge::Result;
use gravical_judge::numfmt::milli_g;
use gravical_sim::{InteractiveSensor, LineOptions, Reading, SimulateOptions};

use crate::event::{Command, Event};

/// Its rate, Hz, and its decimals.
const RATE_HZ: f64 = 100.0;
const DECIMALS: usize = 4;
/// Rows that it gives at once.
const ROWS: u64 = 10;
/// Directions over which its true error is averaged.
const DIRECTIONS: usize = 400;
/// Pause in its clock when a session is resumed, s.
const RESUMED_AFTER_S: f64 = 5.0;

/// A simulated board.
pub struct SimulatedBoard {
    sensor: InteractiveSensor,
    rows: u64,
    /// Time stamp of its start, s.
    offset_s: f64,
}

impl SimulatedBoard {
    /// Time of the rows that it gives at once, s.
    pub const PERIOD_S: f64 = ROWS as f64 / RATE_HZ;

    /// Gravity where it is.
    ///
    /// # Errors
    ///
    /// None with the default options.
    pub fn gravity() -> Result<Gravity> {
        Gravity::given(options(0).gravity_mps2)
    }

    /// A sensor with this seed, whose recording so far is `before`.
    ///
    /// # Errors
    ///
    /// None with the default options.
    pub fn new(seed: u64, before: &str) -> Result<Self> {
        let stamp_ms = |line: &str| line.split(',').next()?.parse::<f64>().ok();
        let last_ms = before.lines().rev().find_map(stamp_ms);
        Ok(SimulatedBoard {
            sensor: InteractiveSensor::new(&options(seed))?,
            rows: 0,
            offset_s: last_ms.map_or(0.0, |ms| ms / 1e3 + RESUMED_AFTER_S),
        })
    }

    /// The next rows, and their header before the first.
    pub fn next_rows(&mut self) -> String {
        let mut text = String::new();
        if self.rows == 0 && self.offset_s == 0.0 {
            text.push_str("# simulated, not measured\n");
            text.push_str(Reading::HEADER);
        }
        for _ in 0..ROWS {
            let t_s = self.rows as f64 / RATE_HZ;
            let stamp_ms = (1e3 * (self.offset_s + t_s)).round() as u64;
            text += &self.sensor.at(t_s).row(stamp_ms, DECIMALS);
            self.rows += 1;
        }
        text
    }

    /// Moves the sensor; false for a command that is not for it. `asked`: the direction that is asked for.
    ///
    /// # Errors
    ///
    /// For a direction that is none.
    pub fn command(&mut self, command: &Command, asked: Option<[f64; 3]>) -> Result<bool> {
        let Command::Hand { put, up, shake } = command else {
            return Ok(false);
        };
        let mut faces = Face::all().into_iter();
        let face = faces.find(|face| Some(face.name()) == *put);
        if *shake {
            self.sensor.push(&LineOptions {
                distance_m: 0.05,
                move_time_s: 0.35,
                ..LineOptions::default()
            })?;
        } else if let Some(face) = face {
            self.sensor.lay(face);
        } else {
            // Any new direction where none is asked for.
            self.sensor.hold(up.or(asked).unwrap_or([0.6, 0.6, 0.5]))?;
        }
        Ok(true)
    }

    /// The true error of a calibration, and its sentence.
    pub fn truth(&self, file: &Calibration) -> (Event, String) {
        let truth = self.sensor.truth();
        let sensor = &truth.accelerometer;
        let calibration = file.accelerometer_calibration();
        let warm_c = file.temperature_c.map_or(0.0, |t| t.mean - 25.0);
        let bias: [f64; 3] =
            std::array::from_fn(|i| sensor.bias_mps2[i] + warm_c * sensor.bias_drift_mps2_per_c[i]);
        let mut squares = [0.0_f64; 2];
        for up in sphere(DIRECTIONS) {
            let force = (up * truth.gravity_mps2).into();
            let raw = add(&mul_vec(&sensor.matrix, &force), &bias);
            for (sum, a) in squares.iter_mut().zip([raw, calibration.apply(raw)]) {
                *sum += (norm(&a) - truth.gravity_mps2).powi(2);
            }
        }
        let [before_mg, norm_error_mg] =
            squares.map(|sum| milli_g((sum / DIRECTIONS as f64).sqrt()));
        let text = format!(
            "The truth: error of ‖a‖ {norm_error_mg:.2} mg rms with this calibration, {before_mg:.1} mg without."
        );
        let event = Event::Truth {
            norm_error_mg,
            before_mg,
        };
        (event, text)
    }
}

fn options(seed: u64) -> SimulateOptions {
    SimulateOptions {
        seed,
        ..SimulateOptions::default()
    }
}
