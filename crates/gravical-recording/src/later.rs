//! Rows after those by which a recording was judged.
//!
//! A recording of any size is judged by its first rows, with all that [`Recording`] judges. The
//! rows after them are read alike, batch by batch; where they cannot be, they end the reading.

use std::fmt;

use crate::error::Error;
use crate::judge::{self, Encoding};
use crate::recording::{self, Recording, find_thermometer, slices};
use crate::text::{Batch, Format};

/// Rows for which all channels may repeat by chance.
const MAX_REPEATS: usize = 20;
/// Rows at the end of a batch whose magnitude shows whether channels may be shifted, and by how
/// much it then differs from gravity.
const SLIP_END_ROWS: usize = 640;
const SLIP_TOLERANCE: f64 = 0.2;
/// Rows before a batch with which shifted channels are looked for.
const TAIL_ROWS: usize = 20_000;

/// Channels of a batch, read as the recording was judged.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Channels {
    /// Specific force in the unit of the file; NaN in a row that is no measurement
    pub accel: [Vec<f64>; 3],
    /// Angular rate in the unit of the file; NaN in a row that is no measurement
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Temperature in the unit of the file
    pub temperature: Option<Vec<f64>>,
    /// Whether each row is a measurement of the sensor that is read
    pub is_measured: Vec<bool>,
}

/// Why rows cannot be read as those before them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Contradiction {
    /// Line of the first of them, from 1
    pub line: u32,
    /// What differs
    pub what: Contradicted,
}

/// What differs from the rows before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Contradicted {
    /// Numbers are written in another way: with the sign, as unsigned, or with a fraction
    Encoding,
    /// Channels are shifted by one or more places
    Slipped,
    /// No row is of the sensor that is read
    Sensor,
}

impl fmt::Display for Contradicted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Contradicted::Encoding => "numbers are written in another way than in the rows before: unsigned integers in one part, signed ones or fractions in the other",
            Contradicted::Slipped => "the values stand in the columns of others from here on: the logger lost a byte",
            Contradicted::Sensor => "the sensor that is read has no more rows from here on",
        })
    }
}

/// How rows are read after those by which a recording was judged.
#[derive(Clone, Debug)]
pub struct Later {
    format: Format,
    encoding: Option<Encoding>,
    /// Whether the gyroscope is decoded with the accelerometer.
    decodes_gyro: bool,
    /// Whether some value of the accelerometer was negative or had a fraction.
    is_signed: bool,
    /// Axes whose empty cells hold the last value, and that value.
    held: [Option<f64>; 3],
    /// Column of the sensors, and the sensor that is read.
    sensor: Option<(usize, Cell)>,
    temperature: Option<usize>,
    /// Whether repeats of all channels mean that the sensor hung.
    marks_hung: bool,
    /// Channels of the last row, and length of the run in which they repeat.
    last: (Vec<f64>, usize),
    /// Gravity in the unit of the file, and the last rows: by them shifted channels are told.
    gravity: Option<f64>,
    tail: ([Vec<f64>; 3], [Vec<f64>; 3]),
}

/// A number, or a word of its column.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Cell {
    Number(f64),
    Word(u8),
}

impl Cell {
    fn of(batch: &Batch, column: usize, row: usize) -> Self {
        match batch.texts[column].get(row) {
            Some(word) if *word > 0 => Cell::Word(*word),
            _ => Cell::Number(batch.columns[column][row]),
        }
    }
}

