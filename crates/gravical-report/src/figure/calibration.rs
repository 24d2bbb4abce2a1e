//! Figures of a calibration.

use std::f64::consts::PI;

use gravical::calibration_file::{CalibrationFile, PoseResult};
use gravical::core::matrix3::{norm as length, unit};
use gravical::numfmt::{self, milli_g};
use gravical::poses::Segmentation;
use gravical::recording::Recording;

use super::panel::{Axis, Figure, Panel, Role, Series, XYZ};
use super::svg::extent;

/// The recordings behind a calibration, and how they were cut.
#[derive(Debug, Clone, Copy)]
pub struct Session<'a> {
    /// The recordings.
    pub recordings: &'a [Recording],
    /// Poses and turns.
    pub segmentation: &'a Segmentation,
}

/// All figures that a calibration allows. What the data do not show is left out; without the
/// session that is the recordings, noise and the temperature.
#[must_use]
pub fn figures(file: &CalibrationFile, session: Option<Session<'_>>) -> Vec<Figure> {
    let mut all = Vec::new();
    if !file.accelerometer.poses.is_empty() {
        all.extend([norm(file), residuals(file), sphere(file)]);
    }
    if let Some(session) = session {
        let track = Track::of(session.recordings);
        all.extend(captures(file, &track, session.segmentation));
        all.extend(noise(file, session));
        all.extend(temperature(&track));
    }
    all
}

/// Unit of raw values.
fn raw_unit(file: &CalibrationFile) -> String {
    numfmt::unit(file.accelerometer.input_unit.name())
}

/// A panel over the poses.
fn over_poses(poses: &[PoseResult], y: Axis) -> Panel {
    Panel::new(
        "",
        Axis::names("pose", poses.iter().map(|p| p.label.as_str())),
        y,
    )
}

/// ‖a‖ of each pose before and after, and what is left of its error, with the pose in the fit and
/// left out.
fn norm(file: &CalibrationFile) -> Figure {
    let (poses, g) = (&file.accelerometer.poses, file.gravity_mps2);
    let off = |p: &PoseResult| length(&p.calibrated) - g;
    let directions = poses.iter().map(|p| unit(&p.calibrated).into());
    let deviations = file.sensor().map(|mut sensor| {
        sensor.model_error_mps2 = 0.0;
        let claims = sensor.claims(directions).into_iter();
        claims.map(|c| milli_g(c.sd_mps2)).collect::<Vec<f64>>()
    });
    let left = Series::categorical(
        "calibrated",
        Role::Result,
        poses.iter().map(|p| milli_g(off(p))),
    );
    let left = match &deviations {
        Some(sd) => left.plus_minus(sd),
        None => left,
    };
    let left_out = poses
        .iter()
        .map(|p| p.left_out_error_mps2.map_or(f64::NAN, milli_g));
    let near = over_poses(poses, Axis::new("‖a‖ − g", "mg"))
        .with(Series::rule("local gravity", 0.0, poses.len()))
        .with(Series::categorical(
            "left out of the fit",
            Role::Warning,
            left_out,
        ))
        .with(left);
    let raw = poses.iter().map(|p| file.accelerometer.nominally(p.raw));
    let before: Option<Vec<f64>> = raw.map(|a| a.map(|a| length(&a))).collect();
    let caption = "At rest ‖a‖ is local gravity in every pose. Before: by the nominal scale, if that is known. Bars are ± 1σ of the parameters; only an error with the pose left out of the fit measures how accurate the calibration is.";
    let figure = Figure::new("norm", "Magnitude at rest", caption);
    // Without a nominal scale there is no before, and the other panel says it all.
    let both = before.map(|before| {
        over_poses(poses, Axis::new("‖a‖", "m/s²"))
            .with(Series::rule("local gravity", g, poses.len()))
            .with(Series::categorical("before", Role::Raw, before))
            .with(Series::categorical(
                "calibrated",
                Role::Result,
                poses.iter().map(|p| off(p) + g),
            ))
    });
    both.into_iter().fold(figure, Figure::with).with(near)
}

/// The components of vectors over names.
fn components(panel: Panel, vectors: &[[f64; 3]]) -> Panel {
    let axes = XYZ.into_iter().enumerate();
    axes.fold(panel, |panel, (axis, (name, role))| {
        panel.with(Series::categorical(
            name,
            role,
            vectors.iter().map(|v| v[axis]),
        ))
    })
}

/// Error of each pose along the axes.
fn residuals(file: &CalibrationFile) -> Figure {
    let poses = &file.accelerometer.poses;
    let vectors: Vec<[f64; 3]> = poses.iter().map(|p| p.error.map(|e| 1e3 * e)).collect();
    let panel = over_poses(poses, Axis::new("error", "mm/s²")).with(Series::rule(
        "no error",
        0.0,
        poses.len(),
    ));
    let caption = "Calibrated minus expected value along each axis (free poses: along their own direction); for a face pose this includes its tilt.";
    Figure::new("residuals", "Errors of the poses", caption).with(components(panel, &vectors))
}

