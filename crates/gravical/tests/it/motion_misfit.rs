//! Motion with a calibration that does not describe the sensor: the bands say so.

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Calibration;
use gravical::motion::{MotionOptions, MotionResult, motion};
use gravical::recording::{ReadOptions, Recording, read};
use gravical::simulate::{LineOptions, PosesOptions, Scenario, SimulateOptions, simulate_to};

use super::support;

/// The displacement that is simulated, m.
const TRUTH_M: [f64; 3] = [0.02, 0.7, 0.0];

fn recorded(scenario: Scenario, seed: u64) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let options = SimulateOptions {
        seed,
        ..SimulateOptions::new(scenario)
    };
    let (_, files) = simulate_to(&options, folder.path(), false).unwrap();
    let mut files = files.iter();
    let csv = files.find(|p| p.extension().is_some_and(|e| e == "csv"));
    read(csv.unwrap(), &ReadOptions::default()).unwrap()
}

fn calibration(seed: u64) -> Calibration {
    let poses = PosesOptions {
        free: 8,
        ..PosesOptions::default()
    };
    let session = [recorded(Scenario::Poses(poses), seed)];
    let options = CalibrateOptions::default();
    calibrate(&session, &options).unwrap().calibration
}

fn line(seed: u64) -> Recording {
    recorded(Scenario::Line(LineOptions::default()), seed)
}

/// Columns with the names of calibrated ones; their values go through `map`.
fn named_calibrated(recording: &Recording, map: impl Fn([f64; 3]) -> [f64; 3]) -> Recording {
    let gyro = recording.gyro.as_ref().unwrap();
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s\n".to_owned();
    for (i, t) in recording.time_s.as_ref().unwrap().iter().enumerate() {
        let [x, y, z] = map(recording.accel_at(i));
        let [p, q, r] = [gyro[0][i], gyro[1][i], gyro[2][i]];
        text += &format!("{t:.4},{x:.6},{y:.6},{z:.6},{p:.6},{q:.6},{r:.6}\n");
    }
    support::read(text.as_bytes())
}

fn moved(recording: &Recording, file: &Calibration) -> MotionResult {
    let name = "cal.json";
    let calibration = Some((file, name));
    let options = MotionOptions::default();
    motion(recording, calibration, &options).unwrap().result
}

/// Error of the displacement over its standard uncertainty, of the axis where that is most.
fn worst_error(result: &MotionResult) -> f64 {
    let one = &result.moves[0];
    let (d, sigma) = (one.displacement_m.unwrap(), one.sigma_m.unwrap());
    let errors = (0..3).map(|i| (d[i] - TRUTH_M[i]).abs() / sigma[i]);
    errors.fold(0.0, f64::max)
}

fn has(result: &MotionResult, kind: &str) -> bool {
    result.findings.iter().any(|f| f.kind == kind)
}

sampled! {
    a_calibration_of_another_sensor_widens_the_bands(3, 8);
    a_calibration_applied_twice_widens_the_bands(2, 6);
}

fn a_calibration_of_another_sensor_widens_the_bands(sensors: u64) {
    let (mut contradicted, mut worst): (u64, f64) = (0, 0.0);
    for seed in 1..=sensors {
        let file = calibration(seed);
        let own = moved(&line(seed), &file);
        assert!(!own.gravity_misfit.unwrap().contradicts, "seed {seed}");
        // The parts of two seeds may agree along gravity by chance.
        let other = moved(&line(seed + 100), &file);
        let misfit = other.gravity_misfit.unwrap();
        let said = other.verdict.reasons[0].contains("gravical check");
        assert_eq!(misfit.contradicts, said);
        if misfit.contradicts {
            contradicted += 1;
            worst = worst.max(worst_error(&other));
            let wide = other.moves[0].sigma_m.unwrap()[1];
            assert!(wide > 2.0 * own.moves[0].sigma_m.unwrap()[1], "seed {seed}");
        }
    }
    let holds = contradicted + 1 >= sensors && worst < 3.5;
    assert!(holds, "{contradicted} {worst}");
}

fn a_calibration_applied_twice_widens_the_bands(sensors: u64) {
    for seed in 1..=sensors {
        let (file, raw) = (calibration(seed), line(seed));
        let apply = file.accelerometer_calibration();
        let twice = moved(&named_calibrated(&raw, |a| apply.apply(a)), &file);
        assert!(has(&twice, "already-calibrated"), "seed {seed}");
        assert!(worst_error(&twice) < 3.5, "seed {seed}");
        // Raw columns of that name, whose gravity shows that they are raw.
        let once = moved(&named_calibrated(&raw, |a| a), &file);
        let raw_misfit = (raw_gravity(&raw) - file.gravity_mps2).abs();
        if raw_misfit > 0.1 {
            assert!(!has(&once, "already-calibrated"), "seed {seed}");
        }
        assert!(worst_error(&once) < 3.5, "seed {seed}");
    }
}

#[test]
fn every_rest_is_held_against_the_calibration() {
    let (file, mut recording) = (calibration(1), line(1));
    // After the move gravity is off by 8 mg.
    let later = recording.accel[2][720..].iter_mut();
    later.for_each(|z| *z += 0.08);
    let misfit = moved(&recording, &file).gravity_misfit.unwrap();
    assert!(misfit.contradicts && misfit.rest_s > 5.0, "{misfit:?}");
}

/// Magnitude of the first two seconds, m/s².
fn raw_gravity(recording: &Recording) -> f64 {
    let mean = |axis: usize| recording.accel[axis][..200].iter().sum::<f64>() / 200.0;
    (0..3).map(|axis| mean(axis).powi(2)).sum::<f64>().sqrt()
}
