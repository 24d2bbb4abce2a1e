//! A recording: its rows, and what was judged of them.

use std::ops::Range;

use gravical_judge::units::{TimeUnit, Units};
use gravical_judge::utc::UtcTime;
use gravical_judge::{Encoding, Finding, Result};
use serde::Serialize;

use crate::problem::Problem;
use crate::text::{Format, Ledger};

/// Bytes of the text that decide on the format.
pub(crate) const HEAD_BYTES: usize = 262_144;

/// What a column of labels says.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Labels {
    /// The different labels in order of appearance
    pub names: Vec<String>,
    /// For each row the index of its label
    pub of_row: Vec<u32>,
}

/// When the rows of a recording were sampled.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Clock {
    /// Unit of the time stamps; `None` without time stamps, and for one without a name, as 100 µs
    pub unit: Option<TimeUnit>,
    /// Seconds of one unit of the time stamps
    pub unit_s: Option<f64>,
    /// The unit is neither stated nor told by a date or a rate, or gives an odd rate
    #[serde(skip)]
    pub is_unit_unsure: bool,
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
    /// The first time stamp, s, on the recorder's clock: it aligns two files from the same recorder
    #[serde(skip)]
    pub start_s: Option<f64>,
    /// When the recording starts by the lines above the header, s since 1970; used where no time
    /// stamp is a date
    #[serde(skip)]
    pub stated_start_s: Option<f64>,
    /// Lines at which the clock begins again, and what would then be the first stamp, s
    #[serde(skip)]
    pub restarts: Vec<(u32, f64)>,
    /// Rows for each reading of the sensor: more than one where it was read faster than it measures
    #[serde(skip)]
    pub rows_per_reading: f64,
}

impl Clock {
    /// The sampling rate to work with, in Hz: that of the time stamps, otherwise the claimed one.
    pub fn rate_hz(&self) -> Option<f64> {
        self.median_rate_hz.or(self.nominal_rate_hz)
    }
}

/// How the cells of a recording are read, as its rows show.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ReadAs {
    /// How the counts of the accelerometer are written
    pub(crate) encoding: Option<Encoding>,
    /// Column of the temperature
    pub(crate) thermometer: Option<usize>,
    /// Label of the rows of the sensor that is read, where rows of several take turns
    pub(crate) sensor: Option<String>,
    /// Most cells are empty: each channel is written when it arrives, and its last value holds
    pub(crate) is_sparse: bool,
}

/// File that was joined to a recording.
#[derive(Debug, Clone)]
pub struct JoinedFile {
    /// Path of the file as given.
    pub name: String,
    /// SHA-256 of the file, if requested.
    pub sha256: Option<String>,
}

/// A recording in columns. All channels have the same number of rows; an empty cell is NaN.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Path of the file as given, `-` for standard input.
    pub name: String,
    /// SHA-256 of the file, if requested.
    pub sha256: Option<String>,
    /// The file of the gyroscope, if it is a separate one ([`join_gyroscope`](crate::join_gyroscope)).
    pub gyro_file: Option<JoinedFile>,
    /// What its head says: columns, claims, the text format.
    pub format: Format,
    /// Specific force along x, y, z in the unit of the file, less the zero offset.
    pub accel: [Vec<f64>; 3],
    /// Angular rate about x, y, z in the unit of the file.
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<Vec<f64>>,
    /// Seconds since the first row; `None` without usable time stamps.
    pub time_s: Option<Vec<f64>>,
    /// The label column.
    pub labels: Option<Labels>,
    /// Line of each row, from 1.
    pub lines: Vec<u32>,
    /// Rows that do not continue the row before: after blank lines, a named gap, a reset of the
    /// board or a repeated header. A single blank line or a header is not a break if the clock
    /// continues across it.
    pub breaks: Vec<usize>,
    /// The lines that were set aside.
    pub ledger: Ledger,
    /// How its cells are read.
    pub read_as: ReadAs,
    /// Rates, gaps, jitter.
    pub clock: Clock,
    /// Units and resolution.
    pub units: Units,
    /// Why the unit of the accelerometer is not known.
    pub why_unit_unknown: Option<Finding>,
    /// Faults found.
    pub findings: Vec<Finding>,
}

impl Recording {
    /// Sets the name, here and in every finding; before another file is joined.
    pub fn with_name(mut self, name: &str) -> Self {
        name.clone_into(&mut self.name);
        for finding in &mut self.findings {
            finding.file = Some(name.to_owned());
        }
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.accel[0].len()
    }

