//! What the uncertainty consists of.

use crate::calibration_file::CalibrationFile;
use crate::document::number::decimals_for;
use crate::figure::{Axis, Figure, Panel, Role, Series};

use super::places;

/// Parts of the uncertainty of ‖a‖ at rest.
pub(super) fn budget(file: &CalibrationFile) -> Option<Figure> {
    let budget = file.accelerometer.budget.as_ref()?;
    let known: Vec<_> = budget
        .contributions
        .iter()
        .filter_map(|c| Some((c.source.replace('-', " "), 1e3 * c.norm_mps2?)))
        .collect();
    if known.is_empty() {
        return None;
    }
    let (names, values): (Vec<_>, Vec<_>) = known.into_iter().unzip();
    let panel = Panel::new(
        Axis::names("", names),
        Axis::new("standard uncertainty of ‖a‖", "mm/s²"),
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
        1e3 * budget.combined_mps2,
    ));
    let caption = format!(
        "Contributions to the standard uncertainty of ‖a‖ at rest, RMS over all directions; combined: root sum of squares, expanded (k = {}): {:.*} mm/s².",
        budget.coverage_factor,
        decimals_for(1e3 * budget.expanded_mps2),
        1e3 * budget.expanded_mps2
    );
    Some(Figure::new("budget", "Uncertainty budget", caption).with(panel))
}
