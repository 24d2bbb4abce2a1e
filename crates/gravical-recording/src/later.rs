//! Rows after those by which a recording was judged.
//!
//! A recording of any size is judged by its first rows, with all that [`Recording`] judges. The
//! rows after them are read alike, batch by batch, each with the last rows before it; where they
//! cannot be, they end the reading.

use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::full_scale::Clipping;
use crate::judge::{self, Encoding};
use crate::readings::Readings;
use crate::recording::Recording;
use crate::recording::judging::findings::of_lines;
use crate::recording::judging::gap_text;
use crate::recording::judging::measured::{Known, Measured, cell_label, keep_sensor, stamped_rows};
use crate::spans::LineSpans;
use crate::text::{Batch, Format, Ledger, Reason, split_hint};

/// So many rows of other sensors alone show that the one that is read has ended.
const MIN_ROWS_OF_OTHERS: usize = 100;
/// Rows before a batch with which it is read.
const TAIL_ROWS: usize = 1024;

/// How rows are read after those by which a recording was judged.
#[derive(Clone, Debug, Default)]
pub struct Later {
    /// With the sensor that is read, and the rate of the first rows.
    format: Format,
    known: Known,
    /// Some value of the accelerometer was no unsigned integer.
    is_signed: bool,
    /// The last rows of the sensor up to one with a stamp, as they are written.
    tail: Batch,
    /// Channels with the ends of their ranges.
    clipping: Vec<(&'static str, Clipping)>,
    /// Lines of the rows before which more than four are missing, and the longest step, s.
    gaps: LineSpans,
    longest_gap_s: f64,
    /// Lines of the measurements that lack a value, and how many values.
    incomplete: LineSpans,
    empty_cells: usize,
    /// What else was found, each kind once: the unit changed, but the user gives it; stamps that are not used.
    findings: Vec<Finding>,
    /// Line of the first row that is read here.
    first_line: Option<u32>,
    ledger: Ledger,
    nul_lines: LineSpans,
    /// Whether rows that cannot be read as those before them are an error. Batches of a recording
    /// that grows are too short to tell.
    pub(crate) contradicts: bool,
}

impl Later {
    /// Judges the first rows of a recording, or all of them, and tells how later ones are read.
    ///
    /// # Errors
    ///
    /// Those of [`Recording::judge`].
    pub fn judge(format: &Format, mut head: Batch) -> Result<(Recording, Later), Error> {
        let mut finding = None;
        let mut format_of_later = format.clone();
        if let Some(column) = format.sensor {
            finding = keep_sensor(format, &mut head, column)?;
            let sensor = (head.rows() > 0).then(|| cell_label(&head, column, 0));
            // A column that is empty names none.
            format_of_later.options.sensor = sensor.filter(|label| !label.is_empty());
        }
        let tail = last_rows(format, &head);
        let mut axes = format.accel.iter().map(|c| &head.columns[*c]);
        let is_signed = !axes.all(|axis| judge::are_unsigned(axis));
        let measured = Measured::new(format, head, None)?;
        let channels = measured.readings.channels();
        let known = Known {
            marks_hung: judge::repeats_are_proof(&channels),
            gravity: judge::quiet_norm([channels[0], channels[1], channels[2]]),
            ..measured.known
        };
        let mut recording = Recording::judge_measured(format, measured)?;
        recording.findings.extend(finding);
        format_of_later.options.rate_hz = recording.timing.rate_hz();
        let ends = recording.ends_of_ranges(format).into_iter();
        let later = Later {
            format: format_of_later,
            known,
            is_signed,
            tail,
            clipping: ends.map(|(_, name, end)| (name, end)).collect(),
            contradicts: true,
            ..Later::default()
        };
        Ok((recording, later))
    }

    /// Reads the rows of the next batch, and takes its account of lines.
    ///
    /// Of repeats that go on from one batch to the next up to 20 rows in the first stay measurements, of
    /// zeros up to four.
    ///
    /// # Errors
    ///
    /// The rows cannot be read as those before them.
    pub fn read(&mut self, batch: &mut Batch) -> Result<Readings, Error> {
        self.ledger.append(std::mem::take(&mut batch.ledger));
        self.nul_lines.append(&batch.nul_lines);
        let first = batch.lines.first().copied().unwrap_or(u32::MAX);
        self.first_line = self.first_line.or(batch.lines.first().copied());
        let mut rows = std::mem::take(&mut self.tail);
        rows.append(batch.slice(0..batch.rows()));
        if let Some(column) = self.format.sensor {
            keep_sensor(&self.format, &mut rows, column)?;
        }
        if self.contradicts {
            self.check_sensor_and_encoding(&rows, batch)?;
        } else {
            self.known.gravity = None;
            // The first second does not show it.
            self.known
                .clock
                .iter_mut()
                .for_each(|c| c.is_bunched = None);
        }
        self.tail = last_rows(&self.format, &rows);
        let measured = Measured::new(&self.format, rows, Some(&self.known))?;
        self.known = measured.known;
        let unused = [FindingKind::FrozenTime, FindingKind::BadStamps];
        for mut finding in measured.findings.iter().cloned() {
            if unused.contains(&finding.kind) {
                finding.message = format!("from line {first} on: {}", finding.message);
                self.add(finding);
            }
        }
        self.check_columns_and_unit(&measured)?;
        for (line, step_s) in measured.time.gaps.iter().filter(|gap| gap.0 >= first) {
            self.gaps.push(u64::from(*line));
            self.longest_gap_s = self.longest_gap_s.max(*step_s);
        }
        let read = &measured.readings;
        let readings = read.in_lines(&measured.rows.lines, &batch.lines);
        self.count_set_aside(batch, &readings);
        self.count_empty_cells(&batch.lines, &readings);
        for ((_, clipping), axis) in self.clipping.iter_mut().zip(readings.channels()) {
            clipping.observe(axis, &batch.lines);
        }
        Ok(readings)
    }

