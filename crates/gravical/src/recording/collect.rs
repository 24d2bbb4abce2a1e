//! A recording in memory: its rows, collected into columns.

use std::collections::HashMap;
use std::path::Path;

use crate::Result;

use super::dialect::decode;
use super::layout::Layout;
use super::monitor::Facts;
use super::names::Quantity;
use super::names::Role;
use super::open::Reopenable;
use super::row::{ACCEL, GYRO, TEMPERATURE};
use super::rows::{Finished, Row, Rows, Source};
use super::text::{OpenFile, open_rows};
use super::timing::Treatment;
use super::{AccelUnit, Finding, Labels, LineMap, ReadOptions, Recording, metadata};

/// Reads the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// What keeps it from being read: `not-found`, `empty-file`, `no-rows`,
/// `no-accelerometer`, `columns-unknown`, `all-zero` …, each with the file and
/// what to do. Everything less is a [`Finding`](super::Finding) of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    collect(Reopenable::of(path), &path.display().to_string(), options)
}

/// Reads a recording that is in memory; `name` stands in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    collect(Reopenable::Memory(bytes.into()), name, options)
}

/// Rows as they come.
#[derive(Default)]
pub(super) struct Columns {
    zero_offset: f64,
    header_unit: Option<AccelUnit>,
    restarted: bool,
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    temperature: Option<Vec<f64>>,
    time_s: Vec<f64>,
    labels: Option<Labels>,
    label_index: HashMap<Vec<u8>, u32>,
    lines: LineMap,
    breaks: Vec<usize>,
}

/// What is known of a recording besides its rows.
#[derive(Default)]
pub(super) struct About {
    pub name: String,
    pub sha256: Option<String>,
    pub description: String,
    pub serial: Option<String>,
    pub column_names: Vec<String>,
    /// About the file.
    pub findings: Vec<Finding>,
}

impl Columns {
    /// Without rows, for the channels of `layout`.
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

    /// All that `rows` has.
    ///
    /// # Errors
    ///
    /// What reading reports.
    pub fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        while let Some(row) = rows.next_row()? {
            self.push(&row);
        }
        Ok(())
    }

    #[inline]
    fn push(&mut self, row: &Row<'_>) {
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
        if number > 0 && (row.restarted || !row.before.is_empty()) {
            self.breaks.push(number);
        }
        self.time_s.push(row.t_s);
        self.lines.push(row.line);
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

    /// The recording, by what all rows came to.
    pub fn into_recording(self, about: About, mut finished: Finished, facts: &Facts) -> Recording {
        let mut findings = about.findings;
        findings.extend(finished.findings());
        for finding in &mut findings {
            finding.file = Some(about.name.clone());
        }
        let found = finished.facts;
        let rows = self.time_s.len();
        let even_hz = |facts: &Facts| {
            facts
                .stamp_reading
                .and_then(|stamp_reading| stamp_reading.even_hz)
        };
        let time_s = facts
            .stamp_reading
            .map(|_| match even_hz(facts).and(even_hz(&found)) {
                // The mean rate of all rows is better than that of the first.
                Some(rate_hz) => (0..rows).map(|row| row as f64 / rate_hz).collect(),
                None => self.time_s,
            });
        Recording {
            name: about.name,
            sha256: about.sha256,
            description: about.description,
            serial: about.serial,
            column_names: about.column_names,
            accel: self.accel,
            gyro: self.gyro,
            gyro_file: None,
            temperature_c: self.temperature,
            time_s,
            time_origin_s: finished.origin_s,
            restarted: self.restarted,
            labels: self.labels,
            breaks: self.breaks,
            zero_offset: facts.zero_offset,
            accel_scale: found.accel,
            unit_doubt: finished.unit_doubt,
            header_unit: self.header_unit,
            gyro_scale: found.gyro,
            resolution: found.resolution,
            timing: finished.timing,
            ledger: finished.ledger,
            findings,
            line_map: self.lines,
            facts: *facts,
        }
    }
}

/// All rows; once more where the first of them were misleading.
fn collect(mut source: Reopenable, name: &str, options: &ReadOptions) -> Result<Recording> {
    let input = source.open(options.hash)?;
    let file = open_rows(input, name, Role::Recording, options, None)?;
    let first = read_all(file, name)?;
    if first.finished.facts.agrees(&first.facts) {
        return Ok(first.into_recording());
    }
    let Some(input) = source.again(options.hash)? else {
        return Ok(first.into_recording());
    };
    let found = first.finished.facts;
    drop(first);
    let file = open_rows(input, name, Role::Recording, options, Some(found))?;
    Ok(read_all(file, name)?.into_recording())
}

/// A file whose rows are all there.
struct Collected {
    columns: Columns,
    about: About,
    finished: Finished,
    /// What they were read by.
    facts: Facts,
}

impl Collected {
    /// Where the rows were read by what all of them contradict, that is said.
    fn into_recording(mut self) -> Recording {
        let contradicted = self.facts.contradicted_by(&self.finished.facts);
        self.about.findings.extend(contradicted);
        self.columns
            .into_recording(self.about, self.finished, &self.facts)
    }
}

fn read_all(file: OpenFile, name: &str) -> Result<Collected> {
    let mut file = file.holding_any_number();
    let facts = *file.rows.facts();
    let mut columns = Columns::new(&file.format.layout, &facts);
    columns.collect(&mut file.rows)?;
    let dialect = &file.format.dialect;
    let serial = metadata::serial(&dialect.metadata);
    let column_names = dialect.header.as_ref().map(|h| h.names.clone());
    let read = file.finish(Treatment::Repaired)?;
    let about = About {
        name: name.to_owned(),
        sha256: read.sha256,
        description: read.description,
        serial,
        column_names: column_names.unwrap_or_default(),
        findings: read.findings,
    };
    Ok(Collected {
        columns,
        about,
        finished: read.finished,
        facts,
    })
}
