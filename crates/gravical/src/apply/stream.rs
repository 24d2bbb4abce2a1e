//! The one pass over the lines.

use std::io::{Read, Write};
use std::path::Path;

use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::open::Input;
use crate::recording::row::{
    ACCEL, GYRO, RowDefect, RowScanner, RowStamps, SLOTS, Span, TIME, Values,
};
use crate::recording::timing::{Parting, Stamps, is_usual_step};
use crate::recording::{Aside, Ledger, LineReasons, LineSpans};
use crate::scan::{Line, Lines};
use crate::{Error, Result};

use super::finish::Done;
use super::plan::Plan;
use super::sensor::Sensor;
use super::tail::Tail;
use super::watch::Watch;

/// Output is handed on in blocks of this many bytes.
const BLOCK: usize = 256 << 10;

/// What becomes of the rows.
pub(crate) trait Sink {
    /// It asks where the fields of a line are.
    const SPANS: bool;

    /// What stands before the first row.
    fn header(&self) -> Vec<u8>;
    /// A row, in order; what it becomes goes to `out`.
    fn row(&mut self, row: &Row<'_>, out: &mut Vec<u8>);
    /// A line before the next row that parts segments: blank, a named gap, or a
    /// repeated header.
    fn part(&mut self, reason: Aside, out: &mut Vec<u8>);
    /// The rows from here on may be none: remember the state.
    fn mark(&mut self);
    /// … they were none: back to it.
    fn rewind(&mut self);
    /// … they were rows.
    fn keep(&mut self);
}

/// A row of the recording.
pub(crate) struct Row<'a> {
    pub number: u64,
    pub bytes: &'a [u8],
    /// Empty where the sink does not ask for them.
    pub spans: &'a [Span],
    pub values: &'a Values,
    /// Specific force, m/s², and angular rate, rad/s; NaN where they are not there.
    pub calibrated: [f64; 6],
}

/// Writes the rows under the names of a plan.
pub(super) struct Rewrite<'a>(pub &'a Plan);

impl Sink for Rewrite<'_> {
    const SPANS: bool = true;

    fn header(&self) -> Vec<u8> {
        self.0.header()
    }

    #[inline]
    fn row(&mut self, row: &Row<'_>, out: &mut Vec<u8>) {
        self.0.write_row(row.bytes, row.spans, &row.calibrated, out);
    }

    fn part(&mut self, reason: Aside, out: &mut Vec<u8>) {
        // It parts segments, so it stays; a comment would be in the way of programs
        // that know none.
        if matches!(reason, Aside::Blank | Aside::NamedGap) {
            out.push(b'\n');
        }
    }

    // Nothing is carried from row to row.
    fn mark(&mut self) {}
    fn rewind(&mut self) {}
    fn keep(&mut self) {}
}

/// The state of the pass.
pub(crate) struct Stream<'a, S> {
    pub(super) sink: S,
    pub(super) sensor: Sensor,
    pub(super) watch: Watch,
    pub(super) stamps: Option<Stamps>,
    /// Accelerometer, gyroscope: an empty cell means the value before.
    pub(super) held: [bool; 2],
    last: Values,
    dialect: &'a Dialect,
    reasons: LineReasons<'a>,
    scanner: RowScanner,
    row_stamps: RowStamps,
    /// Usual step of the raw stamps; infinite where nothing is known of them.
    usual_step: f64,
    last_stamp: f64,
    /// Lines since the last row that part segments, unless the clock goes on across them.
    parts: Vec<Aside>,
    pub(super) ledger: Ledger,
    /// Rows whose calibrated acceleration, or rate, is empty.
    pub(super) empty: [LineSpans; 2],
    pub(super) nul_lines: LineSpans,
    pub(super) foreign_lines: LineSpans,
    pub(super) tail: Tail,
    pub(super) any_movement: bool,
    block: Vec<u8>,
}

