//! The moves one by one, and what the uncertainty of the end consists of.

use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::motion::{Motion, Move};

use super::{AXES, result_name};

/// Moves that are shown at the most.
const SHOWN: usize = 400;

/// Displacement of each move; none for a single one.
pub(super) fn moves(motion: &Motion) -> Option<Figure> {
    let all = &motion.result.moves;
    let usable: Vec<(usize, &Move)> = all
        .iter()
        .enumerate()
        .filter(|(_, m)| m.displacement_m.is_some())
        .collect();
    if usable.len() < 2 {
        return None;
    }
    let shown = usable.get(..SHOWN).unwrap_or(&usable);
    let names: Vec<String> = shown.iter().map(|(i, _)| (i + 1).to_string()).collect();
    let x: Vec<f64> = (0..shown.len()).map(|i| i as f64).collect();
    let more = match usable.len() - shown.len() {
        0 => String::new(),
        n => format!(" {n} more are not shown."),
    };
    let mut figure = Figure::new(
        "moves",
        "Moves",
        format!("Displacement of each move; bars are ± 1σ.{more}"),
    );
    for (axis, name) in AXES.into_iter().enumerate() {
        let of = |value: &dyn Fn(&Move) -> Option<f64>| -> Vec<f64> {
            let all = shown.iter().map(|(_, m)| value(m));
            all.map(|v| v.unwrap_or(f64::NAN)).collect()
        };
        let known = |v: &[f64]| v.iter().any(|v| v.is_finite());
        let own = of(&|m| m.displacement_m.map(|d| d[axis]));
        let sigma = of(&|m| m.sigma_m.map(|s| s[axis]));
        let plain = of(&|m| Some(uncalibrated(motion, m)?[axis]));
        let reference = of(&|m| Some(reference(motion, m)?[axis]));
        let mut panel = Panel::new(
            Axis::names("move", names.clone()),
            Axis::new("", "m").including(&[0.0]),
        )
        .titled(name);
        if known(&plain) {
            panel = panel.with(Series::points("uncalibrated", Role::Raw, x.clone(), plain));
        }
        let points = Series::points(result_name(motion), Role::Calibrated, x.clone(), own);
        panel = panel.with(if known(&sigma) {
            points.plus_minus(&sigma)
        } else {
            points
        });
        if known(&reference) {
            let points = Series::points("reference", Role::Reference, x.clone(), reference);
            panel = panel.with(points);
        }
        figure = figure.with(panel);
    }
    Some(figure)
}

fn uncalibrated(motion: &Motion, m: &Move) -> Option<[f64; 3]> {
    let track = &motion.track;
    let plain = track.uncalibrated.as_ref()?;
    let at = |t: f64| plain.position_m.get(track.t_s.partition_point(|s| *s < t));
    let (from, to) = (at(m.start_s)?, at(m.end_s)?);
    Some(std::array::from_fn(|i| to[i] - from[i]))
}

fn reference(motion: &Motion, m: &Move) -> Option<[f64; 3]> {
    let truth = motion.result.truth.as_ref()?;
    let own = truth.moves.iter().find(|o| o.start_s == m.start_s)?;
    let moved = m.displacement_m?;
    Some(std::array::from_fn(|i| moved[i] - own.end_error_m[i]))
}

/// Parts of the uncertainty of the end.
pub(super) fn budget(motion: &Motion) -> Option<Figure> {
    let budget = motion.result.budget_m?;
    let parts = [
        ("noise", budget.noise),
        ("bias", budget.bias),
        ("scale", budget.scale),
        ("clock", budget.clock),
        ("tilt", budget.tilt),
    ];
    let combined = parts.iter().map(|(_, v)| v * v).sum::<f64>().sqrt();
    if !(combined > 0.0 && combined.is_finite()) {
        return None;
    }
    let (unit, factor) = if combined < 0.5 {
        ("mm", 1e3)
    } else {
        ("m", 1.0)
    };
    let names = parts.iter().map(|p| p.0.to_owned()).collect();
    let values = parts.iter().map(|p| factor * p.1).collect();
    let x = (0..parts.len()).map(|i| i as f64).collect();
    let panel = Panel::new(
        Axis::names("", names),
        Axis::new("standard uncertainty", unit),
    )
    .with(Series::columns("part", Role::Calibrated, x, values))
    .with(Series::rule("combined", Role::Reference, factor * combined));
    let figure = Figure::new(
        "budget",
        "Uncertainty of the end position",
        "Contributions to the standard uncertainty of the end position, all three axes; combined: root sum of squares.",
    );
    Some(figure.with(panel))
}
