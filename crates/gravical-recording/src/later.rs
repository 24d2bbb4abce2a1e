//! Rows after those by which a recording was judged.
//!
//! A recording of any size is judged by its first rows, with all that [`Recording`] judges. The
//! rows after them are read alike, batch by batch; where they cannot be, they end the reading.

mod clock;

use clock::LaterClock;

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::full_scale::Clipping;
use crate::judge::{self, Encoding, Held};
use crate::recording::Recording;
use crate::recording::judging::{self, cell_label, celsius, find_thermometer, keep_sensor};
use crate::text::{Batch, Format, Ledger, MIN_ROWS_GONE, Reason, split_hint};

/// Rows at the end of a batch whose magnitude shows whether channels may be shifted, and by how
/// much it then differs from gravity.
const SLIP_END_ROWS: usize = 640;
const SLIP_TOLERANCE: f64 = 0.2;
/// So many rows of other sensors alone show that the one that is read has ended.
const MIN_ROWS_OF_OTHERS: usize = 100;
/// Rows before a batch with which shifted channels are looked for.
const TAIL_ROWS: usize = 20_000;

/// Channels of the rows of a batch, as the recording was judged.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Readings {
    /// Specific force in the unit of the file, less the zero offset; NaN in a row that is no
    /// measurement
    pub accel: [Vec<f64>; 3],
    /// Angular rate in the unit of the file; NaN in a row that is no measurement
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Temperature, °C
    pub temperature_c: Option<Vec<f64>>,
    /// Whether each row is a measurement of the sensor that is read
    pub is_measured: Vec<bool>,
    /// Time since the first row of the recording, s, NaN in rows of other sensors; `None` without
    /// a clock
    pub time_s: Option<Vec<f64>>,
    /// Measurements before which the recording breaks
    pub breaks: Vec<usize>,
}

const ENCODING: (&str, &str) = (
    "encoding-changed",
    "numbers are written in another way than before: unsigned integers in one part, signed ones or fractions in the other",
);
const SLIPPED: (&str, &str) = (
    "shifted-columns",
    "the values stand in the columns of others from here on: the bus lost a byte",
);
const SENSOR: &str = "sensor-ended";

