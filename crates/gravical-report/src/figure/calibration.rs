//! Figures of a calibration.

use std::f64::consts::PI;

use gravical::calibration_file::{Calibration, PoseResult};
use gravical::core::matrix3::{norm as length, unit};
use gravical::numfmt::{self, milli_g};
use gravical::poses::Segmentation;
use gravical::recording::Recording;

use super::panel::{Axis, Figure, Panel, Role, Scale, Series, XYZ};
use super::svg::extent;

/// All figures that a calibration allows; with its recordings and how they were cut those, too. What
/// the data do not show is left out.
pub fn figures(file: &Calibration, session: Option<(&[Recording], &Segmentation)>) -> Vec<Figure> {
    let mut all = Vec::new();
    if !file.poses.is_empty() {
        all.extend([norm(file), sphere(file)]);
    }
    all.extend(session.and_then(|(recordings, cut)| captures(file, recordings, cut)));
    all
}

/// ‖a‖ of each pose before and after, and what is left of its error, with the pose in the fit and
/// left out.
fn norm(file: &Calibration) -> Figure {
    let (poses, g) = (&file.poses, file.gravity_mps2);
    let off = |p: &PoseResult| length(&p.calibrated) - g;
    let errors = poses.iter().map(|p| milli_g(off(p)));
    let mut calibrated = Series::categorical("calibrated", Role::Result, errors);
    if let Some(mut sensor) = file.sensor() {
        sensor.model_error_mps2 = 0.0;
        let claims = sensor.claims(poses.iter().map(|p| unit(&p.calibrated).into()));
        let sd: Vec<f64> = claims.into_iter().map(|c| milli_g(c.sd_mps2)).collect();
        calibrated = calibrated.plus_minus(&sd);
    }
    let left_out = poses
        .iter()
        .map(|p| p.left_out_error_mps2.map_or(f64::NAN, milli_g));
    let left_out = Series::categorical("left out of the fit", Role::Warning, left_out);
    // A panel over the poses, with a line across at gravity.
    let panel = |y: Axis, gravity: f64, series: [Series; 2]| {
        let names = poses.iter().map(|p| p.label.clone()).collect();
        let x = Axis::scaled("pose", "", Scale::Names(names));
        let ends = [-0.5, poses.len() as f64 - 0.5].map(|x| (x, gravity));
        let rule = Series::line("local gravity", Role::Reference, ends);
        Panel::new("", x, y, [rule].into_iter().chain(series))
    };
    let near = panel(Axis::new("‖a‖ − g", "mg"), 0.0, [left_out, calibrated]);
    // Without a nominal scale there is no before, and the other panel says it all.
    let before = poses.iter().map(|p| file.accelerometer.nominally(p.raw));
    let before: Option<Vec<f64>> = before.map(|a| a.map(|a| length(&a))).collect();
    let both = before.map(|before| {
        let before = Series::categorical("before", Role::Raw, before);
        let after = poses.iter().map(|p| off(p) + g);
        let after = Series::categorical("calibrated", Role::Result, after);
        panel(Axis::new("‖a‖", "m/s²"), g, [before, after])
    });
    let caption = "At rest ‖a‖ is local gravity in every pose. Before: by the nominal scale, if that is known. Bars are ± 1σ of the parameters; only an error with the pose left out of the fit measures how accurate the calibration is.";
    let panels = both.into_iter().chain([near]);
    Figure::new("norm", "Magnitude at rest", caption, panels)
}

/// Where the poses point, and where the next ones would help: two hemispheres.
fn sphere(file: &Calibration) -> Figure {
    let caption = "Direction of specific force (up, in sensor axes) at each pose: two hemispheres in equal-area projection, circles at 30° and 60°.";
    let sides = [(1.0, "seen from +z"), (-1.0, "seen from −z")];
    let panels = sides.map(|(side, title)| hemisphere(file, side, title));
    Figure::new("sphere", "Poses on the sphere", caption, panels).beside()
}

/// Where a unit vector lies in the disc of radius 1 whose centre is ±z: the equal-area projection
/// of J. H. Lambert (1772; Snyder, Map Projections, 1987, ch. 24). Seen from below x runs to the
/// left where y runs up.
fn project(d: [f64; 3], side: f64) -> (f64, f64) {
    let k = 1.0 / (1.0 + (side * d[2]).max(0.0)).sqrt();
    (side * d[0] * k, d[1] * k)
}

