//! What each placement shows: magnitude, error, tilt.

use crate::figure::{Axis, Figure, Panel, Role, Series, Symbol};
use gravical::calibration_file::{CalibrationFile, Method, PoseResult};
use gravical::numfmt::{milli_g, words};

use super::{Scale, norm_of, places};

fn names(poses: &[PoseResult]) -> Axis {
    Axis::names("pose", poses.iter().map(|p| p.label.clone()).collect())
}

/// ‖a‖ of each placement before and after, and after alone with its uncertainty.
pub(super) fn norm(file: &CalibrationFile, scale: &Scale) -> Option<Figure> {
    let a = &file.accelerometer;
    let poses = &a.poses;
    if poses.is_empty() {
        return None;
    }
    let x = places(poses.len());
    let after: Vec<f64> = poses.iter().map(|p| norm_of(p.calibrated)).collect();
    let directions = poses.iter().zip(&after);
    let directions = directions.map(|(p, norm)| p.calibrated.map(|c| c / norm));
    let deviations = file.sensor().map(|sensor| sensor.sd_along(directions));
    let before: Option<Vec<f64>> = poses
        .iter()
        .map(|p| scale.nominally(p.raw).map(norm_of))
        .collect();
    let g = file.gravity_mps2;
    let calibrated = Series::points("calibrated", Role::Calibrated, x.clone(), after.clone());
    let calibrated = match &deviations {
        Some(sd) => calibrated.plus_minus(sd),
        None => calibrated,
    };
    // Without a nominal scale there is no before, and the other panel says it all.
    let both = before.map(|before| {
        Panel::new(names(poses), Axis::new("‖a‖", "m/s²"))
            .with(Series::rule("local gravity", Role::Reference, g))
            .with(Series::points("before", Role::Raw, x.clone(), before))
            .with(calibrated)
    });
    let off: Vec<f64> = after.iter().map(|n| milli_g(n - g)).collect();
    let near = Series::points("calibrated", Role::Calibrated, x, off);
    let near = match &deviations {
        Some(sd) => near.plus_minus(&sd.iter().map(|v| milli_g(*v)).collect::<Vec<_>>()),
        None => near,
    };
    let near = Panel::new(names(poses), Axis::new("‖a‖ − g", "mg"))
        .with(Series::rule("local gravity", Role::Reference, 0.0))
        .with(near);
    let bars = match deviations {
        Some(_) => " Bars are ± 1σ of the parameters.",
        None => "",
    };
    let what = match both {
        Some(_) => "Above by the nominal scale and calibrated, below what is left.",
        None => "The remaining error after calibration; the nominal scale is unknown.",
    };
    let caption = format!("At rest ‖a‖ is local gravity in every pose. {what}{bars}");
    let figure = Figure::new("norm", "Magnitude at rest", caption);
    Some(both.into_iter().fold(figure, Figure::with).with(near))
}

/// Error of each placement: components, and the magnitude with it in the fit and
/// left out.
pub(super) fn residuals(file: &CalibrationFile) -> Option<Figure> {
    let poses = &file.accelerometer.poses;
    if poses.is_empty() {
        return None;
    }
    let x = places(poses.len());
    let roles = [("x", Role::X), ("y", Role::Y), ("z", Role::Z)];
    let mut components = Panel::new(names(poses), Axis::new("error", "mm/s²"));
    for (axis, (name, role)) in roles.into_iter().enumerate() {
        let errors = poses.iter().map(|p| 1e3 * p.error[axis]).collect();
        components = components.with(Series::columns(name, role, x.clone(), errors));
    }
    let figure = Figure::new(
        "residuals",
        "Errors of the poses",
        "Above: calibrated minus expected value along each axis (free poses: along their own direction); for a face pose this includes its tilt. Below: error of ‖a‖ with the pose in the fit and left out of it; only the latter measures how accurate the calibration is.",
    )
    .with(components);
    let of = |value: fn(&PoseResult) -> Option<f64>| -> Vec<f64> {
        let all = poses.iter().map(value);
        all.map(|v| v.map_or(f64::NAN, milli_g)).collect()
    };
    let fitted = of(|p| p.magnitude_error_mps2);
    let left_out = of(|p| p.left_out_error_mps2);
    let any = |v: &[f64]| v.iter().any(|v| v.is_finite());
    if !any(&left_out) {
        return Some(figure);
    }
    let mut magnitude = Panel::new(names(poses), Axis::new("‖a‖ − g", "mg")).with(Series::rule(
        "no error",
        Role::Reference,
        0.0,
    ));
    if any(&fitted) {
        magnitude = magnitude.with(Series::points(
            "in the fit",
            Role::Calibrated,
            x.clone(),
            fitted,
        ));
    }
    let left_out = Series::points("left out of the fit", Role::Warning, x, left_out);
    Some(figure.with(magnitude.with(left_out)))
}

/// Tilt of each face, and the tilt that the uncertainty assumes.
pub(super) fn tilt(file: &CalibrationFile) -> Option<Figure> {
    let a = &file.accelerometer;
    let faces: Vec<&PoseResult> = a.poses.iter().filter(|p| p.tilt_deg.is_some()).collect();
    if faces.is_empty() {
        return None;
    }
    let tilts = faces
        .iter()
        .map(|p| p.tilt_deg.unwrap_or(f64::NAN))
        .collect();
    let deviations: Vec<f64> = faces
        .iter()
        .map(|p| p.tilt_sd_deg.unwrap_or(f64::NAN))
        .collect();
    let labels = faces.iter().map(|p| p.label.clone()).collect();
    let fitted = a.method != Method::Ferraris;
    let name = if fitted {
        "tilt"
    } else {
        "angle of the raw mean"
    };
    let mut points = Series::points(name, Role::Calibrated, places(faces.len()), tilts);
    if deviations.iter().any(|d| d.is_finite()) {
        points = points.plus_minus(&deviations);
    }
    let mut panel = Panel::new(
        Axis::names("pose", labels),
        Axis::new("tilt off the face", "°").including(&[0.0]),
    );
    if let Some(tilt) = a.pose_tilt_deg {
        let how = format!("{}: standard deviation", words(&tilt.source));
        panel = panel.with(Series::rule(&how, Role::Reference, tilt.value));
    }
    let caption = if fitted {
        "Estimated tilt of each face pose. Bars are ± 1σ."
    } else {
        "Angle between the raw mean and the face: tilt, bias and misalignment together."
    };
    let panel = panel.with(points.drawn_as(Symbol::Circle));
    Some(Figure::new("tilt", "Tilt of the face poses", caption).with(panel))
}
