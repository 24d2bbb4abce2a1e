//! Temperature over the session, and the drift that a model takes off.

use crate::figure::{Arrangement, Axis, Figure, Panel, Role, Series};
use gravical::calibration_file::{CalibrationFile, TemperatureModel};
use gravical::temperature::evaluate;

use super::Session;
use super::captures::{joined, placed, time_axis};

/// Points of a curve.
const FINE: usize = 100;

/// Temperature over time, and drift over temperature; none without either.
pub(super) fn temperature(file: &CalibrationFile, session: Option<Session<'_>>) -> Option<Figure> {
    let mut figure = Figure::new("temperature", "Temperature", "").beside();
    if let Some(panel) = session.and_then(over_time) {
        figure
            .caption
            .push_str("Temperature of the sensor while it was recorded. ");
        figure.panels.push(panel);
    }
    if let Some(model) = &file.temperature_model {
        let before = figure.panels.len();
        for (title, channels) in [("accelerometer", "ax ay az"), ("gyroscope", "gx gy gz")] {
            figure.panels.extend(drift(model, title, channels));
        }
        if figure.panels.len() > before {
            figure.caption.push_str("Drift of the channels that temperature predicts, which is corrected; zero at the reference temperature.");
        }
    }
    if let [only] = &mut figure.panels[..] {
        // One alone fills the width.
        figure.arrangement = Arrangement::Stacked;
        only.aspect = None;
    }
    (!figure.panels.is_empty()).then_some(figure)
}

fn over_time(session: Session<'_>) -> Option<Panel> {
    let all = placed(session.recordings);
    let lines = all.iter().filter_map(|p| {
        let t = p.recording.temperature_c.as_ref()?;
        let value = |i: usize| t.get(i).copied().unwrap_or(f64::NAN);
        Some(p.line(Role::Calibrated, "temperature", value))
    });
    let line = joined(lines).filter(|l| l.y.iter().any(|v| v.is_finite()))?;
    let mut panel = Panel::new(
        time_axis(session.recordings),
        Axis::new("temperature", "°C"),
    );
    panel.aspect = Some(0.75);
    Some(panel.titled("over time").with(line))
}

fn drift(model: &TemperatureModel, title: &str, channels: &str) -> Option<Panel> {
    let [from, to] = model.range_c;
    let mut panel =
        Panel::new(Axis::new("temperature", "°C"), Axis::new("drift", "")).titled(title);
    panel.aspect = Some(0.75);
    let roles = [("x", Role::X), ("y", Role::Y), ("z", Role::Z)];
    for (channel, (name, role)) in channels.split(' ').zip(roles) {
        let Some(own) = model.channel(channel).filter(|c| c.is_corrected()) else {
            continue;
        };
        panel.y.unit = unit_text(&own.input_unit);
        let t = (0..=FINE).map(|i| from + (to - from) * i as f64 / FINE as f64);
        let t: Vec<f64> = t.collect();
        let drift = t
            .iter()
            .map(|t| evaluate(&own.coefficients, t - model.reference_c));
        let drift = drift.collect();
        panel = panel.with(Series::line(name, role, t, drift));
    }
    (!panel.series.is_empty()).then_some(panel)
}

/// A unit as it stands on an axis.
fn unit_text(name: &str) -> String {
    match name {
        "m/s^2" => "m/s²",
        "deg/s" => "°/s",
        "unknown" => "unit of the file",
        other => other,
    }
    .to_owned()
}
