//! Is it physics, is it the sensor that was asked for, is it repeatable?

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::*;

fn ideal(scenario: Scenario) -> SimulateOptions {
    SimulateOptions {
        tilt_sd_deg: 0.0,
        sensor: SensorOptions::ideal(),
        ..SimulateOptions::new(scenario)
    }
}

fn session() -> Scenario {
    Scenario::SixPosition(SixPositionOptions {
        continuous: true,
        hold_s: 3.0,
        ..Default::default()
    })
}

fn quick_six() -> SimulateOptions {
    SimulateOptions::new(Scenario::SixPosition(SixPositionOptions {
        hold_s: 1.0,
        ..Default::default()
    }))
}

fn still_for(duration_s: f64) -> Scenario {
    Scenario::Static(StaticOptions { duration_s })
}

fn accel(file: &SimulatedFile, row: usize) -> Vector3<f64> {
    Vector3::from([0, 1, 2].map(|axis| file.accel_mps2[axis][row]))
}

fn gyro(file: &SimulatedFile, row: usize) -> Vector3<f64> {
    Vector3::from([0, 1, 2].map(|axis| file.gyro_rad_s[axis][row]))
}

/// Rows with start ≤ t < end.
fn rows(file: &SimulatedFile, start_s: f64, end_s: f64) -> std::ops::Range<usize> {
    let first = file.t_s.partition_point(|&t| t < start_s);
    first..file.t_s.partition_point(|&t| t < end_s)
}

/// Change of attitude by the gyroscope over `rows`, midpoint rule.
fn turned(file: &SimulatedFile, rows: std::ops::Range<usize>) -> UnitQuaternion<f64> {
    let mut q = UnitQuaternion::identity();
    for row in rows {
        let dt = file.t_s[row + 1] - file.t_s[row];
        let rate = 0.5 * (gyro(file, row) + gyro(file, row + 1));
        q *= UnitQuaternion::from_scaled_axis(rate * dt);
    }
    q
}

#[test]
fn the_gyroscope_turns_gravity_to_where_the_accelerometer_finds_it() {
    let mut options = ideal(Scenario::Poses(PosesOptions::default()));
    options.rate_hz = 500.0;
    options.tilt_sd_deg = 2.0;
    let simulation = simulate(&options).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0]);
    assert_eq!(truth.poses.len(), 12);
    for pair in truth.poses.windows(2) {
        let between = rows(file, pair[0].end_s - 0.1, pair[1].start_s + 0.1);
        let before = accel(file, between.start).normalize();
        let after = accel(file, between.end).normalize();
        let predicted = turned(file, between).inverse() * before;
        let off = (predicted - after).norm();
        assert!(off < 1e-6, "{} to {}: {off}", pair[0].label, pair[1].label);
        assert!((after - Vector3::from(pair[1].up)).norm() < 1e-9);
    }
}

#[test]
fn a_turn_of_minus_360_degrees_integrates_to_minus_two_pi() {
    let simulation = simulate(&ideal(session())).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0]);
    assert_eq!(truth.turns.len(), 3);
    for (axis, turn) in truth.turns.iter().enumerate() {
        assert_eq!(turn.angle_deg, -360.0);
        let mut sum = Vector3::zeros();
        for row in rows(file, turn.start_s, turn.end_s) {
            sum += gyro(file, row) / 100.0;
        }
        let mut expected = Vector3::zeros();
        expected[axis] = -std::f64::consts::TAU;
        assert!((sum - expected).norm() < 1e-6, "{sum}");
    }
}