/// How rows are read after those by which a recording was judged.
#[derive(Clone, Debug)]
pub struct Later {
    format: Format,
    encoding: Option<Encoding>,
    /// Whether the gyroscope is decoded with the accelerometer.
    decodes_gyro: bool,
    /// Whether some value of the accelerometer was negative or had a fraction.
    is_signed: bool,
    zero_offset: f64,
    /// Where the last value of each channel holds in empty cells.
    accel_held: Option<[Held; 3]>,
    gyro_held: Option<[Held; 3]>,
    /// Column of the sensors, and the sensor that is read.
    sensor: Option<(usize, String)>,
    thermometer: Option<usize>,
    /// Whether repeats of all channels mean that the sensor hung.
    marks_hung: bool,
    repeats: Repeats,
    /// Last rows in a row in which the accelerometer reads zero.
    zeros: usize,
    /// Gravity in the unit of the file, and the last rows: shifted channels are recognised by them.
    gravity: Option<f64>,
    tail: [Vec<f64>; 6],
    /// The unit changed, but the user gives it.
    unit_finding: Option<Finding>,
    clock: Option<LaterClock>,
    /// A break or so many rows of zeros lie before the next measurement.
    is_broken: bool,
    rows_gone: usize,
    /// Channels with the ends of their ranges.
    clipping: Vec<(&'static str, Clipping)>,
    /// Line of the first row that is read here.
    first_line: Option<u32>,
    ledger: Ledger,
    /// Whether rows that cannot be read as those before them are an error. Batches of a recording
    /// that grows are too short to tell.
    pub(crate) contradicts: bool,
}

/// Channels of the last row, and length of the run in which they repeat.
#[derive(Clone, Debug, Default)]
struct Repeats {
    values: Vec<f64>,
    run: usize,
}

impl Repeats {
    /// Length of the run that ends in this row.
    fn push(&mut self, channels: &[&[f64]], row: usize) -> usize {
        let values = channels.iter().map(|c| c[row]);
        let repeats = values.clone().eq(self.values.iter().copied());
        self.run = if repeats { self.run + 1 } else { 1 };
        self.values.clear();
        self.values.extend(values);
        self.run
    }
}

impl Later {
    /// Judges the first rows of a recording, or all of them, and tells how later ones are read.
    ///
    /// # Errors
    ///
    /// Those of [`Recording::judge`].
    pub fn judge(format: &Format, mut head: Batch) -> Result<(Recording, Later), Error> {
        let (mut finding, mut sensor) = (None, None);
        if let Some((column, _)) = format.sensor {
            finding = keep_sensor(format, &mut head, column)?;
            sensor = (head.rows() > 0).then(|| (column, cell_label(&head, column, 0)));
        }
        let channels = head.slices(&format.channels());
        let is_unsigned = |c: &&[f64]| {
            c.iter()
                .all(|v| v.is_nan() || v.fract() == 0.0 && *v >= 0.0)
        };
        let decodes_gyro = channels[3..].iter().all(is_unsigned);
        let is_signed = !channels[..3].iter().all(is_unsigned);
        let axes = |columns: [usize; 3]| columns.map(|c| head.columns[c].as_slice());
        let mut accel_held = Held::of(axes(format.accel), f64::INFINITY);
        let gyro = format.gyro.map(axes);
        let mut gyro_held = gyro.and_then(|gyro| Held::of(gyro, judge::GYRO_HELD));
        let zeros = judge::unread_runs(axes(format.accel), 0).1;
        let mut repeats = Repeats::default();
        let is_short = |row: &usize| {
            let run = repeats.push(&channels, *row);
            (2..=judge::MAX_REPEATS).contains(&run)
        };
        let repeats_are_rare = (0..head.rows()).filter(is_short).count() * 20 <= head.rows();
        let thermometer = find_thermometer(format, &head);
        let stamps = LaterClock::stamps(format, &head);
        let last_line = head.lines.last().copied();

        let mut recording = Recording::judge(format, head)?;
        recording.findings.extend(finding);
        let mut kinds = recording.findings.iter().map(|finding| finding.kind);
        let is_decoded = kinds.any(|kind| kind == FindingKind::UnsignedCounts);
        let encoding = if recording.zero_offset != 0.0 {
            Encoding::OffsetBinary
        } else {
            Encoding::TwosComplement
        };
        let accel = accel_held.iter_mut().flatten().zip(&recording.accel);
        let gyro = recording.gyro.iter().flatten();
        for (held, channel) in accel.chain(gyro_held.iter_mut().flatten().zip(gyro)) {
            held.value = channel.last().copied().unwrap_or(f64::NAN);
        }
        let accel = recording.accel.each_ref().map(Vec::as_slice);
        let ends = recording.ends_of_ranges(format).into_iter();
        let mut later = Later {
            format: format.clone(),
            encoding: is_decoded.then_some(encoding),
            decodes_gyro,
            is_signed,
            zero_offset: recording.zero_offset,
            accel_held,
            gyro_held,
            sensor,
            thermometer,
            marks_hung: repeats_are_rare && judge::resolves_noise(accel),
            repeats,
            zeros,
            gravity: judge::quiet_norm(accel),
            tail: Default::default(),
            unit_finding: None,
            clock: LaterClock::new(format, stamps, &recording),
            is_broken: recording.lines.last().copied() != last_line,
            rows_gone: 0,
            clipping: ends.map(|(_, name, end)| (name, end)).collect(),
            first_line: None,
            ledger: Ledger::default(),
            contradicts: true,
        };
        later.keep_tail(&recording.accel, recording.gyro.as_ref());
        Ok((recording, later))
    }

