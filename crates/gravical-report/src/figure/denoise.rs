//! Figures of filters: the recording before and after, its spectrum at rest, what each leaves of the noise.

use std::f64::consts::TAU;
use std::ops::Range;

use gravical::denoise::{DenoiseSummary, Sigmas};
use gravical::numfmt::unit;
use gravical::poses::rests::find_rests;
use gravical::recording::Recording;

use super::drawing::Figure;
use super::panel::{Axis, Mark, Panel, Role, Series, XYZ};

/// Samples of a stretch whose spectrum is taken: 0.4 Hz apart at 100 Hz.
const STRETCH: usize = 256;
/// Stretches that are averaged: the density of each is off by as much as itself.
const STRETCHES: usize = 64;

/// The accelerometer before and after all filters, over time and, at rest, over frequency.
pub fn before_and_after(raw: &Recording, filtered: &Recording) -> Vec<Figure> {
    let period_s = 1.0 / raw.working_rate_hz();
    let by_rate = || (0..raw.rows()).map(|i| period_s * i as f64).collect();
    let t_s: Vec<f64> = raw.time_s.clone().unwrap_or_else(by_rate);
    let unit = unit(raw.units.accel.unit.name());
    let both = [
        ("raw", Role::Raw, raw),
        ("filtered", Role::Result, filtered),
    ];
    let panel = |axis: usize| {
        let line = |(name, role, of): (&str, Role, &Recording)| {
            let points = t_s.iter().zip(&of.accel[axis]).map(|(t, v)| [*t, *v]);
            Series::line(name, role, points, &raw.breaks)
        };
        let x = Axis::over("time, s", "t = {} s", t_s.iter().copied(), 0.0);
        let y = Axis::over("", "", raw.accel[axis].iter().copied(), 0.06);
        Panel::new(XYZ[axis], &unit, [x, y], both.map(line)).linked("t")
    };
    let over_time = Figure::new("filtered", "Raw and filtered", "", [0, 1, 2].map(panel));
    let rests = find_rests(raw);
    let density = |(name, role, of): (&str, Role, &Recording)| {
        let points = spectrum(&of.accel, &rests, period_s);
        Series::line(
            name,
            role,
            points.into_iter().map(|[f, s]| [f.log10(), s.log10()]),
            &[],
        )
    };
    let series = both.map(density);
    let values = |c: usize| {
        let points = series.iter().flat_map(|s| match &s.mark {
            Mark::Line(points) => &points[..],
            _ => &[],
        });
        points.map(move |p| p[c]).collect::<Vec<f64>>()
    };
    let x = Axis::over("frequency, Hz", "f = {} Hz", values(0), 0.0).log();
    let y = Axis::over("", "", values(1), 0.05).log();
    let name = "Noise density, mean of the axes";
    let is_known = series.iter().all(Series::has_values);
    let panel = Panel::new(name, &format!("{unit}/√Hz"), [x, y], series).alone();
    let at_rest = Figure::new("spectrum", "Spectrum at rest", "", [panel]);
    let at_rest = Some(at_rest).filter(|_| is_known);
    std::iter::once(over_time).chain(at_rest).collect()
}

/// One-sided noise density, root of the mean of the axes, by the periodograms of stretches at rest with a Hann window
/// (Welch, IEEE Trans. Audio Electroacoust. 15, 1967): frequency in Hz, density. None without a stretch.
fn spectrum(accel: &[Vec<f64>; 3], rests: &[Range<usize>], period_s: f64) -> Vec<[f64; 2]> {
    let stretches = rests.iter().flat_map(|r| {
        (r.start..r.end)
            .step_by(STRETCH)
            .map(|s| s..s + STRETCH)
            .filter(|s| s.end <= r.end)
    });
    let stretches: Vec<Range<usize>> = stretches.take(STRETCHES).collect();
    let angle = TAU / STRETCH as f64;
    let window = |i: usize| 0.5 - 0.5 * (angle * i as f64).cos();
    let weight: f64 = (0..STRETCH).map(|i| window(i).powi(2)).sum();
    let power = |values: &[f64], k: usize| {
        let mean = values.iter().sum::<f64>() / STRETCH as f64;
        let parts = values.iter().enumerate().map(|(i, v)| {
            let (sin, cos) = (angle * (i * k % STRETCH) as f64).sin_cos();
            [cos, sin].map(|part| part * window(i) * (v - mean))
        });
        let [re, im] = parts.fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
        2.0 * period_s * (re * re + im * im) / weight
    };
    // The window takes the lowest two.
    let density = |k: usize| {
        let all = stretches
            .iter()
            .flat_map(|s| accel.iter().map(|axis| &axis[s.clone()]));
        let (sum, count) = all.fold((0.0, 0.0), |(sum, n), values| {
            (sum + power(values, k), n + 1.0)
        });
        [k as f64 / (STRETCH as f64 * period_s), (sum / count).sqrt()]
    };
    (2..STRETCH / 2)
        .map(density)
        .filter(|p| p[1].is_finite())
        .collect()
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_noise_has_its_density_at_every_frequency() {
        // A generator of even numbers (Park and Miller, CACM 31, 1988): σ = 1/√12, at 100 Hz.
        let mut state = 1_u64;
        let mut value = || {
            state = state * 48271 % 2_147_483_647;
            state as f64 / 2_147_483_647.0 - 0.5
        };
        let axes: [Vec<f64>; 3] =
            std::array::from_fn(|_| (0..64 * STRETCH).map(|_| value()).collect());
        let points = spectrum(&axes, std::slice::from_ref(&(0..64 * STRETCH)), 0.01);
        let expected = (2.0 * 0.01 / 12.0_f64).sqrt();
        assert_eq!(points.len(), STRETCH / 2 - 2);
        assert!((points[8][0] - 10.0 * 100.0 / STRETCH as f64).abs() < 1e-9);
        // 192 periodograms leave 7 %, four times that is never.
        for [f, density] in points {
            assert!((density / expected - 1.0).abs() < 0.15, "{f} Hz: {density}");
        }
    }
}
