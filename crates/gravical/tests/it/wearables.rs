//! Stills of daily life: means without rows, and long recordings of a wrist.

use std::io::Read as _;

use gravical::estimate::joint::{FOLDS, JointOptions, JointPose, Role, joint, test_drift};
use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2 as G;

use crate::support::*;

/// Columns of the stills that GGIR published: means, standard deviations and temperature.
fn ggir_stills() -> Option<Vec<JointPose>> {
    let file = std::fs::File::open(data()?.join("ggir-stills/stills_10s.csv.gz")).unwrap();
    let mut text = String::new();
    flate2::read::GzDecoder::new(file)
        .read_to_string(&mut text)
        .unwrap();
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    let pose = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(number).collect();
        JointPose {
            mean: [cells[1], cells[2], cells[3]],
            // Ten seconds of which a tenth of a second at a time is independent.
            standard_error: std::array::from_fn(|i| cells[4 + i] / 10.0),
            role: Role::Open,
            temperature_c: Some(cells[7]),
        }
    };
    Some(text.lines().skip(1).map(pose).collect())
}

/// Mean of |‖a‖ − 1 g|, mg, over eighths of 84 h of wear that the fit did not use. GGIR's model,
/// fitted to the same seven eighths, reaches 2.20 mg, and what it published had used them all.
#[test]
fn autocalibration_predicts_stills_left_out() {
    let Some(stills) = ggir_stills() else {
        return;
    };
    let options = JointOptions {
        gravity: G,
        nominal: Some(1.0 / G),
        ..JointOptions::default()
    };
    let mut sum = 0.0;
    for part in 0..FOLDS {
        let out = part * stills.len() / FOLDS..(part + 1) * stills.len() / FOLDS;
        // As many as a week has poses of their own.
        let used: Vec<JointPose> = (0..stills.len())
            .filter(|k| !out.contains(k))
            .step_by(12)
            .map(|k| stills[k])
            .collect();
        let test = test_drift(&used, &options).unwrap();
        let chosen = JointOptions {
            drift: test.helps,
            ..options
        };
        let fit = joint(&used, &chosen).unwrap();
        let inverse = matrix3::inverse(&fit.model).unwrap();
        let error = |still: &JointPose| {
            let offset: [f64; 3] = std::array::from_fn(|i| {
                let drift = fit.drift.map_or(0.0, |d| {
                    d.per_c[i] * (still.temperature_c.unwrap() - d.reference_c)
                });
                fit.bias[i] + drift
            });
            let a = matrix3::mul_vec(&inverse, &matrix3::sub(&still.mean, &offset));
            1000.0 * (matrix3::norm(&a) / G - 1.0).abs()
        };
        let errors: Vec<f64> = stills[out].iter().map(error).collect();
        println!(
            "eighth {part}: {:.2} mg, drift {}, {} left out",
            mean(&errors),
            test.helps,
            fit.poses.iter().filter(|p| p.bad.is_some()).count()
        );
        sum += mean(&errors);
    }
    let reached = sum / FOLDS as f64;
    println!("{reached:.3} mg");
    assert!(reached <= 2.05, "{reached}");
}
