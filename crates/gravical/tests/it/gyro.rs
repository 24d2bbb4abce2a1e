//! The gyroscope from motions, on real recordings.

use std::path::PathBuf;

use gravical::estimate::gyro::{GyroFit, GyroOptions, Still, from_motions, motion_residuals_deg};
use gravical::recording::{ReadOptions, Recording, join_gyroscope, read};
use gravical::segment::{SegmentOptions, segment};
use gravical_core::calibration::{Calibration, GyroscopeCalibration};

/// The folder with real recordings; says that a test is skipped without it.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("GRAVICAL_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: GRAVICAL_DATA is not set");
    }
    folder
}

fn xsens() -> Option<(Recording, Vec<Still>, GyroOptions, Calibration<f64>)> {
    let folder = data()?.join("imu_tk-xsens");
    let options = ReadOptions::default();
    let mut recording = read(&folder.join("xsens_acc.txt.gz"), &options).unwrap();
    join_gyroscope(&mut recording, &folder.join("xsens_gyro.txt.gz"), &options).unwrap();
    let session = segment(std::slice::from_ref(&recording), &SegmentOptions::default()).unwrap();
    let stills = Still::of(&session.placements, 0);
    let gyro = GyroOptions {
        scale: session.gyro_scale,
    };
    // The published result of the accelerometer, a = T K (u − b).
    let k = [0.00241278463, 0.00242712280, 0.00241168028];
    let t = [
        [1.0, -0.00335929903, -0.00890639474],
        [0.0, 1.0, -0.0213341192],
        [0.0, 0.0, 1.0],
    ];
    let accelerometer = Calibration {
        matrix: std::array::from_fn(|r| std::array::from_fn(|c| t[r][c] * k[c])),
        bias: [33124.1826, 33275.1794, 32364.4156].map(|b| b - recording.zero_offset),
    };
    Some((recording, stills, gyro, accelerometer))
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn the_xsens_set_agrees_with_its_published_result() {
    let Some((recording, stills, options, accelerometer)) = xsens() else {
        return;
    };
    let start = std::time::Instant::now();
    let GyroFit { section, findings } =
        from_motions(&recording, &stills, &accelerometer, &options).unwrap();
    println!("{:?}", start.elapsed());
    println!("{findings:#?}");
    let g = section.unwrap();
    println!("{}", serde_json::to_string(&g).unwrap());
    let listed = GyroscopeCalibration {
        matrix: gravical_core::matrix3::diagonal([2.09294526e-4, 2.09898540e-4, 2.09482984e-4]),
        bias: [32777.13994, 32459.80288, 32511.84746],
        g_sensitivity: [[0.0; 3]; 3],
    };
    let own = GyroscopeCalibration {
        matrix: g.matrix,
        bias: g.bias,
        g_sensitivity: g.g_sensitivity,
    };
    let residuals = |c: &GyroscopeCalibration<f64>| {
        motion_residuals_deg(&recording, &stills, &accelerometer, c, &options)
    };
    let (a, b) = (residuals(&listed), residuals(&own));
    println!("{a:.2?}\n{b:.2?}\n{} {}", rms(&a), rms(&b));
    println!(
        "{:?}",
        std::array::from_fn::<f64, 3, _>(|i| g.matrix[i][i] / listed.matrix[i][i])
    );
}
