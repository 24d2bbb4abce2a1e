//! The moves one by one, and what the uncertainty of the end consists of.

use gravical::core::matrix3::norm;

use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::motion::Move;

use super::{AXES, Motion, result_name};

/// Moves that are shown at the most.
const SHOWN: usize = 400;

/// Displacement of each move; none for a single one.
pub(super) fn moves(motion: &Motion<'_>) -> Option<Figure> {
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
        let plain = of(&|m| Some(m.uncalibrated_m?[axis]));
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

fn reference(motion: &Motion<'_>, m: &Move) -> Option<[f64; 3]> {
    let truth = motion.result.truth.as_ref()?;
    let own = truth.moves.iter().find(|o| o.start_s == m.start_s)?;
    let moved = m.displacement_m?;
    Some(std::array::from_fn(|i| moved[i] - own.end_error_m[i]))
}

/// Parts of the uncertainty of the move that is least certain.
pub(super) fn budget(motion: &Motion<'_>) -> Option<Figure> {
    let (number, budget) = motion.result.largest_budget()?;
    let parts = [
        ("noise", norm(&budget.noise)),
        ("calibration", norm(&budget.calibration)),
        ("attitude", norm(&budget.attitude)),
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
    let of = match motion.result.moves.len() {
        1 => "the displacement".to_owned(),
        _ => format!("the displacement of move {number}, the least certain one"),
    };
    let figure = Figure::new(
        "budget",
        "Uncertainty of the displacement",
        format!(
            "Contributions to the standard uncertainty of {of}, all three axes; combined: root sum of squares."
        ),
    );
    Some(figure.with(panel))
}
