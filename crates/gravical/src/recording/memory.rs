//! Recordings from samples in memory.

use crate::finding::Finding;
use crate::{Error, Result};

use super::collect::{About, Collected, Columns, Sink};
use super::head::determine_facts;
use super::layout::{Layout, table_layout};
use super::ledger::Aside;
use super::monitor::RecordingClaims;
use super::names::Quantity;
use super::row::{RowStamps, SLOTS, TIME, Values};
use super::rows::{Item, Rows, Source, Text};
use super::{ReadOptions, Recording};

/// Samples of one sensor as columns of equal length; missing values are NaN.
///
/// Units are given in [`ReadOptions`], or determined as for a file.
#[derive(Debug, Clone, Copy, Default)]
pub struct SampleColumns<'a> {
    /// Time stamps.
    pub time: Option<&'a [f64]>,
    /// Specific force along x, y, z.
    pub accel: [&'a [f64]; 3],
    /// Angular rate about x, y, z.
    pub gyro: Option<[&'a [f64]; 3]>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<&'a [f64]>,
}

impl SampleColumns<'_> {
    fn len(&self) -> usize {
        self.accel[0].len()
    }

    fn even(&self) -> bool {
        let all = self.accel.iter().chain(self.gyro.iter().flatten());
        let others = self.time.iter().chain(self.temperature_c.iter());
        all.chain(others).all(|column| column.len() == self.len())
    }

    fn layout(&self) -> Layout {
        let quantities = self.columns().into_iter().map(|(quantity, _)| quantity);
        Layout {
            fields: quantities
                .enumerate()
                .map(|(field, quantity)| (quantity, field))
                .collect(),
            ..Layout::default()
        }
    }

    fn columns(&self) -> Vec<(Quantity, &[f64])> {
        let accel = (0..3).map(|i| (Quantity::Accel(i), self.accel[i]));
        let gyro = self.gyro.into_iter();
        let gyro = gyro.flat_map(|g| (0..3).map(move |i| (Quantity::Gyro(i), g[i])));
        let time = self.time.map(|c| (Quantity::Time, c));
        let temperature = self.temperature_c.map(|c| (Quantity::Temperature, c));
        let all = time.into_iter().chain(accel).chain(gyro);
        all.chain(temperature).collect()
    }
}

/// A column of a table in memory.
#[derive(Debug, Clone, Copy)]
pub enum TableColumn<'a> {
    /// Numbers; missing ones are NaN.
    Numbers(&'a [f64]),
    /// Texts, such as the labels of poses.
    Texts(&'a [String]),
}

impl<'a> TableColumn<'a> {
    fn len(self) -> usize {
        match self {
            TableColumn::Numbers(values) => values.len(),
            TableColumn::Texts(texts) => texts.len(),
        }
    }

    fn number(self, row: usize) -> f64 {
        match self {
            TableColumn::Numbers(values) => values[row],
            TableColumn::Texts(_) => f64::NAN,
        }
    }

    fn numbers(self) -> Option<&'a [f64]> {
        match self {
            TableColumn::Numbers(values) => Some(values),
            TableColumn::Texts(_) => None,
        }
    }
}

impl Recording {
    /// Creates a recording from samples in memory; `name` is used in messages. Clock, units,
    /// empty cells and faults are evaluated as for a file; a "line" is a sample, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths; `no-rows`, `no-values`,
    /// `all-zero` as [`read`](super::read).
    ///
    /// # Example
    ///
    /// ```
    /// use gravical::recording::{ReadOptions, Recording, SampleColumns};
    ///
    /// let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
    /// let (x, z) = ([0.1; 100], [9.8; 100]);
    /// let samples = SampleColumns {
    ///     time: Some(&time),
    ///     accel: [&x, &x, &z],
    ///     ..SampleColumns::default()
    /// };
    /// let recording = Recording::from_samples("desk", &samples, &ReadOptions::default())?;
    /// assert_eq!(recording.accel_scale.unit.name(), "m/s^2");
    /// # Ok::<(), gravical::Error>(())
    /// ```
    pub fn from_samples(
        name: &str,
        samples: &SampleColumns<'_>,
        options: &ReadOptions,
    ) -> Result<Self> {
        options.validate()?;
        if !samples.even() {
            return Err(Error::usage(
                "samples-length",
                "the columns of samples have different lengths",
            )
            .at(name.as_ref(), None)
            .with_hint("give one value of each for every sample, NaN where there is none"));
        }
        let columns = samples.columns();
        let about = About {
            description: "samples in memory".to_owned(),
            ..About::default()
        };
        let rows = ColumnRows {
            slots: columns
                .iter()
                .filter_map(|(quantity, column)| Some((quantity.slot()?, *column)))
                .collect(),
            rows: samples.len(),
            ..ColumnRows::default()
        };
        collect(name, samples.layout(), options, about, &rows)
    }