impl Later {
    /// Judges the first rows of a recording, or all of them, and tells how later ones are read.
    ///
    /// # Errors
    ///
    /// Those of [`Recording::judge`].
    pub fn judge(format: &Format, head: Batch) -> Result<(Recording, Later), Error> {
        let has_rows = head.rows() > 0;
        let sensor = format.sensor.filter(|_| has_rows);
        let mut later = Later {
            format: format.clone(),
            encoding: None,
            decodes_gyro: false,
            is_signed: false,
            held: [None; 3],
            sensor: sensor.map(|(column, _)| (column, Cell::of(&head, column, 0))),
            temperature: find_thermometer(format, &head),
            marks_hung: false,
            last: (Vec::new(), 0),
            gravity: None,
            tail: Default::default(),
        };
        let rows = later.rows_of_sensor(&head);
        let columns = format.channels();
        let is_unsigned = |column: &usize| {
            let mut values = rows.iter().map(|row| head.columns[*column][*row]);
            values.all(|v| v.is_nan() || v.fract() == 0.0 && v >= 0.0)
        };
        later.is_signed = !columns[..3].iter().all(is_unsigned);
        later.decodes_gyro = columns[3..].iter().all(is_unsigned);
        let is_slow = format.accel.map(|column| {
            let empty = rows
                .iter()
                .filter(|row| head.columns[column][**row].is_nan());
            empty.count() * 5 > rows.len()
        });
        let channels = slices(&head, &columns);
        let short = rows.iter().filter(|row| {
            let run = later.push_repeat(&channels, **row);
            (2..=MAX_REPEATS).contains(&run)
        });
        let repeats_are_rare = short.count() * 20 <= rows.len();
        let recording = Recording::judge(format, head)?;
        let accel = recording.accel.each_ref().map(Vec::as_slice);
        later.marks_hung = repeats_are_rare && judge::resolves_noise(accel);
        later.gravity = judge::median(judge::quiet_norms(accel));
        later.encoding = recording.encoding;
        for axis in (0..3).filter(|axis| is_slow[*axis]) {
            later.held[axis] = recording.accel[axis].last().copied();
        }
        if let Some(gyro) = &recording.gyro {
            later.keep_tail(&recording.accel, gyro);
        }
        Ok((recording, later))
    }

    /// Reads the rows of the next batch, whose columns are taken.
    ///
    /// A run of repeats that goes on in the next batch may leave up to 20 rows before it.
    ///
    /// # Errors
    ///
    /// The rows cannot be read as those before them.
    pub fn read(&mut self, batch: &mut Batch) -> Result<Channels, Contradiction> {
        let own = self.rows_of_sensor(batch);
        let (Some(first), Some(line)) = (own.first(), batch.lines.first()) else {
            let line = batch.lines.first().copied().unwrap_or_default();
            let what = Contradicted::Sensor;
            return if line > 0 {
                Err(Contradiction { line, what })
            } else {
                Ok(Channels::default())
            };
        };
        let (first, line) = (*first, *line);
        let columns = self.format.channels();
        let mut is_measured = vec![false; batch.rows()];
        let channels = slices(batch, &columns);
        for row in &own {
            is_measured[*row] = channels.iter().any(|c| c[*row] != 0.0);
        }
        if self.marks_hung {
            self.mark_hung(&channels, &own, &mut is_measured);
        }
        let mut accel = self
            .format
            .accel
            .map(|c| std::mem::take(&mut batch.columns[c]));
        let mut gyro = self
            .format
            .gyro
            .map(|g| g.map(|c| std::mem::take(&mut batch.columns[c])));
        let unmeasured = || {
            is_measured
                .iter()
                .enumerate()
                .filter(|(_, m)| !**m)
                .map(|(row, _)| row)
        };
        for channel in accel.iter_mut().chain(gyro.iter_mut().flatten()) {
            unmeasured().for_each(|row| channel[row] = f64::NAN);
        }
        if !self.decode(&mut accel, gyro.as_mut()) {
            let line = batch.lines.get(first).copied().unwrap_or(line);
            return Err(Contradiction {
                line,
                what: Contradicted::Encoding,
            });
        }
        for (axis, last) in accel.iter_mut().zip(&mut self.held) {
            if let Some(last) = last {
                hold(axis, &is_measured, last);
            }
        }
        if let Some(gyro) = &gyro {
            if let Some(row) = self.slipped_row(&accel, gyro) {
                let line = batch.lines.get(row).copied().unwrap_or(line);
                return Err(Contradiction {
                    line,
                    what: Contradicted::Slipped,
                });
            }
            self.keep_tail(&accel, gyro);
        }
        Ok(Channels {
            accel,
            gyro,
            temperature: self
                .temperature
                .map(|c| std::mem::take(&mut batch.columns[c])),
            is_measured,
        })
    }

