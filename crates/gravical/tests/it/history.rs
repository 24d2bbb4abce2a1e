//! Histories of sensors whose truth is known: how often is a change claimed where there is none,
//! and is one found where there is?
//!
//! `GRAVICAL_HISTORIES=500` simulates that many sensors of each kind.

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::CalibrationFile;
use gravical::compare::{History, Stability, history};
use gravical::estimate::accelerometer::{EstimateOptions, Method};
use gravical::gravity::Gravity;
use gravical::simulate::{PosesOptions, Scenario, SimulateOptions, SixPositionOptions, simulate};

use crate::support::*;
use crate::truth::recordings;

/// How the sessions of a sensor are recorded and calibrated.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    free: Option<u32>,
    tilt_deg: f64,
    /// Whether the tilt is given to the fit, or estimated.
    tilt_given: bool,
    methods: [Method; 2],
    sessions: usize,
    gravity_given: bool,
    /// Share of alarms that is allowed.
    most: f64,
}

const SIX_FACES: Case = Case {
    name: "six faces, joint",
    free: None,
    tilt_deg: 1.0,
    tilt_given: true,
    methods: [Method::Joint, Method::Joint],
    sessions: 4,
    gravity_given: true,
    most: 0.01,
};
/// Faces that are tilted by 1° are taken for exact.
const EXACT: Case = Case {
    name: "six faces, ferraris",
    methods: [Method::Ferraris, Method::Ferraris],
    most: 0.025,
    ..SIX_FACES
};
const MIXED: Case = Case {
    name: "six faces, joint and ferraris by turns",
    methods: [Method::Joint, Method::Ferraris],
    most: 0.025,
    ..SIX_FACES
};
const FREE: Case = Case {
    name: "six faces and six free poses, tilt estimated",
    free: Some(6),
    tilt_given: false,
    sessions: 3,
    ..SIX_FACES
};
const ASSUMED: Case = Case {
    name: "the same at 0.3°, gravity assumed in every second session",
    tilt_deg: 0.3,
    sessions: 4,
    gravity_given: false,
    ..FREE
};
const JIG: Case = Case {
    name: "six faces in a jig",
    tilt_deg: 0.1,
    sessions: 6,
    ..SIX_FACES
};

/// The sessions of one sensor; from the middle on its z bias is larger by `shift_mps2`.
fn sessions(case: &Case, seed: u64, shift_mps2: f64) -> Vec<CalibrationFile> {
    let scenario = || match case.free {
        None => Scenario::SixPosition(SixPositionOptions {
            hold_s: 1.0,
            ..Default::default()
        }),
        Some(free) => Scenario::Poses(PosesOptions { hold_s: 3.0, free }),
    };
    let mut sensor: Option<([[f64; 3]; 3], [f64; 3])> = None;
    (0..case.sessions)
        .map(|i| {
            let mut options = SimulateOptions::new(scenario());
            options.seed = seed + 100_000 * i as u64;
            options.tilt_sd_deg = case.tilt_deg;
            options.sensor.bias_drift_mg_per_c = 0.0;
            if let Some((matrix, mut bias)) = sensor {
                if 2 * i >= case.sessions {
                    bias[2] += shift_mps2;
                }
                options.sensor.accel_matrix = Some(matrix);
                options.sensor.accel_bias_mps2 = Some(bias);
            }
            let session = simulate(&options).unwrap();
            let truth = &session.truth.accelerometer;
            sensor.get_or_insert((truth.matrix, truth.bias_mps2));
            let gravity = match case.gravity_given || i % 2 == 0 {
                true => Gravity::given(9.80665).unwrap(),
                false => Gravity::default(),
            };
            let options = CalibrateOptions {
                gravity,
                estimate: EstimateOptions {
                    pose_tilt_deg: case.tilt_given.then_some(case.tilt_deg),
                    method: case.methods[i % 2],
                    ..EstimateOptions::default()
                },
                ..CalibrateOptions::default()
            };
            calibrated(&recordings(&session), &options).file
        })
        .collect()
}

fn judged(case: &Case, seed: u64, shift_mps2: f64) -> History {
    let files = sessions(case, seed, shift_mps2);
    let names: Vec<String> = (0..files.len()).map(|i| i.to_string()).collect();
    let named: Vec<_> = files.iter().zip(names.iter().map(|n| &**n)).collect();
    history(&named)
}

/// Number of sensors.
fn count(of: u64) -> u64 {
    let given = std::env::var("GRAVICAL_HISTORIES").ok();
    given.and_then(|n| n.parse().ok()).unwrap_or(of)
}

#[test]
fn sensors_that_do_not_change_seldom_alarm() {
    for case in [SIX_FACES, EXACT, MIXED, FREE, ASSUMED, JIG] {
        let n = count(40);
        let all: Vec<History> = (1..=n).map(|seed| judged(&case, seed, 0.0)).collect();
        let tested: usize = all.iter().map(|h| h.tested).sum();
        let changed = |h: &&History| h.verdict.judgement == Stability::Changed;
        let alarms = all.iter().filter(changed).count() as f64;
        println!(
            "{}: {alarms} of {n} changed, {:.1} sessions tested each",
            case.name,
            tested as f64 / n as f64
        );
        // Three standard deviations of a Poisson number.
        let expected = case.most * n as f64;
        assert!(
            alarms <= expected + 3.0 * expected.sqrt().max(0.7),
            "{alarms}"
        );
        assert!(tested as f64 > 0.8 * n as f64 * case.sessions as f64);
    }
}

#[test]
fn a_bias_that_steps_by_eight_sigma_is_found_and_placed() {
    for case in [FREE, JIG] {
        let n = count(20);
        let (mut found, mut placed) = (0, 0);
        for seed in 1..=n {
            let before = sessions(&case, seed, 0.0);
            let sigma = before[0].accelerometer.deviations.unwrap().bias[2];
            let result = judged(&case, seed, 8.0 * sigma);
            if result.verdict.judgement == Stability::Changed {
                found += 1;
                let step = result.magnitude.unwrap().step.unwrap();
                let until = case.sessions.div_ceil(2).to_string();
                placed += u64::from(step.until == until && step.largest.name == "bias_z");
            }
        }
        println!("{}: {found} of {n} found, {placed} placed", case.name);
        assert!(found * 10 >= n * 8, "{found}");
        assert!(placed * 10 >= n * 6, "{placed}");
    }
}