/// Where the poses point, and where the next ones would help: two hemispheres.
fn sphere(file: &CalibrationFile) -> Figure {
    let caption = "Direction of specific force (up, in sensor axes) at each pose: two hemispheres in equal-area projection, circles at 30° and 60°.";
    Figure::new("sphere", "Poses on the sphere", caption).beside([
        hemisphere(file, 1.0, "seen from +z"),
        hemisphere(file, -1.0, "seen from −z"),
    ])
}

/// Where a unit vector lies in the disc of radius 1 whose centre is ±z: the equal-area projection
/// of J. H. Lambert (1772; Snyder, Map Projections, 1987, ch. 24). Seen from below x runs to the
/// left where y runs up.
fn project(d: [f64; 3], side: f64) -> (f64, f64) {
    let k = 1.0 / (1.0 + (side * d[2]).max(0.0)).sqrt();
    (side * d[0] * k, d[1] * k)
}

fn hemisphere(file: &CalibrationFile, side: f64, title: &str) -> Panel {
    let a = &file.accelerometer;
    let rim = || Axis::hidden([-1.14, 1.14]);
    let mut panel = Panel::new(title, rim(), rim()).equal();
    // Circles at 30°, 60° and 90° from the pole.
    for off_deg in [30.0_f64, 60.0, 90.0] {
        let (sine, cosine) = off_deg.to_radians().sin_cos();
        let turn = (0..=96).map(|i| (2.0 * PI * f64::from(i) / 96.0).sin_cos());
        let points = turn.map(|(sin, cos)| project([sine * cos, sine * sin, side * cosine], side));
        let (x, y) = points.unzip();
        panel = panel.with(Series::line("circle", Role::Guide, x, y));
    }
    let axes = [
        ("+x", side, 0.0),
        ("−x", -side, 0.0),
        ("+y", 0.0, 1.0),
        ("−y", 0.0, -1.0),
    ];
    for (name, x, y) in axes {
        let text = Series::points("axes", Role::Guide, vec![1.1 * x], vec![1.1 * y]);
        panel = panel
            .with(Series::line(
                "axes",
                Role::Guide,
                vec![0.0, x],
                vec![0.0, y],
            ))
            .with(text.labelled(vec![name.to_owned()]));
    }
    let points = |name, role, poses: &mut dyn Iterator<Item = ([f64; 3], String)>| {
        let here = poses.filter(|(d, _)| (d[2] >= 0.0) == (side > 0.0));
        let (places, labels): (Vec<_>, Vec<_>) = here.map(|(d, l)| (project(d, side), l)).unzip();
        let (x, y) = places.into_iter().unzip();
        Series::points(name, role, x, y).labelled(labels)
    };
    let poses = |fitted: bool| {
        let poses = a.poses.iter().filter(move |p| p.fitted == fitted);
        poses.map(|p| (unit(&p.calibrated), p.label.clone()))
    };
    let next = a.proposed_poses().iter().enumerate();
    let mut next = next.map(|(i, pose)| (pose.direction, format!("next {}", i + 1)));
    panel
        .with(points("pose", Role::Result, &mut poses(true)))
        .with(points("not in the fit", Role::Bad, &mut poses(false)))
        .with(points("would help", Role::Warning, &mut next))
}

/// Recordings one after the other on one axis of time.
struct Track<'a> {
    recordings: &'a [Recording],
    /// Time of each row, s.
    t_s: Vec<f64>,
    /// Rows before which others are missing.
    breaks: Vec<usize>,
    /// First row of each recording.
    starts: Vec<usize>,
}

impl<'a> Track<'a> {
    fn of(recordings: &'a [Recording]) -> Self {
        let (mut t_s, mut breaks, mut starts) = (Vec::<f64>::new(), Vec::new(), Vec::new());
        let mut from_s = 0.0;
        for recording in recordings {
            let start = t_s.len();
            starts.push(start);
            breaks.push(start);
            breaks.extend(recording.breaks.iter().map(|b| start + b));
            let period_s = 1.0 / recording.working_rate_hz().0;
            match &recording.time_s {
                Some(time_s) => t_s.extend(time_s.iter().map(|t| from_s + t)),
                None => t_s.extend((0..recording.rows()).map(|i| from_s + period_s * i as f64)),
            }
            // A gap that is seen where the next recording begins.
            let end_s = extent(t_s[start..].iter().copied()).1.max(from_s);
            from_s = end_s + 0.1 * (end_s - from_s);
        }
        Track {
            recordings,
            t_s,
            breaks,
            starts,
        }
    }