fn hemisphere(file: &Calibration, side: f64, title: &str) -> Panel {
    // Circles at 30°, 60° and 90° from the pole.
    let circles = [30.0_f64, 60.0, 90.0].map(|off_deg| {
        let (sine, cosine) = off_deg.to_radians().sin_cos();
        let turn = (0..=96).map(|i| (2.0 * PI * f64::from(i) / 96.0).sin_cos());
        let points = turn.map(|(sin, cos)| project([sine * cos, sine * sin, side * cosine], side));
        Series::line("circle", Role::Guide, points)
    });
    let ends = [
        ("+x", side, 0.0),
        ("−x", -side, 0.0),
        ("+y", 0.0, 1.0),
        ("−y", 0.0, -1.0),
    ];
    let axes = ends.iter().flat_map(|(name, x, y)| {
        let text = Series::points("axes", Role::Guide, [(1.1 * x, 1.1 * y)]);
        let line = Series::line("axes", Role::Guide, [(0.0, 0.0), (*x, *y)]);
        [line, text.labelled([(*name).to_owned()])]
    });
    let points = |name, role, poses: &mut dyn Iterator<Item = ([f64; 3], String)>| {
        let here = poses.filter(|(d, _)| (d[2] >= 0.0) == (side > 0.0));
        let (places, labels): (Vec<_>, Vec<_>) = here.map(|(d, l)| (project(d, side), l)).unzip();
        Series::points(name, role, places).labelled(labels)
    };
    let poses = |fitted: bool| {
        let poses = file.poses.iter().filter(move |p| p.fitted == fitted);
        poses.map(|p| (unit(&p.calibrated), p.label.clone()))
    };
    let next = file.reliability.proposed_poses().iter().enumerate();
    let mut next = next.map(|(i, pose)| (pose.direction, format!("next {}", i + 1)));
    let poses = [
        points("pose", Role::Result, &mut poses(true)),
        points("not in the fit", Role::Bad, &mut poses(false)),
        points("would help", Role::Warning, &mut next),
    ];
    let [x, y] = [(); 2].map(|()| Axis::scaled("", "", Scale::Hidden));
    let series = circles.into_iter().chain(axes).chain(poses);
    Panel::new(title, x, y, series).equal()
}

