//! What the uncertainty consists of.

use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibration_file::CalibrationFile;
use gravical::numfmt::{decimals_for, milli_g, words};

use super::places;

/// Parts of the uncertainty of ‖a‖ at rest.
pub(super) fn budget(file: &CalibrationFile) -> Option<Figure> {
    let budget = file.accelerometer.budget.as_ref()?;
    let known: Vec<_> = budget
        .contributions
        .iter()
        .filter_map(|c| Some((words(&c.source), milli_g(c.norm_mps2?))))
        .collect();
    if known.is_empty() {
        return None;
    }
    let (names, values): (Vec<_>, Vec<_>) = known.into_iter().unzip();
    let panel = Panel::new(
        Axis::names("", names),
        Axis::new("standard uncertainty of ‖a‖", "mg"),
    )
    .with(Series::columns(
        "part",
        Role::Calibrated,
        places(values.len()),
        values,
    ))
    .with(Series::rule(
        "combined",
        Role::Reference,
        milli_g(budget.combined_mps2),
    ));
    let caption = format!(
        "Contributions to the standard uncertainty of ‖a‖ at rest, RMS over all directions; combined: root sum of squares, expanded (k = {}): {:.*} mg.",
        budget.coverage_factor,
        decimals_for(milli_g(budget.expanded_mps2)),
        milli_g(budget.expanded_mps2)
    );
    Some(Figure::new("budget", "Uncertainty budget", caption).with(panel))
}
