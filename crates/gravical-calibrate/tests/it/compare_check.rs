//! `compare` and `check` against sensors whose truth is known: how often is a
//! difference claimed where there is none, and is one found where there is?

use gravical_calibrate::calibrate::{CalibrateOptions, EstimateOptions, Method};
use gravical_calibrate::calibration_file::Calibration;
use gravical_calibrate::check::{CheckOptions, CheckReport, Judgement, check};
use gravical_calibrate::compare::{Comparison, compare};
use gravical_calibrate::recording::Recording;
use gravical_sim::{
    PosesOptions, Scenario, SimulateOptions, Simulation, SixPositionOptions, simulate,
};

use crate::support::*;
use crate::truth::recordings;

fn six(hold_s: f64) -> Scenario {
    Scenario::SixPosition(SixPositionOptions {
        hold_s,
        ..Default::default()
    })
}

fn poses(hold_s: f64, free: u32) -> Scenario {
    Scenario::Poses(PosesOptions { hold_s, free })
}

/// A session of the sensor that `sensor` drew (that of `seed` itself without
/// one). The bias does not drift: the covariances know nothing of temperature.
fn session(
    scenario: Scenario,
    seed: u64,
    tilt_deg: f64,
    sensor: Option<&Simulation>,
) -> Simulation {
    let mut options = SimulateOptions::new(scenario);
    options.seed = seed;
    options.tilt_sd_deg = tilt_deg;
    options.sensor.bias_drift_mg_per_c = 0.0;
    if let Some(sensor) = sensor {
        options.sensor.accel_matrix = Some(sensor.truth.accelerometer.matrix);
        options.sensor.accel_bias_mps2 = Some(sensor.truth.accelerometer.bias_mps2);
    }
    simulate(&options).unwrap()
}

/// With tilts as given, or estimated.
fn calibration(
    session: &[Recording],
    tilt_deg: impl Into<Option<f64>>,
    method: Method,
) -> Calibration {
    let options = CalibrateOptions {
        estimate: EstimateOptions {
            pose_tilt_deg: tilt_deg.into(),
            method,
            ..EstimateOptions::default()
        },
        ..with_gravity(9.80665)
    };
    calibrated(session, &options).calibration
}

fn share_under(p: &[f64], level: f64) -> f64 {
    p.iter().filter(|p| **p < level).count() as f64 / p.len() as f64
}

fn each<T>(of: &[T], value: impl Fn(&T) -> f64) -> Vec<f64> {
    of.iter().map(value).collect()
}

/// Two sessions of each of 150 sensors, six faces placed within `tilt_deg`, which the calibrations are told or not.
fn compared(tilt_deg: f64, is_told: bool, method: Method) -> Vec<Comparison> {
    let twice = |seed| {
        let first = session(six(1.0), seed, tilt_deg, None);
        let second = session(six(1.0), 10_000 + seed, tilt_deg, Some(&first));
        let told = is_told.then_some(tilt_deg);
        let [a, b] = [first, second].map(|s| calibration(&recordings(&s), told, method));
        compare(&a, &b, ["a.json", "b.json"]).unwrap()
    };
    (1..=150).map(twice).collect()
}

/// At a level of 5 % a share of 150 scatters by 1.8 %, at 1 % by 0.8 %; bounds
/// are about three times that. Two sessions share the data-sheet prior of the
/// joint fit, and are nearer to each other than their covariances say where it is
/// all that tells the angles between the axes (0.6 times at 2°): the lower bound
/// of the RMS.
#[test]
#[ignore = "slow: 1500 sessions"]
fn two_sessions_of_one_sensor_seldom_differ() {
    for (method, tilt, is_told) in [
        (Method::Joint, 0.1, true),
        (Method::Joint, 1.0, true),
        (Method::Joint, 1.0, false),
        (Method::Joint, 2.0, true),
        (Method::Ferraris, 1.0, true),
    ] {
        let all = compared(tilt, is_told, method);
        let magnitude = each(&all, |c| c.magnitude.test.unwrap().p_value);
        let orientation = |c: &Comparison| c.orientation.as_ref().unwrap().test.unwrap();
        let turned = each(&all, |c| orientation(c).p_value);
        let differ = each(&all, |c| match c.verdict.judgement {
            Judgement::Differs => 0.0,
            Judgement::Agrees => 1.0,
            _ => panic!("{:?}", c.verdict),
        });
        let squares = each(&all, |c| c.magnitude.norm_rms_mps2.powi(2));
        let predicted = each(&all, |c| c.magnitude.predicted_rms_mps2.unwrap().powi(2));
        let ratio = (mean(&squares) / mean(&predicted)).sqrt();
        let (five_m, five_o) = (share_under(&magnitude, 0.05), share_under(&turned, 0.05));
        let wrong = share_under(&differ, 0.5);
        let shown = format!(
            "{method:?}, tilt {tilt} (told: {is_told}): p < 0.05 in {five_m:.3} (‖a‖) and {five_o:.3} (rotation), {wrong:.3} differ; RMS over predicted {ratio:.3}"
        );
        println!("{shown}");
        let are_five = [five_m, five_o].iter().all(|s| (0.005..=0.1).contains(s));
        assert!(are_five, "{shown}");
        assert!(wrong <= 0.02 && (0.55..=1.15).contains(&ratio), "{shown}");
    }
}

