//! Figures of a motion.

use std::f64::consts::PI;

use gravical::motion::truth::Reference;
use gravical::motion::{MotionResult, MotionSample, SampleState};

use super::panel::{Axis, Figure, Panel, Role, Series, XYZ};
use super::svg::{DIAMOND, extent};

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
        velocity(motion),
        acceleration(motion),
        motion_acceleration(motion),
    ];
    all.into_iter().flatten().collect()
}

/// Smallest and largest along an axis of the positions that are known.
fn span<'a, 'b: 'a>(paths: impl IntoIterator<Item = &'a Path<'b>>, axis: usize) -> [f64; 2] {
    let values = paths.into_iter().flat_map(|path| &path.values);
    let (low, high) = extent(values.map(|v| v[axis]).filter(|v| v.is_finite()));
    [low, high]
}

/// First and last that is known.
fn ends(positions: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
    let is_known = |p: &&[f64; 3]| p.iter().all(|v| v.is_finite());
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
        figure: Figure,
        unit: &str,
        series: impl Fn(usize) -> Vec<Series>,
    ) -> Option<Figure> {
        let rests = self.result.rests.iter();
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

    /// Vectors over time, the result with a band of twice its uncertainty.
    fn banded(
        &self,
        title: &str,
        unit: &str,
        paths: &[Path<'_>],
        sigma: &[[f64; 3]],
    ) -> Option<Figure> {
        let has_bands = ends(sigma).is_some();
        let bands = if has_bands {
            " The band is twice the predicted standard uncertainty; it is cut off where it is much wider than the motion."
        } else {
            ""
        };
        let caption = format!("{title} in the frame of the result.{bands}");
        let figure = Figure::new(&title.to_lowercase(), title, caption);
        let mut figure = self.over_time(figure, unit, |axis| {
            let result = paths.iter().filter(|p| has_bands && p.role == Role::Result);
            let bands = result.map(|result| {
                let ends = result.values.iter().zip(sigma);
                let ends = ends.map(|(v, s)| (v[axis] - 2.0 * s[axis], v[axis] + 2.0 * s[axis]));
                let (low, high) = ends.unzip();
                let x = result.t_s.to_vec();
                Series::band("± 2σ", Role::Result, x, low, high).thinned(result.breaks)
            });
            let lines = paths.iter().map(|p| p.line(|t, v| [t, v[axis]]));
            bands.chain(lines).collect()
        })?;
        // In view is what the lines reach, and one and a half times as much on either side: bands
        // that dwarf them would leave nothing else to see.
        for panel in &mut figure.panels {
            let (low, high) = extent(panel.series.iter().flat_map(|s| &s.y).copied());
            let room = 1.5 * (high - low);
            panel.y.within = (room > 0.0).then_some([low - room, high + room]);
        }
        Some(figure)
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
    let sigma = motion.column(|s| s.state.velocity_sd_mps);
    motion.banded("Velocity", "m/s", &paths, &sigma)
}

/// Position along each axis, with the reference where there is one.
fn position(motion: &Motion<'_>) -> Option<Figure> {
    let sigma = motion.column(|s| s.state.position_sd_m);
    motion.banded("Position", "m", &motion.positions(), &sigma)
}

/// The path in space: from above, and from the side where it reaches further.
fn trajectory(motion: &Motion<'_>) -> Option<Figure> {
    let paths = motion.positions();
    let [start, end] = ends(&motion.column(|s| s.state.position_m))?;
    let sigma = ends(&motion.column(|s| s.state.position_sd_m)).map(|[_, sigma]| sigma);
    // The uncalibrated path does not decide what is in view.
    let shown = || paths.iter().filter(|p| p.role != Role::Raw);
    let spans = [0, 1, 2].map(|axis| span(shown(), axis));
    let size = spans.map(|[low, high]| high - low);
    let room = 0.3 * size.into_iter().fold(0.0, f64::max);
    let side = if size[0] >= size[1] { [0, 2] } else { [1, 2] };
    let panel = |title: &str, plane: [usize; 2]| {
        let flat = |v: [f64; 3]| plane.map(|axis| v[axis]);
        let [x, y] = plane.map(|axis| {
            let [low, high] = spans[axis];
            let mut shown = Axis::new(XYZ[axis].0, "m");
            shown.within = (room > 0.0).then_some([low - room, high + room]);
            shown
        });
        let mut panel = Panel::new(title, x, y).equal();
        panel
            .series
            .extend(sigma.map(|s| ellipse(flat(end), flat(s))));
        panel
            .series
            .extend(paths.iter().map(|p| p.line(|_, v| flat(v))));
        let spot = |name, [x, y]: [f64; 2]| Series::points(name, Role::Result, vec![x], vec![y]);
        panel
            .with(spot("start", flat(start)))
            .with(spot("end", flat(end)).drawn_as(DIAMOND))
    };
    let caption = "The path from above and from the side, equal scale on both axes. Circle: start, diamond: end, shaded: ± 1σ of the end. What reaches much further than the path is cut off.";
    let figure = Figure::new("trajectory", "Trajectory", caption);
    Some(figure.beside([panel("from above", [0, 1]), panel("from the side", side)]))
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
    const NAMES: [&str; 5] = [
        "position",
        "trajectory",
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
        let along_y = samples.iter().map(|s| &s.state.position_m[1]);
        assert!(shown.y.iter().eq(along_y));
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
}
