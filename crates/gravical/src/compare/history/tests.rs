//! Histories made by hand.

use super::*;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{Covariance, GravitySource, InputFile};
use crate::estimate::accelerometer::Method;
use crate::recording::{AccelUnit, ReadOptions, read_bytes};

/// A file of six means, with `sigma` for the elements of M and g times it for the bias.
fn file(sigma: f64) -> CalibrationFile {
    let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
               -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default()).unwrap()];
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let mut file = calibrate(&session, &options).unwrap().file;
    let variance = |i: usize| (if i < 9 { sigma } else { 9.81 * sigma }).powi(2);
    let row = |r: usize| {
        (0..12)
            .map(|c| if r == c { variance(r) } else { 0.0 })
            .collect()
    };
    file.accelerometer.covariance = Some(Covariance {
        parameters: Covariance::parameter_names(),
        values: (0..12).map(row).collect(),
    });
    file.accelerometer.gravity_sd_mps2 = 0.0;
    file.verdict.grade = Grade::Good;
    file.inputs.clear();
    file
}

/// The same, each with another bias along x, in σ, and another along y, so that no two are alike.
fn sessions(shifts: &[f64]) -> Vec<CalibrationFile> {
    let shifted = |(i, shift): (usize, &f64)| {
        let mut file = file(1e-4);
        file.accelerometer.bias[0] += shift * 9.81e-4;
        file.accelerometer.bias[1] += 1e-9 * i as f64;
        file
    };
    shifts.iter().enumerate().map(shifted).collect()
}

fn of(files: &[CalibrationFile]) -> History {
    let names: Vec<String> = (0..files.len())
        .map(|i| format!("2026-0{}-01", i + 1))
        .collect();
    let named: Vec<_> = files
        .iter()
        .zip(&names)
        .map(|(f, n)| (f, n.as_str()))
        .collect();
    history(&named)
}

fn has(h: &History, kind: &str) -> bool {
    h.findings.iter().any(|f| f.kind == kind)
}

#[test]
fn a_step_of_the_bias_is_found_and_placed() {
    let result = of(&sessions(&[0.0, 0.5, -0.5, 8.0, 8.5]));
    assert_eq!(result.verdict.judgement, Stability::Changed);
    let magnitude = result.magnitude.as_ref().unwrap();
    assert_eq!(magnitude.whole.degrees_of_freedom, 36);
    let step = magnitude.step.as_ref().unwrap();
    assert_eq!(
        (step.after.as_str(), step.until.as_str()),
        ("2026-03-01", "2026-04-01")
    );
    assert_eq!(step.largest.name, "bias_x");
    assert!(
        (step.largest.value - 8.25 * 9.81e-4).abs() < 1e-5,
        "{step:?}"
    );
    assert!(step.largest.sigma.unwrap() < 9.81e-4);
    // The frame has not moved.
    assert!(result.orientation.unwrap().p_value > 0.9);
    let text = &result.verdict.reasons[0];
    assert!(text.contains("between 2026-03-01 and 2026-04-01"), "{text}");
}

#[test]
fn nothing_is_claimed_of_what_scatters_as_it_should() {
    let result = of(&sessions(&[0.4, -1.1, 0.7, 1.3, -0.6]));
    assert_eq!(result.verdict.judgement, Stability::Unchanged);
    assert_eq!(result.tested, 5);
    // The mean of 0.4, −1.1, 0.7, 1.3, −0.6 is 0.14.
    let shift = (result.mean[0].value - file(1e-4).accelerometer.bias[0]) / 9.81e-4;
    assert!((shift - 0.14).abs() < 1e-6, "{shift}");
    let bias = &result.entries[1].parameters[0];
    assert!((bias.sigma.unwrap() - 9.81e-4).abs() < 1e-9);
    let [low, high] = bias.interval_95.unwrap();
    assert!(low < bias.value && bias.value < high);
}

#[test]
fn two_are_judged_as_compare_judges_them() {
    let files = sessions(&[0.0, 3.7]);
    let result = of(&files);
    let pair = compare(&files[0], &files[1], ["a", "b"]).unwrap();
    let (ours, theirs) = (result.magnitude.unwrap(), pair.magnitude.test.unwrap());
    assert!((ours.whole.chi2 - theirs.chi2).abs() < 1e-6);
    assert!((ours.p_value - theirs.p_value).abs() < 1e-9);
    let since = result.entries[1].since_previous.as_ref().unwrap();
    assert_eq!(since.magnitude.unwrap(), theirs);
}

