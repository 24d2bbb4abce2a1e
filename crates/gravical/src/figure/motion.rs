//! Figures of a motion.

use crate::motion::Motion;

use super::{Axis, Figure, Panel, Role, Series, thin};

/// All figures that a result allows, in the order of a report.
#[must_use]
pub fn figures(motion: &Motion) -> Vec<Figure> {
    vec![velocity(motion)]
}

/// Velocity along each axis.
fn velocity(motion: &Motion) -> Figure {
    let track = &motion.track;
    let mut figure = Figure::new("velocity", "Velocity", "…");
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let line = thin::line("calibrated", Role::Calibrated, &track.t_s, |i| {
            (track.t_s[i], track.velocity_mps[i][axis])
        });
        let mut panel = Panel::new(Axis::new("time", "s"), Axis::new("", "m/s")).titled(name);
        for span in &motion.result.still {
            panel = panel.shaded("at rest", span.start_s, span.end_s);
        }
        if let Some(plain) = &track.uncalibrated {
            panel = panel.with(thin::line("uncalibrated", Role::Raw, &track.t_s, |i| {
                (
                    track.t_s[i],
                    plain.velocity_mps.get(i).map_or(f64::NAN, |v| v[axis]),
                )
            }));
        }
        figure = figure.with(panel.with(Series { ..line }));
    }
    figure
}
