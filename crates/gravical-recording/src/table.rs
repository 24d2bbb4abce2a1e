//! Recordings from samples and tables in memory.

use std::path::Path;

use crate::error::{Error, Result};
use crate::options::ReadOptions;
use crate::recording::Recording;
use crate::text::{Batch, Format};

/// Rows by which columns without names are recognised.
const SAMPLE_ROWS: usize = 400;

/// A column of a table in memory.
#[derive(Debug, Clone, Copy)]
pub enum TableColumn<'a> {
    /// Numbers; missing ones are NaN.
    Numbers(&'a [f64]),
    /// Texts, such as the labels of poses.
    Texts(&'a [String]),
}

impl TableColumn<'_> {
    /// Number of rows.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            TableColumn::Numbers(values) => values.len(),
            TableColumn::Texts(texts) => texts.len(),
        }
    }
}

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
    /// The columns with the names of their channels.
    fn columns(&self) -> Vec<(&'static str, &[f64])> {
        let accel = ["ax", "ay", "az"].into_iter().zip(self.accel);
        let gyro = self.gyro.into_iter();
        let gyro = gyro.flat_map(|g| ["gx", "gy", "gz"].into_iter().zip(g));
        let time = self.time.map(|c| ("t", c));
        let temperature = self.temperature_c.map(|c| ("temperature", c));
        let all = time.into_iter().chain(accel).chain(gyro);
        all.chain(temperature).collect()
    }
}

impl Recording {
    /// Creates a recording from samples in memory; `name` is used in messages. Clock, units,
    /// empty cells and faults are evaluated as for a file; a "line" is a sample, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths; `no-rows`, `no-values`,
    /// `all-zero` as [`read`](crate::read()).
    ///
    /// # Example
    ///
    /// ```
    /// use gravical_recording::{ReadOptions, Recording, SampleColumns};
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
    /// # Ok::<(), gravical_recording::Error>(())
    /// ```
    pub fn from_samples(
        name: &str,
        samples: &SampleColumns<'_>,
        options: &ReadOptions,
    ) -> Result<Self> {
        let numbers = |(name, values): (&str, _)| (name.to_owned(), TableColumn::Numbers(values));
        let columns = samples.columns().into_iter().map(numbers);
        let (names, columns): (Vec<String>, Vec<TableColumn<'_>>) = columns.unzip();
        let mut recording = Recording::from_table(name, &names, &columns, options)?;
        recording.column_names.clear();
        recording.description = "samples in memory".to_owned();
        Ok(recording)
    }

    /// Creates a recording from a table in memory, such as a data frame: `columns` are recognised
    /// by `names`, as those of a file by its header, or, with no names, by their numbers. A "line"
    /// is a row of the table, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths; `no-accelerometer`,
    /// `columns-unknown`, `columns-missing` and what else [`read`](crate::read()) says of columns
    /// that are not recognised; `no-rows`, `no-values`, `all-zero`.
    ///
    /// # Example
    ///
    /// ```
    /// use gravical_recording::{ReadOptions, Recording, TableColumn};
    ///
    /// let time: Vec<f64> = (0..100).map(|i| 10.0 * f64::from(i)).collect();
    /// let (x, z) = ([0.01; 100], [1.0; 100]);
    /// let columns = [&time[..], &x, &x, &z].map(TableColumn::Numbers);
    /// let names = ["t [ms]", "acc_x", "acc_y", "acc_z"].map(str::to_owned);
    /// let recording = Recording::from_table("desk", &names, &columns, &ReadOptions::default())?;
    /// assert_eq!(recording.accel_scale.unit.name(), "g");
    /// assert_eq!(recording.timing.median_rate_hz.map(f64::round), Some(100.0));
    /// # Ok::<(), gravical_recording::Error>(())
    /// ```
    pub fn from_table(
        name: &str,
        names: &[String],
        columns: &[TableColumn<'_>],
        options: &ReadOptions,
    ) -> Result<Self> {
        let rows = table(name, names, columns, options)?;
        let in_file = |e: Error| e.in_file(Path::new(name));
        let sample = rows.slice(0..SAMPLE_ROWS);
        let format = Format::of_table(names, columns.len(), &sample, options).map_err(in_file)?;
        for column in format.channels() {
            if let Some(TableColumn::Texts(_)) = columns.get(column) {
                let text = format!("column {} holds texts, not numbers", column + 1);
                let error = Error::input("no-values", text)
                    .with_hint("convert it to numbers, or name other columns, as t=…,ax=…")
                    .advise("columns", "");
                return Err(in_file(error));
            }
        }
        let judged = Recording::judge(&format, rows).map_err(in_file)?;
        let mut recording = judged.with_name(name);
        recording.description = "table in memory".to_owned();
        Ok(recording)
    }
}

/// The columns as rows of equal length.
fn table(
    name: &str,
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<Batch> {
    options.validate()?;
    let rows = columns.first().map_or(0, |c| c.rows());
    let named = names.is_empty() || names.len() == columns.len();
    if columns.iter().any(|c| c.rows() != rows) || !named {
        return Err(Error::usage(
            "samples-length",
            "the columns of the table have different lengths",
        )
        .at(name.as_ref(), None)
        .with_hint(
            "give every column one value for each row, NaN where there is none, and one name",
        ));
    }
    let mut batch = Batch::new(columns.len());
    for (at, column) in columns.iter().enumerate() {
        match column {
            // An infinite number is no reading, as in a file.
            TableColumn::Numbers(values) => {
                let finite = |v: &f64| if v.is_finite() { *v } else { f64::NAN };
                batch.columns[at] = values.iter().map(finite).collect();
            }
            TableColumn::Texts(texts) => {
                batch.columns[at] = vec![f64::NAN; rows];
                for text in *texts {
                    batch.push_word(at, text);
                }
            }
        }
    }
    batch.lines = (1..=rows as u32).collect();
    batch.ledger.lines = rows;
    Ok(batch)
}