    fn axis(&self) -> Axis {
        match self.recordings {
            [_] => Axis::new("time", "s"),
            _ => Axis::new("time, one recording after the other", "s"),
        }
    }

    /// A line through a column of all recordings.
    fn line(
        &self,
        name: &str,
        role: Role,
        column: impl Fn(&'a Recording) -> Option<&'a Vec<f64>>,
    ) -> Series {
        let values = |r: &'a Recording| {
            let known = column(r).into_iter().flatten().copied();
            known.chain(std::iter::repeat(f64::NAN)).take(r.rows())
        };
        let y = self.recordings.iter().flat_map(values).collect();
        Series::line(name, role, self.t_s.clone(), y).thinned(&self.breaks)
    }
}

/// Raw readings along each axis, with the poses' windows.
fn captures(file: &CalibrationFile, track: &Track<'_>, cut: &Segmentation) -> Option<Figure> {
    let (mut windows, mut names) = (Vec::new(), Vec::new());
    for pose in &cut.poses {
        let start = *track.starts.get(pose.recording)?;
        if pose.rows.is_empty() {
            continue;
        }
        let window = [
            *track.t_s.get(start + pose.rows.start)?,
            *track.t_s.get(start + pose.rows.end - 1)?,
        ];
        if window.iter().all(|t| t.is_finite()) {
            windows.push(window);
            names.push(pose.face.map_or_else(|| pose.label.clone(), |f| f.name()));
        }
    }
    let caption = "Raw recording. Shaded: the poses whose means were used.";
    let mut figure = Figure::new("captures", "Recorded poses", caption);
    for (axis, (name, _)) in XYZ.into_iter().enumerate() {
        let line = track.line("raw", Role::Raw, |r| r.accel.get(axis));
        let mut panel = Panel::new(name, track.axis(), Axis::new("", &raw_unit(file)));
        panel = panel.with(Series::intervals("used", &windows));
        // The names of few windows, above the line.
        if axis == 0 && windows.len() <= 12 {
            let (low, high) = extent(line.y.iter().copied());
            let above = high + 0.14 * (high - low).max(1e-6 * high.abs());
            let middles = windows.iter().map(|w| 0.5 * (w[0] + w[1])).collect();
            let texts = Series::points("pose", Role::Guide, middles, vec![above; windows.len()]);
            panel = panel.with(texts.labelled(names.clone()));
        }
        figure = figure.with(panel.with(line));
    }
    (!track.t_s.is_empty()).then_some(figure)
}

/// Standard deviation of the samples in each pose.
fn noise(file: &CalibrationFile, session: Session<'_>) -> Option<Figure> {
    let poses = &session.segmentation.poses;
    let results = &file.accelerometer.poses;
    let results = (results.len() == poses.len()).then_some(results);
    let noise = poses.iter().enumerate().filter_map(|(i, pose)| {
        let recording = session.recordings.get(pose.recording)?;
        let sigma = [0, 1, 2].map(|axis| {
            let values = recording.accel[axis].get(pose.rows.clone());
            deviation(values.into_iter().flatten().copied())
        });
        let name = results.map_or(&pose.label, |results| &results[i].label);
        sigma.iter().any(|s| s.is_finite()).then_some((name, sigma))
    });
    let (names, sigma): (Vec<&String>, Vec<[f64; 3]>) = noise.unzip();
    let y = Axis::new("noise, 1σ of a sample", &raw_unit(file)).including(&[0.0]);
    let panel = Panel::new("", Axis::names("pose", names), y);
    let caption = "Standard deviation of the samples of each pose. A high value indicates a disturbed pose, zero a frozen axis.";
    let figure = Figure::new("noise", "Noise at rest", caption);
    (!sigma.is_empty()).then(|| figure.with(components(panel, &sigma)))
}

/// Standard deviation of what is finite; NaN of fewer than three values.
fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    f64::sqrt(squares / if n > 2.0 { n - 1.0 } else { f64::NAN })
}