impl<'a, S: Sink> Stream<'a, S> {
    /// `held`: an empty cell of the accelerometer, of the gyroscope, means the value
    /// before. `usual_step`: of the raw stamps, none without a clock.
    #[allow(clippy::too_many_arguments)] // what a head tells, and where rows go
    pub fn new(
        sink: S,
        sensor: Sensor,
        watch: Watch,
        stamps: Option<Stamps>,
        usual_step: Option<f64>,
        held: [bool; 2],
        dialect: &'a Dialect,
        layout: &Layout,
    ) -> Self {
        let mut block = Vec::with_capacity(BLOCK + (BLOCK >> 2));
        block.extend_from_slice(&sink.header());
        Stream {
            sink,
            sensor,
            watch,
            stamps,
            held,
            last: [f64::NAN; SLOTS],
            dialect,
            reasons: LineReasons::new(dialect),
            scanner: layout.scanner(dialect),
            row_stamps: layout.stamps(),
            usual_step: usual_step.unwrap_or(f64::NAN),
            last_stamp: f64::NAN,
            parts: Vec::new(),
            ledger: Ledger::default(),
            empty: Default::default(),
            nul_lines: LineSpans::default(),
            foreign_lines: LineSpans::default(),
            tail: Tail::default(),
            any_movement: false,
            block,
        }
    }

    /// Goes through `lines`, writes them to `out` and says what is odd.
    ///
    /// # Errors
    ///
    /// `no-rows`, `no-values`, `all-zero`; what reading and writing report.
    pub fn run<R: Read>(
        mut self,
        mut lines: Lines<R>,
        input: &Input,
        name: &str,
        out: &mut dyn Write,
    ) -> Result<Done<S>> {
        let here = Path::new(name);
        let mut values: Values = [f64::NAN; SLOTS];
        let mut spans = Vec::with_capacity(self.scanner.fields());
        while let Some(line) = lines.next_line().map_err(|e| Error::io(here, e))? {
            if line.nul_bytes > 0 {
                self.nul_lines.push(line.number);
            }
            if line.number < self.dialect.first_data_line {
                let reason = self.reasons.before(&line);
                self.set_aside(reason, &line);
                continue;
            }
            let scanned = if S::SPANS {
                self.scanner.scan_spans(line.bytes, &mut values, &mut spans)
            } else {
                self.scanner.scan(line.bytes, &mut values, &mut (0, 0))
            };
            match scanned {
                Ok(()) => self.row(&line, &mut values, &spans),
                Err(defect) => self.no_row(&line, defect),
            }
            if self.block.len() >= BLOCK {
                self.hand_on(out)?;
            }
        }
        self.finish(input, name, out)
    }

    #[inline]
    fn row(&mut self, line: &Line<'_>, values: &mut Values, spans: &[Span]) {
        self.ledger.row();
        self.row_stamps.stamp(values);
        if !self.parts.is_empty() {
            self.settle_parts(values[TIME]);
        }
        if values[TIME].is_finite() {
            self.last_stamp = values[TIME];
        }
        if self.held != [false; 2] {
            self.hold(values);
        }
        let mut calibrated = if self.sensor.drift.is_none() {
            self.sensor.calibrate(values)
        } else {
            self.without_drift(values, line.number)
        };
        let [ax, ay, az, gx, gy, gz] = calibrated;
        if !(ax + ay + az).is_finite() {
            self.empty[0].push(line.number);
            calibrated[..3].fill(f64::NAN);
        }
        if self.sensor.gyro.is_some() && !(gx + gy + gz).is_finite() {
            self.empty[1].push(line.number);
            calibrated[3..].fill(f64::NAN);
        }
        let zero = is_zero(values, self.watch.channels());
        self.any_movement |= !zero;
        if zero && self.any_movement && self.tail.holds() {
            return self.hold_back(line, values, spans, &calibrated);
        }
        if !zero && !self.tail.is_clear() {
            self.write_tail();
        }
        if zero && !self.tail.holds() {
            self.tail.given_up.push(line.number);
        }
        self.see(values, line.number);
        let row = Row {
            number: line.number,
            bytes: line.bytes,
            spans,
            values,
            calibrated,
        };
        self.sink.row(&row, &mut self.block);
    }

