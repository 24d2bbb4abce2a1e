//! Rows of a recording that grows, by the ordinary reader.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{self, Read};
use std::rc::Rc;

use super::collect::{About, Collected, Columns};
use super::file::{OpenFile, open_rows};
use super::monitor::MonitorSummary;
use super::open::Input;
use super::row::{ACCEL, GYRO, TEMPERATURE, Values};
use super::rows::Row;
use super::units::AccelScale;
use super::{ReadOptions, Recording, metadata};
use crate::finding::Finding;
use crate::{Error, Result};

/// The format is first determined from this many rows.
const FIRST_ROWS: usize = 50;
/// … of at least this time, s; without time stamps from
const LEAST_S: f64 = 1.0;
/// … this many rows.
const UNTIMED_ROWS: usize = 100;
/// Without a recognised format after this many rows there is none.
const MOST_ROWS: usize = 800;

/// In a shorter recording nothing is said of the samples: a channel is first frozen when it keeps
/// its value in this many rows, unless the recording ends there.
const SAID_ROWS: usize = 100;

/// A row of the recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Its number, from 0.
    pub row: usize,
    /// Line of the recording, from 1.
    pub line: u64,
    /// Seconds since the first row.
    pub t_s: f64,
    /// It does not continue the row before.
    pub is_break: bool,
    values: Values,
    zero_offset: f64,
}

impl Sample {
    /// Specific force in the unit of the recording, less the zero offset.
    pub fn accel(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.values[ACCEL + i] - self.zero_offset)
    }

    /// Angular rate in the unit of the recording; NaN without a gyroscope.
    pub fn gyro(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.values[GYRO + i])
    }

    /// Temperature, °C; NaN if unknown.
    pub fn temperature_c(&self) -> f64 {
        self.values[TEMPERATURE]
    }
}

/// Bytes that were received and not read yet.
#[derive(Debug, Clone, Default)]
struct Queue {
    bytes: Rc<RefCell<VecDeque<u8>>>,
    /// More was asked for than there is.
    is_exhausted: Rc<Cell<bool>>,
}

impl Queue {
    fn extend(&self, bytes: &[u8]) {
        self.bytes.borrow_mut().extend(bytes);
    }
}

impl Read for Queue {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.bytes.borrow_mut().read(buffer)?;
        self.is_exhausted.set(n == 0);
        match n {
            // Not the end: the call is repeated when there is more.
            0 => Err(io::ErrorKind::WouldBlock.into()),
            n => Ok(n),
        }
    }
}

/// Reads a recording while it grows, in memory that does not.
///
/// ```
/// use gravical::recording::{ReadOptions, growing::Growing};
///
/// let mut growing = Growing::new("desk.csv", ReadOptions::default());
/// growing.observe(b"t_ms,ax,ay,az\n")?;
/// for i in 0..300_u32 {
///     let noise = 1e-3 * f64::from(i * 7919 % 61);
///     growing.observe(format!("{},{noise:.3},0.5,{:.3}\n", 10 * i, 9.8 - noise).as_bytes())?;
/// }
/// assert!(growing.sample_findings()[0].message.starts_with("ay keeps exactly one value"));
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct Growing {
    name: String,
    options: ReadOptions,
    queue: Queue,
    /// Bytes before the format is known: those examined are whole lines.
    head: Vec<u8>,
    examined: usize,
    rows_in_head: usize,
    next_try: usize,
    file: Option<Box<OpenFile>>,
    rows: usize,
    last_s: f64,
}

impl Growing {
    /// `name` is used in messages.
    #[must_use]
    pub fn new(name: &str, options: ReadOptions) -> Self {
        Growing {
            name: name.to_owned(),
            options,
            queue: Queue::default(),
            head: Vec::new(),
            examined: 0,
            rows_in_head: 0,
            next_try: FIRST_ROWS,
            file: None,
            rows: 0,
            last_s: 0.0,
        }
    }

