//! Columns of rows that arrive one by one, before there is a file.

use super::clock::{self, first_column_rises};
use super::spec::Given;
use super::{ColumnsSpec, Layout, Request, find, understand_all};
use crate::Result;
use crate::finding::Finding;
use crate::recording::ReadOptions;
use crate::recording::dialect::Dialect;
use crate::recording::names::{Quantity, Role};
use crate::recording::row::Delimiter;

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
    match find(Role::Recording, dialect, request, &mut Vec::new()) {
        Err(error) if error.is_usage() => Err(error),
        Err(_) => time_alone(dialect, columns),
        found => found,
    }
}

/// The columns of a table in memory, as those of a file; none of the `names` for a table without.
///
/// # Errors
///
/// As [`find`].
pub(in crate::recording) fn table_layout(
    file: &str,
    names: &[String],
    sample: Vec<Vec<f64>>,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
) -> Result<Layout> {
    let fields = sample.first().map_or(names.len(), Vec::len);
    let names = (!names.is_empty()).then(|| names.to_vec());
    let dialect = Dialect::of_columns(Delimiter::Byte(b','), fields, names, sample);
    let request = Request {
        columns: options.columns.as_ref(),
        sensor: options.sensor.as_deref(),
        file,
    };
    let found = find(Role::Recording, &dialect, request, findings);
    found.map_err(|error| error.in_file(file.as_ref()))
}

/// The layout of rows in which no accelerometer is recognised.
fn time_alone(dialect: &Dialect, columns: Option<&ColumnsSpec>) -> Result<Layout> {
    let given = Given::of(dialect, columns, Role::Recording)?;
    let rows: Vec<&Vec<f64>> = dialect.sample.iter().collect();
    let recognised = || match &dialect.header {
        Some(header) => {
            let mut named = understand_all(header, "", Role::Recording);
            named.retain(|(field, _)| !given.uses(*field));
            let clock = clock::choose(&rows, &named, &header.names, "", &mut Vec::new());
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(layout: &Layout) -> Vec<(Quantity, usize)> {
        layout.fields.clone()
    }

    fn names(text: &str) -> Vec<String> {
        text.split(',').map(str::to_owned).collect()
    }

    #[test]
    fn names_alone_decide_before_the_first_row() {
        let of = |text: &str| {
            let names = names(text);
            let comma = Delimiter::Byte(b',');
            let dialect = Dialect::of_columns(comma, names.len(), Some(names), Vec::new());
            stream_layout(&dialect, None)
        };
        let layout = of("ms,ax,ay,az,mx,my,mz").unwrap();
        use Quantity::{Accel, Time};
        assert_eq!(
            fields(&layout),
            [(Time, 0), (Accel(0), 1), (Accel(1), 2), (Accel(2), 3)]
        );
        let layout = of("x,y,z").unwrap();
        assert_eq!(fields(&layout), [0, 1, 2].map(|i| (Accel(i), i)));
        let layout = of("dt,ax,ay,az").unwrap();
        assert!(layout.sums_time && layout.field(Time) == Some(0));
        // A temperature and a pressure.
        assert_eq!(fields(&of("foo,bar,millis").unwrap()), [(Time, 2)]);
        assert!(of("foo,bar,baz").unwrap().fields.is_empty());
    }

    #[test]
    fn numbers_decide_without_names_and_the_option_before_both() {
        let rows = |first: fn(usize) -> f64, fields: usize| -> Vec<Vec<f64>> {
            let value = |k: usize| [0.1, -0.2, 9.8, 0.01, 0.02, 0.03][k % 6];
            let noise = |i: usize, k: usize| (i * 7919 + k * 31) as f64 % 13.0 * 0.001;
            let row = |i: usize| {
                let rest = (0..fields - 1).map(|k| value(k) + noise(i, k));
                [first(i)].into_iter().chain(rest).collect()
            };
            (0..50).map(row).collect()
        };
        let stream_layout = |fields, sample: &[Vec<f64>], spec| {
            let comma = Delimiter::Byte(b',');
            stream_layout(
                &Dialect::of_columns(comma, fields, None, sample.to_vec()),
                spec,
            )
        };
        let stamped = rows(|i| 10.0 * i as f64, 7);
        let layout = stream_layout(7, &stamped, None).unwrap();
        assert_eq!(layout.field(Quantity::Time), Some(0));
        assert_eq!(layout.field(Quantity::Accel(2)), Some(3));
        // Eleven numbers have no meaning of their own, but the first is a clock.
        let eleven = rows(|i| 10.0 * i as f64, 11);
        let layout = stream_layout(11, &eleven, None).unwrap();
        assert_eq!(fields(&layout), [(Quantity::Time, 0)]);
        let spec: ColumnsSpec = "t,gx,gy,gz,ax,ay,az".parse().unwrap();
        let layout = stream_layout(11, &eleven, Some(&spec)).unwrap();
        assert_eq!(layout.field(Quantity::Accel(0)), Some(4));
        let error = stream_layout(3, &[], Some(&spec)).unwrap_err();
        assert_eq!(error.code(), "columns-missing");
    }
}