#[test]
fn double_integration_of_the_accelerometer_gives_the_line() {
    let mut options = ideal(Scenario::Line(LineOptions::default()));
    options.rate_hz = 1000.0;
    let simulation = simulate(&options).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0].moves[0]);
    let gravity = Vector3::z() * options.gravity_mps2;
    let (mut velocity, mut position) = (Vector3::zeros(), Vector3::zeros());
    for row in 1..file.t_s.len() {
        let dt = file.t_s[row] - file.t_s[row - 1];
        let a = 0.5 * (accel(file, row) + accel(file, row - 1)) - gravity;
        position += velocity * dt + 0.5 * a * dt * dt;
        velocity += a * dt;
    }
    assert!(velocity.norm() < 1e-9);
    let expected = Vector3::from(truth.displacement_m);
    assert_eq!(expected, Vector3::new(0.02, 0.7, 0.0));
    assert!((position - expected).norm() < 1e-6, "{position}");
}

#[test]
fn strapdown_with_both_sensors_finds_a_wobbling_line() {
    let mut options = ideal(Scenario::Line(LineOptions {
        wobble_deg: 3.0,
        ..Default::default()
    }));
    options.rate_hz = 1000.0;
    options.tilt_sd_deg = 1.0;
    let simulation = simulate(&options).unwrap();
    let file = &simulation.files[0];
    let start = file.path.state_at(0.0).attitude;
    let mut attitude = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
        start[0], start[1], start[2], start[3],
    ));
    let gravity = Vector3::z() * options.gravity_mps2;
    let (mut velocity, mut position) = (Vector3::zeros(), Vector3::zeros());
    let mut mean_subtracted = [0.0; 2];
    let (mut before, level) = (Vector3::zeros(), accel(file, 0).y);
    for row in 1..file.t_s.len() {
        attitude *= turned(file, row - 1..row);
        let now = attitude * accel(file, row) - gravity;
        velocity += 0.5e-3 * (before + now);
        position += 1e-3 * velocity;
        before = now;
        if rows(file, 5.0, 7.0).contains(&row) {
            mean_subtracted[0] += 1e-3 * (accel(file, row).y - level);
            mean_subtracted[1] += 1e-3 * mean_subtracted[0];
        }
    }
    let error = (position - Vector3::new(0.02, 0.7, 0.0)).norm();
    assert!(error < 0.004, "{error}");
    // What the same wobble costs without the gyroscope: g·A·T²/2π = 327 mm.
    assert!(((mean_subtracted[1] - 0.7).abs() - 0.327).abs() < 0.01);
}

#[test]
fn the_same_options_give_the_same_files() {
    let mut written = Vec::new();
    for seed in [3, 3, 4] {
        let folder = tempfile::tempdir().unwrap();
        let options = SimulateOptions {
            seed,
            dropped_fraction: 0.05,
            stamp_jitter_ms: 1.0,
            ..quick_six()
        };
        let paths = write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
        assert_eq!(paths.len(), 7);
        written.push(
            paths
                .iter()
                .map(|p| std::fs::read(p).unwrap())
                .collect::<Vec<_>>(),
        );
    }
    assert_eq!(written[0], written[1]);
    for (a, b) in written[0].iter().zip(&written[2]) {
        assert_ne!(a, b);
    }
}

#[test]
fn changing_one_option_leaves_the_other_draws_alone() {
    let base = simulate(&quick_six()).unwrap();
    let mut other = quick_six();
    other.sensor = other.sensor.with_noise_factor(3.0);
    other.dropped_fraction = 0.2;
    other.stamp_jitter_ms = 2.0;
    other.sensor.accel_bias_mps2 = Some([0.1, 0.2, 0.3]);
    let other = simulate(&other).unwrap();
    let (a, b) = (&base.truth.accelerometer, &other.truth.accelerometer);
    assert_eq!(a.matrix, b.matrix);
    assert_eq!(a.bias_drift_mps2_per_c, b.bias_drift_mps2_per_c);
    assert_eq!(b.bias_mps2, [0.1, 0.2, 0.3]);
    let (a, b) = (&base.truth.gyroscope, &other.truth.gyroscope);
    assert_eq!(a.bias_rad_s, b.bias_rad_s);
    for (a, b) in base.truth.files.iter().zip(&other.truth.files) {
        assert_eq!(a.poses, b.poses);
        assert_eq!(a.first_stamp_ms, b.first_stamp_ms);
    }
}