    /// Creates a recording from a table in memory, such as a data frame: `columns` are recognised
    /// by `names`, as those of a file by its header, or, with no names, by their numbers. A "line"
    /// is a row of the table, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths; `no-accelerometer`,
    /// `columns-unknown`, `columns-missing` and what else [`read`](super::read) says of columns
    /// that are not recognised; `no-rows`, `no-values`, `all-zero`.
    ///
    /// # Example
    ///
    /// ```
    /// use gravical::recording::{ReadOptions, Recording, TableColumn};
    ///
    /// let time: Vec<f64> = (0..100).map(|i| 10.0 * f64::from(i)).collect();
    /// let (x, z) = ([0.01; 100], [1.0; 100]);
    /// let columns = [&time[..], &x, &x, &z].map(TableColumn::Numbers);
    /// let names = ["t [ms]", "acc_x", "acc_y", "acc_z"].map(str::to_owned);
    /// let recording = Recording::from_table("desk", &names, &columns, &ReadOptions::default())?;
    /// assert_eq!(recording.accel_scale.unit.name(), "g");
    /// assert_eq!(recording.timing.median_rate_hz.map(f64::round), Some(100.0));
    /// # Ok::<(), gravical::Error>(())
    /// ```
    pub fn from_table(
        name: &str,
        names: &[String],
        columns: &[TableColumn<'_>],
        options: &ReadOptions,
    ) -> Result<Self> {
        let (layout, findings) = recognised(name, names, columns, options)?;
        let rows = columns.first().map_or(0, |c| c.len());
        let numbers = |field: usize| columns.get(field).and_then(|c| c.numbers());
        let mut slots = Vec::new();
        for (quantity, field) in &layout.fields {
            match (quantity.slot(), numbers(*field)) {
                (Some(slot), Some(column)) => slots.push((slot, column)),
                (Some(_), None) => {
                    return Err(Error::input(
                        "no-values",
                        format!("column {} holds texts, not numbers", field + 1),
                    )
                    .at(name.as_ref(), None)
                    .with_hint(
                        "convert it to numbers, or name other columns: --columns t=…,ax=…",
                    ));
                }
                (None, _) => {}
            }
        }
        let label = layout
            .field(Quantity::Label)
            .and_then(|field| match columns.get(field) {
                Some(TableColumn::Texts(texts)) => Some(*texts),
                _ => None,
            });
        let with = |of: Option<(usize, f64)>| of.and_then(|(field, x)| Some((numbers(field)?, x)));
        let source = ColumnRows {
            slots,
            label,
            fraction: with(layout.fraction),
            instance: with(layout.instance),
            stamps: layout.stamps(),
            rows,
            next: 0,
        };
        let about = About {
            description: "table in memory".to_owned(),
            column_names: names.to_vec(),
            is_calibrated: layout.reads_calibrated(names),
            findings,
            ..About::default()
        };
        collect(name, layout, options, about, &source)
    }
}

impl Recording {
    /// The channels of a table in memory (`t`, `ax` … `gz`, `temperature`), each with its column
    /// from 0, as [`from_table`](Self::from_table) recognises them.
    ///
    /// # Errors
    ///
    /// Those of [`from_table`](Self::from_table) about columns.
    pub fn table_fields(
        name: &str,
        names: &[String],
        columns: &[TableColumn<'_>],
        options: &ReadOptions,
    ) -> Result<Vec<(&'static str, usize)>> {
        /// By slot.
        const CHANNELS: [&str; SLOTS] = ["t", "ax", "ay", "az", "gx", "gy", "gz", "temperature"];
        let (layout, _) = recognised(name, names, columns, options)?;
        let channel =
            |(quantity, field): &(Quantity, usize)| Some((CHANNELS[quantity.slot()?], *field));
        Ok(layout.fields.iter().filter_map(channel).collect())
    }
}

/// The columns of a table by what they hold.
fn recognised(
    name: &str,
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<(Layout, Vec<Finding>)> {
    options.validate()?;
    let rows = columns.first().map_or(0, |c| c.len());
    let named = names.is_empty() || names.len() == columns.len();
    if columns.iter().any(|c| c.len() != rows) || !named {
        return Err(Error::usage(
            "samples-length",
            "the columns of the table have different lengths",
        )
        .at(name.as_ref(), None)
        .with_hint(
            "give every column one value for each row, NaN where there is none, and one name",
        ));
    }
    let sample = (0..rows.min(SAMPLE)).map(|row| columns.iter().map(|c| c.number(row)).collect());
    let mut findings = Vec::new();
    let layout = table_layout(name, names, sample.collect(), options, &mut findings)?;
    Ok((layout, findings))
}

/// Number of rows by which columns without names are recognised, as of a file.
const SAMPLE: usize = 200;

fn collect(
    name: &str,
    layout: Layout,
    options: &ReadOptions,
    about: About,
    source: &ColumnRows<'_>,
) -> Result<Recording> {
    let claims = RecordingClaims {
        layout,
        options: options.clone(),
        metadata_rate_hz: None,
    };
    // Facts are determined from all samples.
    let rows =
        |facts| Rows::new(source.clone(), name, claims.clone(), facts).expecting(source.rows);
    let facts = determine_facts(rows);
    let mut rows = rows(facts);
    let mut columns = Columns::new(&claims.layout, &facts);
    columns.collect(&mut rows)?;
    let finished = rows.finish()?;
    let read = Collected {
        rows: columns,
        about: About {
            name: name.to_owned(),
            ..about
        },
        finished,
        facts,
        zeros_from: None,
    };
    Ok(read.into_recording())
}

/// Source of rows.
#[derive(Clone)]
struct ColumnRows<'a> {
    slots: Vec<(usize, &'a [f64])>,
    label: Option<&'a [String]>,
    /// The fraction of a second of the time stamp, and its unit in s.
    fraction: Option<(&'a [f64], f64)>,
    /// Only rows with this value are of the sensor.
    instance: Option<(&'a [f64], f64)>,
    stamps: RowStamps,
    rows: usize,
    next: usize,
}

impl Default for ColumnRows<'_> {
    fn default() -> Self {
        ColumnRows {
            slots: Vec::new(),
            label: None,
            fraction: None,
            instance: None,
            stamps: RowStamps::new(false),
            rows: 0,
            next: 0,
        }
    }
}

impl Source for ColumnRows<'_> {
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        let row = self.next;
        if row >= self.rows {
            return Ok(None);
        }
        self.next += 1;
        if self
            .instance
            .is_some_and(|(column, value)| column[row] != value)
        {
            return Ok(Some(Item::Aside(Aside::OtherSensor)));
        }
        values.fill(f64::NAN);
        for (slot, column) in &self.slots {
            // An infinite number is no reading, as in a file.
            values[*slot] = if column[row].is_finite() {
                column[row]
            } else {
                f64::NAN
            };
        }
        if let Some((column, unit_s)) = self.fraction {
            values[TIME] += column[row] * unit_s;
        }
        self.stamps.stamp(values);
        Ok(Some(Item::Row))
    }

    fn number(&self) -> u64 {
        self.next as u64
    }

    fn text(&self) -> Text<'_> {
        let row = self.next.wrapping_sub(1);
        let label = self.label.and_then(|texts| texts.get(row));
        Text {
            label: label.map_or(&[], |text| text.as_bytes()),
            ..Text::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{FindingKind, read_bytes};

    #[test]
    fn samples_and_their_text_give_equal_recordings() {
        let wave = |i: u32, k: f64| (f64::from(i) * k).sin();
        let rows: Vec<[f64; 8]> = (0..4000)
            .map(|i| {
                let value = |k| (1e4 * (0.02 * wave(i, k))).round() / 1e4;
                let t = 10.0 * f64::from(i) + if i > 2000 { 700.0 } else { 0.0 };
                let mut row = [
                    t,
                    value(0.7),
                    value(1.3),
                    9.8 + value(2.1),
                    0.0,
                    0.0,
                    0.0,
                    25.0,
                ];
                (4..7).for_each(|k| row[k] = value(0.9 * k as f64));
                if i % 1000 == 17 {
                    row[1..7].fill(0.0);
                }
                row
            })
            .collect();
        let mut text = "t_ms,ax,ay,az,gx (rad/s),gy (rad/s),gz (rad/s),temp (C)\n".to_owned();
        for row in &rows {
            let cells: Vec<String> = row.iter().map(ToString::to_string).collect();
            text += &(cells.join(",") + "\n");
        }
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..8).map(column).collect();
        let samples = SampleColumns {
            time: Some(&columns[0]),
            accel: [&columns[1], &columns[2], &columns[3]],
            gyro: Some([&columns[4], &columns[5], &columns[6]]),
            temperature_c: Some(&columns[7]),
        };
        let options = ReadOptions {
            time_unit: Some(super::super::TimeUnit::Millisecond),
            ..ReadOptions::default()
        };
        let own = Recording::from_samples("memory", &samples, &options).unwrap();
        let read = read_bytes(text.as_bytes(), "memory", &options).unwrap();
        assert_eq!((own.rows(), &own.timing), (read.rows(), &read.timing));
        assert_eq!(own.time_s, read.time_s);
        assert_eq!(own.resolution, read.resolution);
        assert_eq!(own.accel_scale.unit, read.accel_scale.unit);
        assert!(own.accel[0][17].is_nan() && read.accel[0][17].is_nan());
        let kinds = |r: &Recording| r.findings.iter().map(|f| f.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&own), kinds(&read));
        assert!(kinds(&own).contains(&FindingKind::ZeroRows));
        // A sample counts as a line: there is no header.
        assert_eq!(own.line(10) + 1, read.line(10));

        let short = SampleColumns {
            time: Some(&columns[0][1..]),
            ..samples
        };
        let error = Recording::from_samples("memory", &short, &options).unwrap_err();
        assert_eq!(error.code(), "samples-length");
        let none = SampleColumns::default();
        let error = Recording::from_samples("memory", &none, &options).unwrap_err();
        assert_eq!(error.code(), "no-rows");
    }
}
