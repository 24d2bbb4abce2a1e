//! Figures of a motion.

mod space;

use std::f64::consts::PI;

use gravical::motion::truth::Reference;
use gravical::motion::{MotionResult, MotionSample, SampleState};
use gravical::numfmt::decimals_for;

use super::panel::{Axis, Figure, Panel, Role, Series, XYZ};
use super::svg::{CIRCLE, DIAMOND, extent};

/// Rests that are shaded at most; a walk has thousands.
const MAX_SHADED: usize = 2000;

/// The uncalibrated path has a panel beside it where it reaches so many times further than the
/// calibrated one: in one picture nothing else could be seen.
const FAR: f64 = 5.0;

/// What is drawn.
struct Motion<'a> {
    result: &'a MotionResult,
    t_s: Vec<f64>,
    samples: Vec<MotionSample>,
    /// Samples before which others are missing.
    breaks: Vec<usize>,
    uncalibrated: Option<Vec<SampleState>>,
    reference: Option<&'a Reference>,
    /// What the result is called beside the uncalibrated one.
    name: &'static str,
}

/// All figures that a result allows. Where nothing moved there is the acceleration; what is not
/// known is left out.
#[must_use]
pub fn figures(motion: &gravical::motion::Motion) -> Vec<Figure> {
    let name = match motion.result.calibration {
        Some(_) => "calibrated",
        None => "without a calibration",
    };
    let motion = &Motion {
        result: &motion.result,
        t_s: motion.samples().map(|s| s.t_s).collect(),
        samples: motion.samples().collect(),
        breaks: motion.breaks().collect(),
        uncalibrated: motion.uncalibrated_states().map(Iterator::collect),
        reference: motion.reference.as_ref(),
        name,
    };
    if motion.result.moves.is_empty() {
        return acceleration(motion).into_iter().collect();
    }
    let all = [
        position(motion),
        trajectory(motion),
        space::position_3d(motion),
        velocity(motion),
        acceleration(motion),
        motion_acceleration(motion),
    ];
    all.into_iter().flatten().collect()
}

/// Smallest and largest along each axis of the positions that are known; none without any.
fn extents<'a>(positions: impl IntoIterator<Item = &'a [f64; 3]>) -> Option<[[f64; 2]; 3]> {
    let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for p in positions.into_iter().filter(is_known) {
        for (a, v) in all.iter_mut().zip(p) {
            *a = [a[0].min(*v), a[1].max(*v)];
        }
    }
    (all[0][0] <= all[0][1]).then_some(all)
}

/// Length of the longest side.
fn longest(extents: &[[f64; 2]; 3]) -> f64 {
    extents
        .iter()
        .map(|[low, high]| high - low)
        .fold(0.0, f64::max)
}

fn is_known(p: &&[f64; 3]) -> bool {
    p.iter().all(|v| v.is_finite())
}

/// First and last that is known.
fn ends(positions: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
    let first = positions.iter().find(is_known)?;
    Some([*first, *positions.iter().rfind(is_known)?])
}

/// Vectors over time under one name.
struct Path<'a> {
    name: &'static str,
    role: Role,
    t_s: &'a [f64],
    /// Rows before which others are missing.
    breaks: &'a [usize],
    values: Vec<[f64; 3]>,
}

impl Path<'_> {
    /// A line through the places that `point` gives for time and vector.
    fn line(&self, point: impl Fn(f64, [f64; 3]) -> [f64; 2]) -> Series {
        let points = self.t_s.iter().zip(&self.values);
        let points = points.map(|(t, v)| <(f64, f64)>::from(point(*t, *v)));
        let (x, y) = points.unzip();
        Series::line(self.name, self.role, x, y).thinned(self.breaks)
    }
}