    /// Rows of the sensor that is read.
    fn rows_of_sensor(&self, batch: &Batch) -> Vec<usize> {
        let is_own = |row: &usize| {
            self.sensor
                .is_none_or(|(column, cell)| Cell::of(batch, column, *row) == cell)
        };
        (0..batch.rows()).filter(is_own).collect()
    }

    /// Length of the run of repeats that ends in this row.
    fn push_repeat(&mut self, channels: &[&[f64]], row: usize) -> usize {
        let (last, run) = &mut self.last;
        let repeats = last.len() == channels.len()
            && channels
                .iter()
                .zip(last.iter())
                .all(|(c, last)| c[row] == *last);
        if repeats {
            *run += 1;
        } else {
            *run = 1;
            last.clear();
            last.extend(channels.iter().map(|c| c[row]));
        }
        *run
    }

    fn mark_hung(&mut self, channels: &[&[f64]], own: &[usize], is_measured: &mut [bool]) {
        for (k, row) in own.iter().enumerate() {
            let run = self.push_repeat(channels, *row);
            if run == MAX_REPEATS + 1 {
                // All but the first row of the run, as far as they are in this batch.
                let from = k.saturating_sub(run - 2);
                own[from..=k]
                    .iter()
                    .for_each(|row| is_measured[*row] = false);
            } else if run > MAX_REPEATS {
                is_measured[*row] = false;
            }
        }
    }

    /// Undoes the encoding; false if the numbers are written in another one.
    fn decode(&self, accel: &mut [Vec<f64>; 3], gyro: Option<&mut [Vec<f64>; 3]>) -> bool {
        let Some(encoding) = self.encoding else {
            return self.is_signed || judge::decode(accel, gyro).is_none();
        };
        let is_unsigned = |v: &f64| v.is_nan() || v.fract() == 0.0 && (0.0..65_536.0).contains(v);
        if !accel.iter().flatten().all(is_unsigned) {
            return false;
        }
        match encoding {
            Encoding::OffsetBinary => accel.iter_mut().flatten().for_each(|v| *v -= 32_768.0),
            Encoding::TwosComplement => {
                let gyro = gyro.into_iter().filter(|_| self.decodes_gyro).flatten();
                let cells = accel.iter_mut().chain(gyro).flatten();
                cells
                    .filter(|v| **v > 32_767.0)
                    .for_each(|v| *v -= 65_536.0);
            }
        }
        true
    }

    /// The row from which on the channels are shifted, where the magnitude at the end of the batch
    /// is not that of gravity.
    fn slipped_row(&self, accel: &[Vec<f64>; 3], gyro: &[Vec<f64>; 3]) -> Option<usize> {
        let gravity = self.gravity?;
        let end = accel
            .each_ref()
            .map(|axis| &axis[axis.len().saturating_sub(SLIP_END_ROWS)..]);
        let norm = judge::median(judge::quiet_norms(end))?;
        if (norm / gravity - 1.0).abs() < SLIP_TOLERANCE {
            return None;
        }
        let joined = |tail: &[Vec<f64>; 3], axes: &[Vec<f64>; 3]| {
            [0, 1, 2].map(|i| [tail[i].as_slice(), axes[i].as_slice()].concat())
        };
        let (accel, gyro) = (joined(&self.tail.0, accel), joined(&self.tail.1, gyro));
        let row = recording::slipped_row(&self.format, &accel, Some(&gyro))?;
        Some(row.saturating_sub(self.tail.0[0].len()))
    }

    fn keep_tail(&mut self, accel: &[Vec<f64>; 3], gyro: &[Vec<f64>; 3]) {
        let tail = |axis: &Vec<f64>| axis[axis.len().saturating_sub(TAIL_ROWS)..].to_vec();
        self.tail = (accel.each_ref().map(tail), gyro.each_ref().map(tail));
    }
}

/// In empty cells of measured rows the last value holds.
fn hold(axis: &mut [f64], is_measured: &[bool], last: &mut f64) {
    for (v, _) in axis.iter_mut().zip(is_measured).filter(|(_, m)| **m) {
        if v.is_nan() {
            *v = *last;
        } else {
            *last = *v;
        }
    }
}