    /// A calibrated row whose drift with temperature was taken off.
    // Most calibrations have no model of it: their loop stays as it was.
    #[inline(never)]
    fn without_drift(&mut self, values: &Values, line: u64) -> [f64; 6] {
        let counts = !is_zero(values, self.watch.channels());
        match &mut self.sensor.drift {
            Some(drift) => {
                let steady = drift.taken_off(values, line, counts);
                self.sensor.calibrate(&steady)
            }
            None => self.sensor.calibrate(values),
        }
    }

    /// The last value of a channel holds until the next comes.
    fn hold(&mut self, values: &mut Values) {
        for (sensor, from) in [(0, ACCEL), (1, GYRO)] {
            if !self.held[sensor] {
                continue;
            }
            let channels = values[from..from + 3].iter_mut();
            for (value, last) in channels.zip(&mut self.last[from..from + 3]) {
                if value.is_nan() {
                    *value = *last;
                } else {
                    *last = *value;
                }
            }
        }
    }

    #[inline]
    fn see(&mut self, values: &Values, line: u64) {
        self.watch.see(values, line);
        if let Some(stamps) = &mut self.stamps {
            stamps.see(values[TIME], || line);
        }
    }

    #[cold]
    fn hold_back(&mut self, line: &Line<'_>, values: &Values, spans: &[Span], row: &[f64; 6]) {
        if self.tail.rows.is_empty() {
            self.sink.mark();
        }
        let row = Row {
            number: line.number,
            bytes: line.bytes,
            spans,
            values,
            calibrated: *row,
        };
        self.sink.row(&row, &mut self.tail.text);
        self.tail.rows.push((line.number, values[TIME]));
        if self.tail.is_full() {
            self.tail.give_up();
            self.release();
        }
    }

    /// The rows that were held back are data.
    #[cold]
    fn write_tail(&mut self) {
        self.release();
        self.tail.given_up = LineSpans::default();
    }

    pub(super) fn release(&mut self) {
        self.sink.keep();
        let mut values: Values = [0.0; SLOTS];
        for (line, time) in std::mem::take(&mut self.tail.rows) {
            values[TIME] = time;
            self.see(&values, line);
        }
        self.block.append(&mut self.tail.text);
    }

    #[cold]
    fn no_row(&mut self, line: &Line<'_>, defect: RowDefect) {
        let reason = self.reasons.among(line, defect);
        if let (Some(how), Some(stamps)) = (Parting::by(reason), &mut self.stamps) {
            stamps.part(how);
        }
        if reason.parts() {
            self.parts.push(reason);
        }
        self.set_aside(reason, line);
    }

    /// A blank line or a header between rows parts nothing where the clock goes on across
    /// it; `stamp` is that of the next row. More than one blank line are deliberate.
    #[cold]
    pub(super) fn settle_parts(&mut self, stamp: f64) {
        let parts = std::mem::take(&mut self.parts);
        let blank = parts.iter().filter(|p| **p == Aside::Blank).count();
        let deliberate = blank > 1 || parts.contains(&Aside::NamedGap);
        if !deliberate && is_usual_step(stamp - self.last_stamp, self.usual_step) {
            return;
        }
        for reason in parts {
            let target = if self.tail.rows.is_empty() {
                &mut self.block
            } else {
                &mut self.tail.text
            };
            self.sink.part(reason, target);
        }
    }

    fn set_aside(&mut self, reason: Aside, line: &Line<'_>) {
        if std::str::from_utf8(line.bytes).is_err() {
            self.foreign_lines.push(line.number);
        }
        self.ledger.aside(reason, line.number, line.bytes);
    }

    pub(super) fn hand_on(&mut self, out: &mut dyn Write) -> Result<()> {
        out.write_all(&self.block)
            .map_err(|e| Error::io(Path::new("output"), e))?;
        self.block.clear();
        Ok(())
    }
}

/// Accelerometer and gyroscope read zero on every axis.
#[inline]
fn is_zero(values: &Values, channels: usize) -> bool {
    values[ACCEL..ACCEL + channels].iter().all(|v| *v == 0.0)
}
