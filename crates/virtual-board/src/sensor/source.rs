//! What the sensor feels: a function of time, or a recording.

use std::path::Path;

use gravical::recording::{ReadOptions, Recording, read};
use gravical::simulate::{
    LineOptions, PosesOptions, Scenario, SimulateOptions, StaticOptions, simulate,
};
use gravical::{Error, Result};

/// What a perfect part would read at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Specific force along x, y, z, m/s².
    pub accel_mps2: [f64; 3],
    /// Angular rate about x, y, z, °/s.
    pub gyro_deg_s: [f64; 3],
    /// Temperature, °C.
    pub temperature_c: f64,
}

impl Default for Reading {
    /// Flat on the table at 25 °C.
    fn default() -> Self {
        Self {
            accel_mps2: [0.0, 0.0, 9.80665],
            gyro_deg_s: [0.0; 3],
            temperature_c: 25.0,
        }
    }
}

/// Where the sensor's readings come from.
pub trait Source {
    /// The reading `time_s` seconds after the start.
    fn at(&mut self, time_s: f64) -> Reading;
}

impl<F: FnMut(f64) -> Reading> Source for F {
    fn at(&mut self, time_s: f64) -> Reading {
        self(time_s)
    }
}

/// Rows in order of time. Each is held until the next one comes, so that noise
/// stays as it was recorded; after the last one it begins again.
#[derive(Debug, Clone)]
pub struct Rows {
    /// Seconds from the first row, never falling.
    times_s: Vec<f64>,
    readings: Vec<Reading>,
    /// From the first row to where it begins again.
    period_s: f64,
}

impl Rows {
    /// A recording, in whatever unit: its accelerometer has to have a unit that
    /// is known. Without a gyroscope the rates are 0, without a thermometer it is
    /// 25 °C; an empty cell is what it was in the row before.
    ///
    /// # Errors
    ///
    /// Those of [`gravical::recording::read`], and `unit-unknown` (input).
    pub fn from_file(path: &Path) -> Result<Self> {
        Self::from_recording(&read(path, &ReadOptions::default())?)
    }

    /// As [`from_file`](Self::from_file), of a recording that is read already.
    ///
    /// # Errors
    ///
    /// `unit-unknown` (input).
    pub fn from_recording(recording: &Recording) -> Result<Self> {
        let Some(per_mps2) = recording.accel_scale.nominal() else {
            return Err(Error::input(
                "unit-unknown",
                format!("{}: the accelerometer's unit is not known", recording.name),
            ));
        };
        let per_rad_s = recording.gyro_scale.as_ref().and_then(|s| s.nominal());
        let (rate_hz, _) = recording.working_rate_hz();
        let mut last = Reading::default();
        let mut rows = Self::with_capacity(recording.rows());
        let keep = |new: f64, old: f64| if new.is_finite() { new } else { old };
        for row in 0..recording.rows() {
            for axis in 0..3 {
                let accel = recording.accel[axis][row] / per_mps2;
                last.accel_mps2[axis] = keep(accel, last.accel_mps2[axis]);
                if let (Some(gyro), Some(scale)) = (&recording.gyro, per_rad_s) {
                    let rate = (gyro[axis][row] / scale).to_degrees();
                    last.gyro_deg_s[axis] = keep(rate, last.gyro_deg_s[axis]);
                }
            }
            if let Some(temperature) = &recording.temperature_c {
                last.temperature_c = keep(temperature[row], last.temperature_c);
            }
            let time_s = match &recording.time_s {
                Some(times) => times[row],
                None => row as f64 / rate_hz,
            };
            rows.push(time_s, last);
        }
        Ok(rows.closed())
    }

