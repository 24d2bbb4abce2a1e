//! Attitude while the sensor moves, beside cameras: trials of BROAD (Laidig et al. 2021, doi 10.3390/data6070072).

use gravical_motion::{CalibrationUncertainty, ElementErrors, MotionOptions, estimate_motion};
use nalgebra::{Rotation3, Vector3};

use crate::real::{columns, rows};
use crate::study::{not_interpolated, rotation};

type V3 = Vector3<f64>;

/// Trials; the last has the whole attitude, the others the direction of up.
pub const TRIALS: [&str; 4] = [
    "broad-orientation/05_undisturbed_slow_rotation_with_breaks_B",
    "broad-orientation/16_undisturbed_fast_translation_B",
    "broad-orientation/26_disturbed_phone_vibration_A",
    "broad-translation/14_undisturbed_slow_translation_with_breaks_B",
];

/// By the data sheet, as where no calibration is given.
pub fn uncalibrated() -> CalibrationUncertainty {
    let errors = |scale: f64, cross: f64, bias_mps2: f64| ElementErrors {
        scale,
        cross,
        bias_mps2,
    };
    CalibrationUncertainty {
        force: errors(0.02, 0.02, 0.35).force(),
        rate: errors(0.0173, 0.0115, 0.0).rate(),
        ..CalibrationUncertainty::default()
    }
}

/// Errors and their standard deviations, rad.
#[derive(Debug, Default)]
pub struct Errors(Vec<[f64; 2]>);

impl Errors {
    /// Rms of the errors, rad, that of the deviations over it, and the share within two deviations.
    pub fn summary(&self) -> [f64; 3] {
        let count = self.0.len() as f64;
        let rms = |k: usize| (self.0.iter().map(|e| e[k].powi(2)).sum::<f64>() / count).sqrt();
        let inside = self.0.iter().filter(|[e, sd]| e.abs() < 2.0 * sd).count();
        [rms(0), rms(1) / rms(0), inside as f64 / count]
    }
}

/// Rms of the inclination of the samples of a trial while it moves, rad, and the errors of tilt and heading at the
/// nodes of the path; none without the data.
pub fn attitude(trial: &str, options: &MotionOptions) -> Option<(f64, Errors, Errors)> {
    let rows = rows(&format!("{trial}.csv.gz"))?;
    let time_s: Vec<f64> = rows.iter().map(|r| r[0]).collect();
    let [force, rate] = [1, 4].map(|first| columns(&rows, first, 1, 1.0));
    let samples = not_interpolated(&time_s, &force, &rate);
    let motion = estimate_motion(&samples, options);
    let whole = |row: &[f64]| rotation([10, 11, 12, 13].map(|c| row[c]));
    let has_whole = rows[0].len() > 11;
    let up_and_moving = |row: &[f64]| {
        if has_whole {
            (whole(row).inverse() * V3::z(), row[14] == 1.0)
        } else {
            (V3::new(row[8], row[9], row[10]), row[7] == 1.0)
        }
    };
    let (mut square, mut count) = (0.0, 0.0);
    for (row, state) in rows.iter().zip(motion.states(&samples)) {
        let (up, is_moving) = up_and_moving(row);
        let angle = (rotation(state.attitude) * up).angle(&V3::z());
        if is_moving && angle.is_finite() {
            square += angle.powi(2);
            count += 1.0;
        }
    }
    assert!(count > 10_000.0, "{trial}");
    let [mut tilt, mut heading] = [Errors::default(), Errors::default()];
    let mut first = None;
    for node in &motion.path {
        let (row, found) = (&rows[node.sample], rotation(node.attitude));
        let (up, is_moving) = up_and_moving(row);
        if !up.x.is_finite() {
            continue;
        }
        // Rotation vector from what is found to the truth; the cameras' heading is that of their room.
        let mut error = (found * up).cross(&V3::z());
        if has_whole {
            let azimuth = |r: Rotation3<f64>| r[(1, 0)].atan2(r[(0, 0)]);
            let turn = azimuth(whole(row)) - azimuth(found);
            error.z = (turn - *first.get_or_insert(turn)).sin();
        }
        if is_moving {
            let errors = [0, 1, 2].map(|c| [error[c], node.attitude_sd_rad[c]]);
            tilt.0.extend(&errors[..2]);
            heading.0.extend(has_whole.then_some(errors[2]));
        }
    }
    Some((f64::sqrt(square / count), tilt, heading))
}

/// Offline VQF has about 0.5°.
#[test]
fn inclination_is_that_of_the_cameras() {
    for (trial, limit_deg) in TRIALS.into_iter().zip([0.4, 0.6, 0.7, 0.4]) {
        for no_stances in [false, true] {
            let mut options = MotionOptions {
                no_stances,
                ..MotionOptions::default()
            };
            let Some((inclination_rad, ..)) = attitude(trial, &options) else {
                return;
            };
            let inclination_deg = inclination_rad.to_degrees();
            println!("{trial}, no_stances {no_stances}: {inclination_deg:.2}°");
            assert!(inclination_deg < limit_deg, "{trial}, {no_stances}");

            options.calibration = uncalibrated();
            let (_, tilt, heading) = attitude(trial, &options).unwrap();
            let holds = |errors: &Errors| errors.0.is_empty() || errors.summary()[2] > 0.93;
            assert!(holds(&tilt) && holds(&heading), "{trial}, {no_stances}");
        }
    }
}
