//! Reading of a recording into columns in memory.

use std::collections::HashMap;
use std::io::Read as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

use super::dialect::decode;
use super::file::{OpenFile, complete_rows, open_rows};
use super::format::Format;
use super::layout::Layout;
use super::monitor::Facts;
use super::names::Quantity;
use super::names::Role;
use super::open::{HEAD, Input, Reopenable, open};
use super::row::{ACCEL, GYRO, TEMPERATURE};
use super::rows::{Finished, Row, Rows, Source};

use super::{AccelUnit, Finding, Labels, ReadOptions, Recording, RowMap, metadata};

/// Reads the first 256 KiB of the recording at `path`: unit, range, first time stamp, serial number
/// and the temperature in it, before all rows are read.
///
/// # Errors
///
/// As [`read`](super::read).
pub fn read_head(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let options = ReadOptions {
        hash: false,
        meter: None,
        ..options.clone()
    };
    let mut bytes = Vec::new();
    let reader = open(path, &options)?.reader;
    let read = reader.take(HEAD as u64).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(path, e))?;
    if bytes.len() == HEAD {
        bytes.truncate(complete_rows(&bytes));
    }
    super::read_bytes(&bytes, &path.display().to_string(), &options)
}

/// Consumer of the rows of a recording.
pub(crate) trait Sink {
    /// Takes the rows it needs.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()>;
}

/// Rows as columns.
#[derive(Default, Clone)]
pub(crate) struct Columns {
    zero_offset: f64,
    header_unit: Option<AccelUnit>,
    pub restarted: bool,
    pub accel: [Vec<f64>; 3],
    pub gyro: Option<[Vec<f64>; 3]>,
    pub temperature: Option<Vec<f64>>,
    time_s: Vec<f64>,
    labels: Option<Labels>,
    label_index: HashMap<Vec<u8>, u32>,
    lines: RowMap,
    pub breaks: Vec<usize>,
}

/// Properties of a recording other than its rows.
#[derive(Default)]
pub(crate) struct About {
    pub name: String,
    pub sha256: Option<String>,
    pub description: String,
    pub serial: Option<String>,
    pub stated_start_s: Option<f64>,
    pub column_names: Vec<String>,
    /// The accelerometer is read from columns with the names of calibrated ones.
    pub is_calibrated: bool,
    /// The board says so.
    pub is_calibrated_by_board: bool,
    /// Findings about the file.
    pub findings: Vec<Finding>,
}

/// Bytes that the columns may take, and those of a row of six channels.
const MAX_BYTES: u64 = 1 << 30;
const BYTES_OF_ROW: u64 = 72;

impl Columns {
    /// Empty columns for the channels of `layout`.
    pub fn new(layout: &Layout, facts: &Facts) -> Self {
        let has = |quantity| layout.field(quantity).is_some();
        Columns {
            zero_offset: facts.zero_offset,
            header_unit: layout.accel_claim.unit,
            gyro: layout.has_gyro().then(Default::default),
            temperature: (has(Quantity::Temperature) && facts.celsius).then(Default::default),
            labels: has(Quantity::Label).then(Default::default),
            ..Columns::default()
        }
    }