    /// A scenario of `gravical simulate`: `static`, `line` or `poses`, its files
    /// one after the other.
    ///
    /// # Errors
    ///
    /// `usage` for another name, and those of [`gravical::simulate::simulate`].
    pub fn simulated(scenario: &str, seed: u64) -> Result<Self> {
        let mut options = SimulateOptions::new(match scenario {
            "static" => Scenario::Static(StaticOptions::default()),
            "line" => Scenario::Line(LineOptions::default()),
            "poses" => Scenario::Poses(PosesOptions::default()),
            other => {
                return Err(Error::usage(
                    "usage",
                    format!("--simulate {other}: static, line or poses"),
                ));
            }
        });
        options.seed = seed;
        // The counts are made by the model of the registers.
        options.sensor.quantise = false;
        let simulation = simulate(&options)?;
        let mut rows = Self::with_capacity(0);
        let mut start_s = 0.0;
        for file in &simulation.files {
            for row in &file.rows {
                rows.push(
                    start_s + row.t_s,
                    Reading {
                        accel_mps2: row.reading.accel_mps2,
                        gyro_deg_s: row.reading.gyro_rad_s.map(f64::to_degrees),
                        temperature_c: row.reading.temperature_c,
                    },
                );
            }
            start_s = rows.times_s.last().copied().unwrap_or(0.0) + 1.0 / options.rate_hz;
        }
        Ok(rows.closed())
    }

    /// Seconds until it begins again.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.period_s
    }

    fn with_capacity(rows: usize) -> Self {
        Self {
            times_s: Vec::with_capacity(rows),
            readings: Vec::with_capacity(rows),
            period_s: 0.0,
        }
    }

    /// A row; a stamp that is no number or runs backwards is as late as the last.
    fn push(&mut self, time_s: f64, reading: Reading) {
        let last = self.times_s.last().copied().unwrap_or(0.0);
        self.times_s.push(if time_s > last { time_s } else { last });
        self.readings.push(reading);
    }

    /// The last row lasts as long as the average one.
    fn closed(mut self) -> Self {
        if let (Some(first), Some(last)) = (self.times_s.first(), self.times_s.last()) {
            let steps = (self.times_s.len() - 1).max(1);
            self.period_s = (last - first) * (1.0 + 1.0 / steps as f64);
        }
        self
    }
}

impl Source for Rows {
    fn at(&mut self, time_s: f64) -> Reading {
        let time_s = if self.period_s > 0.0 {
            time_s.rem_euclid(self.period_s)
        } else {
            0.0
        };
        // A sensor as fast as the rows takes each of them once: half a
        // millisecond keeps rounding from deciding which.
        let at = self.times_s.partition_point(|&t| t <= time_s + 5e-4);
        self.readings
            .get(at.saturating_sub(1))
            .copied()
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::recording::read_bytes;

    #[test]
    fn rows_are_held_and_begin_again() {
        let text = "t_ms,ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)\n\
                    0,0.0,0.1,9.8,1,2,3\n10,0.5,0.1,9.7,4,5,6\n20,0.0,0.2,9.8,,8,9\n";
        let recording = read_bytes(text.as_bytes(), "t", &ReadOptions::default()).unwrap();
        let mut rows = Rows::from_recording(&recording).unwrap();
        assert!((rows.duration_s() - 0.03).abs() < 1e-12);
        assert_eq!(rows.at(0.0).accel_mps2, [0.0, 0.1, 9.8]);
        assert_eq!(rows.at(0.009).accel_mps2, [0.0, 0.1, 9.8]);
        assert_eq!(rows.at(0.0101).accel_mps2, [0.5, 0.1, 9.7]);
        let last = rows.at(0.025);
        assert!((last.gyro_deg_s[0] - 4.0).abs() < 1e-9, "an empty cell");
        assert!((last.gyro_deg_s[2] - 9.0).abs() < 1e-9);
        assert_eq!(rows.at(0.0305).accel_mps2, rows.at(0.0).accel_mps2);
    }

    #[test]
    fn what_cannot_be_fed() {
        assert!(Rows::from_file(Path::new("/nowhere.csv")).is_err());
        assert_eq!(Rows::simulated("circle", 1).unwrap_err().code(), "usage");
        let mut none = Rows::with_capacity(0).closed();
        assert_eq!(none.at(3.0), Reading::default());
    }

    #[test]
    fn scenarios() {
        for scenario in ["static", "line", "poses"] {
            let mut rows = Rows::simulated(scenario, 3).unwrap();
            let norm = rows.at(1.0).accel_mps2.iter().map(|v| v * v).sum::<f64>();
            assert!((norm.sqrt() - 9.8).abs() < 1.0, "{scenario}");
            assert!(rows.duration_s() > 5.0);
        }
    }
}
