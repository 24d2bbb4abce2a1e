//! The trajectory in a plane.

use std::f64::consts::PI;

use crate::figure::thin::{self, Times};
use crate::figure::{Axis, Figure, Panel, Role, Series, Symbol};
use gravical::numfmt::decimals_for;

use super::{AXES, Extent, FAR, Motion, ends, result_name, times};

/// How much larger than the way a drawn uncertainty may be.
const WIDEST: f64 = 1.0;

/// Points of an ellipse.
const FINE: usize = 72;

/// Seen from above; where it goes up more than along, from the side.
pub(super) fn trajectory(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let extent = Extent::of(&track.position_m)?;
    let plane = plane_of(&extent);
    let plain = track.uncalibrated.as_ref().map(|u| &u.position_m[..]);
    let around = plain.and_then(Extent::of);
    let far = around.is_some_and(|e| e.largest() > FAR * extent.largest());
    let seen = match plane {
        [0, 1] => "seen from above".to_owned(),
        [a, b] => format!(
            "in the plane of {} and {}, where it reaches furthest",
            AXES[a], AXES[b]
        ),
    };
    let figure = Figure::new(
        "trajectory",
        "Trajectory",
        format!(
            "The path {seen}, equal scale on both axes. Circle: start, diamond: end{}.",
            sigma_told(motion, &extent, plane)
        ),
    );
    let own = with_result(empty(plane), motion, plane);
    let figure = match plain {
        None => figure.with(own),
        Some(plain) if far => {
            let both = with_result(
                with_plain(empty(plane), motion, plain, plane),
                motion,
                plane,
            );
            figure
                .beside()
                .with(squared(own.titled(result_name(motion))))
                .with(squared(both.titled("and uncalibrated")))
        }
        Some(plain) => figure.with(with_result(
            with_plain(empty(plane), motion, plain, plane),
            motion,
            plane,
        )),
    };
    Some(match figure.panels.len() {
        1 => shaped(figure),
        _ => figure,
    })
}

/// Standard uncertainty of the end, where it does not dwarf the way: an ellipse
/// much larger than that would be all that is seen.
fn sigma_to_draw(motion: &Motion<'_>, extent: &Extent, plane: [usize; 2]) -> Option<[f64; 3]> {
    let (_, sigma) = ends(&motion.track.sigma_position_m)?;
    let most = WIDEST * extent.largest();
    plane.iter().all(|&i| sigma[i] <= most).then_some(sigma)
}

fn sigma_told(motion: &Motion<'_>, extent: &Extent, plane: [usize; 2]) -> String {
    let Some((_, sigma)) = ends(&motion.track.sigma_position_m) else {
        return String::new();
    };
    if sigma_to_draw(motion, extent, plane).is_some() {
        return ", the ellipse ± 1σ of its position".to_owned();
    }
    let label = |i: usize| {
        format!(
            "{:.*} m along {}",
            decimals_for(sigma[i]),
            sigma[i],
            AXES[i]
        )
    };
    let [a, b] = plane.map(label);
    format!("; 1σ of its position is {a} and {b}, more than the picture shows")
}

/// Indices of the two axes to show: x and y, unless z reaches further than both.
pub(super) fn plane_of(extent: &Extent) -> [usize; 2] {
    let [x, y, z] = extent.size();
    if z <= x.max(y) {
        [0, 1]
    } else if x >= y {
        [0, 2]
    } else {
        [1, 2]
    }
}

fn empty(plane: [usize; 2]) -> Panel {
    let axis = |i: usize| Axis::new(AXES[i], "m");
    Panel::new(axis(plane[0]), axis(plane[1]))
}

fn squared(panel: Panel) -> Panel {
    panel.equal(1.0)
}

/// As high as the way needs, within reason.
fn shaped(mut figure: Figure) -> Figure {
    for panel in &mut figure.panels {
        let span = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(v), h.max(v))
                });
            high - low
        };
        let w = span(&mut panel.series.iter().flat_map(|s| s.x.iter().copied()));
        let h = span(&mut panel.series.iter().flat_map(|s| s.y.iter().copied()));
        let aspect = h / w;
        panel.equal = true;
        panel.aspect = Some(if aspect.is_finite() {
            aspect.clamp(0.35, 0.8)
        } else {
            0.6
        });
    }
    figure
}

fn way(name: &str, role: Role, times: Times<'_>, p: &[[f64; 3]], [a, b]: [usize; 2]) -> Series {
    thin::line(name, role, times, |i| {
        p.get(i).map_or((f64::NAN, f64::NAN), |p| (p[a], p[b]))
    })
}

fn mark(name: &str, role: Role, p: [f64; 3], [a, b]: [usize; 2]) -> Series {
    Series::points(name, role, vec![p[a]], vec![p[b]])
}

fn with_plain(panel: Panel, motion: &Motion<'_>, plain: &[[f64; 3]], plane: [usize; 2]) -> Panel {
    let times = times(&motion.track);
    let panel = panel.with(way("uncalibrated", Role::Raw, times, plain, plane));
    match ends(plain) {
        Some((_, end)) => {
            let end = mark("end, uncalibrated", Role::Raw, end, plane);
            panel.with(end.drawn_as(Symbol::Diamond))
        }
        None => panel,
    }
}

fn with_result(mut panel: Panel, motion: &Motion<'_>, plane: [usize; 2]) -> Panel {
    let track = &motion.track;
    if let Some(reference) = motion.reference {
        let (t, p) = (&reference.t_s, &reference.position_m);
        panel = panel.with(way("reference", Role::Reference, Times::from(t), p, plane));
    }
    let name = result_name(motion);
    panel = panel.with(way(
        name,
        Role::Calibrated,
        times(track),
        &track.position_m,
        plane,
    ));
    let Some((start, end)) = ends(&track.position_m) else {
        return panel;
    };
    let sigma = Extent::of(&track.position_m).and_then(|e| sigma_to_draw(motion, &e, plane));
    if let Some(sigma) = sigma {
        panel = panel.with(ellipse("± 1σ at the end", end, sigma, plane));
    }
    panel
        .with(mark("start", Role::Calibrated, start, plane).drawn_as(Symbol::Circle))
        .with(mark("end", Role::Calibrated, end, plane).drawn_as(Symbol::Diamond))
}

/// The area within one standard uncertainty of each axis.
pub(super) fn ellipse(name: &str, centre: [f64; 3], sigma: [f64; 3], [a, b]: [usize; 2]) -> Series {
    let turns = (0..=FINE).map(|k| PI * k as f64 / FINE as f64);
    let (mut x, mut low, mut high) = (Vec::new(), Vec::new(), Vec::new());
    for (sine, cosine) in turns.map(f64::sin_cos) {
        x.push(centre[a] - sigma[a] * cosine);
        low.push(centre[b] - sigma[b] * sine);
        high.push(centre[b] + sigma[b] * sine);
    }
    Series {
        samples: 1,
        ..Series::band(name, Role::Calibrated, x, low, high)
    }
}