    /// The same for a format.
    pub fn of_format(format: &Format, facts: &Facts) -> Self {
        Columns::new(&format.layout, facts)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// The columns, without a copy of what is large, until [`take_back`](Self::take_back).
    pub fn lend(&mut self) -> Self {
        let (accel, gyro, temperature) = (
            std::mem::take(&mut self.accel),
            self.gyro.take(),
            self.temperature.take(),
        );
        Columns {
            accel,
            gyro,
            temperature,
            ..self.clone()
        }
    }

    /// Takes back what [`lend`](Self::lend) gave, from the recording that was made of it.
    pub fn take_back(&mut self, recording: Recording) {
        self.accel = recording.accel;
        self.gyro = recording.gyro;
        self.temperature = recording.temperature_c;
    }

    /// There is a label column.
    pub fn has_labels(&self) -> bool {
        self.labels.is_some()
    }

    /// All columns of numbers.
    fn numbers(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let gyro = self.gyro.iter_mut().flatten();
        let channels = self.accel.iter_mut().chain(gyro);
        channels
            .chain(&mut self.temperature)
            .chain([&mut self.time_s])
    }

    /// Makes room for `rows` more rows, and for no others.
    ///
    /// # Errors
    ///
    /// `too-large`; `no-memory` if there is not enough.
    #[cold]
    fn reserve(&mut self, rows: usize) -> Result<()> {
        let held = self.rows() as u64;
        if (held + rows as u64) * BYTES_OF_ROW > MAX_BYTES {
            let what = format!(
                "its columns take more than {} MiB of memory",
                MAX_BYTES >> 20
            );
            return Err(Error::input("too-large", what)
                .with_hint("cut the file, and read the parts separately"));
        }
        let labels = self
            .labels
            .as_mut()
            .map(|l| l.of_row.try_reserve_exact(rows));
        self.numbers()
            .try_for_each(|column| column.try_reserve_exact(rows))
            .and(labels.unwrap_or(Ok(())))
            .map_err(|_| Error::no_memory(held))
    }

    /// Gives back the room that no row needed.
    fn shrink(&mut self) {
        self.numbers().for_each(Vec::shrink_to_fit);
        if let Some(labels) = &mut self.labels {
            labels.of_row.shrink_to_fit();
        }
    }

    /// Adds a row; `is_break`: it does not continue the row before.
    ///
    /// # Errors
    ///
    /// `no-memory` if there is not enough.
    #[inline]
    pub fn push(&mut self, row: &Row<'_>, is_break: bool) -> Result<()> {
        if self.time_s.len() == self.time_s.capacity() {
            self.reserve((self.rows() / 4).max(1 << 10))?;
        }
        let number = self.time_s.len();
        for (i, channel) in self.accel.iter_mut().enumerate() {
            channel.push(row.values[ACCEL + i] - self.zero_offset);
        }
        for (i, channel) in self.gyro.iter_mut().flatten().enumerate() {
            channel.push(row.values[GYRO + i]);
        }
        if let Some(temperature) = &mut self.temperature {
            temperature.push(row.values[TEMPERATURE]);
        }
        if self.labels.is_some() {
            self.push_label(row.text.label.trim_ascii());
        }
        self.restarted |= row.restarted;
        if number > 0 && is_break {
            self.breaks.push(number);
        }
        self.time_s.push(row.t_s);
        self.lines.push(row.line);
        Ok(())
    }

    fn push_label(&mut self, text: &[u8]) {
        let Some(labels) = &mut self.labels else {
            return;
        };
        let index = match self.label_index.get(text) {
            Some(&index) => index,
            None => {
                let index = labels.names.len() as u32;
                labels.names.push(decode(text).trim_matches('"').to_owned());
                self.label_index.insert(text.to_vec(), index);
                index
            }
        };
        labels.of_row.push(index);
    }
}

impl Sink for Columns {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_at_most(usize::MAX);
        // What was expected may be too much: the rows themselves decide.
        let _ = self.reserve(rows.expected());
        while let Some(row) = rows.next_row()? {
            self.push(&row, row.is_break())?;
        }
        self.shrink();
        Ok(())
    }
}

/// A recording that was read to its end.
pub(crate) struct Collected<T> {
    pub rows: T,
    pub about: About,
    pub finished: Finished,
    /// What the rows were read with.
    pub facts: Facts,
    /// The line from which all rows are zero.
    pub zeros_from: Option<u64>,
}

impl<T> Collected<T> {
    /// The same with other rows.
    pub fn with<U>(self, rows: U) -> (T, Collected<U>) {
        let rest = Collected {
            rows,
            about: self.about,
            finished: self.finished,
            facts: self.facts,
            zeros_from: self.zeros_from,
        };
        (self.rows, rest)
    }

    /// Rate of evenly spaced rows, Hz: the mean of all rows, which is more accurate than that of the
    /// first ones; `None` if each row has a time of its own.
    pub fn even_hz(&self) -> Option<f64> {
        let of = |facts: &Facts| facts.stamp_reading.and_then(|reading| reading.even_hz);
        of(&self.facts).and(of(&self.finished.summary.facts))
    }
}

impl Collected<Columns> {
    /// The recording. If its rows were read with facts that all rows contradict, a finding
    /// reports it.
    pub fn into_recording(mut self) -> Recording {
        // When the rows are read again, they have the same times.
        let even_hz = self.even_hz();
        let Columns {
            accel,
            gyro,
            temperature,
            labels,
            breaks,
            lines,
            ..
        } = self.rows;
        let contradicted = self.facts.contradicted_by(&self.finished.summary.facts);
        let mut findings = self.about.findings;
        findings.extend(contradicted);
        findings.extend(self.finished.findings());
        for finding in &mut findings {
            finding.file = Some(self.about.name.clone());
        }
        let found = self.finished.summary.facts;
        let time_s = self.facts.stamp_reading.map(|_| {
            if let Some(rate_hz) = even_hz {
                let times = self.rows.time_s.iter_mut().enumerate();
                times.for_each(|(row, t_s)| *t_s = row as f64 / rate_hz);
            }
            self.rows.time_s
        });
        Recording {
            name: self.about.name,
            sha256: self.about.sha256,
            description: self.about.description,
            serial: self.about.serial,
            column_names: self.about.column_names,
            is_calibrated: self.about.is_calibrated,
            is_calibrated_by_board: self.about.is_calibrated_by_board,
            accel,
            gyro,
            gyro_file: None,
            temperature_c: temperature,
            time_s,
            time_origin_s: self.finished.summary.origin_s,
            stated_start_s: self.about.stated_start_s,
            restarted: self.rows.restarted,
            labels,
            breaks,
            zero_offset: self.facts.zero_offset,
            accel_scale: found.accel,
            unit_doubt: self.finished.summary.unit_doubt,
            header_unit: self.rows.header_unit,
            gyro_scale: found.gyro,
            resolution: found.resolution,
            timing: self.finished.summary.timing,
            ledger: self.finished.ledger,
            findings,
            line_map: lines,
            excerpt: None,
        }
    }
}

