//! Figures of a calibration.

use std::f64::consts::PI;

use gravical::calibration_file::{CalibrationFile, Method, PoseResult, TemperatureModel};
use gravical::core::matrix3::{norm as length, unit};
use gravical::numfmt::{self, milli_g, words};
use gravical::poses::Segmentation;
use gravical::recording::Recording;
use gravical::temperature::evaluate;

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
/// session that is the recordings, noise and the temperature over time.
#[must_use]
pub fn figures(file: &CalibrationFile, session: Option<Session<'_>>) -> Vec<Figure> {
    let track = session.map(|s| Track::of(s.recordings));
    let no_poses = file.accelerometer.poses.is_empty();
    let of_poses = |figure: fn(&CalibrationFile) -> Figure| (!no_poses).then(|| figure(file));
    let all = [
        of_poses(norm),
        of_poses(residuals),
        of_poses(sphere),
        tilt(file),
        track
            .as_ref()
            .zip(session)
            .and_then(|(t, s)| captures(file, t, s.segmentation)),
        session.and_then(|session| noise(file, session)),
        temperature(file, track.as_ref()),
    ];
    all.into_iter().flatten().collect()
}

/// Unit of raw values in a figure, and what to multiply differences in the file's unit with to have
/// them in it: m/s² where that can be.
fn shown_unit(file: &CalibrationFile) -> (String, f64) {
    let a = &file.accelerometer;
    match a.nominal_per_mps2() {
        Some(nominal) => ("m/s²".to_owned(), 1.0 / nominal),
        None => (numfmt::unit(a.input_unit.name()), 1.0),
    }
}

fn labels(poses: &[PoseResult]) -> Axis {
    Axis::names("pose", poses.iter().map(|p| p.label.as_str()))
}

/// ‖a‖ of each pose before and after, and after alone with its uncertainty.
fn norm(file: &CalibrationFile) -> Figure {
    let poses = &file.accelerometer.poses;
    let g = file.gravity_mps2;
    let after: Vec<f64> = poses.iter().map(|p| length(&p.calibrated)).collect();
    let directions = poses.iter().map(|p| unit(&p.calibrated).into());
    let deviations = file.sensor().map(|mut sensor| {
        sensor.model_error_mps2 = 0.0;
        let claims = sensor.claims(directions).into_iter();
        claims.map(|c| c.sd_mps2).collect::<Vec<f64>>()
    });
    let calibrated = |values: Vec<f64>, factor: f64| {
        let points = Series::categorical("calibrated", Role::Result, values);
        match &deviations {
            Some(sd) => points.plus_minus(&sd.iter().map(|v| factor * v).collect::<Vec<_>>()),
            None => points,
        }
    };
    let raw = poses.iter().map(|p| p.raw);
    let before = raw.map(|raw| file.accelerometer.nominally(raw).map(|a| length(&a)));
    let before: Option<Vec<f64>> = before.collect();
    // Without a nominal scale there is no before, and the other panel says it all.
    let both = before.map(|before| {
        Panel::new("", labels(poses), Axis::new("‖a‖", "m/s²"))
            .with(Series::rule("local gravity", Role::Reference, g))
            .with(Series::categorical("before", Role::Raw, before))
            .with(calibrated(after.clone(), 1.0))
    });
    let what = match both {
        Some(_) => "Above by the nominal scale and calibrated, below what is left.",
        None => "The remaining error after calibration; the nominal scale is unknown.",
    };
    let bars = match deviations {
        Some(_) => " Bars are ± 1σ of the parameters.",
        None => "",
    };
    let off = after.iter().map(|n| milli_g(n - g)).collect();
    let near = Panel::new("", labels(poses), Axis::new("‖a‖ − g", "mg"))
        .with(Series::rule("local gravity", Role::Reference, 0.0))
        .with(calibrated(off, milli_g(1.0)));
    let caption = format!("At rest ‖a‖ is local gravity in every pose. {what}{bars}");
    let figure = Figure::new("norm", "Magnitude at rest", caption);
    both.into_iter().fold(figure, Figure::with).with(near)
}

/// Columns of the components of vectors over names.
fn components(panel: Panel, vectors: &[[f64; 3]]) -> Panel {
    let axes = XYZ.into_iter().enumerate();
    axes.fold(panel, |panel, (axis, (name, role))| {
        panel.with(Series::columns(name, role, vectors.iter().map(|v| v[axis])))
    })
}

