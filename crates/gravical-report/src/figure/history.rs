//! Parameters of a sensor over time.

use gravical::compare::HistoryParameter;
use gravical::store::SensorHistory;

use super::{Axis, Figure, Panel, Role, Series};

/// Names of the figures.
pub const NAMES: [&str; 2] = ["bias-history", "scale-history"];

/// The figures of a history: bias and scale over time. Empty for less than two calibrations with
/// parameters.
#[must_use]
pub fn figures(history: &SensorHistory) -> Vec<Figure> {
    let caption = "with intervals of 95 %: those that are tested (filled circles) and those that are not (crosses). Dotted: the mean of the tested ones, weighted by their uncertainties.";
    let figure = |name, title, what, kind: &str, unit: &str| {
        let panels = ["x", "y", "z"].map(|axis| panel(history, &format!("{kind}_{axis}"), unit));
        let figure = Figure::new(
            name,
            title,
            format!("{what} of each axis over time, {caption}"),
        );
        let panels: Option<Vec<Panel>> = panels.into_iter().collect();
        Some(panels?.into_iter().fold(figure, Figure::with))
    };
    [
        figure(NAMES[0], "Bias over time", "Bias", "bias", "m/s²"),
        figure(
            NAMES[1],
            "Scale over time",
            "Deviation of the scale from nominal",
            "scale",
            "%",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// One parameter over time.
fn panel(history: &SensorHistory, name: &str, unit: &str) -> Option<Panel> {
    let first = history.calibrations.first()?.time;
    let entries = history.calibrations.iter().zip(&history.history.entries);
    let points: Vec<(f64, bool, &HistoryParameter)> = entries
        .filter_map(|(c, entry)| {
            let own = entry.parameters.iter().find(|p| p.name == name)?;
            Some((first.days_until(c.time), entry.not_tested.is_none(), own))
        })
        .collect();
    if points.len() < 2 {
        return None;
    }
    let x = Axis::new(&format!("days since {}", first.date()), "");
    let mut panel = Panel::new(x, Axis::new(&name.replace('_', " "), unit));
    panel.aspect = Some(0.28);
    if let Some(mean) = history.history.mean.iter().find(|p| p.name == name) {
        panel = panel.with(Series::rule("weighted mean", Role::Reference, mean.value));
    }
    for (title, role, tested) in [
        ("tested", Role::Calibrated, true),
        ("not tested", Role::Raw, false),
    ] {
        let own: Vec<_> = points.iter().filter(|(_, t, _)| *t == tested).collect();
        if own.is_empty() {
            continue;
        }
        let half = |p: &HistoryParameter| {
            p.interval_95
                .map_or(f64::NAN, |[low, high]| 0.5 * (high - low))
        };
        let half: Vec<f64> = own.iter().map(|(_, _, p)| half(p)).collect();
        let series = Series::points(
            title,
            role,
            own.iter().map(|(t, _, _)| *t).collect(),
            own.iter().map(|(_, _, p)| p.value).collect(),
        );
        let symbol = match tested {
            true => super::Symbol::Circle,
            false => super::Symbol::Cross,
        };
        panel = panel.with(series.plus_minus(&half).drawn_as(symbol));
    }
    Some(panel)
}
