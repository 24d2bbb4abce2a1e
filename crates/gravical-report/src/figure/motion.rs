//! Figures of a motion and of an orientation.

use gravical::motion::{Motion, MotionSample, SampleState};

use gravical::numfmt::COVERAGE;

use super::drawing::{Drawing, Figure};
use super::panel::{Axis, Panel, Role, Series, XYZ, extent};
use super::space::track;

/// Bands of lengths are in view as far as this many times what the lines reach: wider ones would leave nothing else to
/// see.
const ROOM: f64 = 1.5;

/// All figures that a result allows. Where nothing moved there is the acceleration; what is not
/// known is left out.
pub fn figures(motion: &Motion) -> Vec<Figure> {
    let drawn = Drawn::new(motion);
    let is_calibrated = motion.result.computation.calibration.is_some();
    let mut force = vec![drawn.of_samples("measured", Role::Result, |s| s.force_mps2)];
    if is_calibrated {
        force[0].name = "calibrated";
        force.insert(0, drawn.of_samples("raw", Role::Raw, |s| s.raw_mps2));
    }
    let force = drawn.over_time("acceleration", "Specific force", "m/s²", &force, None);
    if motion.result.moves.is_empty() {
        return force.into_iter().collect();
    }
    let plain = motion.uncalibrated_states();
    let plain = plain
        .map(Iterator::collect::<Vec<SampleState>>)
        .unwrap_or_default();
    // Of the states: without the calibration, where there is one, and of the result.
    let of_states = |vector: fn(&SampleState) -> [f64; 3]| -> Vec<Vectors> {
        let without = plain.iter().map(vector).collect();
        let without = Vectors {
            name: "uncalibrated",
            role: Role::Raw,
            values: without,
        };
        let own = drawn.samples.iter().map(|s| vector(&s.state)).collect();
        let own = Vectors {
            name: "result",
            role: Role::Result,
            values: own,
        };
        let without = Some(without).filter(|v| !v.values.is_empty());
        without.into_iter().chain([own]).collect()
    };
    let positions = of_states(|s| s.position_m);
    let sd = |vector: fn(&SampleState) -> [f64; 3]| -> Vec<[f64; 3]> {
        drawn.samples.iter().map(|s| vector(&s.state)).collect()
    };
    let position_sd = sd(|s| s.position_sd_m);
    let space = path(
        &drawn,
        &positions,
        &position_sd,
        motion.result.r#final.position_m.is_some(),
    );
    let (velocities, velocity_sd) = (of_states(|s| s.velocity_mps), sd(|s| s.velocity_sd_mps));
    let linear = drawn.of_samples("result", Role::Result, |s| s.state.acceleration_mps2);
    let all = [
        space,
        drawn.over_time("position", "Position", "m", &positions, Some(&position_sd)),
        drawn.over_time(
            "velocity",
            "Velocity",
            "m/s",
            &velocities,
            Some(&velocity_sd),
        ),
        drawn.over_time(
            "motion-acceleration",
            "Acceleration without gravity",
            "m/s²",
            &[linear],
            None,
        ),
        force,
    ];
    all.into_iter().flatten().collect()
}

/// Those of its orientation: roll, pitch and yaw with their bands, and where the vertical points.
pub fn orientation(motion: &Motion) -> Vec<Figure> {
    let drawn = Drawn::new(motion);
    let angles = |s: &MotionSample| s.roll_pitch_yaw_deg();
    let mut rows: Vec<[f64; 3]> = drawn.samples.iter().map(angles).collect();
    // A turn goes on beyond 180°.
    for axis in [0, 2] {
        let mut turns = 0.0;
        for i in 1..rows.len() {
            let step = rows[i][axis] + turns - rows[i - 1][axis];
            if step.is_finite() {
                turns -= 360.0 * (step / 360.0).round();
            }
            rows[i][axis] += turns;
        }
    }
    let sd = drawn.samples.iter().map(|s| {
        let [tilt, heading] = s.attitude_sd_deg();
        [tilt, tilt, heading]
    });
    let sd: Vec<[f64; 3]> = sd.collect();
    let angles = [Vectors {
        name: "result",
        role: Role::Result,
        values: rows,
    }];
    let figure = drawn.over_time("angles", "Roll, pitch, yaw", "°", &angles, Some(&sd));
    let names = ["Roll", "Pitch", "Yaw"];
    figure
        .into_iter()
        .map(|mut figure| {
            if let Drawing::Panels(panels) = &mut figure.drawing {
                for (panel, name) in panels.iter_mut().zip(names) {
                    panel.name = format!("{name}, °");
                }
            }
            figure
        })
        .collect()
}

