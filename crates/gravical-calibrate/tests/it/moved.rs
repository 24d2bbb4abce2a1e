//! A bias that moved while the poses were recorded.

use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::calibration_file::Grade;
use gravical_calibrate::recording::{ReadOptions, read_bytes};

const G: f64 = 9.80665;

/// Twelve means, six faces and six oblique poses; from the seventh on the bias is off by 20 mg on x.
fn means(moved: f64) -> String {
    let free = [
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -1.0, -1.0],
        [-1.0, -1.0, 1.0],
        [1.0, 0.2, -1.0],
        [-0.3, 1.0, 1.0],
    ];
    let mut rows = "label,ax,ay,az\n".to_owned();
    let faces = (0..6).map(|k| {
        let mut face = [0.0; 3];
        face[k / 2] = [1.0, -1.0][k % 2];
        face
    });
    for (k, n) in faces.chain(free).enumerate() {
        let size = n.iter().map(|v| v * v).sum::<f64>().sqrt();
        let bias = [0.1 + if k < 6 { 0.0 } else { moved }, -0.2, 0.15];
        // Residues of a hash in place of noise, 4 mm/s².
        let noise = |i: usize| 0.004 * (((37 * k + 11 * i + 5) % 19) as f64 / 9.0 - 1.0);
        let u: Vec<String> = (0..3)
            .map(|i| format!("{:.4}", n[i] / size * G + bias[i] + noise(i)))
            .collect();
        rows += &format!("pose {k},{}\n", u.join(","));
    }
    rows
}

#[test]
fn what_else_explains_the_poses_is_said_and_claimed() {
    let options = CalibrateOptions::default();
    let calibrated = |text: &str| {
        let table = read_bytes(text.as_bytes(), "means.csv", &ReadOptions::default()).unwrap();
        calibrate(&[table], &options).unwrap().calibration
    };
    let still = calibrated(&means(0.0));
    assert_ne!(still.grade(), Grade::Poor, "{:?}", still.verdict());
    assert!(
        still
            .findings
            .iter()
            .all(|f| f.kind != "several-explanations")
    );
    let moved = calibrated(&means(0.02 * G));
    let finding = moved
        .findings
        .iter()
        .find(|f| f.kind == "several-explanations");
    let said = &finding.unwrap().message;
    assert!(
        said.contains("the bias moved before pose 6") && said.contains("by the lines"),
        "{said}"
    );
    // The claim holds whichever it is: half a jump is 10 mg.
    let claim = moved.reliability.worst_direction.unwrap().error_mps2;
    assert!(
        claim > 0.01 * G && moved.grade() == Grade::Poor,
        "{claim} {}",
        moved.grade()
    );
}