    /// Takes the next bytes of the recording.
    ///
    /// # Errors
    ///
    /// Those of reading, once enough rows show that it is not a recording.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<()> {
        if self.file.is_some() {
            self.queue.extend(bytes);
            return Ok(());
        }
        self.head.extend_from_slice(bytes);
        while let Some(length) = memchr::memchr(b'\n', &self.head[self.examined..]) {
            let line = self.head[self.examined..self.examined + length].trim_ascii_start();
            let is_row = line
                .first()
                .is_some_and(|b| b.is_ascii_digit() || matches!(b, b'-' | b'+' | b'.' | b'"'));
            self.rows_in_head += usize::from(is_row);
            self.examined += length + 1;
            if self.rows_in_head == self.next_try && self.open()? {
                break;
            }
        }
        Ok(())
    }

    /// Determines the format from the lines so far; false if more are needed.
    fn open(&mut self) -> Result<bool> {
        let queue = Queue::default();
        queue.extend(&self.head[..self.examined]);
        let input = Input::growing(Box::new(queue.clone()), self.examined);
        let file = match open_rows(input, &self.name, &self.options) {
            Ok(file) => file,
            Err(error) if self.rows_in_head >= MOST_ROWS => return Err(error),
            Err(_) => {
                self.next_try *= 2;
                return Ok(false);
            }
        };
        let rate = file.rows.facts().stamp_reading.map(|s| match s.even_hz {
            Some(rate) => rate,
            None => 1.0 / (s.usual * s.unit.seconds()),
        });
        let enough = rate.map_or(UNTIMED_ROWS, |rate| (LEAST_S * rate).ceil() as usize);
        if self.rows_in_head < enough {
            self.next_try = enough;
            return Ok(false);
        }
        queue.extend(&self.head[self.examined..]);
        self.queue = queue;
        self.file = Some(Box::new(file));
        self.head = Vec::new();
        Ok(true)
    }

    /// Takes the next bytes of the recording and reads all rows in them.
    ///
    /// # Errors
    ///
    /// Those of reading, once enough rows show that it is not a recording.
    pub fn observe(&mut self, bytes: &[u8]) -> Result<()> {
        self.push(bytes)?;
        while self.next()?.is_some() {}
        Ok(())
    }

    /// What is odd in the samples so far: frozen axes, limits of the range, repeated rows. None as
    /// long as the rows contradict what the first of them said of clock and units.
    #[must_use]
    pub fn sample_findings(&self) -> Vec<Finding> {
        let file = self.file.as_ref().filter(|_| self.rows >= SAID_ROWS);
        let summary = file.map(|file| (file, file.rows.monitor().finish()));
        let sound = summary.filter(|(file, summary)| file.rows.facts().agrees(&summary.facts));
        sound.map_or_else(Vec::new, |(_, summary)| summary.found.values)
    }

    /// Unit of the accelerometer by the first rows, once it is known.
    #[must_use]
    pub fn accel_scale(&self) -> Option<AccelScale> {
        Some(self.file.as_ref()?.rows.facts().accel)
    }

    /// The line with the board's settings says that it calibrates.
    pub(crate) fn is_calibrated_by_board(&self) -> bool {
        let file = self.file.as_ref();
        file.is_some_and(|file| file.format.layout.calibrated_by_board)
    }

    /// The next row; none until more bytes arrive.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub(crate) fn next(&mut self) -> Result<Option<Sample>> {
        let Some(file) = &mut self.file else {
            return Ok(None);
        };
        let zero_offset = file.rows.facts().zero_offset;
        let rate = self.options.rate_hz.unwrap_or(Recording::ASSUMED_RATE_HZ);
        self.queue.is_exhausted.set(false);
        match file.rows.next_row() {
            Ok(Some(row)) => {
                let untimed = row.t_s.is_nan();
                let sample = Sample {
                    row: self.rows,
                    line: row.line,
                    t_s: match untimed {
                        true => self.last_s + 1.0 / rate,
                        false => row.t_s,
                    },
                    is_break: row.is_break(),
                    values: *row.values,
                    zero_offset,
                };
                self.rows += 1;
                self.last_s = sample.t_s;
                Ok(Some(sample))
            }
            Ok(None) => Ok(None),
            Err(_) if self.queue.is_exhausted.get() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// What all rows so far say of units, clock and faults.
    pub(crate) fn summary(&self) -> Option<MonitorSummary> {
        let file = self.file.as_ref()?;
        Some(file.rows.monitor().finish())
    }

    /// Resolution of ax … gz, in their units.
    pub(crate) fn resolution(&self) -> [f64; 6] {
        let file = self.file.as_ref();
        file.map_or([0.0; 6], |f| f.rows.monitor().resolution())
    }

    /// Value subtracted from the accelerometer's counts.
    pub(crate) fn zero_offset(&self) -> f64 {
        self.file
            .as_ref()
            .map_or(0.0, |f| f.rows.facts().zero_offset)
    }

    /// Names of the columns.
    pub(crate) fn column_names(&self) -> Vec<String> {
        let header = self.file.as_ref().map(|f| &f.format.dialect.header);
        let names = header.and_then(|h| h.as_ref()).map(|h| h.names.clone());
        names.unwrap_or_default()
    }

    /// No rows, with the channels of the recording.
    pub(crate) fn columns(&self) -> Option<Columns> {
        let file = self.file.as_ref()?;
        Some(Columns::new(&file.format.layout, file.rows.facts()))
    }

    /// A recording with some of the rows, and all that is known from all of them.
    ///
    /// # Errors
    ///
    /// `no-rows` before the format is known.
    pub(crate) fn recording(&self, columns: Columns) -> Result<Recording> {
        let Some(file) = &self.file else {
            return Err(Error::input("no-rows", "no row was received yet"));
        };
        let dialect = &file.format.dialect;
        let column_names = self.column_names();
        let about = About {
            name: self.name.clone(),
            description: file.format.description.clone(),
            serial: metadata::serial(&dialect.metadata),
            is_calibrated: file.format.layout.reads_calibrated(&column_names),
            column_names,
            ..About::default()
        };
        let read = Collected {
            rows: columns,
            about,
            summary: file.rows.monitor().finish_with_resolution(),
            facts: *file.rows.facts(),
        };
        Ok(read.into_recording())
    }
}