#[test]
fn one_or_none_are_undecided() {
    for files in [&sessions(&[])[..], &sessions(&[0.0])] {
        let result = of(files);
        assert_eq!(result.verdict.judgement, Stability::Undecided);
        assert_eq!(result.entries.len(), files.len());
    }
}

#[test]
fn what_cannot_be_tested_is_left_out_with_its_reason() {
    let mut files = sessions(&[0.0, 0.3, 50.0, 50.0, 50.0, 50.0]);
    files[2].verdict.grade = Grade::Poor;
    files[3].accelerometer.covariance = None;
    let a = &mut files[4].accelerometer;
    (a.input_unit, a.scale_deviation_percent) = (AccelUnit::Unknown, None);
    a.scale = a.scale.map(|s| 9.0 * s);
    let input = InputFile {
        path: "x.csv".into(),
        sha256: Some("00".into()),
        role: Default::default(),
    };
    files[5].inputs = vec![input.clone()];
    files.push(file(1e-4));
    files[6].accelerometer.bias[1] += 1e-6;
    files[6].inputs = vec![input];
    let result = of(&files);
    let why = |i: usize| result.entries[i].not_tested.as_deref().unwrap_or("");
    assert!(why(2).contains("poor"), "{}", why(2));
    assert!(why(3).contains("no uncertainty"), "{}", why(3));
    assert!(why(4).contains("units"), "{}", why(4));
    assert!(why(5).contains("2026-07-01"), "{}", why(5));
    assert_eq!(result.tested, 3);
    assert_eq!(result.verdict.judgement, Stability::Unchanged);
    for kind in [
        "poor-calibration",
        "covariance-missing",
        "unit-mismatch",
        "same-recordings",
    ] {
        assert!(has(&result, kind), "{kind}");
    }
}

#[test]
fn the_error_of_an_assumed_gravity_counts_between_places_only() {
    let mut files = sessions(&[0.0, 0.1, 0.2]);
    for f in &mut files {
        f.gravity_source = GravitySource::Standard;
        let a = &mut f.accelerometer;
        a.gravity_sd_mps2 = 0.015;
        let model = gravical_core::matrix3::inverse(&a.matrix).unwrap();
        let own = crate::uncertainty::of_gravity(&model, 0.015, f.gravity_mps2);
        for (row, own) in a.covariance.as_mut().unwrap().values.iter_mut().zip(own) {
            row.iter_mut().zip(own).for_each(|(c, own)| *c += own);
        }
    }
    // A scale that differs by 1 ‰, ten σ, within one gravity.
    let scaled = |f: &mut CalibrationFile, by: f64| {
        f.accelerometer.matrix = f.accelerometer.matrix.map(|r| r.map(|v| v * by));
    };
    let mut within = files.clone();
    scaled(&mut within[2], 1.001);
    assert_eq!(of(&within).verdict.judgement, Stability::Changed);
    // The same where the last one has a gravity of its own, known to 1.5 ‰.
    let mut between = files.clone();
    scaled(&mut between[2], 1.001);
    between[2].gravity_mps2 *= 1.001;
    let result = of(&between);
    assert_eq!(
        result.verdict.judgement,
        Stability::Unchanged,
        "{:?}",
        result.verdict
    );
    assert!(has(&result, "gravity-differs"));
    assert!(result.magnitude_at_one_gravity.unwrap().whole.chi2 < 1.0);
    // The interval of a scale contains it.
    let scale = &result.entries[0].parameters[3];
    assert!(scale.sigma.unwrap() > 0.14, "{scale:?}");
}

#[test]
fn mirror_images_are_a_change() {
    let mut files = sessions(&[0.0, 0.1, 0.2]);
    files[1].accelerometer.matrix[2] = files[1].accelerometer.matrix[2].map(|v| -v);
    let result = of(&files);
    assert_eq!(result.verdict.judgement, Stability::Changed);
    assert!(result.verdict.reasons.iter().any(|r| r.contains("mirror")));
}
