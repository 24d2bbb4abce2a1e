//! What is said where columns are not understood.

use super::clocks;
use crate::error::Error;
use crate::role::Role;
use crate::text::format::Format;
use crate::text::rows::Rows;

pub(super) fn columns_unknown(format: &Format, sample: &Rows) -> Error {
    if let Some(error) = too_few_axes(format, sample) {
        return error;
    }
    let columns = format.columns.len();
    let text = match &format.misfit {
        Some(misfit) => format!("{misfit}, and the numbers do not show their meaning"),
        None => format!(
            "the file has no header and {columns} columns whose meaning the numbers do not show"
        ),
    };
    Error::input("columns-unknown", text)
        .with_hint("name them in order, as t,ax,ay,az,gx,gy,gz; - skips one")
        .advise("columns", "")
}

/// `no-accelerometer` where fewer than three columns can be axes: then none can be assigned.
fn too_few_axes(format: &Format, sample: &Rows) -> Option<Error> {
    let may_be_axis = |c: &usize| {
        let (column, values) = (&format.columns[*c], &sample.columns[*c]);
        let is_other = matches!(column.role, Role::Time | Role::Step) || column.is_dated;
        !is_other && !sample.is_text(*c) && !clocks::rises(values)
    };
    let axes = (0..format.columns.len()).filter(may_be_axis).count();
    let text = format!("{axes} of the columns may be axes, but an accelerometer has three");
    let hint = "record x, y and z of the accelerometer";
    (axes < 3).then(|| Error::input("no-accelerometer", text).with_hint(hint))
}

pub(super) fn no_gyroscope(names: &[String]) -> Error {
    let text = "no three columns of this file are a gyroscope's x, y and z";
    let columns = list_columns(names);
    let columns = columns.split(';').next().unwrap_or_default();
    Error::input("no-gyroscope", text)
        .with_hint(format!(
            "{columns}; give the file with the gyroscope, or name its columns, as gx=…,gy=…,gz=…"
        ))
        .advise("gyro", "")
        .advise("columns", "")
}

pub(super) fn no_accelerometer(has_gyroscope: bool, format: &Format, sample: &Rows) -> Error {
    if has_gyroscope {
        let text = "this file holds a gyroscope and no accelerometer";
        let error = Error::input("gyroscope-alone", text);
        return error
            .with_hint("give the accelerometer's recording as the input, and this file beside it")
            .advise("gyro", "");
    }
    if let Some(error) = too_few_axes(format, sample) {
        return error;
    }
    let text = "no three columns are named as an accelerometer's x, y and z";
    let error = Error::input("no-accelerometer", text)
        .with_hint(list_columns(&format.names))
        .advise("columns", "");
    match format.header_line {
        0 => error,
        line => error.at_line(line),
    }
}

/// `sensor-unknown`: there is no sensor `wanted` among these.
pub(crate) fn sensor_unknown(wanted: &str, sensors: &[String]) -> Error {
    let error = Error::usage("sensor-unknown", format!("there is no sensor {wanted}"));
    error.of_option("sensor").with_hint(if sensors.len() < 2 {
        "this file has one sensor: leave the option out".to_owned()
    } else {
        format!("give one of: {}", sensors.join(", "))
    })
}

/// Names of columns that a hint lists.
const MAX_LISTED: usize = 16;

/// A hint that lists the columns of a file.
pub(super) fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as t,ax,ay,az".to_owned();
    }
    let names = names.iter().map(String::as_str);
    let list: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
    let more = if list.len() > MAX_LISTED { ", …" } else { "" };
    let shown = list[..list.len().min(MAX_LISTED)].join(", ");
    format!("its columns are: {shown}{more}; assign them, as ax=…,ay=…,az=…")
}
