//! Recordings from tables in memory.

use std::path::Path;

use gravical_judge::{Error, ReadOptions, Result};

use crate::problem::Problem;
use crate::recording::Recording;
use crate::text::{Format, Rows};

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
    pub fn rows(self) -> usize {
        match self {
            TableColumn::Numbers(values) => values.len(),
            TableColumn::Texts(texts) => texts.len(),
        }
    }
}

impl Recording {
    /// Creates a recording from a table in memory, such as a data frame: `columns` are recognised
    /// by `names`, as those of a file by its header, or, with no names, by their numbers. Clock,
    /// units, empty cells and faults are judged as for a file; a "line" is a row of the table, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths, or names of some only;
    /// `no-accelerometer`, `columns-unknown`, `columns-missing` and what else
    /// [`read`](crate::read()) says of columns that are not recognised; `no-rows`, `no-values`,
    /// `all-zero`.
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
    /// assert_eq!(recording.units.accel.unit.name(), "g");
    /// assert_eq!(recording.clock.median_rate_hz.map(f64::round), Some(100.0));
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
        let mut format =
            Format::of_table(names, columns.len(), &sample, options).map_err(in_file)?;
        format.device = Some("table in memory".to_owned());
        for column in format.channels() {
            if let Some(TableColumn::Texts(_)) = columns.get(column) {
                let column = column + 1;
                return Err(in_file(Problem::TextColumn { column }.into()));
            }
        }
        let judged = Recording::judge(&format, rows).map_err(in_file)?;
        Ok(judged.with_name(name))
    }
}

/// The columns as rows of equal length.
fn table(
    name: &str,
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<Rows> {
    options.validate()?;
    let rows = columns.first().map_or(0, |c| c.rows());
    let named = names.is_empty() || names.len() == columns.len();
    if columns.iter().any(|c| c.rows() != rows) || !named {
        let mut lengths: Vec<usize> = columns.iter().map(|c| c.rows()).collect();
        lengths.sort_unstable();
        lengths.dedup();
        let problem = Problem::SamplesLength {
            columns: columns.len(),
            lengths,
            names: names.len(),
        };
        return Err(problem.error().at(name.as_ref(), None));
    }
    let mut table = Rows::new(columns.len());
    for (at, column) in columns.iter().enumerate() {
        match column {
            // An infinite number is no reading, as in a file.
            TableColumn::Numbers(values) => {
                let finite = |v: &f64| if v.is_finite() { *v } else { f64::NAN };
                table.columns[at] = values.iter().map(finite).collect();
            }
            TableColumn::Texts(texts) => {
                table.columns[at] = vec![f64::NAN; rows];
                for text in *texts {
                    table.push_word(at, text);
                }
            }
        }
    }
    table.lines = (1..=rows as u32).collect();
    table.ledger.lines = rows;
    Ok(table)
}
