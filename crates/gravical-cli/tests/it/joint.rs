//! The default method on real recordings with known results.

use serde_json::Value;

use crate::support::*;

const MG: f64 = 1000.0 / 9.80665;

/// U of M Mᵀ = U Uᵀ, upper triangular with a positive diagonal: the frame of
/// imu_tk, A = U⁻¹.
fn triangular(file: &Value) -> [[f64; 3]; 3] {
    let a = &file["accelerometer"];
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
    let a = &file["accelerometer"];
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
    let left_out_mg = number(&a["leave_one_out_rms_mps2"]) * MG;
    assert!(left_out_mg <= 0.156, "{left_out_mg}");
    assert_eq!(file["verdict"]["grade"], "good");
    // Real sensors miss the model by more than the noise of their means.
    let chi2 = number(&a["fit"]["chi2_per_freedom"]);
    assert!((2.0..12.0).contains(&chi2), "{chi2}");
    assert!(number(&a["fit"]["model_error_mps2"]) < 3e-3);
}

/// What is refused says how many directions are spanned and what to do next.
#[test]
fn too_few_directions_are_refused_with_numbers() {
    let folder = six_files(&Sensor::default());
    let [x, y, z] = ["x_axis_pos.csv", "y_axis_pos.csv", "z_axis_pos.csv"];
    let plane = format!("{x} x_axis_neg.csv {y} y_axis_neg.csv");
    for (files, said) in [
        (x.to_owned(), "only the x axis is covered"),
        (format!("{x} x_axis_neg.csv"), "2 poses"),
        (plane, "z up and z down"),
        (format!("{x} {y} {z}"), "record y down"),
    ] {
        let line = format!("calibrate {files} --gravity 9.81");
        let error = fails(folder.path(), &line, 3, "underdetermined").to_string();
        assert!(error.contains(said), "{said} in {error}");
    }
}

#[test]
fn a_placement_can_be_forced_and_a_wrong_name_is_told() {
    let folder = six_files(&Sensor::default());
    let line = ". --gravity 9.81 --free-pose x_axis_pos --free-pose x_axis_neg";
    let free = calibrate(folder.path(), line, 0);
    assert_eq!(faces(&free).len(), 4);
    let line = "calibrate . --gravity 9.81 --free-pose nothing";
    fails(folder.path(), line, 2, "no-such-pose");
}