    fn check_sensor_and_encoding(&self, rows: &Batch, batch: &Batch) -> Result<(), Error> {
        let first = batch.lines.first().copied().unwrap_or_default();
        let count = batch.rows();
        if count >= MIN_ROWS_OF_OTHERS && rows.lines.last().is_none_or(|line| *line < first) {
            let text = format!("the sensor that is read has no row in the next {count} rows");
            return Err(contradiction("sensor-ended", &text, first.into()));
        }
        let axes = self.format.accel.map(|c| rows.columns[c].as_slice());
        let is_alike = match self.known.encoding {
            Some(_) => axes.iter().all(|axis| judge::are_unsigned(axis)),
            None if self.is_signed || self.format.options.zero_offset.is_some() => true,
            None => Encoding::of(axes).is_none(),
        };
        let text = "numbers are written in another way than before: unsigned integers in one part, signed ones or fractions in the other";
        if is_alike {
            Ok(())
        } else {
            Err(contradiction("encoding-changed", text, first.into()))
        }
    }

    fn check_columns_and_unit(&mut self, measured: &Measured) -> Result<(), Error> {
        let slipped = measured.rows.ledger.reasons.get(&Reason::Slipped);
        if let Some([line, _]) = slipped.and_then(|aside| aside.lines.ranges().first()) {
            let text =
                "the values stand in the columns of others from here on: the bus lost a byte";
            return Err(contradiction("shifted-columns", text, *line));
        }
        let (accel, lines) = (&measured.readings.accel, &measured.rows.lines);
        let gravity = self.known.gravity;
        if let Some(finding) = gravity.and_then(|g| judge::unit_change(accel, lines, Some(g))) {
            if self.format.options.accel_unit.is_none() {
                let line = finding.lines.first().map_or(0, |l| l[0]);
                return Err(contradiction("unit-changed", &finding.message, line));
            }
            self.add(finding);
        }
        Ok(())
    }

    /// Adds what was not found yet.
    fn add(&mut self, finding: Finding) {
        if !self.findings.iter().any(|known| known.kind == finding.kind) {
            self.findings.push(finding);
        }
    }

    fn count_empty_cells(&mut self, lines: &[u32], readings: &Readings) {
        let channels = readings.channels();
        for (row, line) in lines
            .iter()
            .enumerate()
            .filter(|(r, _)| readings.is_measured[*r])
        {
            let empty = channels.iter().filter(|c| c[row].is_nan()).count();
            self.empty_cells += empty;
            if empty > 0 {
                self.incomplete.push(u64::from(*line));
            }
        }
    }

    fn count_set_aside(&mut self, batch: &Batch, readings: &Readings) {
        let channels = batch.slices(&self.format.channels());
        let is_other = |row: usize| {
            let sensor = self.format.sensor.zip(self.format.options.sensor.as_ref());
            sensor.is_some_and(|(column, label)| cell_label(batch, column, row) != *label)
        };
        for (row, line) in batch.lines.iter().enumerate() {
            if readings.is_measured[row] {
                continue;
            }
            let reason = if is_other(row) {
                Reason::OtherSensor
            } else if channels.iter().all(|c| c[row] == 0.0) {
                Reason::Zeros
            } else {
                Reason::Hung
            };
            self.ledger.add(reason, *line as usize, "");
        }
    }

    /// The account of these lines, with the rows that are no measurements, and what was found in them,
    /// once all are read.
    pub fn finish(self) -> (Ledger, Vec<Finding>) {
        let mut findings = Vec::new();
        if !self.gaps.is_empty() {
            let text = gap_text(self.gaps.count() as usize, self.longest_gap_s);
            findings.push(Finding::new(FindingKind::Gap, text).at_lines(&self.gaps));
        }
        if self.empty_cells > 0 {
            let (cells, rows) = (self.empty_cells, self.incomplete.count());
            let text = format!("{cells} empty cells in {rows} rows; they stay empty");
            let empty = Finding::new(FindingKind::EmptyCells, text);
            findings.push(empty.at_lines(&self.incomplete));
        }
        findings.extend(self.clipping.iter().filter_map(|(name, c)| c.finding(name)));
        let of_lines = of_lines(&self.ledger, &self.nul_lines).into_iter();
        // Blank lines are told of the first rows.
        findings.extend(of_lines.filter(|f| f.kind != FindingKind::BlankRows));
        let line = self.first_line.unwrap_or_default();
        for finding in &mut findings {
            finding.message = format!("from line {line} on: {}", finding.message);
        }
        findings.extend(self.findings);
        (self.ledger, findings)
    }
}

fn contradiction(code: &'static str, text: &str, line: u64) -> Error {
    let error = Error::contradiction(code, text).at_line(line as usize);
    error.with_hint(split_hint(line))
}

/// The last rows up to one with a stamp.
fn last_rows(format: &Format, rows: &Batch) -> Batch {
    let end = stamped_rows(format, rows);
    rows.slice(end.saturating_sub(TAIL_ROWS)..end)
}
