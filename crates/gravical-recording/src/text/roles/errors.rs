//! What is said where columns are not understood.

use gravical_judge::Role;

use super::clocks;
use crate::problem::Problem;
use crate::text::format::Format;
use crate::text::rows::Rows;

pub(super) fn columns_unknown(format: &Format, sample: &Rows) -> Problem {
    too_few_axes(format, sample).unwrap_or(match format.misfit {
        Some(misfit) => Problem::NamesMisfit { misfit },
        None => Problem::ColumnsUnknown {
            columns: format.columns.len(),
        },
    })
}

/// Where fewer than three columns can be axes none can be assigned.
fn too_few_axes(format: &Format, sample: &Rows) -> Option<Problem> {
    let may_be_axis = |c: &usize| {
        let (column, values) = (&format.columns[*c], &sample.columns[*c]);
        let is_other = matches!(column.role, Role::Time | Role::Step) || column.is_dated;
        !is_other && !sample.is_text(*c) && !clocks::rises(values)
    };
    let axes = (0..format.columns.len()).filter(may_be_axis).count();
    (axes < 3).then_some(Problem::TooFewAxes { axes })
}

pub(super) fn no_accelerometer(has_gyroscope: bool, format: &Format, sample: &Rows) -> Problem {
    if has_gyroscope {
        return Problem::GyroscopeAlone;
    }
    too_few_axes(format, sample).unwrap_or_else(|| Problem::NoAccelerometer {
        names: format.names.clone(),
        header_line: format.header_line,
    })
}