#[test]
fn values_lie_on_the_grid_of_the_converter() {
    let mut options = SimulateOptions::new(still_for(2.0));
    options.sensor.accel_range_g = 8;
    let simulation = simulate(&options).unwrap();
    let file = &simulation.files[0];
    for row in 0..file.t_s.len() {
        for value in accel(file, row).iter() {
            let counts = value / (9.80665 / 4096.0);
            assert!((counts - counts.round()).abs() < 1e-9);
        }
        for value in gyro(file, row).iter() {
            let counts = value.to_degrees() * 131.0;
            assert!((counts - counts.round()).abs() < 1e-9);
        }
        let counts = (file.temperature_c[row] - 36.53) * 340.0;
        assert!((counts - counts.round()).abs() < 1e-6);
    }
}

#[test]
fn a_bias_beyond_the_range_saturates() {
    let mut options = SimulateOptions::new(still_for(1.0));
    options.sensor.accel_bias_mps2 = Some([25.0, -25.0, 0.0]);
    let simulation = simulate(&options).unwrap();
    let file = &simulation.files[0];
    let lsb = simulation.truth.accelerometer.lsb_mps2;
    assert!(
        file.accel_mps2[0]
            .iter()
            .all(|v| (v / lsb - 32767.0).abs() < 1e-9)
    );
    assert!(
        file.accel_mps2[1]
            .iter()
            .all(|v| (v / lsb + 32768.0).abs() < 1e-9)
    );
    assert_eq!(simulation.truth.files[0].clipped_rows, 100);
}

#[test]
fn lost_rows_leave_the_stamps_of_the_others_alone() {
    let whole = simulate(&SimulateOptions::new(still_for(40.0))).unwrap();
    let mut options = SimulateOptions::new(still_for(40.0));
    options.dropped_fraction = 0.05;
    let holey = simulate(&options).unwrap();
    let (whole, file) = (&whole.files[0], &holey.files[0]);
    let lost = holey.truth.files[0].dropped_rows;
    assert_eq!(file.t_s.len() + lost, 4000);
    // 200 ± 14.
    assert!((140..260).contains(&lost), "{lost}");
    for row in 0..file.t_s.len() {
        let same = (file.t_s[row] * 100.0).round() as usize;
        assert_eq!(file.stamp_ms[row], whole.stamp_ms[same]);
        assert_eq!(file.accel_mps2[2][row], whole.accel_mps2[2][same]);
    }
}

#[test]
fn stamps_follow_rate_clock_and_jitter() {
    let mut options = SimulateOptions::new(still_for(40.0));
    options.rate_hz = 62.5;
    let file = simulate(&options).unwrap().files.remove(0);
    assert_eq!(file.t_s.len(), 2500);
    assert!(file.stamp_ms.windows(2).all(|w| w[1] - w[0] == 16));

    options.clock_error_ppm = 2000.0;
    let file = simulate(&options).unwrap().files.remove(0);
    let counted = (file.stamp_ms[2499] - file.stamp_ms[0]) as f64 / 1000.0;
    let ppm = (counted / file.t_s[2499] - 1.0) * 1e6;
    assert!((ppm - 2000.0).abs() < 30.0, "{ppm}");

    options.clock_error_ppm = 0.0;
    options.stamp_jitter_ms = 3.0;
    let simulation = simulate(&options).unwrap();
    let (file, first) = (
        &simulation.files[0],
        simulation.truth.files[0].first_stamp_ms,
    );
    let off: Vec<_> = (0..2500)
        .map(|i| file.stamp_ms[i] as f64 - first as f64 - 16.0 * i as f64)
        .collect();
    assert!(off.iter().all(|o| (-3.0..=3.0).contains(o)));
    assert!(off.iter().any(|o| *o > 1.5) && off.iter().any(|o| *o < -1.5));
    assert!(file.stamp_ms.is_sorted());
}

