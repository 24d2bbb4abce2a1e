//! The figure of filters: what each leaves of the noise at rest.

use gravical::denoise::{DenoiseSummary, Sigmas};

use super::drawing::Figure;
use super::panel::{Axis, Panel, Role, Series, XYZ};

/// Noise at rest of each channel after each filter, as a share of what was recorded; none without a rest.
pub fn denoise(summary: &DenoiseSummary) -> Vec<Figure> {
    let channels = |sigmas: &Sigmas| -> Vec<f64> {
        let sensors = [sigmas.accelerometer, sigmas.gyroscope];
        sensors.into_iter().flatten().flatten().collect()
    };
    let recorded = channels(&summary.recorded);
    let sensors = [
        (summary.recorded.accelerometer, 'a'),
        (summary.recorded.gyroscope, 'g'),
    ];
    let sensors = sensors.into_iter().filter(|(sigmas, _)| sigmas.is_some());
    let names = sensors.flat_map(|(_, letter)| XYZ.map(|axis| format!("{letter}{axis}")));
    let last = summary.filters.len().saturating_sub(1);
    let series = summary.filters.iter().enumerate().map(|(i, f)| {
        let values = channels(&f.sigma)
            .into_iter()
            .zip(&recorded)
            .map(|(after, before)| after / before);
        let earlier = [Role::Raw, Role::Warning, Role::Claim, Role::Rest];
        let role = if i == last {
            Role::Result
        } else {
            earlier[i % 4]
        };
        let name = format!("after {}", f.filter);
        Series::in_rows(&name, role, values.map(|share| [share, f64::NAN]))
    });
    let series: Vec<Series> = series.collect();
    let axes = [
        Axis::new("share of what was recorded", "", [0.0, 1.1]),
        Axis::rows(names),
    ];
    let panel = Panel::new("σ at rest, of what was recorded", "", axes, series);
    let figure = Figure::new("noise", "Noise at rest", "1 is as recorded.", [panel]);
    Some(figure)
        .filter(|f| f.panels()[0].series.iter().any(Series::has_values))
        .into_iter()
        .collect()
}
