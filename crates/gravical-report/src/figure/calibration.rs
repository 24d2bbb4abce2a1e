//! Figures of a calibration.

use std::cmp::Reverse;

use gravical::calibration_file::{Calibration, PoseResult};
use gravical::core::matrix3::{norm as length, unit};
use gravical::numfmt::{self, COVERAGE, digits, mg, milli_g};
use gravical::poses::Segmentation;
use gravical::recording::Recording;

use super::drawing::{Drawing, Figure};
use super::panel::{Axis, Panel, Role, Series, XYZ, extent};
use super::space::{Direction, sphere};

/// More poses than this are not shown one by one.
const MAX_POSES: usize = 60;
/// Of so many only the largest are.
const LARGEST: usize = 40;

/// All figures that a calibration allows; with its recordings and how they were cut those, too. What
/// the data do not show is left out.
pub fn figures(file: &Calibration, session: Option<(&[Recording], &Segmentation)>) -> Vec<Figure> {
    let mut all = Vec::new();
    if !file.poses.is_empty() {
        all.push(errors(file));
        all.extend(more_poses(file));
        all.push(directions(file));
    }
    all.extend(session.and_then(|(recordings, cut)| recorded(file, recordings, cut)));
    all
}

/// Error of ‖a‖ of the fitted poses by the nominal scale, m/s² rms; none where that is not known.
pub(crate) fn rms_before(file: &Calibration) -> Option<f64> {
    let fitted = file.poses.iter().filter(|p| p.fitted);
    let off =
        |p: &PoseResult| Some(length(&file.accelerometer.nominally(p.raw)?) - file.gravity_mps2);
    let squares: Option<Vec<f64>> = fitted.map(|p| Some(off(p)?.powi(2))).collect();
    let squares = squares.filter(|all| !all.is_empty())?;
    Some((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// ‖a‖ − g of each pose by the nominal scale, and left out of the fit, with what is claimed.
fn errors(file: &Calibration) -> Figure {
    let g = file.gravity_mps2;
    let tested = |p: &PoseResult| p.left_out_error_mps2.is_some();
    let is_tested = file.poses.iter().any(tested);
    let after = |p: &PoseResult| {
        let own = (!is_tested).then(|| length(&p.calibrated) - g);
        milli_g(p.left_out_error_mps2.or(own).unwrap_or(f64::NAN))
    };
    let mut poses: Vec<&PoseResult> = file.poses.iter().collect();
    let all = poses.len();
    if all > MAX_POSES {
        poses.sort_by_key(|p| Reverse((1e6 * after(p).abs()) as u64));
        poses.truncate(LARGEST);
    }
    let claim = file
        .reliability
        .worst_direction
        .map(|w| milli_g(w.error_mps2));
    let shade = claim.map(|claim| {
        let name = format!("claimed: ± {} mg", digits(claim, 2));
        Series::shade(&name, Role::Claim, &[[-claim, claim]])
    });
    let names = || poses.iter().map(|p| p.label.clone());
    let panel = |quantity: &str, x: Axis, series: Series, rms: Option<f64>| {
        let series = shade.clone().into_iter().chain([series]);
        let panel = Panel::new(quantity, "mg", [x, Axis::rows(names())], series);
        panel.noted(rms.map_or(String::new(), |rms| format!("rms {}", mg(rms))))
    };
    let before: Option<Vec<f64>> = poses
        .iter()
        .map(|p| {
            file.accelerometer
                .nominally(p.raw)
                .map(|a| milli_g(length(&a) - g))
        })
        .collect();
    let before = before.map(|before| {
        let x = Axis::around_zero("", before.iter().copied().chain(claim));
        let series = Series::in_rows("before", Role::Raw, before.iter().map(|v| [*v, f64::NAN]));
        panel("Before", x, series, rms_before(file))
    });
    let left_out: Vec<f64> = poses.iter().map(|p| after(p)).collect();
    let half = |p: &PoseResult| COVERAGE * milli_g(p.left_out_sd_mps2.unwrap_or(f64::NAN));
    let bars: Vec<[f64; 2]> = poses
        .iter()
        .zip(&left_out)
        .map(|(p, v)| [*v, half(p)])
        .collect();
    let ends = bars
        .iter()
        .map(|[v, half]| v.abs() + if half.is_finite() { *half } else { 0.0 });
    let x = Axis::around_zero("", ends.chain(claim));
    let (quantity, name, caption) = if is_tested {
        let caption =
            "Left out: the calibration comes from the other poses. Before: by the nominal scale.";
        ("Left out", "left out ± 95 %", caption)
    } else {
        let caption =
            "No pose is left over to test the result: what is left in the fit proves nothing.";
        ("In the fit", "in the fit", caption)
    };
    let series = Series::in_rows(name, Role::Result, bars);
    let after = panel(quantity, x, series, file.reliability.left_out_rms_mps2);
    let mut caption = caption.to_owned();
    if all > poses.len() {
        caption += &format!(" The {} largest of {all}.", poses.len());
    }
    let panels = before.into_iter().chain([after]);
    Figure::new(
        "errors",
        "Error of ‖a‖ at rest, before and after",
        caption,
        panels,
    )
}

/// What the next poses lower: the error in the worst direction, or what one wrong pose could hide.
fn more_poses(file: &Calibration) -> Option<Figure> {
    let r = &file.reliability;
    let next = r.proposed_poses();
    let worst = std::iter::once(r.worst_direction.map(|w| w.error_mps2));
    let worst = worst.chain(next.iter().map(|p| p.worst_mps2));
    let worst: Vec<f64> = worst.map(|v| v.map_or(f64::NAN, milli_g)).collect();
    let hidden = std::iter::once(r.undetected.map(|u| u.effect_mps2));
    let hidden = hidden.chain(next.iter().map(|p| p.undetected_effect_mps2));
    let hidden: Vec<f64> = hidden.map(|v| v.map_or(f64::NAN, milli_g)).collect();
    let names = (0..=next.len()).map(|i| match i {
        0 => "now".to_owned(),
        i => format!("next {i}"),
    });
    let names: Vec<String> = names.collect();
    let panel = |quantity: &str, values: &[f64]| {
        let x = Axis::new("", "", [0.0, 1.1 * extent(values.iter().copied())[1]]);
        let points = values.iter().map(|v| [*v, f64::NAN]);
        let series = Series::in_rows("with these poses", Role::Result, points);
        Panel::new(quantity, "mg", [x, Axis::rows(names.clone())], [series])
    };
    let panels = [("Error, 95 %", &worst), ("Could be hidden", &hidden)];
    let panels = panels
        .into_iter()
        .filter(|(_, values)| values.iter().any(|v| v.is_finite()));
    let panels = panels.map(|(name, values)| panel(name, values));
    let caption = "Error of ‖a‖ in the worst direction, and what one wrong pose could hide. Each pose is the one that helps most after those above it.";
    let figure = Figure::new("more-poses", "What more poses bring", caption, panels);
    (!next.is_empty()).then_some(figure)
}

/// Where the poses point, and where the next ones would help.
fn directions(file: &Calibration) -> Figure {
    let pose = |p: &PoseResult| Direction {
        unit: unit(&p.calibrated),
        title: p.label.clone(),
        role: if p.fitted { Role::Result } else { Role::Bad },
    };
    let next = file.reliability.proposed_poses().iter().zip(1..);
    let next = next.map(|(pose, number)| Direction {
        unit: pose.direction,
        title: format!("next {number}"),
        role: Role::Warning,
    });
    let all: Vec<Direction> = file.poses.iter().map(pose).chain(next).collect();
    let names = [
        ("pose", Role::Result),
        ("not in the fit", Role::Bad),
        ("next pose", Role::Warning),
    ];
    Figure {
        drawing: Drawing::Space(sphere(&all, &names)),
        ..Figure::new(
            "sphere",
            "Poses on the sphere",
            "What points up, in sensor axes. Poses should surround the sphere.",
            [],
        )
    }
}

/// Readings along each axis, the recordings one after the other, with the poses' windows; none of tables of means,
/// which are no recording over time.
fn recorded(
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
        let end_s = extent(t_s[start..].iter().copied())[1].max(from_s);
        from_s = end_s + 0.1 * (end_s - from_s);
    }
    let poses = segmentation.poses.iter().filter(|p| !p.rows.is_empty());
    let is_over_time = poses.clone().any(|p| p.count > 1);
    let windows = poses.filter_map(|pose| {
        let start = *starts.get(pose.recording)?;
        let from_s = *t_s.get(start + pose.rows.start)?;
        let to_s = *t_s.get(start + pose.rows.end - 1)?;
        (from_s.is_finite() && to_s.is_finite()).then_some([from_s, to_s])
    });
    let windows: Vec<[f64; 2]> = windows.collect();
    let unit = numfmt::unit(file.accelerometer.input_unit.name());
    let time = match recordings {
        [_] => "time, s",
        _ => "time, one recording after the other, s",
    };
    let values = |axis: usize| recordings.iter().flat_map(move |r| &r.accel[axis]).copied();
    let line = |axis: usize| {
        let points = t_s.iter().copied().zip(values(axis)).map(<[f64; 2]>::from);
        Series::line(XYZ[axis], Role::Axis(axis), points, &breaks)
    };
    let shade = Series::shade("used: at rest", Role::Rest, &windows);
    let series = [shade].into_iter().chain([0, 1, 2].map(line));
    let x = Axis::over(time, "t = {} s", t_s.iter().copied(), 0.0);
    let y = Axis::over("", "", (0..3).flat_map(values), 0.06);
    let panel = Panel::new("Accelerometer, as recorded", &unit, [x, y], series);
    let figure = Figure::new("recording", "Recording", "", [panel.linked("rec").alone()]);
    (is_over_time && !t_s.is_empty()).then_some(figure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::panel::Mark;
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

    fn series<'a>(figures: &'a [Figure], name: &str, panel: usize, series: &str) -> &'a Mark {
        let figure = figures.iter().find(|f| f.name == name).unwrap();
        let mut all = figure.panels()[panel].series.iter();
        &all.find(|s| s.name == series).unwrap().mark
    }

    #[test]
    fn figures_show_the_numbers_of_the_file() {
        let (file, figures) = simulated(Scenario::Poses(PosesOptions::default()));
        let shown = |panel: usize, of: &str| match series(&figures, "errors", panel, of) {
            Mark::Points(points) => points.clone(),
            _ => Vec::new(),
        };
        let (before, left_out) = (shown(0, "before"), shown(1, "left out ± 95 %"));
        for (i, p) in file.poses.iter().enumerate() {
            // The files are in m/s², which is their nominal scale.
            let raw = milli_g(length(&p.raw) - file.gravity_mps2);
            assert!((before[i][0] - raw).abs() < 1e-9);
            let error = p.left_out_error_mps2.map_or(f64::NAN, milli_g);
            assert_eq!(left_out[i][0].to_bits(), error.to_bits());
            let half = COVERAGE * milli_g(p.left_out_sd_mps2.unwrap_or(f64::NAN));
            assert_eq!(left_out[i][2].to_bits(), half.to_bits());
        }
        let sphere = figures.iter().find(|f| f.name == "sphere").unwrap();
        let drawn = crate::figure::draw::standalone(sphere);
        let count = |class: &str| drawn.matches(&format!("class=\"dot {class}")).count();
        assert_eq!(
            count("result"),
            file.poses.iter().filter(|p| p.fitted).count()
        );
        assert_eq!(count("warn"), file.reliability.proposed_poses().len());
    }

    #[test]
    fn recordings_stand_one_after_the_other_with_a_break_before_each() {
        let (_, figures) = simulated(Scenario::SixPosition(SixPositionOptions::default()));
        let Mark::Shade(used) = series(&figures, "recording", 0, "used: at rest") else {
            panic!("no shade");
        };
        assert_eq!(used.len(), 6);
        let Mark::Line(line) = series(&figures, "recording", 0, "x") else {
            panic!("no line");
        };
        let x = || line.iter().map(|p| p[0]);
        assert!(x().filter(|x| x.is_finite()).is_sorted());
        assert_eq!(x().filter(|x| x.is_nan()).count(), 5);
    }
}
