//! What temperature does to the readings.

use maud::{Markup, html};

use super::cells::{cell, digits, fixed, heads, maybe, number, small, table};
use super::gallery::Gallery;
use crate::calibration_file::{CalibrationFile, ReferenceSource, TemperatureModel};
use crate::temperature::r2_text;

pub(super) fn temperature(file: &CalibrationFile, gallery: &mut Gallery<'_>) -> Markup {
    html! {
        @match &file.temperature_c {
            Some(t) => p {
                "During the placements: " (number("/temperature_c/mean", t.mean, &fixed(t.mean, 1)))
                " °C on average, from " (number("/temperature_c/min", t.min, &fixed(t.min, 1)))
                " to " (number("/temperature_c/max", t.max, &fixed(t.max, 1))) " °C."
            },
            None => p { "The recordings have no temperature." },
        }
        (gallery.show(&["temperature"]))
        @match &file.temperature_model {
            Some(model) => (drift(model)),
            None => p { "How the readings drift with temperature was not measured." },
        }
    }
}

fn drift(model: &TemperatureModel) -> Markup {
    let base = "/temperature_model";
    let [low, high] = model.range_c;
    let body = html! {
        @for (i, c) in model.channels.iter().enumerate() {
            @let key = |name: &str| format!("{base}/channels/{i}/{name}");
            tr {
                th scope="row" { (c.channel) }
                (maybe(&key("slope"), c.slope, |v| small(v, 3)))
                td { (c.input_unit) " per °C" }
                (maybe(&key("r2_cooling_to_warming"), c.r2_cooling_to_warming, r2))
                (maybe(&key("r2_warming_to_cooling"), c.r2_warming_to_cooling, r2))
                (maybe(&key("hysteresis"), c.hysteresis, |v| small(v, 3)))
                (cell(&key("drift_rms"), c.drift_rms, &small(c.drift_rms, 3)))
                (maybe(&key("residual_rms"), c.residual_rms, |v| small(v, 3)))
                td { @if c.is_accepted() { "taken off, order " (c.order) } @else { "refused" } ": " (c.reason) }
            }
        }
    };
    let how = match model.reference_source {
        ReferenceSource::Session => "the mean of the placements",
        ReferenceSource::Soak => "the middle of the soak",
    };
    let names = [
        "channel",
        "slope",
        "",
        "R² cooling → warming",
        "R² warming → cooling",
        "apart at most",
        "rms before",
        "rms after",
        "verdict",
    ];
    html! {
        p {
            "The model holds from " (number(&format!("{base}/range_c/0"), low, &digits(low, 3)))
            " to " (number(&format!("{base}/range_c/1"), high, &digits(high, 3)))
            " °C and counts from " (number(&format!("{base}/reference_c"), model.reference_c, &fixed(model.reference_c, 1)))
            " °C, " (how) ". Outside of the range its edge is held."
        }
        (table("Drift of each channel", &heads(&names), &body))
    }
}

fn r2(v: f64) -> String {
    r2_text(v).replace('-', "−")
}
