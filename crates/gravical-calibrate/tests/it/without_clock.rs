//! Recordings without time stamps and without a rate: rests are counted in rows.

use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::recording::{AccelUnit, Recording};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::support::{FACES, calibrated, close, read_options, read_with};

const SCALE: [f64; 3] = [1.012, 0.991, 1.006];

/// The faces `rows` rows each, and between two of them three of a turn.
fn recording(faces: &[usize], rows: usize, bias: [f64; 3]) -> Recording {
    let mut text = "ax,ay,az\n".to_owned();
    let mut previous = FACES[faces[0]].1;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for face in faces {
        let up = FACES[*face].1;
        for k in 0..rows + 3 {
            let share = ((k + 1) as f64 / 4.0).min(1.0);
            let way: [f64; 3] = [0, 1, 2].map(|c| previous[c] + share * (up[c] - previous[c]));
            let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            let [x, y, z] = [0, 1, 2].map(|c| {
                let a = 9.80665 * way[c] / length.max(0.1);
                SCALE[c] * a + bias[c] + 0.02 * rng.sample::<f64, _>(StandardNormal)
            });
            text += &format!("{x:.4},{y:.4},{z:.4}\n");
        }
        previous = up;
    }
    let options = read_options(|o| o.accel_unit = Some(AccelUnit::Counts));
    read_with(text.as_bytes(), &options)
}

#[test]
fn faces_are_found_and_seen_from_the_centre_of_the_readings() {
    let usual = [0.21, -0.33, 0.45];
    // A bias of 1 g moves every face.
    for (rows, bias) in [
        (10, usual),
        (15, usual),
        (22, usual),
        (30, usual),
        (47, usual),
        (47, [0.0, 0.4, 10.0]),
    ] {
        let session = [recording(&[0, 2, 1, 3, 4, 5], rows, bias)];
        let calibration = calibrated(&session, &CalibrateOptions::default()).calibration;
        for c in 0..3 {
            close(calibration.accelerometer.bias[c], bias[c], 0.02);
            close(calibration.accelerometer.scale()[c], SCALE[c], 0.003);
        }
    }
}

#[test]
fn errors_about_rests_that_are_counted_in_rows_advise_the_rate() {
    let bias = [0.0; 3];
    for (faces, rows, code) in [
        // Rows on the way from face to face are no poses, though they lie on the sphere.
        (&[0, 2, 4, 1, 3, 5, 0, 3, 4, 2][..], 8, "never-static"),
        (&[0, 2, 0, 2][..], 60, "underdetermined"),
    ] {
        let session = [recording(faces, rows, bias)];
        let error = calibrate(&session, &CalibrateOptions::default()).unwrap_err();
        assert_eq!(error.code(), code);
        let mut options = error.options().iter();
        assert!(options.any(|option| option.name == "rate"), "{error}");
    }
}