/// Vectors over time under one name.
struct Vectors {
    name: &'static str,
    role: Role,
    values: Vec<[f64; 3]>,
}

/// What all figures of a motion have.
struct Drawn {
    samples: Vec<MotionSample>,
    t_s: Vec<f64>,
    /// Rows before which others are missing.
    breaks: Vec<usize>,
    rests: Series,
}

impl Drawn {
    fn new(motion: &Motion) -> Drawn {
        let samples: Vec<MotionSample> = motion.samples().collect();
        let rests = motion.result.computation.rests.iter();
        let rests: Vec<[f64; 2]> = rests.map(|s| [s.start_s, s.end_s]).collect();
        Drawn {
            t_s: samples.iter().map(|s| s.t_s).collect(),
            breaks: motion.breaks().collect(),
            rests: Series::shade("at rest", Role::Rest, &rests),
            samples,
        }
    }

    fn of_samples(
        &self,
        name: &'static str,
        role: Role,
        vector: fn(&MotionSample) -> [f64; 3],
    ) -> Vectors {
        let values = self.samples.iter().map(vector).collect();
        Vectors { name, role, values }
    }

    /// A figure of a panel over time for each axis, with the rests shaded and a band of 95 % about the result, where
    /// its deviations are given; none where it shows nothing.
    fn over_time(
        &self,
        name: &str,
        title: &str,
        unit: &str,
        all: &[Vectors],
        sd: Option<&[[f64; 3]]>,
    ) -> Option<Figure> {
        let rows = || self.t_s.iter().copied();
        let panel = |axis: usize| {
            let line = |v: &Vectors| {
                let points = rows().zip(&v.values).map(|(t, v)| [t, v[axis]]);
                Series::line(v.name, v.role, points, &self.breaks)
            };
            let lines: Vec<Series> = all.iter().map(line).collect();
            let result = all.iter().filter(|v| v.role == Role::Result);
            let ends = |v: &[f64; 3], sd: &[f64; 3]| {
                [v[axis] - COVERAGE * sd[axis], v[axis] + COVERAGE * sd[axis]]
            };
            let bands = result.clone().filter_map(|v| {
                let each = rows().zip(v.values.iter().zip(sd?));
                let each = each.map(|(t, (v, sd))| [t, ends(v, sd)[0], ends(v, sd)[1]]);
                Some(Series::band(
                    &format!("{} ± 95 %", v.name),
                    v.role,
                    each,
                    &self.breaks,
                ))
            });
            let bands: Vec<Series> = bands.collect();
            let [low, high] = extent(all.iter().flat_map(|v| &v.values).map(|v| v[axis]));
            let bounds = result.flat_map(|v| v.values.iter().zip(sd.unwrap_or(&[])));
            let [least, most] = extent(bounds.flat_map(|(v, sd)| ends(v, sd)));
            let room = if unit == "°" {
                f64::INFINITY
            } else {
                ROOM * (high - low).max(1e-9)
            };
            let y = [
                low.min(least.max(low - room)),
                high.max(most.min(high + room)),
            ];
            let y = Axis::over("", "", y, 0.06);
            let x = Axis::over("time, s", "t = {} s", rows(), 0.0);
            let mut lines = lines;
            if let (Some(_), Some(own)) = (bands.first(), lines.last_mut()) {
                // A line and its band are one name.
                own.name += " ± 95 %";
            }
            let series = [self.rests.clone()].into_iter().chain(bands).chain(lines);
            Panel::new(XYZ[axis], unit, [x, y], series).linked("t")
        };
        let panels = [0, 1, 2].map(panel);
        let is_known = panels
            .iter()
            .any(|p| p.series[1..].iter().any(Series::has_values));
        is_known.then(|| Figure::new(name, title, "", panels))
    }
}

/// The path in space, with the end's uncertainty.
fn path(drawn: &Drawn, positions: &[Vectors], sd: &[[f64; 3]], ends: bool) -> Option<Figure> {
    let of = |role: Role| {
        positions
            .iter()
            .find(|v| v.role == role)
            .map_or(&[][..], |v| &v.values)
    };
    let is_known = |v: &&[f64; 3]| v.iter().all(|v| v.is_finite());
    let last = sd.iter().rfind(is_known).filter(|_| ends);
    let end_95 = last.map(|sd| sd.map(|v| COVERAGE * v));
    let space = track(&drawn.t_s, of(Role::Result), of(Role::Raw), end_95)?;
    Some(Figure {
        drawing: Drawing::Space(space),
        ..Figure::new("path", "Path in space", "", [])
    })
}
