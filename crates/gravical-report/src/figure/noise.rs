//! Figures of an Allan deviation: one for each sensor.

use gravical::noise::{AllanPoint, ChannelNoise, NoiseResult, Term};

use super::drawing::Figure;
use super::panel::{Axis, Panel, Role, Series, extent};

const CAPTION: &str = "White noise N falls, bias instability B is level, random walk K rises; without rounding and drift.";

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
    let [low, high] = extent(sigma);
    let y = Axis::new("", "", [low - 0.4, high + 0.4]).log();
    let row = |p: &AllanPoint, of: [f64; 2]| {
        let [low, high] = of.map(f64::log10);
        [p.tau_s.log10(), low, high]
    };
    let band = channel.adev.iter().map(|p| row(p, [p.low, p.high]));
    let mut series = vec![Series::band(
        "Allan deviation ± 95 %",
        Role::Result,
        band,
        &[],
    )];
    // A curve over averaging times, smooth on logarithmic axes.
    let tau = || channel.adev.iter().map(|p| p.tau_s.log10());
    let [from, to] = extent(tau());
    let curve = |name: &str, role, at: &dyn Fn(f64) -> f64| {
        let x = (0..=60).map(|k| from + (to - from) * f64::from(k) / 60.0);
        Series::line(name, role, x.map(|x| [x, at(10_f64.powf(x)).log10()]), &[])
    };
    if let Some(fit) = channel.fit {
        for term in Term::ALL {
            let x = fit.parameters[term as usize];
            if x > 0.0 && channel.estimate(term).is_some() {
                let part = |t: f64| x * term.shape(t).sqrt();
                let role = match term {
                    Term::N => Role::Raw,
                    Term::B => Role::Reference,
                    Term::K => Role::Rest,
                };
                series.push(curve(term.symbol(), role, &part));
            }
        }
        series.push(curve("fitted curve", Role::Warning, &|t| fit.deviation(t)));
    }
    let points = tau()
        .zip(&channel.adev)
        .map(|(tau, p)| [tau, p.sigma.log10()]);
    series.push(Series::points(
        "Allan deviation ± 95 %",
        Role::Result,
        points,
    ));
    let x = Axis::over("averaging time τ, s", "τ = {} s", tau(), 0.03).log();
    Panel::new(&channel.channel, unit, [x, y], series).alone()
}
