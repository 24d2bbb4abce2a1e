//! Figures of an Allan deviation: one for each sensor.

use gravical::noise::{ChannelNoise, NoiseResult, Term};

use super::{Axis, Figure, Panel, Role, Series};

/// Names of the figures.
pub const NAMES: [&str; 2] = ["allan-accelerometer", "allan-gyroscope"];

/// The figures of a result: accelerometer, gyroscope.
#[must_use]
pub fn figures(result: &NoiseResult) -> Vec<Figure> {
    let sensors = [
        (
            'a',
            NAMES[0],
            "Allan deviation of the accelerometer",
            "m/s²",
        ),
        ('g', NAMES[1], "Allan deviation of the gyroscope", "rad/s"),
    ];
    let figure = |(letter, name, title, unit): (char, &str, &str, &str)| {
        let own = result.channels.iter();
        let own: Vec<&ChannelNoise> = own.filter(|c| c.channel.starts_with(letter)).collect();
        if own.is_empty() {
            return None;
        }
        let caption = "Allan deviation σ over the averaging time τ, with its 95 % band, and the fitted curve. Thin lines: its terms, white noise N (falling), bias instability B (level) and random walk K (rising), as far as they are part of the curve.";
        let sheet = match own.iter().find_map(|c| c.data_sheet.as_ref()) {
            Some(sheet) => format!(
                " Dotted: white noise by the data sheet of the {}.",
                sheet.part
            ),
            None => String::new(),
        };
        let figure = Figure::new(name, title, format!("{caption}{sheet}")).beside();
        Some(
            own.iter()
                .fold(figure, |f, channel| f.with(panel(channel, &own, unit))),
        )
    };
    sensors.into_iter().filter_map(figure).collect()
}

fn panel(channel: &ChannelNoise, all: &[&ChannelNoise], unit: &str) -> Panel {
    let tau = |c: &ChannelNoise| c.adev.iter().map(|p| p.tau_s).collect::<Vec<f64>>();
    // All axes are drawn alike.
    let points = || all.iter().flat_map(|c| &c.adev);
    let levels: Vec<f64> = points().map(|p| p.sigma).filter(|s| *s > 0.0).collect();
    let low = levels.iter().copied().fold(f64::INFINITY, f64::min);
    let high = levels.iter().copied().fold(0.0, f64::max);
    let x = Axis::new("τ", "s").log();
    let mut y = Axis::new("σ", unit).log().including(&[low, high]);
    // Terms fall far below what was measured.
    y.within = (low < high).then_some([0.4 * low, 2.5 * high]);
    let mut panel = Panel::new(x, y).titled(&channel.channel);
    panel.aspect = Some(0.8);
    let column = |f: fn(&gravical::noise::AllanPoint) -> f64| -> Vec<f64> {
        channel.adev.iter().map(f).collect()
    };
    let band = Series::band(
        "95 %",
        Role::Calibrated,
        tau(channel),
        column(|p| p.low),
        column(|p| p.high),
    );
    panel = panel.with(band);
    if let Some(sheet) = &channel.data_sheet {
        let name = format!("data sheet of the {}", sheet.part);
        panel = panel.with(line(&name, Role::Reference, channel, |t| {
            sheet.n / t.sqrt()
        }));
    }
    if let Some(fit) = channel.fit {
        for term in Term::ALL {
            let x = fit.parameters[term as usize];
            if x > 0.0 {
                let name = format!("{} of {}", term.symbol(), channel.channel);
                let part = |t: f64| x * term.shape(t).sqrt();
                panel = panel.with(line(&name, Role::Guide, channel, part));
            }
        }
        panel = panel.with(line("fitted curve", Role::Warning, channel, |t| {
            fit.deviation(t)
        }));
    }
    let measured = Series::points(
        "Allan deviation",
        Role::Calibrated,
        tau(channel),
        column(|p| p.sigma),
    );
    panel.with(measured)
}

/// A curve over the averaging times of a channel, smooth on logarithmic axes.
fn line(name: &str, role: Role, channel: &ChannelNoise, at: impl Fn(f64) -> f64) -> Series {
    let ends = channel.adev.first().zip(channel.adev.last());
    let (from, to) = ends.map_or((1.0, 1.0), |(a, b)| (a.tau_s, b.tau_s));
    const STEPS: i32 = 60;
    let x: Vec<f64> = (0..=STEPS)
        .map(|k| from * (to / from).powf(f64::from(k) / f64::from(STEPS)))
        .collect();
    let y = x.iter().map(|t| at(*t)).collect();
    Series::line(name, role, x, y)
}
