//! Figures of an Allan deviation: one for each sensor.

use gravical::noise::{AllanPoint, ChannelNoise, NoiseResult, Term};

use super::panel::{Axis, Figure, Panel, Role, Scale, Series};
use super::svg::extent;

const CAPTION: &str = "Allan deviation σ over the averaging time τ, without rounding noise and drift, with its 95 % band, and the fitted curve. Thin lines: its terms, white noise N (falling), bias instability B (level) and random walk K (rising), as far as they are part of the curve.";

/// The figures of a result: accelerometer, gyroscope.
pub fn figures(result: &NoiseResult) -> Vec<Figure> {
    let sensors = [("accelerometer", "m/s²"), ("gyroscope", "rad/s")];
    let figure = |(sensor, unit): (&str, &str)| {
        let channels = result.channels.iter();
        let channels = channels.filter(|c| c.channel.starts_with(&sensor[..1]));
        let channels: Vec<&ChannelNoise> = channels.collect();
        let title = format!("Allan deviation of the {sensor}");
        let panels = channels.iter().map(|c| panel(c, &channels, unit));
        let figure = Figure::new(&format!("allan-{sensor}"), &title, CAPTION, panels).beside();
        (!channels.is_empty()).then_some(figure)
    };
    sensors.into_iter().filter_map(figure).collect()
}

fn panel(channel: &ChannelNoise, all: &[&ChannelNoise], unit: &str) -> Panel {
    // All channels over one range, which is that of the measurement: terms fall far below it.
    let sigma = all.iter().flat_map(|c| &c.adev).map(|p| p.sigma.log10());
    let (low, high) = extent(sigma.filter(|s| s.is_finite()));
    let y = Axis {
        include: vec![low, high],
        within: Some([low - 0.4, high + 0.4]),
        ..Axis::scaled("σ", unit, Scale::Log)
    };
    let column = |value: fn(&AllanPoint) -> f64| -> Vec<f64> {
        let values = channel.adev.iter().map(value);
        values.map(f64::log10).collect()
    };
    let tau = column(|p| p.tau_s);
    let (low, high) = (column(|p| p.low), column(|p| p.high));
    let mut series = vec![Series::band("95 %", Role::Result, tau.clone(), low, high)];
    // A curve over averaging times, smooth on logarithmic axes.
    let (from, to) = extent(tau.iter().copied());
    let curve = |name: &str, role, at: &dyn Fn(f64) -> f64| {
        let x = (0..=60).map(|k| from + (to - from) * f64::from(k) / 60.0);
        Series::line(name, role, x.map(|x| (x, at(10_f64.powf(x)).log10())))
    };
    if let Some(fit) = channel.fit {
        for term in Term::ALL {
            let x = fit.parameters[term as usize];
            if x > 0.0 {
                let part = |t: f64| x * term.shape(t).sqrt();
                series.push(curve(term.symbol(), Role::Guide, &part));
            }
        }
        series.push(curve("fitted curve", Role::Warning, &|t| fit.deviation(t)));
    }
    let points = tau.into_iter().zip(column(|p| p.sigma));
    series.push(Series::points("Allan deviation", Role::Result, points));
    let x = Axis::scaled("τ", "s", Scale::Log);
    Panel::new(&channel.channel, x, y, series)
}
