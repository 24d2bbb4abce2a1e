//! Figures of a motion.

mod end;
mod plane;
mod space;
#[cfg(test)]
mod tests;
mod time;

use gravical::motion::{MotionResult, ReferenceTrack, Track};

use super::thin::Times;
use super::{Figure, Mark, Role};

/// Names of all figures that a motion can have, in the order of a report.
#[doc(hidden)]
pub const NAMES: [&str; 8] = [
    "acceleration",
    "motion-acceleration",
    "velocity",
    "trajectory",
    "position-3d",
    "position",
    "moves",
    "budget",
];

/// What is drawn.
struct Motion<'a> {
    result: &'a MotionResult,
    track: Track,
    reference: Option<&'a ReferenceTrack>,
}

/// All figures that a result allows, in the order of [`NAMES`]. Where nothing moved
/// there is the acceleration; what is not known is left out.
#[must_use]
pub fn figures(motion: &gravical::motion::Motion) -> Vec<Figure> {
    let motion = &Motion {
        result: &motion.result,
        track: motion.track(),
        reference: motion.reference.as_ref(),
    };
    let moved = !motion.result.moves.is_empty();
    let of_motion = |make: fn(&Motion<'_>) -> Option<Figure>| moved.then(|| make(motion)).flatten();
    let all = [
        time::acceleration(motion),
        of_motion(time::motion_acceleration),
        of_motion(time::velocity),
        of_motion(plane::trajectory),
        of_motion(space::position_3d),
        of_motion(time::position),
        of_motion(end::moves),
        of_motion(end::budget),
    ];
    all.into_iter().flatten().filter(shows_something).collect()
}

/// A result is known somewhere.
fn shows_something(figure: &Figure) -> bool {
    let mut series = figure.panels.iter().flat_map(|p| &p.series);
    series.any(|s| {
        s.role != Role::Guide
            && s.mark != Mark::Rule
            && s.y.iter().chain(&s.low).any(|v| v.is_finite())
    })
}

/// What the result is called beside the uncalibrated one.
fn result_name(motion: &Motion<'_>) -> &'static str {
    match motion.result.calibration {
        Some(_) => "calibrated",
        None => "without a calibration",
    }
}

/// Axes in the order of a vector.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The uncalibrated track has a panel beside it where it reaches so many times
/// further than the calibrated one: in one picture nothing else could be seen.
const FAR: f64 = 5.0;

/// Smallest and largest of each axis over what is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    low: [f64; 3],
    high: [f64; 3],
}

impl Extent {
    /// None where nothing is known.
    fn of<'a>(positions: impl IntoIterator<Item = &'a [f64; 3]>) -> Option<Self> {
        let mut extent = Extent {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        };
        for p in positions {
            if p.iter().all(|v| v.is_finite()) {
                extent = extent.with(p);
            }
        }
        (extent.low[0] <= extent.high[0]).then_some(extent)
    }

    fn with(&self, p: &[f64; 3]) -> Self {
        Extent {
            low: std::array::from_fn(|i| self.low[i].min(p[i])),
            high: std::array::from_fn(|i| self.high[i].max(p[i])),
        }
    }

    fn size(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.high[i] - self.low[i])
    }

    fn largest(&self) -> f64 {
        self.size().into_iter().fold(0.0, f64::max)
    }
}

/// First and last that is known.
fn ends(positions: &[[f64; 3]]) -> Option<([f64; 3], [f64; 3])> {
    let known = |p: &&[f64; 3]| p.iter().all(|v| v.is_finite());
    let first = positions.iter().find(known)?;
    let last = positions.iter().rev().find(known)?;
    Some((*first, *last))
}

/// Seconds as they are read: 3.25 s is 3.3 s, 120.4 s is 120 s.
fn seconds(t_s: f64, of_s: f64) -> String {
    let decimals = usize::from(of_s < 100.0) + usize::from(of_s < 1.0);
    format!("{t_s:.decimals$} s").replace('-', "−")
}
/// When the samples of a track were taken, and where some are missing.
fn times(track: &Track) -> Times<'_> {
    Times {
        t_s: &track.t_s,
        breaks: &track.breaks,
    }
}