impl Motion<'_> {
    /// A vector of each sample.
    fn column(&self, vector: impl Fn(&MotionSample) -> [f64; 3]) -> Vec<[f64; 3]> {
        self.samples.iter().map(vector).collect()
    }

    /// Vectors of the result.
    fn result(&self, vector: impl Fn(&MotionSample) -> [f64; 3]) -> Path<'_> {
        Path {
            name: self.name,
            role: Role::Result,
            t_s: &self.t_s,
            breaks: &self.breaks,
            values: self.column(vector),
        }
    }

    /// Vectors without the calibration; none without one.
    fn uncalibrated(&self, vector: impl Fn(&SampleState) -> [f64; 3]) -> Option<Path<'_>> {
        let states = self.uncalibrated.as_ref()?.iter();
        Some(Path {
            name: "uncalibrated",
            role: Role::Raw,
            t_s: &self.t_s,
            breaks: &self.breaks,
            values: states.map(vector).collect(),
        })
    }

    /// Positions uncalibrated, of the result, and of the reference.
    fn positions(&self) -> Vec<Path<'_>> {
        let plain = self.uncalibrated(|s| s.position_m);
        let reference = self.reference.map(|r| Path {
            name: "reference",
            role: Role::Reference,
            t_s: &r.t_s,
            breaks: &[],
            values: r.position_m.clone(),
        });
        let result = self.result(|s| s.state.position_m);
        plain.into_iter().chain([result]).chain(reference).collect()
    }

    /// A figure of a panel over time for each axis, with the rests shaded; none where it shows
    /// nothing.
    fn over_time(
        &self,
        mut figure: Figure,
        unit: &str,
        series: impl Fn(usize) -> Vec<Series>,
    ) -> Option<Figure> {
        if self.result.rests.len() > MAX_SHADED {
            figure.caption += &format!(" Only the first {MAX_SHADED} rests are shaded.");
        }
        let rests = self.result.rests.iter().take(MAX_SHADED);
        let rests: Vec<[f64; 2]> = rests.map(|s| [s.start_s, s.end_s]).collect();
        let axes = XYZ.into_iter().enumerate();
        let figure = axes.fold(figure, |figure, (axis, (name, _))| {
            let panel = Panel::new(name, Axis::new("time", "s"), Axis::new("", unit));
            let mut panel = panel.with(Series::intervals("at rest", &rests));
            panel.series.extend(series(axis));
            figure.with(panel)
        });
        let lines = figure.panels.iter().flat_map(|p| &p.series[1..]);
        lines.into_iter().any(Series::has_values).then_some(figure)
    }
}

/// Specific force raw and calibrated, along the axes of the sensor.
fn acceleration(motion: &Motion<'_>) -> Option<Figure> {
    let raw = Path {
        name: "raw",
        role: Role::Raw,
        ..motion.result(|s| s.raw_mps2)
    };
    let force = motion.result(|s| s.force_mps2);
    let (paths, both) = match motion.result.calibration {
        Some(_) => (vec![raw, force], ": nominal scale and calibrated"),
        None => (vec![force], ""),
    };
    let caption =
        format!("Specific force in sensor axes, including gravity{both}. Rests are shaded.");
    let figure = Figure::new("acceleration", "Acceleration", caption);
    motion.over_time(figure, "m/s²", |axis| {
        paths.iter().map(|p| p.line(|t, v| [t, v[axis]])).collect()
    })
}

/// Acceleration without gravity in the frame of the result.
fn motion_acceleration(motion: &Motion<'_>) -> Option<Figure> {
    let frame = &motion.result.frame;
    let caption = format!("Acceleration without gravity, in the frame of the result ({frame}).");
    let figure = Figure::new("motion-acceleration", "Acceleration of the motion", caption);
    let values = motion.result(|s| s.state.acceleration_mps2);
    motion.over_time(figure, "m/s²", |axis| {
        vec![values.line(|t, v| [t, v[axis]])]
    })
}

