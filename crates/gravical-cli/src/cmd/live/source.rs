//! Where the rows of a session come from: a port, a simulated sensor, a recording.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gravical::calibration_file::Calibration;
use gravical::core::matrix3::{add, mul_vec, norm};
use gravical::fit::model::sphere;
use gravical::gravity::Gravity;
use gravical::live::event::{Command, Event};
use gravical::live::folder::RECORDING;
use gravical::live::recorder::{self, Output};
use gravical::numfmt::milli_g;
use gravical::poses::face::Face;
use gravical::recording::bytes::Input;
use gravical::simulate::{InteractiveSensor, LineOptions, Reading, SimulateOptions};
use gravical::{Error, Result};

use crate::cmd::log::{self, Existing, LogFile};

/// Bytes of a recording that are read at once.
const AT_ONCE: usize = 1 << 12;
/// Rate of the simulated sensor, Hz.
const RATE_HZ: f64 = 100.0;
/// Its decimals.
const DECIMALS: usize = 4;
/// Rows that it gives at once.
const ROWS: u64 = 10;
/// The longest wait for rows before it is asked again, s.
const MAX_WAIT_S: f64 = 0.02;
/// Directions over which its true error is averaged.
const DIRECTIONS: usize = 400;
/// Pause in its clock when a session is resumed, s.
const RESUMED_AFTER_S: f64 = 5.0;

/// What a source has next: bytes of the recording, which are in the file, and then what happened.
#[derive(Default)]
pub struct Incoming {
    pub bytes: Vec<u8>,
    pub events: Vec<recorder::Event>,
}

/// A source of rows.
pub trait Source {
    /// What it has next; waits shortly. None: there are no more rows.
    ///
    /// # Errors
    ///
    /// Those that end the session.
    fn next(&mut self) -> Result<Option<Incoming>>;
    /// Makes the rows so far safe on the disk.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    fn make_safe(&mut self) -> Result<()> {
        Ok(())
    }
    /// Moves a simulated sensor; false for any other. `asked`: the direction that is asked for.
    ///
    /// # Errors
    ///
    /// For a direction that is none.
    fn hand(&mut self, _command: &Command, _asked: Option<[f64; 3]>) -> Result<bool> {
        Ok(false)
    }
    /// The session has ended: writes what waits. One that `has_failed` before its first row leaves no file.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    fn close(&mut self, _has_failed: bool) -> Result<()> {
        Ok(())
    }
    /// The true error of a simulated sensor with the result, and its sentence; for a recording in m/s².
    fn truth(&self, _file: &Calibration) -> Option<(Event, String)> {
        None
    }
}

/// A recording; packed, and in any encoding.
pub struct Replay {
    pub input: Input,
    pub path: PathBuf,
}

impl Source for Replay {
    fn next(&mut self) -> Result<Option<Incoming>> {
        let mut bytes = vec![0; AT_ONCE];
        let read = self.input.reader.read(&mut bytes);
        bytes.truncate(read.map_err(|e| Error::io(&self.path, e))?);
        let events = Vec::new();
        Ok((!bytes.is_empty()).then_some(Incoming { bytes, events }))
    }
}

/// A simulated sensor that is moved by commands. Its rows are written to a file.
pub struct Simulated {
    sensor: InteractiveSensor,
    pub file: LogFile,
    rows: u64,
    /// Time stamp of its start, s.
    offset_s: f64,
    /// When it last gave rows.
    last: Instant,
    speed: f64,
}

impl Simulated {
    /// A seed that nobody knows.
    pub fn draw_seed() -> u64 {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        now.map_or(1, |d| d.subsec_nanos() as u64 % 1_000_000)
    }

    /// Gravity where it is.
    pub fn gravity() -> Result<Gravity> {
        Gravity::given(Self::options(0).gravity_mps2)
    }

    fn options(seed: u64) -> SimulateOptions {
        SimulateOptions {
            seed,
            ..SimulateOptions::default()
        }
    }

    /// Starts it; `resumes`: its file is continued.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn open(path: &Path, resumes: bool, seed: u64, speed: f64) -> Result<Self> {
        let mut file = LogFile::open(path, Existing::of_session(resumes))?;
        file.start()?;
        let before = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
        Ok(Simulated {
            sensor: InteractiveSensor::new(&Self::options(seed))?,
            file,
            offset_s: last_row_s(&before).map_or(0.0, |t_s| t_s + RESUMED_AFTER_S),
            rows: 0,
            last: Instant::now(),
            speed,
        })
    }
}

/// Time of the last row of a recording of [`Simulated`], s; none without one.
fn last_row_s(text: &str) -> Option<f64> {
    let stamp_ms = |line: &str| line.split(',').next()?.parse::<f64>().ok();
    text.lines().rev().find_map(stamp_ms).map(|ms| ms / 1e3)
}

impl Source for Simulated {
    fn next(&mut self) -> Result<Option<Incoming>> {
        // Where the session does not keep up, the sensor waits for it: a hand could do nothing during the
        // rows that would have been due.
        let due_s = ROWS as f64 / RATE_HZ / self.speed;
        let left_s = due_s - self.last.elapsed().as_secs_f64();
        if self.speed > 0.0 && left_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left_s.min(MAX_WAIT_S)));
            return Ok(Some(Incoming::default()));
        }
        self.last = Instant::now();
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
        let bytes = text.into_bytes();
        self.file.write(&bytes)?;
        let events = Vec::new();
        Ok(Some(Incoming { bytes, events }))
    }

    fn make_safe(&mut self) -> Result<()> {
        self.file.sync()
    }

    fn hand(&mut self, command: &Command, asked: Option<[f64; 3]>) -> Result<bool> {
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

    fn truth(&self, file: &Calibration) -> Option<(Event, String)> {
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
        Some((event, text))
    }
}

/// A board at a port, recorded as `gravical log` does.
pub struct Port {
    pub recording: log::Recording,
    /// For synchronisation.
    pub file: File,
}

impl Port {
    /// Whether it has ended by an error, which is returned.
    fn end(&mut self, discards: bool) -> Result<()> {
        let Some((ended, _)) = self.recording.end(discards) else {
            return Ok(());
        };
        if discards {
            ended.file.discard_empty();
        }
        ended.done
    }
}

impl Source for Port {
    fn next(&mut self) -> Result<Option<Incoming>> {
        let Some(Output { lines, events, .. }) = self.recording.next() else {
            return self.end(true).map(|()| None);
        };
        let bytes = lines;
        Ok(Some(Incoming { bytes, events }))
    }

    fn make_safe(&mut self) -> Result<()> {
        let synced = self.file.sync_data();
        synced.map_err(|e| Error::io(Path::new(RECORDING), e))
    }

    fn close(&mut self, has_failed: bool) -> Result<()> {
        self.end(has_failed)
    }
}
