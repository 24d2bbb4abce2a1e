//! Open-loop drift of a recording in which nothing moves.

use crate::figure::{Axis, Figure, Panel, Role, Series, Symbol, thin};
use gravical::motion::Motion;

use super::plane::ellipse;
use super::{Extent, FAR, ends, result_name};

/// Drift in the plane, and its distance from the start over time.
pub(super) fn static_drift(motion: &Motion) -> Option<Figure> {
    let track = motion.track.static_drift.as_ref()?;
    let drift = motion.result.static_drift.as_ref()?;
    Extent::of(&track.position_m)?;
    let name = result_name(motion);
    let t = &track.t_s;
    let plain = Some(&track.uncalibrated_m[..]).filter(|p| !p.is_empty());
    let way = |name: &str, role, p: &[[f64; 3]]| {
        thin::line(name, role, t, |i| {
            p.get(i).map_or((f64::NAN, f64::NAN), |p| (p[0], p[1]))
        })
    };
    let mark = |name: &str, role, p: &[f64; 3], symbol| {
        Series::points(name, role, vec![p[0]], vec![p[1]]).drawn_as(symbol)
    };
    let mut above = Panel::new(Axis::new("x", "m"), Axis::new("y", "m"))
        .titled("seen from above")
        .equal(1.0);
    if let Some(plain) = plain {
        above = above.with(way("uncalibrated", Role::Raw, plain));
        if let Some((_, end)) = ends(plain) {
            let end = mark("end, uncalibrated", Role::Raw, &end, Symbol::Diamond);
            above = above.with(end);
        }
    }
    let (start, end) = ends(&track.position_m)?;
    // A band that is much wider than the drift would hide it: then the other
    // panel has it.
    let sigma = drift.predicted_sigma_m;
    let reach = [plain.and_then(Extent::of), Extent::of(&track.position_m)];
    let reach = reach
        .iter()
        .flatten()
        .map(Extent::largest)
        .fold(0.0, f64::max);
    if sigma.iter().all(|s| *s <= FAR * reach) {
        above = above.with(ellipse("± 1σ predicted", start, sigma, [0, 1]));
    }
    above = above
        .with(way(name, Role::Calibrated, &track.position_m))
        .with(mark("start", Role::Calibrated, &start, Symbol::Circle))
        .with(mark("end", Role::Calibrated, &end, Symbol::Diamond));

    let distance = |p: &[f64; 3]| p.iter().map(|v| v * v).sum::<f64>().sqrt();
    let over = |name: &str, role, p: &[[f64; 3]]| {
        let from = p.first().copied().unwrap_or_default();
        let at = |p: &[f64; 3]| distance(&std::array::from_fn(|i| p[i] - from[i]));
        thin::line(name, role, t, |i| {
            let distance = p.get(i).map_or(f64::NAN, at);
            (t.get(i).copied().unwrap_or(f64::NAN), distance)
        })
    };
    let mut time = Panel::new(
        Axis::new("time since the rest", "s"),
        Axis::new("distance", "m"),
    )
    .titled("from the start");
    time.aspect = Some(1.0);
    let expected: Vec<f64> = track.sigma_m.iter().map(distance).collect();
    if expected.iter().any(|v| v.is_finite()) {
        let none = vec![0.0; expected.len()];
        let band = Series::band(
            "± 1σ predicted",
            Role::Calibrated,
            t.clone(),
            none,
            expected,
        );
        time = time.with(band);
    }
    if let Some(plain) = plain {
        time = time.with(over("uncalibrated", Role::Raw, plain));
    }
    time = time.with(over(name, Role::Calibrated, &track.position_m));
    let figure = Figure::new(
        "static-drift",
        "Drift at rest",
        format!(
            "Sensor at rest: drift of the position over {:.1} s, integrated without zero-velocity updates, and its predicted uncertainty.",
            drift.duration_s
        ),
    );
    Some(figure.beside().with(above).with(time))
}
