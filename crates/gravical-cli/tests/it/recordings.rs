//! Real recordings with known results.

use std::collections::HashMap;
use std::path::Path;

use serde_json::Value;

use crate::support::*;

/// K, R and b of both sensors and the g-sensitivity against a file in imucal's
/// form; its K_g is per °/s, ours per rad/s. `sense`: −1 where it took the turns for the other way round.
fn agrees_with_imucal(calibration: &Value, imucal: &Value, sense: f64) {
    let (a, g) = (&calibration["accelerometer"], &calibration["gyroscope"]);
    for (ours, factor, key) in [
        (&a["scale"], 1.0, "K_a"),
        (&a["bias"], 1.0, "b_a"),
        (&a["orientation"], 1.0, "R_a"),
        (&g["scale"], std::f64::consts::PI / 180.0, "K_g"),
        (&g["bias"], 1.0, "b_g"),
        (&g["orientation"], sense, "R_g"),
        (&g["g_sensitivity"], 1.0, "K_ga"),
    ] {
        let ours: Vec<f64> = numbers(ours).iter().map(|v| v * factor).collect();
        let mut theirs = numbers(&imucal[key]);
        if key == "K_a" || key == "K_g" {
            theirs = vec![theirs[0], theirs[4], theirs[8]];
        }
        agree(&ours, &theirs, 1e-9, key);
    }
}

#[test]
fn ferraris_equals_imucal() {
    let Some(data) = data() else { return };
    let references = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference");
    for (session, options, reference, sense) in [
        (
            "example_ferraris_session.csv",
            "--rate 102.4 --sections imucal-ferraris/example_ferraris_session_list.json",
            read(&references, "imucal/example_ferraris_session.json"),
            1.0,
        ),
        (
            "annotated_session.csv",
            "--rate 204.8",
            read(&data, "imucal-ferraris/published_example_cal.json"),
            -1.0,
        ),
    ] {
        let line = format!("imucal-ferraris/{session} {options} --gravity 9.81 --method ferraris");
        let reference = serde_json::from_str(&reference).unwrap();
        agrees_with_imucal(&calibrate(&data, &line, 0), &reference, sense);
    }
}

/// Sessions, where a value is in the result, what the owners of the recordings or other programs
/// publish, and how far it may be off: the data sheet allows a gyroscope 3 %; the bias of the second
/// board drifts by 0.08 °/s; the sections of the third session were marked by a person for imucal;
/// the bias that is listed for the gyroscope of the last one is that of its first still, with the part
/// that gravity has in it.
const PUBLISHED: &str = "\
mikoff-mpu9150/imu0.log --rate 100 --gravity 9.81 | accelerometer/bias | 0.1027 0.0967 0.3444 | 3e-3
mikoff-mpu9150/imu0.log --rate 100 --gravity 9.81 | accelerometer/scale_deviation_percent | 0.36 0.32 0.65 | 0.03
mikoff-mpu9150/imu0.log --rate 100 --gravity 9.81 | gyroscope/scale | 1 1 1 | 0.03
tomisuarez-mpu6050/calibration.csv --method ferraris | accelerometer/bias | 699 -345 -1830 | 15
tomisuarez-mpu6050/calibration.csv | gyroscope/bias | -427.46 147.95 -80.72 | 10
imucal-ferraris/example_ferraris_session.csv --rate 102.4 --gravity 9.81 | accelerometer/scale | 0.9967459 1.0024376 1.0233953 | 1e-3
imucal-ferraris/example_ferraris_session.csv --rate 102.4 --gravity 9.81 | accelerometer/bias | 0.537117 -0.616203 0.398867 | 0.02
{xsens} | accelerometer/bias | 33124.1826 33275.1794 32364.4156 | 1
{xsens} | gyroscope/bias | 32777.13994 32459.80288 32511.84746 | 12
{xsens} | gyroscope/matrix/0/0 | 2.09294526e-4 | 2.1e-6
{xsens} | gyroscope/matrix/1/1 | 2.09898540e-4 | 2.1e-6
{xsens} | gyroscope/matrix/2/2 | 2.09482984e-4 | 2.1e-6
{xsens} | gyroscope/residual_deg | 0 | 0.2";

const XSENS: &str =
    "imu_tk-xsens/xsens_acc.txt.gz --gyro imu_tk-xsens/xsens_gyro.txt.gz --gravity 9.81744";

#[test]
fn published_results_are_found() {
    let Some(data) = data() else { return };
    let mut files = HashMap::new();
    for row in PUBLISHED.lines() {
        let [line, at, wanted, tolerance] = row.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        let run = || calibrate(&data, &line.replace("{xsens}", XSENS), 0);
        let file = files.entry(line).or_insert_with(run);
        let found = numbers(file.pointer(&format!("/{at}")).unwrap());
        for (found, wanted) in found.iter().zip(wanted.split(' ')) {
            close(*found, wanted.parse().unwrap(), tolerance.parse().unwrap());
        }
    }
}

/// U of M Mᵀ = U Uᵀ, upper triangular with a positive diagonal: the frame of imu_tk, A = U⁻¹; its
/// diagonal.
fn triangular(file: &Value) -> [f64; 3] {
    let a = &file["accelerometer"];
    let (scale, r) = (numbers(&a["scale"]), numbers(&a["orientation"]));
    let m = |i: usize, j: usize| scale[i] * r[3 * i + j];
    let p = |i: usize, j: usize| (0..3).map(|k| m(i, k) * m(j, k)).sum::<f64>();
    let zz = p(2, 2).sqrt();
    let (yz, xz) = (p(1, 2) / zz, p(0, 2) / zz);
    let yy = (p(1, 1) - yz * yz).sqrt();
    let xy = (p(0, 1) - xz * yz) / yy;
    [(p(0, 0) - xy * xy - xz * xz).sqrt(), yy, zz]
}

#[test]
fn xsens_by_hand_38_poses() {
    let Some(data) = data() else { return };
    let file = calibrate(&data, XSENS, 0);
    assert_eq!(list(&file["poses"]).len(), 38);
    // A = T K with T of unit diagonal, so that 1/U_ii is K_i.
    let published = [0.00241278463, 0.00242712280, 0.00241168028];
    for (u, k) in triangular(&file).iter().zip(published) {
        close(1.0 / u / k, 1.0, 1e-4);
    }
    let a = &file["reliability"];
    // Hardly worse left out than nine free parameters (0.146 to 0.151 mg).
    let left_out_mg = number(&a["left_out_rms_mps2"]) * 1000.0 / 9.80665;
    assert!(left_out_mg <= 0.156, "{left_out_mg}");
    // Real sensors miss the model by more than the noise of their means.
    let chi2 = number(&a["fit"]["chi2_per_freedom"]);
    assert!((2.0..12.0).contains(&chi2), "{chi2}");
}

#[test]
fn imucals_files_are_read_and_written_back_with_equal_values() {
    let Some(data) = data() else { return };
    for name in ["published_example_cal", "legacy_calibration_pre_2.0"] {
        let path = format!("imucal-ferraris/{name}.json");
        let before: Value = serde_json::from_str(&read(&data, &path)).unwrap();
        let after = ends(&data, &format!("export {path} --to imucal"), 0).json();
        for key in ["K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g"] {
            agree(&numbers(&after[key]), &numbers(&before[key]), 1e-15, key);
        }
        for key in ["acc_unit", "from_acc_unit", "cal_type"] {
            let before = before.get(key).unwrap_or(&Value::Null);
            assert_eq!(after[key], *before, "{key}");
        }
        ends(&data, &format!("export {path} --to gravical"), 0).calibration();
    }
}