/// Adds a row to columns; `is_break`: it does not continue the row before.
///
/// # Errors
///
/// `no-memory` if there is not enough.
pub(crate) fn keep(columns: &mut Columns, sample: &Sample, is_break: bool) -> Result<()> {
    let row = Row {
        line: sample.line,
        label: &[],
        values: &sample.values,
        before: &[],
        t_s: sample.t_s,
        restarted: false,
    };
    columns.push(&row, is_break)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows_of(reader: &mut Growing) -> Result<usize> {
        let mut rows = 0;
        while reader.next()?.is_some() {
            rows += 1;
        }
        Ok(rows)
    }

    /// A board that starts again with other settings: its rows mean something else, and that is not
    /// "no row yet".
    #[test]
    fn an_error_in_the_last_bytes_is_an_error() {
        let mut reader = Growing::new("board", ReadOptions::default());
        reader.push(b"t_s,ax_g,ay_g,az_g\n").unwrap();
        for i in 0..300 {
            let row = format!("{},0.0{},0.01,1.0{}\n", f64::from(i) / 100.0, i % 7, i % 3);
            reader.push(row.as_bytes()).unwrap();
        }
        assert_eq!(rows_of(&mut reader).unwrap(), 300);
        // Half a line is no error: the rest arrives.
        reader.push(b"3.0,0.02,").unwrap();
        assert_eq!(rows_of(&mut reader).unwrap(), 0);
        reader.push(b"0.01,1.01\n").unwrap();
        assert_eq!(rows_of(&mut reader).unwrap(), 1);
        reader
            .push(b"t_s,ax_g,ay_g,temperature_c\n3.1,0.02,0.01,25.0\n")
            .unwrap();
        let error = rows_of(&mut reader).unwrap_err();
        assert_eq!(error.code(), "header-differs");
    }
}