    /// Reads the rows of the next batch and takes its channels and temperature; stamps stay.
    ///
    /// A run of repeats that goes on from one batch to the next may leave 20 rows in the first, one
    /// of zeros four.
    ///
    /// # Errors
    ///
    /// The rows cannot be read as those before them.
    pub fn read(&mut self, batch: &mut Batch) -> Result<Readings, Error> {
        let own = self.rows_of_sensor(batch);
        let (time_s, marks) = self.read_clock(batch, &own);
        let lines = &batch.lines;
        self.first_line = self.first_line.or(lines.first().copied());
        let at = |row: usize, (code, message): (&'static str, &str)| {
            let line = lines.get(row).copied().unwrap_or_default();
            Error::contradiction(code, message)
                .at_line(line as usize)
                .with_hint(split_hint(line.into()))
        };
        if self.contradicts && own.is_empty() && lines.len() >= MIN_ROWS_OF_OTHERS {
            let rows = lines.len();
            let text = format!("the sensor that is read has no row in the next {rows} rows");
            return Err(at(0, (SENSOR, &text)));
        }
        let columns = self.format.channels();
        let channels = batch.slices(&columns);
        let mut is_measured = vec![false; lines.len()];
        let reads_zeros = self.format.columns[columns[0]].is_linear;
        for row in &own {
            is_measured[*row] = reads_zeros || channels.iter().any(|c| c[*row] != 0.0);
        }
        let is_read = is_measured.clone();
        if self.marks_hung {
            self.mark_hung(&channels, &own, &mut is_measured);
        }
        let mut take = |c: usize| std::mem::take(&mut batch.columns[c]);
        let mut accel = self.format.accel.map(&mut take);
        let mut gyro = self.format.gyro.map(|g| g.map(&mut take));
        let mut temperature_c = self.thermometer.map(&mut take);
        for (row, _) in is_measured.iter().enumerate().filter(|(_, m)| !**m) {
            let reason = match own.binary_search(&row) {
                Err(_) => Reason::OtherSensor,
                Ok(_) if is_read[row] => Reason::Hung,
                Ok(_) => Reason::Zeros,
            };
            self.ledger.add(reason, lines[row] as usize, "");
            let channels = accel.iter_mut().chain(gyro.iter_mut().flatten());
            channels.for_each(|channel| channel[row] = f64::NAN);
        }
        if !reads_zeros {
            let axes = accel.each_ref().map(Vec::as_slice);
            let (runs, zeros) = judge::unread_runs(axes, self.zeros);
            self.zeros = zeros;
            for run in runs {
                let axes = accel.iter_mut();
                axes.for_each(|axis| axis[run.clone()].fill(f64::NAN));
            }
        }
        if !self.decode(&mut accel, gyro.as_mut()) && self.contradicts {
            return Err(at(0, ENCODING));
        }
        let gravity = self.gravity.filter(|_| self.contradicts);
        if let Some(row) = gravity.and_then(|g| self.slipped_row(g, &accel, gyro.as_ref())) {
            return Err(at(row, SLIPPED));
        }
        let before = gravity.filter(|_| !self.format.options.is_gyroscope);
        if let Some((row, finding)) =
            before.and_then(|g| judge::unit_change(&accel, lines, Some(g)))
        {
            if self.format.options.accel_unit.is_none() {
                return Err(at(row, ("unit-changed", &finding.message)));
            }
            self.unit_finding.get_or_insert(finding);
        }
        self.keep_tail(&accel, gyro.as_ref());
        let breaks = self.find_breaks(&own, marks, &is_read, &is_measured);
        let axes = accel.iter().chain(gyro.iter().flatten());
        for ((_, clipping), axis) in self.clipping.iter_mut().zip(axes) {
            clipping.observe_all(axis, lines);
        }
        let accel_axes = self.accel_held.iter_mut().flatten().zip(&mut accel);
        let gyro_axes = gyro.iter_mut().flatten();
        let gyro_axes = self.gyro_held.iter_mut().flatten().zip(gyro_axes);
        for (held, axis) in accel_axes.chain(gyro_axes) {
            let cells = axis.iter_mut().zip(&is_measured).filter(|(_, m)| **m);
            held.fill(cells.map(|(v, _)| v));
        }
        if let (Some(column), Some(temperature_c)) = (self.thermometer, &mut temperature_c) {
            celsius(&self.format, column, temperature_c);
            for t in temperature_c {
                if !judge::POSSIBLE_C.contains(t) {
                    *t = f64::NAN;
                }
            }
        }
        Ok(Readings {
            accel,
            gyro,
            temperature_c,
            is_measured,
            time_s,
            breaks,
        })
    }

    /// Times of the rows since the first row of the recording, and rows before which clock or
    /// marks break, sorted.
    fn read_clock(&mut self, batch: &Batch, own: &[usize]) -> (Option<Vec<f64>>, Vec<usize>) {
        let before_s = self.clock.as_ref().map_or(f64::NAN, |clock| clock.last_s);
        let times = self.clock.as_mut().map(|clock| clock.times(batch, own));
        let (time_s, restarts) = times.unzip();
        let mut breaks: Vec<usize> = restarts.unwrap_or_default();
        if batch.breaks.is_empty() && batch.headers.is_empty() && batch.blanks.is_empty() {
            return (time_s, breaks);
        }
        // The row before the batch is the first.
        let place = |row: usize| 1 + own.partition_point(|r| *r < row);
        let places = |rows: &[usize]| rows.iter().map(|row| place(*row)).collect::<Vec<_>>();
        let blanks = batch.blanks.iter().map(|(row, n)| (place(*row), *n));
        let blanks: Vec<(usize, usize)> = blanks.collect();
        let known = time_s.as_ref().map(|time_s| {
            let times = own.iter().map(|row| time_s[*row]);
            [before_s].into_iter().chain(times).collect::<Vec<_>>()
        });
        let rate_hz = self.clock.as_ref().and_then(|clock| clock.rate_hz);
        let (known, rows) = (known.unwrap_or_default(), 1 + own.len());
        let mut parts = judge::breaks(&places(&batch.headers), &blanks, &known, rate_hz, rows);
        let gaps = places(&batch.breaks).into_iter();
        parts.extend(gaps.filter(|place| *place < rows));
        breaks.extend(parts.into_iter().map(|place| own[place - 1]));
        breaks.sort_unstable();
        (time_s, breaks)
    }