/// Reads all rows; a second time if the first rows gave wrong facts.
///
/// # Errors
///
/// As [`read`](super::read).
pub(crate) fn collect<T: Sink>(
    source: &mut Reopenable,
    name: &str,
    role: Role,
    options: &ReadOptions,
    sink: impl Fn(&Format, &Facts) -> T,
) -> Result<Collected<T>> {
    let input = source.open(options)?;
    collect_from(input, source, name, role, options, sink)
}

/// The same, with `source` already open.
///
/// # Errors
///
/// As [`read`](super::read).
pub(crate) fn collect_from<T: Sink>(
    mut input: Input,
    source: &mut Reopenable,
    name: &str,
    role: Role,
    options: &ReadOptions,
    sink: impl Fn(&Format, &Facts) -> T,
) -> Result<Collected<T>> {
    let (mut known, mut zeros_from) = (None, None);
    let mut passes = 1;
    loop {
        let mut file = open_rows(input, name, role, options, known)?;
        file.rows = file.rows.with_zeros_from(zeros_from);
        let mut read = read_all(file, name, &sink)?;
        read.zeros_from = zeros_from;
        let wrong_facts = !read.finished.summary.facts.agrees(&read.facts);
        if passes > 1 || !wrong_facts && read.finished.zeros_from.is_none() {
            return Ok(read);
        }
        let Some(reopened) = source.reopen(options)? else {
            return Ok(read);
        };
        known = Some(if wrong_facts {
            read.finished.summary.facts
        } else {
            read.facts
        });
        zeros_from = read.finished.zeros_from;
        passes += 1;
        input = reopened;
    }
}

/// Reads a recording again, with what is known of it.
pub(crate) struct Rereader<'a> {
    source: &'a mut Reopenable,
    name: &'a str,
    options: ReadOptions,
    pub known: Known,
}

impl<'a> Rereader<'a> {
    pub fn new(
        source: &'a mut Reopenable,
        name: &'a str,
        options: &ReadOptions,
        known: Known,
    ) -> Self {
        let options = ReadOptions {
            hash: false,
            ..options.clone()
        };
        Rereader {
            source,
            name,
            options,
            known,
        }
    }

    /// The rows again; they have a time, and no further statistics.
    ///
    /// # Errors
    ///
    /// As [`read`]; `changed` (input) for a pipe that could not be copied.
    pub fn open(&mut self) -> Result<OpenFile> {
        let input = self.source.reopen(&self.options)?;
        let input = input.ok_or_else(|| {
            Error::input(
                "changed",
                "it has to be read twice, and there was no room for a temporary copy of it",
            )
            .at(Path::new(self.name), None)
            .with_hint("write the data of a pipe to a file first")
        })?;
        let facts = Some(self.known.facts);
        let mut file = open_rows(input, self.name, Role::Recording, &self.options, facts)?;
        file.rows = file
            .rows
            .with_zeros_from(self.known.zeros_from)
            .times_only();
        Ok(file)
    }

    /// Passes rows to `sink` until it has those it needs.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn collect<T: Sink>(&mut self, sink: impl FnOnce(&Format, &Facts) -> T) -> Result<T> {
        let mut file = self.open()?;
        let mut sink = sink(&file.format, &self.known.facts);
        sink.collect(&mut file.rows)?;
        Ok(sink)
    }

    /// It had other rows than the first time.
    pub fn changed(&self) -> Error {
        Error::input(
            "changed",
            "it did not have the same rows when it was read again: the file changed",
        )
        .at(Path::new(self.name), None)
        .with_hint("wait until no program writes to it")
    }
}

/// What a recording is read with a second time.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Known {
    pub facts: Facts,
    /// The line from which all rows are zero.
    pub zeros_from: Option<u64>,
}

fn read_all<T: Sink>(
    mut file: OpenFile,
    name: &str,
    sink: impl Fn(&Format, &Facts) -> T,
) -> Result<Collected<T>> {
    let facts = *file.rows.facts();
    let mut rows = sink(&file.format, &facts);
    let here = Path::new(name);
    rows.collect(&mut file.rows)
        .map_err(|e| match e.location() {
            Some(_) => e,
            None => e.at(here, None),
        })?;
    let dialect = &file.format.dialect;
    let serial = metadata::serial(&dialect.metadata);
    let stated_start_s = metadata::start_s(&dialect.metadata);
    let column_names = dialect.header.as_ref().map(|h| h.names.clone());
    let column_names = column_names.unwrap_or_default();
    let is_calibrated = file.format.layout.reads_calibrated(&column_names);
    let is_calibrated_by_board = file.format.layout.calibrated_by_board;
    let read = file.finish()?;
    let about = About {
        name: name.to_owned(),
        sha256: read.sha256,
        description: read.description,
        serial,
        stated_start_s,
        column_names,
        is_calibrated,
        is_calibrated_by_board,
        findings: read.findings,
    };
    Ok(Collected {
        rows,
        about,
        finished: read.finished,
        facts,
        zeros_from: None,
    })
}