/// Error of each pose: components, and the magnitude with it in the fit and left out.
fn residuals(file: &CalibrationFile) -> Figure {
    let poses = &file.accelerometer.poses;
    let vectors: Vec<[f64; 3]> = poses.iter().map(|p| p.error.map(|e| 1e3 * e)).collect();
    let panel = Panel::new("", labels(poses), Axis::new("error", "mm/s²"));
    let errors = |name, role, value: fn(&PoseResult) -> Option<f64>| {
        let values = poses.iter().map(value);
        Series::categorical(name, role, values.map(|v| v.map_or(f64::NAN, milli_g)))
    };
    let left_out = errors("left out of the fit", Role::Warning, |p| {
        p.left_out_error_mps2
    });
    let caption = "Calibrated minus expected value along each axis (free poses: along their own direction); for a face pose this includes its tilt.";
    let figure = Figure::new("residuals", "Errors of the poses", caption);
    let mut figure = figure.with(components(panel, &vectors));
    if !left_out.has_values() {
        return figure;
    }
    figure.caption += " Below: error of ‖a‖ with the pose in the fit and left out of it; only the latter measures how accurate the calibration is.";
    let magnitude = Panel::new("", labels(poses), Axis::new("‖a‖ − g", "mg"))
        .with(Series::rule("no error", Role::Reference, 0.0))
        .with(errors("in the fit", Role::Result, |p| {
            p.magnitude_error_mps2
        }))
        .with(left_out);
    figure.with(magnitude)
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
    let rim = [-1.14, 1.14];
    let mut panel = Panel::new(title, Axis::hidden(rim), Axis::hidden(rim)).equal(1.0);
    panel.series = graticule(side);
    let x = [1.1 * side, -1.1 * side, 0.0, 0.0].to_vec();
    let names = ["+x", "−x", "+y", "−y"].map(str::to_owned).to_vec();
    let axes = Series::points("axes", Role::Guide, x, vec![0.0, 0.0, 1.1, -1.1]);
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
        .with(axes.labelled(names))
        .with(points("pose", Role::Result, &mut poses(true)))
        .with(points("not in the fit", Role::Bad, &mut poses(false)))
        .with(points("would help", Role::Warning, &mut next))
}

/// The rim, circles at 30° and 60° from the pole, and a meridian each 30°.
fn graticule(side: f64) -> Vec<Series> {
    let line = |points: Vec<[f64; 3]>| {
        let (x, y) = points.into_iter().map(|d| project(d, side)).unzip();
        Series::line("graticule", Role::Guide, x, y)
    };
    let circles = [30.0_f64, 60.0, 90.0].map(|off_deg| {
        let (sine, cosine) = off_deg.to_radians().sin_cos();
        let turn = (0..=96).map(|i| (2.0 * PI * f64::from(i) / 96.0).sin_cos());
        let points = turn.map(|(sin, cos)| [sine * cos, sine * sin, side * cosine]);
        line(points.collect())
    });
    let meridians = (0..6).map(|k| {
        let (sine, cosine) = (f64::from(k) * PI / 6.0).sin_cos();
        line(vec![[-cosine, -sine, 0.0], [cosine, sine, 0.0]])
    });
    circles.into_iter().chain(meridians).collect()
}

/// Tilt of each face pose, and the tilt that the uncertainty assumes.
fn tilt(file: &CalibrationFile) -> Option<Figure> {
    let a = &file.accelerometer;
    let faces = a.poses.iter().filter_map(|p| Some((p, p.tilt_deg?)));
    let (faces, tilts): (Vec<&PoseResult>, Vec<f64>) = faces.unzip();
    if faces.is_empty() {
        return None;
    }
    let deviations = faces.iter().map(|p| p.tilt_sd_deg.unwrap_or(f64::NAN));
    let deviations: Vec<f64> = deviations.collect();
    let (name, caption) = match a.method {
        Method::Ferraris => (
            "angle of the raw mean",
            "Angle between the raw mean and the face: tilt, bias and misalignment together.",
        ),
        _ => ("tilt", "Estimated tilt of each face pose. Bars are ± 1σ."),
    };
    let points = Series::categorical(name, Role::Result, tilts).plus_minus(&deviations);
    let x = Axis::names("pose", faces.iter().map(|p| p.label.as_str()));
    let y = Axis::new("tilt off the face", "°").including(&[0.0]);
    let mut panel = Panel::new("", x, y);
    if let Some(tilt) = a.pose_tilt_deg {
        let how = format!("{}: standard deviation", words(&tilt.source));
        panel = panel.with(Series::rule(&how, Role::Reference, tilt.value));
    }
    Some(Figure::new("tilt", "Tilt of the face poses", caption).with(panel.with(points)))
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
    axis: Axis,
}