/// Standard deviation of means over `seconds`, pooled over three axes, about
/// the mean of each.
fn sd_of_means(channels: &[Vec<f64>; 3], per_block: usize) -> f64 {
    let (mut sum, mut freedom) = (0.0, 0.0);
    for channel in channels {
        let blocks = channel.chunks_exact(per_block);
        let means: Vec<f64> = blocks
            .map(|b| b.iter().sum::<f64>() / per_block as f64)
            .collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        sum += means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
        freedom += means.len() as f64 - 1.0;
    }
    (sum / freedom).sqrt()
}

#[test]
fn the_noise_has_the_density_that_was_asked_for_at_every_rate() {
    for rate_hz in [62.5, 200.0] {
        let mut options = SimulateOptions::new(still_for(200.0));
        options.rate_hz = rate_hz;
        options.sensor.temperature_rise_c = 0.0;
        let file = simulate(&options).unwrap().files.remove(0);
        // Means over 2 s of white noise N: N/√2. 300 blocks: ±4 %. At 62.5 Hz
        // what the low-pass leaves above 31 Hz folds back: up to 12 % more.
        let per_block = (2.0 * rate_hz) as usize;
        let n = sd_of_means(&file.accel_mps2, per_block) * 2f64.sqrt();
        let ratio = n / 3.3e-3;
        let expected = if rate_hz > 100.0 {
            1.0
        } else {
            folded(rate_hz)
        };
        assert!((ratio / expected - 1.0).abs() < 0.1, "{rate_hz}: {ratio}");
        let n = sd_of_means(&file.gyro_rad_s, per_block) * 2f64.sqrt();
        let ratio = n / 0.005f64.to_radians();
        assert!((ratio / expected - 1.0).abs() < 0.1, "{rate_hz}: {ratio}");
    }
}

/// Gain at frequency 0 after sampling behind a 44 Hz Butterworth: the power
/// at multiples of the rate folds onto it.
fn folded(rate_hz: f64) -> f64 {
    let power = |f: f64| 1.0 / (1.0 + (f / 44.0).powi(4));
    let above: f64 = (1..5).map(|i| 2.0 * power(f64::from(i) * rate_hz)).sum();
    (1.0 + above).sqrt()
}

#[test]
fn a_narrow_low_pass_correlates_neighbours() {
    let correlation = |low_pass_hz| {
        let mut options = SimulateOptions::new(still_for(20.0));
        options.sensor.low_pass_hz = low_pass_hz;
        options.sensor.temperature_rise_c = 0.0;
        let file = simulate(&options).unwrap().files.remove(0);
        let x = &file.accel_mps2[0];
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let lagged: f64 = x.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum();
        lagged / x.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
    };
    assert!(correlation(None).abs() < 0.07);
    let at_44 = correlation(Some(44.0));
    assert!((0.0..0.25).contains(&at_44), "{at_44}");
    assert!(correlation(Some(10.0)) > 0.6);
}

#[test]
fn averages_of_a_clean_set_give_back_what_was_put_in() {
    let mut options = quick_six();
    options.tilt_sd_deg = 0.0;
    options.sensor = options.sensor.with_noise_factor(0.0);
    options.sensor.quantise = false;
    options.sensor.temperature_rise_c = 0.0;
    let simulation = simulate(&options).unwrap();
    let mean = |i: usize| {
        let file = &simulation.files[i];
        let n = file.t_s.len();
        (0..n).map(|row| accel(file, row)).sum::<Vector3<f64>>() / n as f64
    };
    let truth = &simulation.truth.accelerometer;
    let mut found = Matrix3::zeros();
    for axis in 0..3 {
        let (plus, minus) = (mean(2 * axis), mean(2 * axis + 1));
        found.set_column(axis, &((plus - minus) / (2.0 * options.gravity_mps2)));
        let bias = (plus + minus) / 2.0;
        assert!((bias - Vector3::from(truth.bias_mps2)).norm() < 1e-9);
    }
    for row in 0..3 {
        for column in 0..3 {
            assert!((found[(row, column)] - truth.matrix[row][column]).abs() < 1e-9);
        }
    }
    assert_ne!(truth.matrix[0][1], truth.matrix[1][0]);
}