/// Temperature over time.
fn temperature(track: &Track<'_>) -> Option<Figure> {
    let line = track.line("temperature", Role::Result, |r| r.temperature_c.as_ref());
    let caption = "Temperature while the sensor was recorded.";
    let figure = Figure::new("temperature", "Temperature", caption);
    let panel = Panel::new("", track.axis(), Axis::new("temperature", "°C"));
    line.has_values().then(|| figure.with(panel.with(line)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::svg;
    use gravical::calibrate::{CalibrateOptions, calibrate};
    use gravical::calibration_file::Method;
    use gravical::recording::{ReadOptions, read, read_bytes};
    use gravical::simulate::{
        PosesOptions, Scenario, SimulateOptions, SixPositionOptions, simulate_to,
    };

    /// In the order of a report.
    const NAMES: [&str; 6] = [
        "norm",
        "residuals",
        "sphere",
        "captures",
        "noise",
        "temperature",
    ];

    fn recordings(scenario: Scenario) -> Vec<Recording> {
        let folder = tempfile::tempdir().unwrap();
        let (_, files) =
            simulate_to(&SimulateOptions::new(scenario), folder.path(), false).unwrap();
        let csv = files
            .iter()
            .filter(|p| p.extension().is_some_and(|e| e == "csv"));
        csv.map(|p| read(p, &ReadOptions::default()).unwrap())
            .collect()
    }

    /// The figures of a calibration, all of which can be drawn, with and without its session.
    fn figures_of(recordings: &[Recording], method: Method) -> (CalibrationFile, Vec<Figure>) {
        let mut options = CalibrateOptions::default();
        options.estimate.method = method;
        let done = calibrate(recordings, &options).unwrap();
        let segmentation = &done.segmentation;
        let drawn = figures(
            &done.file,
            Some(Session {
                recordings,
                segmentation,
            }),
        );
        for figure in drawn.iter().chain(&figures(&done.file, None)) {
            assert!(NAMES.contains(&figure.name.as_str()) && !figure.caption.is_empty());
            let text = svg::standalone(figure);
            roxmltree::Document::parse(&text).unwrap();
            assert!(
                !text.contains("NaN") && !text.contains("no values"),
                "{text}"
            );
        }
        (done.file, drawn)
    }

    fn series<'a>(figures: &'a [Figure], name: &str, panel: usize, series: &str) -> &'a Series {
        let figure = figures.iter().find(|f| f.name == name).unwrap();
        let all = figure.panels[panel].series.iter();
        all.into_iter().find(|s| s.name == series).unwrap()
    }

    #[test]
    fn six_files_have_all_figures_with_the_numbers_of_the_file() {
        let recordings = recordings(Scenario::SixPosition(SixPositionOptions::default()));
        let (file, figures) = figures_of(&recordings, Method::Joint);
        assert_eq!(
            figures.iter().map(|f| &f.name[..]).collect::<Vec<_>>(),
            NAMES
        );
        let a = &file.accelerometer;
        let shown = |name: &str, panel: usize, of: &str| &series(&figures, name, panel, of).y;
        let error = |p: &PoseResult| p.magnitude_error_mps2.unwrap();
        for (i, p) in a.poses.iter().enumerate() {
            // The files are in m/s², which is their nominal scale.
            assert!((shown("norm", 0, "before")[i] - length(&p.raw)).abs() < 1e-9);
            let after = shown("norm", 0, "calibrated")[i] - file.gravity_mps2;
            assert!((after - error(p)).abs() < 1e-12);
            assert!((shown("norm", 1, "calibrated")[i] - milli_g(error(p))).abs() < 1e-9);
            assert_eq!(shown("residuals", 0, "y")[i], 1e3 * p.error[1]);
        }
        assert_eq!(series(&figures, "captures", 0, "used").x.len(), 12);
        // One recording after the other, with a break before each.
        let x = &series(&figures, "captures", 1, "raw").x;
        assert!(x.iter().filter(|x| x.is_finite()).is_sorted());
        assert_eq!(x.iter().filter(|x| x.is_nan()).count(), 5);
    }

    #[test]
    fn free_poses_show_what_was_left_out_of_the_fit_and_what_would_help() {
        let recordings = recordings(Scenario::Poses(PosesOptions::default()));
        let (file, figures) = figures_of(&recordings, Method::Joint);
        let left_out = series(&figures, "norm", 1, "left out of the fit");
        for (p, shown) in file.accelerometer.poses.iter().zip(&left_out.y) {
            let error = p.left_out_error_mps2.map_or(f64::NAN, milli_g);
            assert_eq!(shown.to_bits(), error.to_bits());
        }
        let sphere = figures.iter().find(|f| f.name == "sphere").unwrap();
        let count = |name: &str| -> usize {
            let all = sphere.panels.iter().flat_map(|p| &p.series);
            all.filter(|s| s.name == name).map(|s| s.x.len()).sum()
        };
        assert_eq!(
            count("pose"),
            file.accelerometer.poses.iter().filter(|p| p.fitted).count()
        );
        assert_eq!(
            count("would help"),
            file.accelerometer.proposed_poses().len()
        );
        // A cap of angle θ has 1 − cos θ of the half's area: r² in a disc of radius 1.
        let (x, y) = project([0.6, 0.0, -0.8], -1.0);
        assert!((x * x + y * y - 0.2).abs() < 1e-12 && x < 0.0);
    }

    #[test]
    fn means_alone_show_neither_noise_nor_uncertainty() {
        let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
                   -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
        let means = read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default()).unwrap();
        let (_, figures) = figures_of(&[means], Method::Ferraris);
        assert!(figures.iter().all(|f| f.name != "noise"));
    }
}
