//! Columns of rows that arrive one by one, before there is a file.

use super::clock::{self, first_column_rises};
use super::spec::Given;
use super::{ColumnsSpec, Layout, Request, find, understand_all};
use crate::Result;
use crate::recording::dialect::Dialect;
use crate::recording::names::Quantity;

/// The columns of rows that a program receives, as [`Layout`] has them for a file: by `columns`,
/// else by the names of a header, else by the numbers of the sample (some hundred rows make it
/// certain). A header may come before the first row: then the names alone decide.
///
/// Unlike a file, a stream need not have an accelerometer: where none is recognised, the
/// layout holds the time alone, or nothing.
///
/// # Errors
///
/// `columns-missing` (usage) when `columns` names a column that does not exist.
pub fn stream_layout(dialect: &Dialect, columns: Option<&ColumnsSpec>) -> Result<Layout> {
    let request = Request {
        columns,
        ..Request::default()
    };
    match find(dialect, request) {
        Err(error) if error.is_usage() => Err(error),
        Err(_) => time_alone(dialect, columns),
        found => found,
    }
}

/// The layout of rows in which no accelerometer is recognised.
fn time_alone(dialect: &Dialect, columns: Option<&ColumnsSpec>) -> Result<Layout> {
    let given = Given::of(dialect, columns)?;
    let rows: Vec<&Vec<f64>> = dialect.sample.iter().collect();
    let recognised = || match &dialect.header {
        Some(header) => {
            let mut named = understand_all(header, "");
            named.retain(|(field, _)| !given.uses(*field));
            let clock = clock::choose(&rows, &named, &header.names, "");
            clock.map(|clock| clock.field)
        }
        None => {
            let (rises, counts) = first_column_rises(&dialect.sample);
            (rises && !counts && !given.uses(0)).then_some(0)
        }
    };
    let time = given.field(Quantity::Time).or_else(|| {
        let is_given = given.includes(Quantity::Time) || given.includes(Quantity::TimeStep);
        (!is_given).then(recognised)?
    });
    Ok(Layout {
        fields: time
            .map(|field| (Quantity::Time, field))
            .into_iter()
            .collect(),
        ..Layout::default()
    })
}
