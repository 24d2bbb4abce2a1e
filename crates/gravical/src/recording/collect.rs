//! Reading of a recording into columns in memory.

use std::collections::HashMap;

use crate::{Error, Result};

use super::dialect::decode;
use super::layout::Layout;
use super::ledger::Ledger;
use super::monitor::{Facts, MonitorSummary};
use super::names::Quantity;
use super::row::{ACCEL, GYRO, TEMPERATURE};
use super::rows::Row;
use super::{AccelUnit, Finding, Labels, Recording};

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
    lines: Vec<u32>,
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
            self.push_label(row.label.trim_ascii());
        }
        self.restarted |= row.restarted;
        if number > 0 && is_break {
            self.breaks.push(number);
        }
        self.time_s.push(row.t_s);
        self.lines.push(u32::try_from(row.line).unwrap_or(u32::MAX));
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

/// A recording that was read to its end.
pub(crate) struct Collected {
    pub rows: Columns,
    pub about: About,
    /// Of all rows so far, whatever facts they were read with.
    pub summary: MonitorSummary,
    /// What the rows were read with.
    pub facts: Facts,
}

impl Collected {
    /// The recording. If its rows were read with facts that all rows contradict, a finding
    /// reports it.
    pub fn into_recording(mut self) -> Recording {
        // Of evenly spaced rows the mean rate of all is more accurate than that of the first ones.
        let even_hz = |facts: &Facts| facts.stamp_reading.and_then(|reading| reading.even_hz);
        let even_hz = even_hz(&self.facts).and(even_hz(&self.summary.facts));
        let Columns {
            accel,
            gyro,
            temperature,
            labels,
            breaks,
            lines,
            ..
        } = self.rows;
        let contradicted = self.facts.contradicted_by(&self.summary.facts);
        let mut findings = self.about.findings;
        findings.extend(contradicted);
        let said = std::mem::take(&mut self.summary.found);
        findings.extend(said.channels);
        findings.extend(said.clock);
        findings.extend(said.cells);
        findings.extend(said.unit);
        findings.extend(said.values);
        for finding in &mut findings {
            finding.file = Some(self.about.name.clone());
        }
        let found = self.summary.facts;
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
            time_origin_s: self.summary.origin_s,
            stated_start_s: self.about.stated_start_s,
            restarted: self.rows.restarted,
            labels,
            breaks,
            zero_offset: self.facts.zero_offset,
            accel_scale: found.accel,
            unit_doubt: self.summary.unit_doubt,
            header_unit: self.rows.header_unit,
            gyro_scale: found.gyro,
            resolution: found.resolution,
            timing: self.summary.timing,
            ledger: Ledger::default(),
            findings,
            lines,
        }
    }
}
