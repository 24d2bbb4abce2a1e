//! The default method on real recordings with known results.

use serde_json::Value;

use crate::support::*;

const MG: f64 = 1000.0 / 9.80665;

fn accelerometer(file: &Value) -> &Value {
    &file["accelerometer"]
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// RMS of ‖calibrated‖ − g over the fitted placements, m/s².
fn residual(file: &Value) -> f64 {
    let squares: Vec<f64> = poses(file)
        .iter()
        .filter(|p| p["fitted"] == true)
        .map(|p| number(&p["magnitude_error_mps2"]).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

fn left_out_mg(file: &Value) -> f64 {
    number(&accelerometer(file)["leave_one_out_rms_mps2"]) * MG
}

/// U of M Mᵀ = U Uᵀ, upper triangular with a positive diagonal: the frame of
/// imu_tk, A = U⁻¹.
fn triangular(file: &Value) -> [[f64; 3]; 3] {
    let a = accelerometer(file);
    let (scale, r) = (numbers(&a["scale"]), numbers(&a["orientation"]));
    let m = |i: usize, j: usize| scale[i] * r[3 * i + j];
    let p = |i: usize, j: usize| (0..3).map(|k| m(i, k) * m(j, k)).sum::<f64>();
    let mut u = [[0.0; 3]; 3];
    u[2][2] = p(2, 2).sqrt();
    u[1][2] = p(1, 2) / u[2][2];
    u[0][2] = p(0, 2) / u[2][2];
    u[1][1] = (p(1, 1) - u[1][2].powi(2)).sqrt();
    u[0][1] = (p(0, 1) - u[0][2] * u[1][2]) / u[1][1];
    u[0][0] = (p(0, 0) - u[0][1].powi(2) - u[0][2].powi(2)).sqrt();
    u
}

#[test]
fn xsens_by_hand_38_poses() {
    let Some(data) = data() else { return };
    let line = "imu_tk-xsens/xsens_acc.txt.gz --gravity 9.81744";
    let file = calibrate(&data, line, 0);
    assert_eq!(poses(&file).len(), 38);
    let a = accelerometer(&file);
    let bias = [33124.1826, 33275.1794, 32364.4156];
    for (got, want) in numbers(&a["bias"]).iter().zip(bias) {
        close(*got, want, 1.0);
    }
    // A = T K with T of unit diagonal, so that 1/U_ii is K_i.
    let u = triangular(&file);
    for (i, k) in [0.00241278463, 0.00242712280, 0.00241168028]
        .iter()
        .enumerate()
    {
        close(1.0 / u[i][i] / k, 1.0, 1e-4);
    }
    // Hardly worse left out than nine free parameters (0.146 to 0.151 mg).
    assert!(left_out_mg(&file) <= 0.156, "{}", left_out_mg(&file));
    assert_eq!(file["verdict"]["grade"], "good");
    // Real sensors miss the model by more than the noise of their means.
    let chi2 = number(&a["fit"]["chi2_per_freedom"]);
    assert!((2.0..12.0).contains(&chi2), "{chi2}");
    assert!(number(&a["fit"]["model_error_mps2"]) < 3e-3);
}

#[test]
fn mikoffs_three_sensors_held_by_hand() {
    let Some(data) = data() else { return };
    for imu in 0..3 {
        let line = format!("mikoff-mpu9150/imu{imu}.log --rate 100 --gravity 9.81");
        let file = calibrate(&data, &line, 0);
        let count = poses(&file).len();
        assert!((22..=23).contains(&count), "imu{imu}: {count}");
        let rms = residual(&file);
        // Of the mean of the posterior, which is not where the residuals are least.
        assert!(rms <= 2.35e-3, "imu{imu}: {rms}");
        // Nothing tells how they sat in the hand: a convention, and said.
        finding(&file, "orientation-open");
        assert_eq!(accelerometer(&file)["fit"]["oriented"], false);
        if imu == 0 {
            let bias = numbers(&accelerometer(&file)["bias"]);
            for (got, want) in bias.iter().zip([0.1027, 0.0967, 0.3444]) {
                close(*got, want, 3e-3);
            }
            let scale = numbers(&accelerometer(&file)["scale_deviation_percent"]);
            for (got, want) in scale.iter().zip([0.36, 0.32, 0.65]) {
                close(*got, want, 0.03);
            }
        }
    }
}

#[test]
fn tomisuarez_ten_poses_stay_within_the_data_sheet() {
    let Some(data) = data() else { return };
    let file = calibrate(&data, "tomisuarez-mpu6050/calibration.csv", 0);
    assert_eq!(poses(&file).len(), 10);
    assert_eq!(faces(&file).len(), 6);
    let r = numbers(&accelerometer(&file)["orientation"]);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let cosine: f64 = (0..3).map(|k| r[3 * i + k] * r[3 * j + k]).sum();
        assert!(cosine.abs() < 0.04, "axes {i} and {j}: {cosine}");
    }
    // No worse than six parameters left one out (2.2 mg).
    assert!(left_out_mg(&file) <= 2.2, "{}", left_out_mg(&file));
}

#[test]
fn imucals_session_by_default() {
    let Some(data) = data() else { return };
    let line = "imucal-ferraris/example_ferraris_session.csv --rate 102.4 --gravity 9.81";
    let file = calibrate(&data, line, 0);
    let a = accelerometer(&file);
    let deviations = &a["deviations"];
    assert!(poses(&file).iter().all(|p| p["fitted"] == true));
    let bias = [0.5371174244458201, -0.6162029930860964, 0.3988673423902682];
    let scale = [0.9967458650887003, 1.0024376185894108, 1.0233953475452096];
    for i in 0..3 {
        let sd = |key: &str| number(&deviations[key][i]);
        close(number(&a["bias"][i]), bias[i], 4.0 * sd("bias"));
        close(number(&a["scale"][i]), scale[i], 4.0 * sd("scale"));
    }
    let tilt = number(&a["pose_tilt_deg"]["value"]);
    assert!((0.05..0.3).contains(&tilt), "on a table: {tilt}°");
    assert_eq!(a["pose_tilt_deg"]["source"], "estimated");
}

#[test]
fn airbrakes_says_what_six_faces_cannot_tell() {
    let Some(data) = data() else { return };
    let file = calibrate(&data, "airbrakes-sixmoves", 0);
    assert_eq!(file["verdict"]["grade"], "not-verifiable");
    assert!(accelerometer(&file)["leave_one_out_rms_mps2"].is_null());
    for position in poses(&file) {
        let (tilt, sd) = (
            number(&position["tilt_deg"]),
            number(&position["tilt_sd_deg"]),
        );
        assert!(tilt < 4.0 && (0.3..1.6).contains(&sd), "{tilt} ± {sd}");
    }
    let reasons = file["verdict"]["reasons"].to_string();
    assert!(reasons.contains("do not separate their tilt"), "{reasons}");
    assert!(reasons.contains("best next pose"), "{reasons}");
    let open = numbers(&accelerometer(&file)["deviations"]["axis_angle_deg"]);
    assert!(open.iter().all(|a| *a > 0.5), "{open:?}");
}

#[test]
fn a_recording_without_stillness_is_refused() {
    let Some(data) = data() else { return };
    let run = run_in(
        &data,
        words("calibrate mjs513-handheld/acc_A.txt.gz --json"),
    );
    assert_eq!((run.code, run.error_code()), (3, "never-static".to_owned()));
}

/// Poses of a tomisuarez-like session one by one: what is refused says how many
/// directions are spanned and what to do next.
#[test]
fn too_few_directions_are_refused_with_numbers() {
    let folder = six_files(&Sensor::default());
    let refuse = |files: &str, reported: &[&str]| {
        let run = run_in(
            folder.path(),
            words(&format!("calibrate {files} --gravity 9.81 --json")),
        );
        assert_eq!(run.code, 3, "{files}: {}", run.out);
        assert_eq!(run.error_code(), "underdetermined");
        let error = run.json();
        let text = format!("{} {}", error["message"], error["hint"]);
        for word in reported {
            assert!(text.contains(word), "{word} in {text}");
        }
    };
    // All alike, along one axis, in one plane, one of each axis.
    refuse(
        "x_axis_pos.csv",
        &["1 pose:", "only the x axis is covered; y and z are missing"],
    );
    refuse(
        "x_axis_pos.csv x_axis_neg.csv",
        &["2 poses", "only the x axis is covered; y and z are missing"],
    );
    refuse(
        "x_axis_pos.csv x_axis_neg.csv y_axis_pos.csv y_axis_neg.csv",
        &[
            "4 poses",
            "only x and y are covered; z is missing",
            "z up and z down",
        ],
    );
    refuse(
        "x_axis_pos.csv y_axis_pos.csv z_axis_pos.csv",
        &["3 poses", "mg", "record y down"],
    );
}

#[test]
fn a_placement_can_be_forced_and_a_wrong_name_is_told() {
    let folder = six_files(&Sensor::default());
    let free = calibrate(
        folder.path(),
        ". --gravity 9.81 --free-pose x_axis_pos --free-pose x_axis_neg",
        0,
    );
    assert_eq!(faces(&free).len(), 4);
    let run = run_in(
        folder.path(),
        words("calibrate . --gravity 9.81 --free-pose nothing --json"),
    );
    assert_eq!((run.code, run.error_code()), (2, "no-such-pose".to_owned()));
}
