//! Bias and scale with their uncertainty.

use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibration_file::CalibrationFile;

use super::{Scale, accel_unit, places};

/// Half of the width of an interval's box, in names.
const HALF: f64 = 0.18;

/// Bias and scale beside each other.
pub(super) fn parameters(file: &CalibrationFile, scale: &Scale) -> Option<Figure> {
    let a = &file.accelerometer;
    if a.poses.is_empty() {
        return None;
    }
    let sd = a.deviations;
    let offset = scale.offset.unwrap_or(0.0);
    let less = match offset {
        0.0 => "bias".to_owned(),
        some => format!("bias − {some}"),
    };
    let factor = sd.map_or(f64::NAN, |_| 1.96);
    let bias = panel(
        Axis::new(&less, accel_unit(a.input_unit)),
        a.bias.map(|b| b - offset),
        sd.map(|d| d.bias),
        factor,
        scale.offset.map(|_| ("no bias", 0.0)),
    )
    .titled("bias");
    let gain = match a.scale_deviation_percent {
        Some(deviation) => {
            let percent = |v: f64, i: usize| (100.0 + deviation[i]) * v / a.scale[i];
            let sd = sd.map(|d| std::array::from_fn(|i| percent(d.scale[i], i)));
            let axis = Axis::new("scale against nominal", "%");
            panel(axis, deviation, sd, factor, Some(("nominal", 0.0)))
        }
        None => {
            let unit = format!("{} per m/s²", accel_unit(a.input_unit));
            let sd = sd.map(|d| d.scale);
            panel(Axis::new("scale", &unit), a.scale, sd, factor, None)
        }
    }
    .titled("scale");
    let caption = match sd {
        Some(_) => {
            "Bias and scale of each axis. Boxes: ± 1σ (dark) and 95 % interval (pale); thin boxes are uncertainties much smaller than the differences between the axes."
        }
        None => "Bias and scale of each axis.",
    };
    let figure = Figure::new("parameters", "Parameters", caption).beside();
    Some(figure.with(bias).with(gain))
}

fn panel(
    y: Axis,
    values: [f64; 3],
    sd: Option<[f64; 3]>,
    factor: f64,
    reference: Option<(&str, f64)>,
) -> Panel {
    let names = ["x", "y", "z"].map(str::to_owned).to_vec();
    let mut panel = Panel::new(Axis::names("axis", names), y);
    panel.aspect = Some(0.75);
    if let Some((name, value)) = reference {
        panel = panel.with(Series::rule(name, Role::Reference, value));
    }
    if let Some(sd) = sd {
        panel = panel
            .with(boxes("95 %", values, sd.map(|s| factor * s)))
            .with(boxes("± 1σ", values, sd));
    }
    let points = Series::points("value", Role::Calibrated, places(3), values.to_vec());
    panel.with(points)
}

/// A box each about the values.
fn boxes(name: &str, values: [f64; 3], half: [f64; 3]) -> Series {
    let (mut x, mut low, mut high) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..3 {
        for at in [i as f64 - HALF, i as f64 + HALF, f64::NAN] {
            x.push(at);
            low.push(values[i] - half[i]);
            high.push(values[i] + half[i]);
        }
    }
    Series {
        samples: 3,
        ..Series::band(name, Role::Calibrated, x, low, high)
    }
}