impl<'a> Track<'a> {
    fn of(recordings: &'a [Recording]) -> Self {
        let time = |r: &Recording| -> Vec<f64> {
            let period_s = 1.0 / r.working_rate_hz().0;
            let counted = || (0..r.rows()).map(|i| period_s * i as f64).collect();
            r.time_s.clone().unwrap_or_else(counted)
        };
        let times: Vec<Vec<f64>> = recordings.iter().map(time).collect();
        let duration = |t: &Vec<f64>| extent(t.iter().copied()).1.max(0.0);
        let gap_s = 0.015 * times.iter().map(duration).sum::<f64>();
        let label = match recordings {
            [_] => "time",
            _ => "time, one recording after the other",
        };
        let (mut t_s, mut breaks, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        let mut from = 0.0;
        for (recording, t) in recordings.iter().zip(times) {
            let start = t_s.len();
            starts.push(start);
            breaks.push(start);
            breaks.extend(recording.breaks.iter().map(|b| start + b));
            t_s.extend(t.iter().map(|t| from + t));
            from += duration(&t) + gap_s;
        }
        let axis = Axis::new(label, "s");
        Track {
            recordings,
            t_s,
            breaks,
            starts,
            axis,
        }
    }

    /// A line through a column of all recordings.
    fn line(
        &self,
        name: &str,
        role: Role,
        factor: f64,
        column: impl Fn(&'a Recording) -> Option<&'a Vec<f64>>,
    ) -> Series {
        let values = |r: &'a Recording| {
            let known = column(r).into_iter().flatten().map(|v| factor * v);
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
    let used = match windows.len() {
        1 => "the pose whose mean was used".to_owned(),
        n => format!("the {n} poses whose means were used"),
    };
    let (in_unit, factor) = shown_unit(file);
    let nominal = if factor == 1.0 { "" } else { ", nominal scale" };
    let caption = format!("Raw recording{nominal}. Shaded: {used}.");
    let mut figure = Figure::new("captures", "Recorded poses", caption);
    for (axis, (name, _)) in XYZ.into_iter().enumerate() {
        let line = track.line("raw", Role::Raw, factor, |r| r.accel.get(axis));
        let mut panel = Panel::new(name, track.axis.clone(), Axis::new("", &in_unit));
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
    let (in_unit, factor) = match shown_unit(file) {
        (unit, factor) if unit == "m/s²" => ("mm/s²".to_owned(), 1e3 * factor),
        other => other,
    };
    let noise = poses.iter().enumerate().filter_map(|(i, pose)| {
        let recording = session.recordings.get(pose.recording)?;
        let sigma = [0, 1, 2].map(|axis| {
            let values = recording.accel[axis].get(pose.rows.clone());
            factor * deviation(values.into_iter().flatten().copied())
        });
        let name = results.map_or(&pose.label, |results| &results[i].label);
        sigma.iter().any(|s| s.is_finite()).then_some((name, sigma))
    });
    let (names, sigma): (Vec<&String>, Vec<[f64; 3]>) = noise.unzip();
    let y = Axis::new("noise, 1σ of a sample", &in_unit);
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

/// Temperature over time, and the drift that a model takes off; none without either.
fn temperature(file: &CalibrationFile, track: Option<&Track<'_>>) -> Option<Figure> {
    let over_time = track.and_then(|track| {
        let line = track.line("temperature", Role::Result, 1.0, |r| {
            r.temperature_c.as_ref()
        });
        let y = Axis::new("temperature", "°C");
        line.has_values()
            .then(|| Panel::new("over time", track.axis.clone(), y).with(line))
    });
    let model = file.temperature_model.as_ref();
    let sensors = [
        ("accelerometer", ["ax", "ay", "az"]),
        ("gyroscope", ["gx", "gy", "gz"]),
    ];
    let drifts = sensors
        .into_iter()
        .filter_map(|(title, channels)| drift(model?, title, channels));
    let caption = "Temperature while the sensor was recorded; with a temperature model the drift of each channel over it, which is corrected (zero at the reference temperature).";
    let figure = Figure::new("temperature", "Temperature", caption);
    let figure = figure.beside(over_time.into_iter().chain(drifts));
    (!figure.panels.is_empty()).then_some(figure)
}

fn drift(model: &TemperatureModel, title: &str, channels: [&str; 3]) -> Option<Panel> {
    let [from, to] = model.range_c;
    let (x, y) = (Axis::new("temperature", "°C"), Axis::new("drift", ""));
    let mut panel = Panel::new(title, x, y);
    for (channel, (name, role)) in channels.into_iter().zip(XYZ) {
        let Some(drift) = model.channel(channel).filter(|c| c.is_corrected()) else {
            continue;
        };
        panel.y.unit = numfmt::unit(&drift.input_unit);
        let t = (0..=100).map(|i| from + (to - from) * f64::from(i) / 100.0);
        let drift = |t: f64| evaluate(&drift.coefficients, t - model.reference_c);
        let (t, y) = t.map(|t| (t, drift(t))).unzip();
        panel = panel.with(Series::line(name, role, t, y));
    }
    (!panel.series.is_empty()).then_some(panel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::svg;
    use gravical::calibrate::{CalibrateOptions, calibrate};
    use gravical::recording::{ReadOptions, read, read_bytes};
    use gravical::simulate::{
        PosesOptions, Scenario, SimulateOptions, SixPositionOptions, simulate_to,
    };

    /// In the order of a report.
    const NAMES: [&str; 7] = [
        "norm",
        "residuals",
        "sphere",
        "tilt",
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
            assert_eq!(shown("tilt", 0, "tilt")[i], p.tilt_deg.unwrap());
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
        let left_out = series(&figures, "residuals", 1, "left out of the fit");
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
