//! Motion on a simulated sensor: errors and bands that the documents promise.
//!
//! The cells are those of `examples/motion_accuracy`, over fewer seeds.

// The names of cells are for its tables.
#[allow(dead_code)]
#[path = "../../examples/motion_accuracy/runs.rs"]
mod runs;

use gravical::motion::MotionOptions;
use runs::{Cell, Gyro, line, run};

const SEEDS: std::ops::Range<u64> = 1..301;

fn wobble(gyro: Gyro) -> Cell {
    Cell {
        tilt_change_deg: 3.0,
        gyro,
        ..line()
    }
}

#[test]
fn a_line_of_two_seconds_ends_within_three_millimetres() {
    let out = run(&line(), 1..61).unwrap();
    assert_eq!(out.found, out.runs);
    // 2.7 mm is what the accelerometer's noise leaves: N √(T³/12).
    assert!((2.2..3.3).contains(&out.rms_mm(0)), "{}", out.rms_mm(0));
}

#[test]
fn a_wobbling_line_ends_within_its_band() {
    let out = run(&wobble(Gyro::Calibrated), 1..41).unwrap();
    assert_eq!(out.found, out.runs);
    assert!(out.rms_mm(0) <= 4.5, "{}", out.rms_mm(0));
    assert!(out.covered(2.0, 0..3) > 0.88, "{}", out.covered(2.0, 0..3));
}

#[test]
#[ignore = "slow: 600 lines"]
fn lost_rows_and_jitter_cost_less_than_a_tenth() {
    let whole = run(&line(), SEEDS).unwrap().rms_mm(0);
    let torn = Cell {
        dropped: 0.02,
        jitter_ms: 1.0,
        ..line()
    };
    let torn = run(&torn, SEEDS).unwrap();
    assert_eq!(torn.found, torn.runs);
    assert!(torn.rms_mm(0) < 1.1 * whole, "{} {whole}", torn.rms_mm(0));
}

#[test]
#[ignore = "slow: 900 lines"]
fn a_wobble_costs_what_the_gyroscope_does_not_know() {
    for (gyro, most) in [(Gyro::Exact, 3.5), (Gyro::Calibrated, 4.0)] {
        let out = run(&wobble(gyro), SEEDS).unwrap();
        assert!(out.rms_mm(0) <= most, "{}", out.rms_mm(0));
    }
    // A scale error s is a tilt of s·3° that comes and goes with the wobble, and
    // ends as s g θ T²/2π: 5.7 mm for s uniform within ±3 %. No rest shows it.
    let blind = run(&wobble(Gyro::Uniform), SEEDS).unwrap();
    let floor = f64::hypot(2.7, 5.66);
    assert!(blind.rms_mm(0) < 1.1 * floor, "{}", blind.rms_mm(0));
    assert!(blind.rms_mm(0) > 0.9 * floor, "{}", blind.rms_mm(0));
}

#[test]
#[ignore = "slow: 300 lines"]
fn a_slow_line_is_found_every_time() {
    let slow = Cell {
        move_s: 4.0,
        ..line()
    };
    let out = run(&slow, SEEDS).unwrap();
    assert_eq!(out.found, out.runs);
    assert!(out.rms_mm(0) <= 9.0, "{}", out.rms_mm(0));
}

#[test]
#[ignore = "slow: 400 lines"]
fn smoothing_makes_no_drift_less() {
    let plain = run(&line(), 1..101).unwrap().rms_mm(0);
    for filter in ["savgol:5,2", "savgol:21,2", "butter:4,5Hz"] {
        let cell = Cell {
            options: MotionOptions {
                smooth: vec![filter.parse().unwrap()],
                ..MotionOptions::default()
            },
            ..line()
        };
        let smooth = run(&cell, 1..101).unwrap().rms_mm(0);
        assert!(smooth > 0.95 * plain, "{filter}: {smooth} {plain}");
    }
}

/// 68.3 ± 3 % and 95.4 ± 2 % over 750 seeds and three axes.
#[test]
#[ignore = "slow: 1500 lines"]
fn the_bands_cover_what_they_say() {
    for gyro in [Gyro::Calibrated, Gyro::DataSheet] {
        let cell = Cell {
            exact: false,
            ..wobble(gyro)
        };
        let out = run(&cell, 1..751).unwrap();
        let (one, two) = (out.covered(1.0, 0..3), out.covered(2.0, 0..3));
        assert!((one - 0.683).abs() < 0.03, "{one}");
        assert!((two - 0.954).abs() < 0.02, "{two}");
    }
}

#[test]
#[ignore = "slow: 200 lines"]
fn the_procedure_of_the_report_is_worse_and_says_so() {
    let report = Cell {
        options: MotionOptions::report(),
        ..line()
    };
    let out = run(&report, 1..101).unwrap();
    assert!(out.rms_mm(0) > 15.0, "{}", out.rms_mm(0));
    assert!(out.covered(2.0, 0..3) > 0.9);
    let tilted = Cell {
        options: MotionOptions::report(),
        ..wobble(Gyro::Exact)
    };
    let out = run(&tilted, 1..101).unwrap();
    assert!((out.rms_mm(0) - 327.0).abs() < 40.0, "{}", out.rms_mm(0));
}
