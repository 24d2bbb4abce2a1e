//! Distributions of the parameters of many sensors.

use gravical::cohort::{AxisColumns, COMMANDS, Cohort};
use gravical::stats::quantile;

use super::{Axis, Figure, Panel, Role, Series};

/// Values up to which each one is a point of its line; of more, so many quantiles.
const MOST_POINTS: usize = 500;

/// The figure of a cohort: of each parameter the share of the results below a value. None with
/// less than two results.
#[must_use]
pub fn figures(cohort: &Cohort) -> Vec<Figure> {
    let table = COMMANDS.iter().find(|t| t.command == cohort.command);
    let mut figure = Figure::new(
        "distributions",
        "Distributions",
        "Share of the results whose value is below that of the axis: where a line is steep there are many, at 50 % is the median. A long tail, a step or two slopes are several kinds of sensors, or results that need a look.",
    )
    .beside();
    for axes in table.map_or(&[][..], |t| t.axes) {
        figure.panels.extend(panel(cohort, axes));
    }
    match figure.panels.is_empty() {
        true => Vec::new(),
        false => vec![figure],
    }
}

fn panel(cohort: &Cohort, axes: &AxisColumns) -> Option<Panel> {
    let own = cohort
        .distributions
        .iter()
        .find(|d| d.name == axes.names[0])?;
    let x = Axis::new(axes.what, &own.unit);
    let mut panel = Panel::new(x, Axis::new("share below", "%").including(&[0.0, 100.0]));
    panel.aspect = Some(0.7);
    for ((name, axis), role) in
        axes.names
            .iter()
            .zip(["x", "y", "z"])
            .zip([Role::X, Role::Y, Role::Z])
    {
        let sorted = cohort.sorted.get(*name).filter(|v| v.len() > 1)?;
        let points = sorted.len().min(MOST_POINTS);
        let share = |i: usize| i as f64 / (points - 1) as f64;
        let values = (0..points).filter_map(|i| quantile(sorted, share(i)));
        let shares = (0..points).map(|i| 100.0 * share(i));
        panel = panel.with(Series::line(axis, role, values.collect(), shares.collect()));
    }
    Some(panel)
}