/// Velocity along each axis.
fn velocity(motion: &Motion<'_>) -> Option<Figure> {
    let plain = motion.uncalibrated(|s| s.velocity_mps);
    let result = motion.result(|s| s.state.velocity_mps);
    let paths: Vec<Path<'_>> = plain.into_iter().chain([result]).collect();
    let figure = Figure::new(
        "velocity",
        "Velocity",
        "Velocity in the frame of the result.",
    );
    let sigma = motion.column(|s| s.state.velocity_sd_mps);
    banded(motion, figure, "m/s", &paths, &sigma)
}

/// Position along each axis, with the reference where there is one.
fn position(motion: &Motion<'_>) -> Option<Figure> {
    let figure = Figure::new(
        "position",
        "Position",
        "Position in the frame of the result.",
    );
    let sigma = motion.column(|s| s.state.position_sd_m);
    banded(motion, figure, "m", &motion.positions(), &sigma)
}

/// Vectors over time, the result with bands of once and twice its uncertainty.
fn banded(
    motion: &Motion<'_>,
    figure: Figure,
    unit: &str,
    paths: &[Path<'_>],
    sigma: &[[f64; 3]],
) -> Option<Figure> {
    let result = paths.iter().find(|p| p.role == Role::Result)?;
    let has_bands = ends(sigma).is_some();
    let mut figure = motion.over_time(figure, unit, |axis| {
        let band = |(name, k): (&str, f64)| {
            let ends = result.values.iter().zip(sigma);
            let ends =
                ends.map(|(v, sigma)| (v[axis] - k * sigma[axis], v[axis] + k * sigma[axis]));
            let (low, high) = ends.unzip();
            let x = result.t_s.to_vec();
            Series::band(name, Role::Result, x, low, high).thinned(result.breaks)
        };
        let bands = [("± 2σ", 2.0), ("± 1σ", 1.0)].into_iter();
        let bands = bands.filter(|_| has_bands).map(band);
        bands
            .chain(paths.iter().map(|p| p.line(|t, v| [t, v[axis]])))
            .collect()
    })?;
    if !has_bands {
        return Some(figure);
    }
    figure
        .caption
        .push_str(" Bands are the predicted standard uncertainty, once and twice.");
    // In view is what the lines reach, and one and a half times as much on either side: bands that
    // dwarf them would leave nothing else to see.
    let mut cut = false;
    for panel in &mut figure.panels {
        let (low, high) = extent(panel.series.iter().flat_map(|s| &s.y).copied());
        let room = 1.5 * (high - low);
        if room > 0.0 {
            panel.y.within = Some([low - room, high + room]);
            let mut bands = panel.series.iter().flat_map(|s| s.low.iter().zip(&s.high));
            cut |= bands.any(|(l, h)| *l < low - room || *h > high + room);
        }
    }
    if cut {
        let cut = " Where they are much wider than the motion they are cut off.";
        figure.caption.push_str(cut);
    }
    Some(figure)
}

/// The path seen from above; where it goes up more than along, from the side.
fn trajectory(motion: &Motion<'_>) -> Option<Figure> {
    let paths = motion.positions();
    let position = motion.column(|s| s.state.position_m);
    let around = extents(&position)?;
    let plane = plane_of(&around);
    let plain = paths
        .iter()
        .find(|p| p.role == Role::Raw)
        .and_then(|p| extents(&p.values));
    let far = plain.is_some_and(|plain| longest(&plain) > FAR * longest(&around));
    // An ellipse much larger than the path would be all that is seen.
    let sigma = ends(&motion.column(|s| s.state.position_sd_m)).map(|[_, sigma]| sigma);
    let drawn = sigma.filter(|s| plane.iter().all(|&i| s[i] <= longest(&around)));
    let uncertainty = match (sigma, drawn) {
        (None, _) => String::new(),
        (_, Some(_)) => ", the ellipse ± 1σ of its position".to_owned(),
        (Some(sigma), None) => {
            let [a, b] = plane.map(|i| {
                let decimals = decimals_for(sigma[i]);
                format!("{:.decimals$} m along {}", sigma[i], XYZ[i].0)
            });
            format!("; 1σ of its position is {a} and {b}, more than the picture shows")
        }
    };
    let [x, y] = plane.map(|i| XYZ[i].0);
    let seen = match plane {
        [0, 1] => "seen from above".to_owned(),
        _ => format!("in the plane of {x} and {y}, where it reaches furthest"),
    };
    let caption = format!(
        "The path {seen}, equal scale on both axes. Circle: start, diamond: end{uncertainty}."
    );
    let figure = Figure::new("trajectory", "Trajectory", caption);
    let panel = |title: &str, roles: &[Role]| Panel {
        series: in_plane(&paths, roles, plane, drawn),
        ..Panel::new(title, Axis::new(x, "m"), Axis::new(y, "m"))
    };
    let [result, all] = [
        &[Role::Result, Role::Reference][..],
        &[Role::Raw, Role::Result, Role::Reference],
    ];
    if far {
        let panels = [panel(motion.name, result), panel("and uncalibrated", all)];
        return Some(figure.beside(panels.map(|p| p.equal(1.0))));
    }
    // As high as the path needs, within reason.
    let panel = panel("", all);
    let span = |column: fn(&Series) -> &Vec<f64>| {
        let (low, high) = extent(panel.series.iter().flat_map(column).copied());
        high - low
    };
    let aspect = span(|s| &s.y) / span(|s| &s.x);
    let aspect = if aspect.is_nan() {
        0.6
    } else {
        aspect.clamp(0.35, 0.8)
    };
    Some(figure.with(panel.equal(aspect)))
}

/// The two axes to show: x and y, unless z reaches further than both.
fn plane_of(extents: &[[f64; 2]; 3]) -> [usize; 2] {
    let [x, y, z] = extents.map(|[low, high]| high - low);
    if z <= x.max(y) {
        [0, 1]
    } else if x >= y {
        [0, 2]
    } else {
        [1, 2]
    }
}

fn spot(name: &str, role: Role, at: [f64; 2], symbol: &'static str) -> Series {
    Series::points(name, role, vec![at[0]], vec![at[1]]).drawn_as(symbol)
}

/// Paths of these roles with their ends; about that of the result an ellipse of `sigma`.
fn in_plane(
    paths: &[Path<'_>],
    roles: &[Role],
    plane: [usize; 2],
    sigma: Option<[f64; 3]>,
) -> Vec<Series> {
    let flat = |v: [f64; 3]| plane.map(|i| v[i]);
    let paths = || paths.iter().filter(|p| roles.contains(&p.role));
    let mut series: Vec<Series> = paths().map(|p| p.line(|_, v| flat(v))).collect();
    for path in paths() {
        let Some([start, end]) = ends(&path.values).map(|ends| ends.map(flat)) else {
            continue;
        };
        match path.role {
            Role::Raw => series.push(spot("end, uncalibrated", path.role, end, DIAMOND)),
            Role::Result => {
                series.extend(sigma.map(|sigma| ellipse(end, flat(sigma))));
                series.push(spot("start", path.role, start, CIRCLE));
                series.push(spot("end", path.role, end, DIAMOND));
            }
            _ => {}
        }
    }
    series
}

/// The area within one standard uncertainty of the end.
fn ellipse([x, y]: [f64; 2], [a, b]: [f64; 2]) -> Series {
    let turn = || (0..=72).map(|k| f64::sin_cos(PI * f64::from(k) / 72.0));
    let side = |b: f64| turn().map(|(sine, _)| y + b * sine).collect();
    let x = turn().map(|(_, cosine)| x - a * cosine).collect();
    Series::band("± 1σ at the end", Role::Result, x, side(-b), side(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::svg;
    use gravical::motion::truth::{add_comparison, read_reference};
    use gravical::motion::{MotionOptions, motion};
    use gravical::recording::{ReadOptions, read, read_bytes};
    use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate_to};

    /// In the order of a report.
    const NAMES: [&str; 6] = [
        "position",
        "trajectory",
        "position-3d",
        "velocity",
        "acceleration",
        "motion-acceleration",
    ];

    fn drawable(figures: &[Figure]) {
        for figure in figures {
            assert!(NAMES.contains(&figure.name.as_str()));
            let text = svg::standalone(figure);
            roxmltree::Document::parse(&text).unwrap();
            assert!(!text.contains("NaN"), "{text}");
        }
    }

    fn series<'a>(figures: &'a [Figure], name: &str, panel: usize, series: &str) -> &'a Series {
        let figure = figures.iter().find(|f| f.name == name).unwrap();
        let all = figure.panels[panel].series.iter();
        all.into_iter().find(|s| s.name == series).unwrap()
    }

    #[test]
    fn a_line_has_the_figures_of_its_track_and_of_a_reference() {
        let folder = tempfile::tempdir().unwrap();
        let options = SimulateOptions::new(Scenario::Line(LineOptions::default()));
        let (_, files) = simulate_to(&options, folder.path(), false).unwrap();
        let csv = files
            .iter()
            .find(|p| p.extension().is_some_and(|e| e == "csv"))
            .unwrap();
        let recording = read(csv, &ReadOptions::default()).unwrap();
        let mut motion = motion(&recording, None, &MotionOptions::default()).unwrap();
        let samples: Vec<MotionSample> = motion.samples().collect();
        let truth = folder.path().join("truth.csv");
        let line = |s: &MotionSample| {
            let [x, y, z] = s.state.position_m;
            format!("{},{x},{y},{z}\n", s.t_s)
        };
        let rows: String = samples.iter().step_by(10).map(line).collect();
        std::fs::write(&truth, format!("t_s,px_m,py_m,pz_m\n{rows}")).unwrap();
        let reference = read_reference(&truth, &recording, csv).unwrap();
        add_comparison(&mut motion, &reference).unwrap();

        let figures = figures(&motion);
        drawable(&figures);
        let names: Vec<&str> = figures.iter().map(|f| &f.name[..]).collect();
        assert_eq!(names, NAMES);
        let shown = series(&figures, "position", 1, "without a calibration");
        assert!(
            shown
                .y
                .iter()
                .eq(samples.iter().map(|s| &s.state.position_m[1]))
        );
        let state = samples.last().unwrap().state;
        let (last, sigma) = (shown.y.last().unwrap(), state.position_sd_m[1]);
        let band = series(&figures, "position", 1, "± 2σ");
        assert_eq!(band.high.last(), Some(&(last + 2.0 * sigma)));
        let rests = series(&figures, "position", 0, "at rest").x.len();
        assert_eq!(rests, 2 * motion.result.rests.len());
        let reference = motion.reference.as_ref().unwrap().t_s.len();
        assert_eq!(
            series(&figures, "position", 2, "reference").y.len(),
            reference
        );
        let end = series(&figures, "trajectory", 0, "end");
        let at = motion.result.r#final.position_m.unwrap();
        assert_eq!((end.x[0], end.y[0]), (at[0], at[1]));
    }

    #[test]
    fn tiny_and_constant_recordings_have_at_most_their_acceleration() {
        for rows in [2, 40, 1000] {
            let text: String = (0..rows)
                .map(|i| format!("{},0,0,9.81\n", 10 * i))
                .collect();
            let text = format!("t_ms,ax,ay,az\n{text}");
            let recording = read_bytes(text.as_bytes(), "c.csv", &ReadOptions::default()).unwrap();
            if let Ok(motion) = motion(&recording, None, &MotionOptions::default()) {
                let figures = figures(&motion);
                drawable(&figures);
                assert!(figures.iter().all(|f| f.name == "acceleration"));
            }
        }
    }

    #[test]
    fn the_plane_is_where_it_moves() {
        let plane = |high: [f64; 3]| plane_of(&high.map(|h| [0.0, h]));
        assert_eq!(plane([1.0, 2.0, 1.5]), [0, 1]);
        assert_eq!(plane([1.0, 2.0, 70.0]), [1, 2]);
        assert_eq!(plane([1.0, 0.0, 70.0]), [0, 2]);
    }
}
