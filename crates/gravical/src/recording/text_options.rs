//! The options of this crate as those of the reader of text.

use gravical_recording as new;

use super::ReadOptions;
use super::layout::{Column, ColumnsSpec};
use super::names::Quantity;

/// The options for the reader of text.
pub(super) fn text_options(options: &ReadOptions, is_gyroscope: bool) -> new::ReadOptions {
    new::ReadOptions {
        accel_unit: options.accel_unit,
        accel_range_g: options.accel_range_g,
        gyro_unit: options.gyro_unit,
        gyro_range_deg_s: options.gyro_range_deg_s,
        columns: options.columns.as_ref().map(columns),
        sensor: options.sensor.clone(),
        rate_hz: options.rate_hz,
        time_unit: options.time_unit,
        zero_offset: options.zero_offset,
        is_gyroscope,
    }
}

fn columns(spec: &ColumnsSpec) -> new::ColumnsSpec {
    let role = |quantity: &Quantity| match quantity {
        Quantity::Time => new::Role::Time,
        Quantity::TimeStep => new::Role::Step,
        Quantity::Accel(i) => new::Role::Accel(*i),
        Quantity::Gyro(i) => new::Role::Gyro(*i),
        Quantity::Temperature => new::Role::Temperature,
        Quantity::Label => new::Role::Label,
        Quantity::Index | Quantity::Instance => new::Role::Other,
    };
    match spec {
        ColumnsSpec::Named(pairs) => {
            let pairs = pairs.iter().map(|(q, name)| (role(q), name.clone()));
            new::ColumnsSpec::Named(pairs.collect())
        }
        ColumnsSpec::Ordered(order) => {
            let choice = |column: &Column| match column {
                Column::Channel(q) => new::ColumnChoice::Channel(role(q)),
                Column::AsRecognised => new::ColumnChoice::AsRecognised,
                Column::Skipped => new::ColumnChoice::Skipped,
            };
            new::ColumnsSpec::Ordered(order.iter().map(choice).collect())
        }
    }
}