    /// Measurements before which there is a mark, or rows that were set aside.
    fn find_breaks(
        &mut self,
        own: &[usize],
        marks: Vec<usize>,
        is_read: &[bool],
        is_measured: &[bool],
    ) -> Vec<usize> {
        let (mut marks, mut breaks) = (marks.into_iter().peekable(), Vec::new());
        for row in own {
            while marks.next_if(|mark| mark <= row).is_some() {
                self.is_broken = true;
            }
            if !is_measured[*row] {
                self.rows_gone += 1;
                self.is_broken |= is_read[*row] || self.rows_gone >= MIN_ROWS_GONE;
                continue;
            }
            if std::mem::take(&mut self.is_broken) {
                breaks.push(*row);
            }
            self.rows_gone = 0;
        }
        breaks
    }

    /// Rows that are no measurements, and what was found in these rows beside that, once all are read.
    #[must_use]
    pub fn finish(self) -> (Ledger, Vec<Finding>) {
        let clipped = self.clipping.iter().filter_map(|(name, c)| c.finding(name));
        let gaps = self.clock.as_ref().and_then(LaterClock::gap_finding);
        let mut findings: Vec<Finding> = gaps.into_iter().chain(clipped).collect();
        let line = self.first_line.unwrap_or_default();
        for finding in &mut findings {
            finding.message = format!("from line {line} on: {}", finding.message);
        }
        findings.extend(self.unit_finding);
        (self.ledger, findings)
    }

    /// Rows of the sensor that is read.
    fn rows_of_sensor(&self, batch: &Batch) -> Vec<usize> {
        let rows = 0..batch.rows();
        match &self.sensor {
            None => rows.collect(),
            Some((column, label)) => {
                let is_read = |row: &usize| cell_label(batch, *column, *row) == *label;
                rows.filter(is_read).collect()
            }
        }
    }

    fn mark_hung(&mut self, channels: &[&[f64]], own: &[usize], is_measured: &mut [bool]) {
        for (k, row) in own.iter().enumerate() {
            let run = self.repeats.push(channels, *row);
            // All but the first row of the run, as far as they are in this batch.
            let marked = match run.checked_sub(judge::MAX_REPEATS) {
                None | Some(0) => continue,
                Some(1) => k.saturating_sub(run - 2)..k + 1,
                Some(_) => k..k + 1,
            };
            own[marked].iter().for_each(|row| is_measured[*row] = false);
        }
    }

    /// Undoes the encoding and subtracts the zero offset; false if the numbers are written in
    /// another way.
    fn decode(&self, accel: &mut [Vec<f64>; 3], gyro: Option<&mut [Vec<f64>; 3]>) -> bool {
        match self.encoding {
            Some(_) if !accel.iter().all(|c| judge::are_unsigned(c)) => return false,
            Some(Encoding::TwosComplement) => {
                let gyro = gyro.into_iter().filter(|_| self.decodes_gyro).flatten();
                Encoding::TwosComplement.undo(accel.iter_mut().chain(gyro).flatten());
            }
            Some(Encoding::OffsetBinary) => {}
            None if self.is_signed || self.zero_offset != 0.0 => {}
            None => return judge::decode(accel, gyro).is_none(),
        }
        let cells = accel.iter_mut().flatten();
        cells.for_each(|v| *v -= self.zero_offset);
        true
    }

    /// The row from which on the channels are shifted, where the magnitude at the end of the batch
    /// is not that of gravity.
    fn slipped_row(
        &self,
        gravity: f64,
        accel: &[Vec<f64>; 3],
        gyro: Option<&[Vec<f64>; 3]>,
    ) -> Option<usize> {
        let gyro = gyro?;
        let end = |axis: &Vec<f64>| axis.len().saturating_sub(SLIP_END_ROWS);
        let norm = judge::quiet_norm(accel.each_ref().map(|axis| &axis[end(axis)..]))?;
        if (norm / gravity - 1.0).abs() < SLIP_TOLERANCE {
            return None;
        }
        let axes = accel.iter().chain(gyro);
        let axes = self.tail.iter().zip(axes);
        let joined: Vec<Vec<f64>> = axes.map(|(t, a)| [&t[..], a].concat()).collect();
        let row =
            judging::slipped_row(&self.format, std::array::from_fn(|i| joined[i].as_slice()))?;
        Some(row.saturating_sub(self.tail[0].len()))
    }

    fn keep_tail(&mut self, accel: &[Vec<f64>; 3], gyro: Option<&[Vec<f64>; 3]>) {
        let axes = accel.iter().chain(gyro.into_iter().flatten());
        for (tail, axis) in self.tail.iter_mut().zip(axes) {
            tail.clear();
            tail.extend_from_slice(&axis[axis.len().saturating_sub(TAIL_ROWS)..]);
        }
    }
}
