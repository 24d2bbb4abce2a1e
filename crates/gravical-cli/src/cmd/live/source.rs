//! Where the rows of a session come from: a port, a simulated sensor, a recording.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gravical::calibration_file::Calibration;
use gravical::live::SimulatedBoard;
use gravical::live::event::{Command, Event};
use gravical::live::folder::RECORDING;
use gravical::live::recorder::{self, Output};
use gravical::recording::bytes::Input;
use gravical::{Error, Result};

use crate::cmd::log::{self, Existing, LogFile};

/// Bytes of a recording that are read at once.
const AT_ONCE: usize = 1 << 12;
/// The longest wait for rows before it is asked again, s.
const MAX_WAIT_S: f64 = 0.02;

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

/// A simulated board in real time, or faster. Its rows are written to a file.
pub struct Simulated {
    board: SimulatedBoard,
    pub file: LogFile,
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
            board: SimulatedBoard::new(seed, &before)?,
            file,
            last: Instant::now(),
            speed,
        })
    }
}

impl Source for Simulated {
    fn next(&mut self) -> Result<Option<Incoming>> {
        // Where the session does not keep up, the sensor waits for it: a hand could do nothing during the
        // rows that would have been due.
        let due_s = SimulatedBoard::PERIOD_S / self.speed;
        let left_s = due_s - self.last.elapsed().as_secs_f64();
        if self.speed > 0.0 && left_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left_s.min(MAX_WAIT_S)));
            return Ok(Some(Incoming::default()));
        }
        self.last = Instant::now();
        let bytes = self.board.next_rows().into_bytes();
        self.file.write(&bytes)?;
        let events = Vec::new();
        Ok(Some(Incoming { bytes, events }))
    }

    fn make_safe(&mut self) -> Result<()> {
        self.file.sync()
    }

    fn hand(&mut self, command: &Command, asked: Option<[f64; 3]>) -> Result<bool> {
        self.board.command(command, asked)
    }

    fn truth(&self, file: &Calibration) -> Option<(Event, String)> {
        Some(self.board.truth(file))
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
        let Some(ended) = self.recording.end(discards) else {
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
