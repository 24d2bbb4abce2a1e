//! A recording: one batch that holds everything, and what was judged of it.

pub(crate) mod judging;

use std::io::{self, BufRead, Cursor, ErrorKind, Read};
use std::path::Path;

pub use judging::notes::CALIBRATED;

use serde::{Deserialize, Serialize};

use crate::board::BoardSettings;
use crate::bytes;
use crate::error::Error;
use crate::judge::UnitDoubt;
use crate::note::{Note, NoteKind};
use crate::options::ReadOptions;
use crate::text::{Aside, Batch, Format, axes, sniff};
use crate::time_unit::TimeUnit;
use crate::units::{AccelScale, AccelUnit, GyroScale};

/// Bytes of the text that decide on the format.
pub const HEAD_BYTES: usize = 262_144;

/// What a column of labels says.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Labels {
    /// The different labels in order of appearance
    pub names: Vec<String>,
    /// For each row the index of its label
    pub of_row: Vec<u32>,
}

/// Timing of a recording.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Timing {
    /// Unit of the time stamps; `None` without time stamps, and for one without a name, as 10 ms
    pub unit: Option<TimeUnit>,
    /// The claimed sampling rate (metadata, `--rate`), in Hz
    pub nominal_rate_hz: Option<f64>,
    /// One over the mean of the steps within half of the median step, in Hz. If the stamps are
    /// times of arrival in bursts, the mean rate
    pub median_rate_hz: Option<f64>,
    /// Number of rows over the recorded time without pauses, in Hz
    pub mean_rate_hz: Option<f64>,
    /// From the first time stamp to the last, in s; without time stamps from rows and claimed rate
    pub duration_s: Option<f64>,
    /// Standard deviation of the steps that are not gaps, in s
    pub jitter_s: Option<f64>,
    /// Share of samples that are missing, 0 to 1
    pub missing_share: Option<f64>,
}

impl Timing {
    /// The sampling rate to work with, in Hz: that of the time stamps, otherwise the claimed one.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        self.median_rate_hz.or(self.nominal_rate_hz)
    }
}

/// Everything that a file holds, in columns, and what was judged of it.
///
/// Values are in the unit of the file; counts less [`zero_offset`](Self::zero_offset). An empty
/// cell is NaN.
#[derive(Clone, PartialEq, Debug)]
pub struct Recording {
    /// Text format in words: `comma separated, header in line 1`
    pub description: String,
    /// Lines above the rows
    pub metadata: Vec<String>,
    /// Names of the columns; empty without a header
    pub column_names: Vec<String>,
    /// Columns of the accelerometer
    pub accel_columns: [usize; 3],
    /// Settings of our board, where it wrote them
    pub board: Option<BoardSettings>,
    /// Seconds since the first row; `None` without usable time stamps
    pub time_s: Option<Vec<f64>>,
    /// The first time stamp, s, on the recorder's clock
    pub start_s: Option<f64>,
    /// The clock restarted at least once
    pub restarted: bool,
    /// Rates, jitter, missing samples
    pub timing: Timing,
    /// Specific force along x, y, z
    pub accel: [Vec<f64>; 3],
    /// Its unit
    pub accel_scale: AccelScale,
    /// Why its unit is unknown; `None` if it is known
    pub unit_doubt: Option<UnitDoubt>,
    /// Its unit according to the header
    pub header_unit: Option<AccelUnit>,
    /// Value subtracted from the counts of the accelerometer
    pub zero_offset: f64,
    /// Angular rate about x, y, z
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Its unit, as far as head and values tell
    pub gyro_scale: Option<GyroScale>,
    /// Resolution of ax, ay, az, gx, gy, gz; 0 where it is unknown
    pub resolution: [f64; 6],
    /// Temperature of the sensor, °C
    pub temperature_c: Option<Vec<f64>>,
    /// Placement or section of each row
    pub labels: Option<Labels>,
    /// Rows that do not continue the row before: after blank lines, a named gap, a reset of the
    /// board, a repeated header, rows that were set aside
    pub breaks: Vec<usize>,
    /// Line in which each row begins, from 1
    pub lines: Vec<u32>,
    /// Lines and rows that were set aside; with the rows they are all lines
    pub aside: Aside,
    /// What whoever uses the recording should know
    pub notes: Vec<Note>,
}

impl Recording {
    /// Reads a file; `-` is standard input, `accel_[xyz].txt` a file per axis.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or holds no samples of an accelerometer.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, Error> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match axes::open(path) {
            Some(text) => Recording::read(text?.as_bytes(), &name, options),
            None => Recording::read(bytes::open(path)?, &name, options),
        }
    }

    /// Reads UTF-8 (see [`bytes::utf8`]); the name of the file may tell the sensor.
    ///
    /// # Errors
    ///
    /// Reading fails, or there are no samples of an accelerometer.
    pub fn read(text: impl BufRead, file_name: &str, options: &ReadOptions) -> Result<Self, Error> {
        let (format, text) = open_text(text, file_name, options)?;
        Recording::collect(&format, format.batches(text))
    }

    /// Collects the batches of a whole file.
    ///
    /// # Errors
    ///
    /// Reading fails, the columns take more than a gigabyte, or there are no samples of an
    /// accelerometer.
    pub fn collect(
        format: &Format,
        batches: impl Iterator<Item = io::Result<Batch>>,
    ) -> Result<Self, Error> {
        let mut rows = Batch::default();
        let mut is_cut = false;
        for batch in batches {
            match batch {
                Ok(batch) => rows.append(batch),
                Err(e) if e.kind() == ErrorKind::UnexpectedEof && rows.rows() > 0 => is_cut = true,
                Err(e) => return Err(e.into()),
            }
            rows.check_size()?;
        }
        let count = rows.rows();
        let mut recording = Recording::judge(format, rows)?;
        if is_cut {
            let text = format!(
                "the packed file is damaged or ends in the middle; {count} rows could be unpacked"
            );
            recording
                .notes
                .push(Note::new(NoteKind::TruncatedFile, text));
        }
        Ok(recording)
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// Rows per second by the stamps, else by what is claimed.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        self.timing.rate_hz()
    }
}

/// The format of a text by its head, and the text from its beginning on.
///
/// # Errors
///
/// Those of [`sniff`], and of reading.
pub fn open_text<R: BufRead>(
    mut text: R,
    file_name: &str,
    options: &ReadOptions,
) -> Result<(Format, impl BufRead + use<R>), Error> {
    let head = bytes::read_head(&mut text, HEAD_BYTES)?;
    let format = sniff(&whole_lines(&head), file_name, options)?;
    Ok((format, Cursor::new(head).chain(text)))
}

/// The first 256 KiB of a text, without the line that they cut.
#[must_use]
pub fn whole_lines(head: &[u8]) -> String {
    let is_cut = head.len() == HEAD_BYTES;
    let end = head
        .iter()
        .rposition(|b| is_cut && matches!(b, b'\n' | b'\r'));
    let text = String::from_utf8_lossy(&head[..end.map_or(head.len(), |e| e + 1)]);
    text.replace('\0', "")
}
