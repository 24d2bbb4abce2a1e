//! Acceleration, velocity and position over time.

use crate::figure::thin::{self, Times};
use crate::figure::{Axis, Figure, Panel, Role, Series};

use super::{AXES, Extent, Motion, result_name, times};

/// Rests that are shaded at the most; a walk has thousands.
const SHADED: usize = 2000;

/// A panel of one axis with the rests shaded.
fn panel(motion: &Motion<'_>, title: &str, unit: &str) -> Panel {
    let mut panel = Panel::new(Axis::new("time", "s"), Axis::new("", unit)).titled(title);
    for span in motion.result.rests.iter().take(SHADED) {
        panel = panel.shaded("at rest", span.start_s, span.end_s);
    }
    panel
}

/// One axis of a column of vectors.
fn line(name: &str, role: Role, times: Times<'_>, values: &[[f64; 3]], axis: usize) -> Series {
    let t = times.t_s;
    thin::line(name, role, times, |i| {
        (at(t, i), component(values, i, axis))
    })
}

fn at(t: &[f64], i: usize) -> f64 {
    t.get(i).copied().unwrap_or(f64::NAN)
}

fn component(values: &[[f64; 3]], i: usize, axis: usize) -> f64 {
    values.get(i).map_or(f64::NAN, |v| v[axis])
}

/// Specific force raw and calibrated, along the axes of the sensor.
pub(super) fn acceleration(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let times = times(track);
    let t = times.t_s;
    let mut figure = Figure::new(
        "acceleration",
        "Acceleration",
        "Specific force in sensor axes, including gravity: nominal scale and calibrated. Rests are shaded.",
    );
    let calibrated = motion.result.calibration.is_some();
    if !calibrated {
        "Specific force in sensor axes, including gravity. Rests are shaded."
            .clone_into(&mut figure.caption);
    }
    for (axis, name) in AXES.into_iter().enumerate() {
        let of = |name, role, column: &[f64]| {
            thin::line(name, role, times, |i| (at(t, i), at(column, i)))
        };
        let mut panel = panel(motion, name, "m/s²");
        if calibrated {
            panel = panel.with(of("raw", Role::Raw, &track.raw_mps2[axis]));
        }
        let own = of(
            result_name(motion),
            Role::Calibrated,
            &track.force_mps2[axis],
        );
        figure = figure.with(panel.with(own));
    }
    Some(figure)
}

/// Acceleration without gravity in the frame of the result.
pub(super) fn motion_acceleration(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let mut figure = Figure::new(
        "motion-acceleration",
        "Acceleration of the motion",
        format!(
            "Acceleration without gravity, in the frame of the result ({}).",
            motion.result.frame
        ),
    );
    for (axis, name) in AXES.into_iter().enumerate() {
        let own = line(
            result_name(motion),
            Role::Calibrated,
            times(track),
            &track.acceleration_mps2,
            axis,
        );
        figure = figure.with(panel(motion, name, "m/s²").with(own));
    }
    Some(figure)
}

/// Values with bands and what stands beside them.
struct Column<'a> {
    values: &'a [[f64; 3]],
    sigma: &'a [[f64; 3]],
    uncalibrated: Option<&'a [[f64; 3]]>,
    unit: &'a str,
}

fn banded(motion: &Motion<'_>, mut figure: Figure, column: &Column<'_>) -> Figure {
    let times = times(&motion.track);
    for (axis, name) in AXES.into_iter().enumerate() {
        let mut panel = panel(motion, name, column.unit);
        if !column.sigma.is_empty() {
            for (name, k) in [("± 2σ", 2.0), ("± 1σ", 1.0)] {
                let band = thin::band(name, Role::Calibrated, times, |i| {
                    let v = component(column.values, i, axis);
                    let half = k * component(column.sigma, i, axis);
                    (v - half, v + half)
                });
                panel = panel.with(band);
            }
        }
        if let Some(plain) = column.uncalibrated {
            panel = panel.with(line("uncalibrated", Role::Raw, times, plain, axis));
        }
        let name = result_name(motion);
        panel = panel.with(line(name, Role::Calibrated, times, column.values, axis));
        panel.y.within = limits(motion, column, axis);
        let beyond = panel.y.within.is_some_and(|[low, high]| {
            let mut bands = panel.series.iter().filter(|s| !s.low.is_empty());
            bands.any(|s| s.low.iter().any(|v| *v < low) || s.high.iter().any(|v| *v > high))
        });
        if beyond && !figure.caption.ends_with(CUT) {
            figure.caption.push_str(CUT);
        }
        figure = figure.with(panel);
    }
    figure
}

/// Said where a band is wider than the picture.
const CUT: &str = " Where they are much wider than the motion they are cut off.";

/// What the lines reach, and one and a half times as much on either side: bands
/// that dwarf them would leave nothing else to see.
fn limits(motion: &Motion<'_>, column: &Column<'_>, axis: usize) -> Option<[f64; 2]> {
    let reference = motion.reference;
    let reference = reference.filter(|_| column.unit == "m");
    let own = Extent::of(column.values)?;
    let others = [
        column.uncalibrated.and_then(Extent::of),
        reference.and_then(|r| Extent::of(&r.position_m)),
    ];
    let all = others.into_iter().flatten();
    let all = all.fold(own, |a, e| a.with(&e.low).with(&e.high));
    let (low, high) = (all.low[axis], all.high[axis]);
    let room = 1.5 * (high - low);
    (room > 0.0).then_some([low - room, high + room])
}

/// Velocity along each axis.
pub(super) fn velocity(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let figure = Figure::new(
        "velocity",
        "Velocity",
        format!(
            "Velocity in the frame of the result.{}",
            bands_told(&track.sigma_velocity_mps)
        ),
    );
    let column = Column {
        values: &track.velocity_mps,
        sigma: &track.sigma_velocity_mps,
        uncalibrated: track.uncalibrated.as_ref().map(|u| &u.velocity_mps[..]),
        unit: "m/s",
    };
    Some(banded(motion, figure, &column))
}

/// Position along each axis, with the reference where there is one.
pub(super) fn position(motion: &Motion<'_>) -> Option<Figure> {
    let track = &motion.track;
    let figure = Figure::new(
        "position",
        "Position",
        format!(
            "Position in the frame of the result.{}",
            bands_told(&track.sigma_position_m)
        ),
    );
    let column = Column {
        values: &track.position_m,
        sigma: &track.sigma_position_m,
        uncalibrated: track.uncalibrated.as_ref().map(|u| &u.position_m[..]),
        unit: "m",
    };
    let mut figure = banded(motion, figure, &column);
    if let Some(reference) = motion.reference {
        let t = &reference.t_s;
        for (axis, panel) in figure.panels.iter_mut().enumerate() {
            let own = line(
                "reference",
                Role::Reference,
                Times::from(t),
                &reference.position_m,
                axis,
            );
            panel.series.push(own);
        }
    }
    Some(figure)
}

fn bands_told(sigma: &[[f64; 3]]) -> &'static str {
    if sigma.is_empty() {
        ""
    } else {
        " Bands are the predicted standard uncertainty, once and twice."
    }
}
