//! Sensor, converter and clock of the board.

use super::*;

#[test]
fn values_are_multiples_of_one_count() {
    let mut options = SimulateOptions::new(still_for(2.0));
    options.sensor.accel_range_g = 8;
    let simulation = simulate(&options).unwrap();
    let file = &simulation.files[0];
    for row in 0..file.rows.len() {
        for value in accel(file, row).iter() {
            let counts = value / (9.80665 / 4096.0);
            assert!((counts - counts.round()).abs() < 1e-9);
        }
        for value in gyro(file, row).iter() {
            let counts = value.to_degrees() * 131.0;
            assert!((counts - counts.round()).abs() < 1e-9);
        }
        let counts = (file.rows[row].reading.temperature_c - 36.53) * 340.0;
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
    for row in &file.rows {
        let [x, y, _] = row.reading.accel_mps2.map(|v| v / lsb);
        assert!((x - 32767.0).abs() < 1e-9 && (y + 32768.0).abs() < 1e-9);
    }
    assert_eq!(simulation.truth.files[0].clipped_rows, 100);
}

#[test]
fn lost_rows_do_not_affect_other_rows() {
    let whole = simulate(&SimulateOptions::new(still_for(40.0))).unwrap();
    let mut options = SimulateOptions::new(still_for(40.0));
    options.dropped_fraction = 0.05;
    let holey = simulate(&options).unwrap();
    let (whole, file) = (&whole.files[0], &holey.files[0]);
    let lost = holey.truth.files[0].dropped_rows;
    assert_eq!(file.rows.len() + lost, 4000);
    // 200 ± 14.
    assert!((140..260).contains(&lost), "{lost}");
    for row in 0..file.rows.len() {
        let same = (file.rows[row].t_s * 100.0).round() as usize;
        assert_eq!(file.rows[row], whole.rows[same]);
    }
}

#[test]
fn stamps_follow_rate_and_jitter() {
    let mut options = SimulateOptions::new(still_for(40.0));
    options.rate_hz = 62.5;
    let file = simulate(&options).unwrap().files.remove(0);
    assert_eq!(file.rows.len(), 2500);
    assert!(
        file.rows
            .windows(2)
            .all(|w| w[1].stamp_ms - w[0].stamp_ms == 16)
    );

    options.stamp_jitter_ms = 3.0;
    let simulation = simulate(&options).unwrap();
    let (file, first) = (
        &simulation.files[0],
        simulation.truth.files[0].first_stamp_ms,
    );
    let off: Vec<_> = (0..2500)
        .map(|i| file.rows[i].stamp_ms as f64 - first as f64 - 16.0 * i as f64)
        .collect();
    assert!(off.iter().all(|o| (-3.0..=3.0).contains(o)));
    assert!(off.iter().any(|o| *o > 1.5) && off.iter().any(|o| *o < -1.5));
    assert!(file.rows.is_sorted_by_key(|row| row.stamp_ms));
}

/// Standard deviation of the means of blocks of `per_block` rows, pooled over three axes, about
/// the mean of each.
fn sd_of_means(
    file: &SimulatedFile,
    values: impl Fn(&Reading) -> [f64; 3],
    per_block: usize,
) -> f64 {
    let (mut sum, mut freedom) = (0.0, 0.0);
    for axis in 0..3 {
        let value = |row: &Row| values(&row.reading)[axis];
        let blocks = file.rows.chunks_exact(per_block);
        let means: Vec<f64> = blocks
            .map(|b| b.iter().map(value).sum::<f64>() / per_block as f64)
            .collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        sum += means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
        freedom += means.len() as f64 - 1.0;
    }
    (sum / freedom).sqrt()
}

#[test]
fn noise_density_is_as_given_at_every_rate() {
    for rate_hz in [62.5, 200.0] {
        let mut options = SimulateOptions::new(still_for(200.0));
        options.rate_hz = rate_hz;
        options.sensor.temperature_rise_c = 0.0;
        let file = simulate(&options).unwrap().files.remove(0);
        // Means over 2 s of white noise N: N/√2. 300 blocks: ±4 %. At 62.5 Hz the noise above 31
        // Hz after the low-pass is aliased: up to 12 % more.
        let per_block = (2.0 * rate_hz) as usize;
        let n = sd_of_means(&file, |r| r.accel_mps2, per_block) * 2f64.sqrt();
        let ratio = n / 3.3e-3;
        let expected = if rate_hz > 100.0 {
            1.0
        } else {
            folded(rate_hz)
        };
        assert!((ratio / expected - 1.0).abs() < 0.1, "{rate_hz}: {ratio}");
        let n = sd_of_means(&file, |r| r.gyro_rad_s, per_block) * 2f64.sqrt();
        let ratio = n / 0.005f64.to_radians();
        assert!((ratio / expected - 1.0).abs() < 0.1, "{rate_hz}: {ratio}");
    }
}

/// Gain at frequency 0 after sampling the output of a 44 Hz Butterworth filter: the power at
/// multiples of the rate is aliased to it.
fn folded(rate_hz: f64) -> f64 {
    let power = |f: f64| 1.0 / (1.0 + (f / 44.0).powi(4));
    let above: f64 = (1..5).map(|i| 2.0 * power(f64::from(i) * rate_hz)).sum();
    (1.0 + above).sqrt()
}

#[test]
fn warming_and_drift_continue_across_files() {
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
        .map(|f| f.rows[0].reading.temperature_c)
        .collect();
    assert_eq!(temperatures[0], 25.0);
    assert!(temperatures.is_sorted() && temperatures[5] > 32.0);
    let drift = simulation.truth.accelerometer.bias_drift_mps2_per_c[1];
    assert!((drift.abs() - 9.80665e-3).abs() < 1e-12);
    // +x and −x files: y reads only its bias.
    let moved = accel(&simulation.files[1], 0).y - accel(&simulation.files[0], 0).y;
    assert!((moved - drift * (temperatures[1] - 25.0)).abs() < 1e-9);
}