/// A calibration of each of 100 sensors, checked on a later session.
#[test]
#[ignore = "slow: 1200 sessions"]
fn new_stills_seldom_contradict_a_good_calibration() {
    for (method, tilt, later) in [
        (Method::Joint, 0.1, poses(3.0, 6)),
        (Method::Joint, 1.0, poses(3.0, 6)),
        (Method::Joint, 1.0, six(1.0)),
        (Method::Joint, 2.0, poses(3.0, 6)),
        (Method::Ferraris, 1.0, poses(3.0, 6)),
        (Method::Ferraris, 3.0, poses(3.0, 6)),
    ] {
        let reports: Vec<CheckReport> = (1..=100)
            .map(|seed| {
                let first = session(six(1.0), seed, tilt, None);
                let second = session(later, 20_000 + seed, 1.0, Some(&first));
                let file = calibration(&recordings(&first), tilt, method);
                let new = recordings(&second);
                check(&file, "cal.json", &new, &CheckOptions::default()).unwrap()
            })
            .collect();
        let five = share_under(&each(&reports, |r| r.test.p_value), 0.05);
        let intervals = reports.iter().flat_map(|r| &r.static_intervals);
        let z2 = mean(&intervals.map(|s| s.z.powi(2)).collect::<Vec<f64>>());
        let judgements = reports.iter().map(|r| r.verdict.judgement);
        let wrong = judgements.filter(|j| *j == Judgement::DoesNotFit).count();
        let shown = format!(
            "{method:?}, tilt {tilt}, {}: p < 0.05 in {five:.3}, {wrong} of 100 do not fit, mean z² {z2:.3}",
            later.name()
        );
        println!("{shown}");
        assert!(five <= 0.11 && (0.6..=1.25).contains(&z2), "{shown}");
        // Tails of products of tilts of 3° without a free pose.
        assert!(wrong <= if tilt < 3.0 { 2 } else { 5 }, "{shown}");
    }
}

sampled! {
    a_bias_off_by_five_sigma_is_found(6, 24);
}

/// The same, with one bias of the file altered by five of the standard deviations
/// that are reckoned with: six faces leave nothing to tell the model error, which is
/// 2 mm/s² then.
fn a_bias_off_by_five_sigma_is_found(sensors: usize) {
    let (mut found, mut differ) = (0, 0);
    for seed in 1..=sensors as u64 {
        let axis = seed as usize % 3;
        let first = session(six(1.0), seed, 0.3, None);
        let second = session(six(10.0), 30_000 + seed, 0.3, Some(&first));
        let good = calibration(&recordings(&first), 0.3, Method::Joint);
        let mut altered = good.clone();
        let variance = good.accelerometer.covariance.as_ref().unwrap().values[9 + axis][9 + axis];
        altered.accelerometer.bias[axis] += 5.0 * variance.sqrt().hypot(0.002);
        let new = recordings(&second);
        let report = check(&altered, "cal.json", &new, &CheckOptions::default()).unwrap();
        found += usize::from(report.verdict.judgement == Judgement::DoesNotFit);
        let other = calibration(&new, 0.3, Method::Joint);
        let result = compare(&altered, &other, ["a.json", "b.json"]).unwrap();
        differ += usize::from(result.verdict.judgement == Judgement::Differs);
    }
    println!("of {sensors}: {found} found, {differ} differ from a new calibration");
    assert!(24 * found >= 20 * sensors && 2 * differ >= sensors);
}
