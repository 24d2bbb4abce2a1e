//! Real recordings whose truth is known; skipped without GRAVICAL_DATA.

use std::io::Read;
use std::path::Path;

use gravical_motion::{Motion, MotionOptions, estimate_motion};

use crate::simulated::norm;
use crate::study::{not_interpolated, options};

const G: f64 = 9.80665;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Rows of numbers, NaN for an empty cell; none without the data.
pub fn rows(file: &str) -> Option<Vec<Vec<f64>>> {
    let Some(data) = std::env::var_os("GRAVICAL_DATA") else {
        println!("skipped: GRAVICAL_DATA is not set");
        return None;
    };
    let bytes = std::fs::read(Path::new(&data).join(file)).unwrap();
    let mut text = String::new();
    if file.ends_with(".gz") {
        flate2::read::GzDecoder::new(&bytes[..])
            .read_to_string(&mut text)
            .unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    let cell = |c: &str| c.parse().unwrap_or(f64::NAN);
    let cells = |line: &str| line.split(',').map(cell).collect();
    Some(text.lines().skip(1).map(cells).collect())
}

/// Three columns from the first on, `step` apart.
pub fn columns(rows: &[Vec<f64>], first: usize, step: usize, unit: f64) -> Vec<[f64; 3]> {
    let three = |row: &Vec<f64>| [0, 1, 2].map(|c| row[first + step * c] * unit);
    rows.iter().map(three).collect()
}

/// Stamps of so many samples, s.
fn even(samples: usize, rate_hz: f64) -> Vec<f64> {
    (0..samples).map(|i| i as f64 / rate_hz).collect()
}

/// Distance between start and end of the path, m.
fn closing_error_m(motion: &Motion) -> f64 {
    let (first, last) = (&motion.path[0], motion.path.last().unwrap());
    norm([0, 1, 2].map(|c| last.position_m[c] - first.position_m[c]))
}

#[test]
fn walks_close() {
    // Published of the second: 0.08 m with a calibrated gyroscope and settings for this recording. Of the walk the
    // limit is its band, 0.5 m (1σ): which seconds of standing count as rest moves the end by more than 0.2 m.
    const SQUARE: &str = "openshoe-square2/square2_u.csv";
    const WALK: &str = "xio-gait/short_walk.csv";
    for (file, [force, rate], units, rate_hz, steps, limit_m) in [
        (SQUARE, [0, 3], [1.0, 1.0], 100.0, 0, 0.2),
        (WALK, [4, 1], [G, DEG], 400.0, 16, 0.5),
    ] {
        let Some(rows) = rows(file) else { return };
        let force = columns(&rows, force, 1, units[0]);
        let rate = columns(&rows, rate, 1, units[1]);
        let samples = not_interpolated(&even(rows.len(), rate_hz), &force, &rate);
        let motion = estimate_motion(&samples, &MotionOptions::default());
        let error_m = closing_error_m(&motion);
        let stances: usize = motion.moves.iter().map(|m| m.stances).sum();
        assert!(stances >= steps, "{file}: {stances}");
        assert!(error_m < limit_m, "{file}: {error_m} m");
        let last = motion.path.last().unwrap();
        let holds = (0..3).all(|c| last.position_m[c].abs() < 2.0 * last.position_sd_m[c]);
        assert!(holds, "{file}: {last:?}");
    }
}

/// Strides of both feet between moments at which the foot stands, beside an optical heel marker.
#[test]
fn strides_are_those_of_the_cameras() {
    let folder = "gaitmap-example";
    let Some(rows_of_both) = rows(&format!("{folder}/imu_sample.csv.gz")) else {
        return;
    };
    let mocap = rows(&format!("{folder}/mocap_sample.csv.gz")).unwrap();
    let events = rows(&format!("{folder}/stride_events_sample.csv.gz")).unwrap();
    // Left and right: columns of the sensor and of the heel; strides of the left foot come first.
    let mut later = 1..events.len();
    let second = later.find(|i| events[*i][2] < events[i - 1][2]).unwrap();
    for (foot, heel, strides) in [(0, 7, &events[..second]), (1, 10, &events[second..])] {
        let time_s = even(rows_of_both.len() - 1, 204.8);
        let axes = |first: usize, unit: f64| columns(&rows_of_both[1..], first + foot, 2, unit);
        let samples = not_interpolated(&time_s, &axes(1, 1.0), &axes(7, DEG));
        let motion = estimate_motion(&samples, &options());
        let path: Vec<[f64; 3]> = motion.states(&samples).map(|s| s.position_m).collect();
        let stands: Vec<f64> = strides.iter().map(|s| s[6]).collect();
        let level = |a: &[f64], b: &[f64]| (b[0] - a[0]).hypot(b[1] - a[1]);
        let errors: Vec<f64> = stands
            .windows(2)
            .filter(|pair| pair[1] - pair[0] < 400.0)
            .filter_map(|pair| {
                let [a, b] = [pair[0], pair[1]].map(|at| at as usize);
                let heel_at =
                    |at: f64| Some(&mocap.get(1 + (at / 2.048) as usize)?[heel..heel + 2]);
                let truth = level(heel_at(pair[0])?, heel_at(pair[1])?) * 1e-3;
                let error = level(&path[a], &path[b]) - truth;
                error.is_finite().then_some(error)
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let sd = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64;
        assert!(errors.len() > 20, "{foot}");
        assert!(mean.abs() < 0.08 && sd.sqrt() < 0.06, "{foot}: {mean} {sd}");
    }
}
