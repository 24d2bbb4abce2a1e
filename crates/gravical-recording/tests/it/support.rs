//! Samples of a sensor on its six faces, and the reader.

use gravical_recording::{Error, Finding, ReadOptions, Recording, read_bytes};

pub const RATE_HZ: f64 = 25.0;
pub const FACE_ROWS: usize = 50;

/// One row: specific force in g, angular rate in °/s.
pub struct Row {
    pub accel_g: [f64; 3],
    pub gyro_deg_s: [f64; 3],
}

/// The sensor lies on its six faces for two seconds each.
pub fn six_faces(seed: u64) -> Vec<Row> {
    // Numbers that look random (Knuth's linear congruential generator), from −1 to 1.
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((state >> 33) % 2001) as f64 / 1000.0 - 1.0
    };
    noise();
    (0..6 * FACE_ROWS)
        .map(|row| {
            let face = row / FACE_ROWS;
            let mut accel_g = [0.02, -0.04, 0.05].map(|bias| bias + 0.003 * noise());
            accel_g[face / 2] += if face.is_multiple_of(2) { 1.0 } else { -1.0 };
            let gyro_deg_s = [0.77, -0.31, 1.16].map(|bias| bias + 0.1 * noise());
            Row {
                accel_g,
                gyro_deg_s,
            }
        })
        .collect()
}

pub fn read(text: &str, file_name: &str) -> Recording {
    try_read(text.as_bytes().to_vec(), file_name).unwrap()
}

pub fn try_read(bytes: Vec<u8>, file_name: &str) -> Result<Recording, Error> {
    let recording = read_bytes(&bytes, file_name, &ReadOptions::default())?;
    let account = &recording.ledger;
    assert_eq!(recording.rows() + account.total(), account.lines);
    Ok(recording)
}

/// The first finding of a kind.
pub fn finding<'a>(recording: &'a Recording, kind: &str) -> Option<&'a Finding> {
    recording.findings.iter().find(|f| f.kind == kind)
}

pub fn has(recording: &Recording, kind: &str) -> bool {
    finding(recording, kind).is_some()
}

pub fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// Whether the rates agree to one percent.
pub fn has_rate(recording: &Recording, rate_hz: f64) -> bool {
    let own = recording.clock.rate_hz();
    own.is_some_and(|r| is_near(r, rate_hz, 0.01 * rate_hz))
}