    /// When it starts, if its time stamps are dates or seconds since 1970, or the lines above the
    /// header say it; a date without a zone counts as UTC.
    pub fn recorded_at(&self) -> Option<UtcTime> {
        self.start_unix_s().and_then(UtcTime::of_stamp)
    }

    /// The same in s since 1970.
    pub fn start_unix_s(&self) -> Option<f64> {
        let is_date = |s: &f64| UtcTime::of_stamp(*s).is_some();
        self.clock
            .start_s
            .filter(is_date)
            .or(self.clock.stated_start_s)
    }

    /// Line number in the file, from 1, of row `row` (from 0).
    pub fn line(&self, row: usize) -> u64 {
        self.lines
            .get(row)
            .map_or(row as u64 + 1, |line| u64::from(*line))
    }

    /// The lines of the first and the last of some rows.
    pub fn lines_of(&self, rows: &Range<usize>) -> [u64; 2] {
        [rows.start, rows.end - 1].map(|row| self.line(row))
    }

    /// The rows in these lines, the first and the last.
    pub fn rows_at(&self, [first, last]: [u32; 2]) -> Range<usize> {
        let before = |line: u32| self.lines.partition_point(|l| *l < line);
        let start = before(first);
        start..before(last.saturating_add(1)).max(start)
    }

    /// True for a recording of a worn device that is too long to hold: its rows are means of
    /// neighbouring samples.
    pub fn is_averaged(&self) -> bool {
        self.ledger.rows() > self.rows()
    }

    /// Samples that each row is the mean of, one where a row of any recording is a sample.
    pub fn samples_per_row(recordings: &[Recording]) -> f64 {
        let each = recordings
            .iter()
            .map(|r| r.ledger.rows() as f64 / r.rows().max(1) as f64);
        each.fold(f64::INFINITY, f64::min).clamp(1.0, 1e6)
    }

    /// Refuses means of samples; `hint`: what to do instead.
    ///
    /// # Errors
    ///
    /// `averaged` (usage).
    pub fn refuse_averaged(&self, hint: &str) -> Result<()> {
        if !self.is_averaged() {
            return Ok(());
        }
        let error = Problem::Averaged.error().at(self.name.as_ref(), None);
        Err(error.with_hint(hint))
    }

    /// True if there is a break within `rows`.
    pub fn is_broken(&self, rows: &Range<usize>) -> bool {
        let at = self.breaks.partition_point(|b| *b <= rows.start);
        self.breaks.get(at).is_some_and(|b| *b < rows.end)
    }

    /// Lowest and highest temperature, °C; `None` without any.
    pub fn temperature_range_c(&self) -> Option<[f64; 2]> {
        let values = self.temperature_c.iter().flatten().copied();
        let values = values.filter(|t| t.is_finite());
        Some([values.clone().reduce(f64::min)?, values.reduce(f64::max)?])
    }

    /// Time of a row since the first, s, by its stamp, or without stamps by the rate.
    pub fn time_at(&self, row: usize) -> Option<f64> {
        match &self.time_s {
            Some(t) => t.get(row).copied().filter(|t| t.is_finite()),
            None => self.clock.rate_hz().map(|rate_hz| row as f64 / rate_hz),
        }
    }

    /// Accelerometer values of a row.
    pub fn accel_at(&self, row: usize) -> [f64; 3] {
        [self.accel[0][row], self.accel[1][row], self.accel[2][row]]
    }

    /// Row ranges between the breaks, none of them empty.
    pub fn segments(&self) -> Vec<Range<usize>> {
        let edges: Vec<usize> = [&[0], &self.breaks[..], &[self.rows()]].concat();
        let ranges = edges.windows(2).map(|w| w[0]..w[1]);
        ranges.filter(|range| !range.is_empty()).collect()
    }

    /// The sampling rate to work with, in Hz; assumed if it is unknown.
    pub fn working_rate_hz(&self) -> f64 {
        self.clock.rate_hz().unwrap_or(Self::ASSUMED_RATE_HZ)
    }

    /// Sampling rate assumed for window lengths if it is unknown, Hz.
    pub const ASSUMED_RATE_HZ: f64 = 100.0;
}

/// The first 256 KiB of a text, without the line that they cut.
pub(crate) fn whole_lines(head: &[u8]) -> String {
    String::from_utf8_lossy(without_cut_line(head)).replace('\0', "")
}

pub(crate) fn without_cut_line(head: &[u8]) -> &[u8] {
    let is_cut = head.len() == HEAD_BYTES;
    let mut line_ends = head.iter();
    let end = line_ends.rposition(|b| is_cut && matches!(b, b'\n' | b'\r'));
    &head[..end.map_or(head.len(), |e| e + 1)]
}