#[test]
fn the_part_warms_up_and_its_bias_drifts_across_the_files() {
    let mut options = quick_six();
    options.sensor = SensorOptions {
        temperature_rise_c: 10.0,
        temperature_time_s: 30.0,
        bias_drift_mg_per_c: 1.0,
        ..SensorOptions::ideal()
    };
    options.tilt_sd_deg = 0.0;
    let simulation = simulate(&options).unwrap();
    let temperatures: Vec<_> = simulation
        .files
        .iter()
        .map(|f| f.temperature_c[0])
        .collect();
    assert_eq!(temperatures[0], 25.0);
    assert!(temperatures.is_sorted() && temperatures[5] > 32.0);
    let drift = simulation.truth.accelerometer.bias_drift_mps2_per_c[1];
    assert!((drift.abs() - 9.80665e-3).abs() < 1e-12);
    // +x and −x files: y reads nothing but its bias.
    let moved = simulation.files[1].accel_mps2[1][0] - simulation.files[0].accel_mps2[1][0];
    assert!((moved - drift * (temperatures[1] - 25.0)).abs() < 1e-9);
}

#[test]
fn each_format_has_its_header_and_units() {
    let text = |format| {
        let folder = tempfile::tempdir().unwrap();
        let mut options = SimulateOptions::new(still_for(0.5));
        options.file.format = format;
        let target = folder.path().join("new/folder");
        let simulation = simulate(&options).unwrap();
        let paths = write(&simulation, &target, false).unwrap();
        assert_eq!(
            write(&simulation, &target, false).unwrap_err().code(),
            "exists"
        );
        write(&simulation, &target, true).unwrap();
        let truth: Truth = serde_json::from_slice(&std::fs::read(&paths[1]).unwrap()).unwrap();
        assert_eq!(truth, simulation.truth);
        std::fs::read_to_string(&paths[0]).unwrap()
    };
    let az = |text: &str| -> f64 {
        let row = text.lines().nth(4).unwrap();
        assert_eq!(row.split(',').count(), 8);
        row.split(',').nth(3).unwrap().parse().unwrap()
    };
    let report = text(FileFormat::Report);
    assert!(report.lines().take(3).all(|l| l.starts_with("# ")));
    let header = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
    assert_eq!(report.lines().nth(3), Some(header));
    assert!((8.0..12.0).contains(&az(&report)));
    assert_eq!(report.lines().count(), 54);
    let honest = text(FileFormat::TrueHeader);
    assert!(honest.contains("Timestamp (ms),aX (m/s^2)"));
    assert_eq!(az(&honest), az(&report));
    let raw = text(FileFormat::Raw);
    assert!(raw.contains("Timestamp (ms),ax,ay,az,temp,gx,gy,gz"));
    assert!((az(&raw) * 9.80665 / 16384.0 - az(&report)).abs() < 1e-4);
}

#[test]
fn nothing_is_written_when_one_target_is_there() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("truth.json"), "mine").unwrap();
    let simulation = simulate(&quick_six()).unwrap();
    assert!(write(&simulation, folder.path(), false).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn options_out_of_range_are_named() {
    let mut options = SimulateOptions::new(still_for(10.0));
    options.rate_hz = f64::NAN;
    let error = simulate(&options).unwrap_err();
    assert!(error.is_usage() && error.message().contains("rate"));
    options.rate_hz = 100.0;
    options.sensor.accel_range_g = 3;
    assert!(simulate(&options).unwrap_err().message().contains("3 g"));
    let mut options = SimulateOptions::new(still_for(86_400.0));
    options.rate_hz = 1000.0;
    assert!(simulate(&options).unwrap_err().message().contains("rows"));
}
