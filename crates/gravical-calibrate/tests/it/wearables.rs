//! Long recordings of a wrist.

use gravical_calibrate::calibrate::CalibrateOptions;
use gravical_calibrate::calibration_file::Grade;
use gravical_core::matrix3;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::support::{calibrated, read};

const SCALE: [f64; 3] = [1.02, 0.99, 1.01];
const BIAS_G: [f64; 3] = [0.02, -0.03, 0.01];
const DRIFT_G_PER_C: [f64; 3] = [1e-3, -5e-4, 0.0];

/// 14 hours of wear at 5 Hz: rests of six minutes with a tremor of 5 mg on each axis, movement between them, and
/// every eighth rest on a table, far quieter. x never points down.
#[test]
fn orientations_that_wear_leaves_out_are_named() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut text = String::from("t_s,ax_g,ay_g,az_g,temperature_c\n");
    let mut n = [0.0, 0.0, 1.0];
    for row in 0..14 * 18_000 {
        let (cycle, at) = (row / 2400, row % 2400);
        if at == 0 {
            n = match cycle % 8 {
                0 => [0.0, 0.6, 0.8],
                _ => [normal().abs() + 0.1, normal(), normal()],
            };
            n = n.map(|v| v / matrix3::norm(&n));
        }
        let noise = match (at, cycle % 8) {
            (1800.., _) => 0.3,
            (_, 0) => 0.0005,
            _ => 0.005,
        };
        let t_s = f64::from(row) / 5.0;
        let t_c = 26.0 + 6.0 * (t_s / 3000.0).sin();
        let [x, y, z] = [0, 1, 2].map(|i| {
            SCALE[i] * n[i] + BIAS_G[i] + DRIFT_G_PER_C[i] * (t_c - 26.0) + noise * normal()
        });
        text += &format!("{t_s:.1},{x:.5},{y:.5},{z:.5},{t_c:.2}\n");
    }
    let file = calibrated(&[read(text.as_bytes())], &CalibrateOptions::default()).calibration;
    assert_eq!(file.verdict().grade, Grade::Poor);
    let mut findings = file.findings.iter();
    let named = findings.find(|f| f.kind == "few-orientations");
    let said = &named.unwrap().message;
    assert!(said.contains("not enough orientations: only x "), "{said}");
}
