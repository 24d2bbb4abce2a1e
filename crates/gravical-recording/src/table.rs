//! Recordings from columns in memory.

use crate::error::Error;
use crate::options::ReadOptions;
use crate::recording::Recording;
use crate::role::Role;
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

impl Recording {
    /// Judges a table in memory. Columns are recognised by `names`, as those of a file by its
    /// header, or, with no names, by their numbers. A line is a row of the table, from 1.
    ///
    /// # Errors
    ///
    /// Columns that are not recognised, or a sensor that did not answer.
    pub fn from_table(
        names: &[String],
        columns: &[TableColumn<'_>],
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        let rows = batch(columns);
        let format = recognised(names, &rows, options)?;
        for column in format.channels() {
            if let Some(TableColumn::Texts(_)) = columns.get(column) {
                let text = format!("column {} holds texts, not numbers", column + 1);
                return Err(Error::input("no-values", text).with_hint(
                    "convert it to numbers, or name other columns: --columns t=…,ax=…",
                ));
            }
        }
        let mut recording = Recording::judge(&format, rows)?;
        recording.description = "table in memory".to_owned();
        Ok(recording)
    }
}

/// The channels of a table (`t`, `ax` … `gz`, `temperature`), each with its column from 0.
///
/// # Errors
///
/// Columns that are not recognised.
pub fn table_channels(
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<Vec<(&'static str, usize)>, Error> {
    let format = recognised(names, &batch(columns), options)?;
    let first = |role| format.columns.iter().position(|c| c.role == role);
    let mut channels = Vec::new();
    channels.extend(first(Role::Time).map(|c| ("t", c)));
    channels.extend(["ax", "ay", "az"].into_iter().zip(format.accel));
    channels.extend(
        format
            .gyro
            .into_iter()
            .flat_map(|g| ["gx", "gy", "gz"].into_iter().zip(g)),
    );
    channels.extend(first(Role::Temperature).map(|c| ("temperature", c)));
    channels.sort_by_key(|(_, column)| *column);
    Ok(channels)
}

fn recognised(names: &[String], rows: &Batch, options: &ReadOptions) -> Result<Format, Error> {
    Format::of_table(names, rows.columns.len(), &rows.first(SAMPLE_ROWS), options)
}

fn batch(columns: &[TableColumn<'_>]) -> Batch {
    let rows = columns.first().map_or(0, |c| c.rows());
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
    batch.aside.lines = rows;
    batch
}
