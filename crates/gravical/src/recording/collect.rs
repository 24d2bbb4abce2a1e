//! A recording in memory: its rows, collected into columns.

use std::collections::HashMap;
use std::path::Path;

use crate::Result;

use super::dialect::decode;
use super::monitor::Facts;
use super::open::Source;
use super::row::{ACCEL, GYRO, TEMPERATURE};
use super::rows::Row;
use super::text::{OpenFile, Role, open_rows};
use super::timing::Treatment;
use super::{Labels, LineMap, ReadOptions, Recording, metadata};

/// Reads the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// What keeps it from being read: `not-found`, `empty-file`, `no-rows`,
/// `no-accelerometer`, `columns-unknown`, `all-zero` …, each with the file and
/// what to do. Everything less is a [`Finding`](super::Finding) of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    collect(Source::of(path), &path.display().to_string(), options)
}

/// Reads a recording that is in memory; `name` stands in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    collect(Source::Memory(bytes.into()), name, options)
}

/// Rows as they come.
#[derive(Default)]
struct Columns {
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    temperature: Option<Vec<f64>>,
    time_s: Vec<f64>,
    labels: Option<Labels>,
    label_index: HashMap<Vec<u8>, u32>,
    lines: LineMap,
    breaks: Vec<usize>,
}

impl Columns {
    #[inline]
    fn push(&mut self, row: &Row<'_>, zero_offset: f64) {
        let number = self.time_s.len();
        for (i, channel) in self.accel.iter_mut().enumerate() {
            channel.push(row.values[ACCEL + i] - zero_offset);
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
}

/// All rows; once more where the first of them were misleading.
fn collect(mut source: Source, name: &str, options: &ReadOptions) -> Result<Recording> {
    let input = source.open(options.hash)?;
    let file = open_rows(input, name, Role::Recording, options, None)?;
    let facts = *file.rows.facts();
    let (recording, found) = read_all(file, name)?;
    if found.agrees(&facts) {
        return Ok(recording);
    }
    drop(recording);
    let input = source.again(options.hash)?;
    let file = open_rows(input, name, Role::Recording, options, Some(found))?;
    read_all(file, name).map(|(recording, _)| recording)
}

fn read_all(mut file: OpenFile, name: &str) -> Result<(Recording, Facts)> {
    let facts = *file.rows.facts();
    let layout = &file.format.layout;
    let has = |quantity| layout.field(quantity).is_some();
    let mut columns = Columns {
        gyro: layout.has_gyro().then(Default::default),
        temperature: (has(super::names::Quantity::Temperature) && facts.celsius)
            .then(Default::default),
        labels: has(super::names::Quantity::Label).then(Default::default),
        ..Columns::default()
    };
    while let Some(row) = file.rows.next_row()? {
        columns.push(&row, facts.zero_offset);
    }
    let dialect = &file.format.dialect;
    let serial = metadata::serial(&dialect.metadata);
    let column_names = dialect.header.as_ref().map(|h| h.names.clone());
    let read = file.finish(Treatment::Repaired)?;
    let mut finished = read.finished;
    let mut findings = read.findings;
    findings.extend(finished.findings());
    for finding in &mut findings {
        finding.file = Some(name.to_owned());
    }
    let found = finished.facts;
    let time_s = match found.beat {
        // The mean rate of all rows is better than that of the first.
        Some(beat) => Some(match beat.even_hz {
            Some(rate_hz) => (0..columns.time_s.len())
                .map(|row| row as f64 / rate_hz)
                .collect(),
            None => columns.time_s,
        }),
        None => None,
    };
    let recording = Recording {
        name: name.to_owned(),
        sha256: read.sha256,
        description: read.description,
        serial,
        column_names: column_names.unwrap_or_default(),
        accel: columns.accel,
        gyro: columns.gyro,
        gyro_file: None,
        temperature_c: columns.temperature,
        time_s,
        time_origin_s: finished.origin_s,
        labels: columns.labels,
        breaks: columns.breaks,
        zero_offset: facts.zero_offset,
        accel_scale: found.accel,
        gyro_scale: found.gyro,
        resolution: found.resolution,
        timing: finished.timing,
        ledger: finished.ledger,
        findings,
        line_map: columns.lines,
    };
    Ok((recording, found))
}