/// Raw readings along each axis, the recordings one after the other, with the poses' windows.
fn captures(
    file: &Calibration,
    recordings: &[Recording],
    segmentation: &Segmentation,
) -> Option<Figure> {
    // Time of each row; rows before which others are missing; first row of each recording.
    let (mut t_s, mut breaks, mut starts) = (Vec::<f64>::new(), Vec::new(), Vec::new());
    let mut from_s = 0.0;
    for recording in recordings {
        let start = t_s.len();
        starts.push(start);
        breaks.push(start);
        breaks.extend(recording.breaks.iter().map(|b| start + b));
        let period_s = 1.0 / recording.working_rate_hz();
        match &recording.time_s {
            Some(time_s) => t_s.extend(time_s.iter().map(|t| from_s + t)),
            None => t_s.extend((0..recording.rows()).map(|i| from_s + period_s * i as f64)),
        }
        // A gap that is seen where the next recording begins.
        let end_s = extent(t_s[start..].iter().copied()).1.max(from_s);
        from_s = end_s + 0.1 * (end_s - from_s);
    }
    let poses = segmentation.poses.iter().filter(|p| !p.rows.is_empty());
    let windows = poses.filter_map(|pose| {
        let start = *starts.get(pose.recording)?;
        let from_s = *t_s.get(start + pose.rows.start)?;
        let to_s = *t_s.get(start + pose.rows.end - 1)?;
        let name = pose.face.map_or_else(|| pose.label.clone(), |f| f.name());
        (from_s.is_finite() && to_s.is_finite()).then_some(([from_s, to_s], name))
    });
    let (windows, names): (Vec<[f64; 2]>, Vec<String>) = windows.unzip();
    let unit = numfmt::unit(file.accelerometer.input_unit.name());
    let time = match recordings {
        [_] => "time",
        _ => "time, one recording after the other",
    };
    let panels = [0, 1, 2].map(|axis| {
        let values = recordings.iter().flat_map(|r| &r.accel[axis]);
        let points = t_s.iter().copied().zip(values.copied());
        let line = Series::line("raw", Role::Raw, points).thinned(&breaks);
        let mut series = vec![Series::intervals("used", &windows)];
        // The names of few windows, above the line.
        if axis == 0 && windows.len() <= 12 {
            let (low, high) = extent(line.y.iter().copied());
            let above = high + 0.14 * (high - low).max(1e-6 * high.abs());
            let middles = windows.iter().map(|w| (0.5 * (w[0] + w[1]), above));
            let texts = Series::points("pose", Role::Guide, middles);
            series.push(texts.labelled(names.clone()));
        }
        series.push(line);
        let (x, y) = (Axis::new(time, "s"), Axis::new("", &unit));
        Panel::new(XYZ[axis], x, y, series)
    });
    let caption = "Raw recording. Shaded: the poses whose means were used.";
    let figure = Figure::new("captures", "Recorded poses", caption, panels);
    (!t_s.is_empty()).then_some(figure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::calibrate::{CalibrateOptions, calibrate};
    use gravical::recording::{ReadOptions, read};
    use gravical::simulate::{
        PosesOptions, Scenario, SimulateOptions, SixPositionOptions, simulate_to,
    };

    /// A calibration and its figures.
    fn simulated(scenario: Scenario) -> (Calibration, Vec<Figure>) {
        let folder = tempfile::tempdir().unwrap();
        let options = SimulateOptions::new(scenario);
        let (_, mut files) = simulate_to(&options, folder.path(), false).unwrap();
        files.retain(|p| p.extension().is_some_and(|e| e == "csv"));
        let recordings = files
            .iter()
            .map(|p| read(p, &ReadOptions::default()).unwrap());
        let recordings: Vec<Recording> = recordings.collect();
        let done = calibrate(&recordings, &CalibrateOptions::default()).unwrap();
        let drawn = figures(
            &done.calibration,
            Some((&recordings[..], &done.segmentation)),
        );
        (done.calibration, drawn)
    }

    fn series<'a>(figures: &'a [Figure], name: &str, panel: usize, series: &str) -> &'a Series {
        let figure = figures.iter().find(|f| f.name == name).unwrap();
        let mut all = figure.panels[panel].series.iter();
        all.find(|s| s.name == series).unwrap()
    }

    #[test]
    fn figures_show_the_numbers_of_the_file() {
        let (file, figures) = simulated(Scenario::Poses(PosesOptions::default()));
        let shown = |name: &str, panel: usize, of: &str| &series(&figures, name, panel, of).y;
        let poses = &file.poses;
        for (i, p) in poses.iter().enumerate() {
            let Some(error) = p.magnitude_error_mps2 else {
                continue;
            };
            // The files are in m/s², which is their nominal scale.
            assert!((shown("norm", 0, "before")[i] - length(&p.raw)).abs() < 1e-9);
            let after = shown("norm", 0, "calibrated")[i] - file.gravity_mps2;
            assert!((after - error).abs() < 1e-12);
            assert!((shown("norm", 1, "calibrated")[i] - milli_g(error)).abs() < 1e-9);
            let left_out = p.left_out_error_mps2.map_or(f64::NAN, milli_g);
            let shown = shown("norm", 1, "left out of the fit")[i];
            assert_eq!(shown.to_bits(), left_out.to_bits());
        }
        let sphere = figures.iter().find(|f| f.name == "sphere").unwrap();
        let count = |name: &str| -> usize {
            let all = sphere.panels.iter().flat_map(|p| &p.series);
            all.filter(|s| s.name == name).map(|s| s.x.len()).sum()
        };
        assert_eq!(count("pose"), poses.iter().filter(|p| p.fitted).count());
        let proposed = file.reliability.proposed_poses().len();
        assert_eq!(count("would help"), proposed);
        // A cap of angle θ has 1 − cos θ of the half's area: r² in a disc of radius 1.
        let (x, y) = project([0.6, 0.0, -0.8], -1.0);
        assert!((x * x + y * y - 0.2).abs() < 1e-12 && x < 0.0);
    }

    #[test]
    fn recordings_stand_one_after_the_other_with_a_break_before_each() {
        let (_, figures) = simulated(Scenario::SixPosition(SixPositionOptions::default()));
        assert_eq!(series(&figures, "captures", 0, "used").x.len(), 12);
        let x = &series(&figures, "captures", 1, "raw").x;
        assert!(x.iter().filter(|x| x.is_finite()).is_sorted());
        assert_eq!(x.iter().filter(|x| x.is_nan()).count(), 5);
    }
}
