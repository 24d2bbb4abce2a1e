//! Time stamps: repeated, backwards, wrapped, late, at the wrong rate.

use super::*;

/// Replaces the stamps by `stamp(row)`.
fn stamped(stamp: impl Fn(usize) -> String) -> Vec<u8> {
    let mut lines = lines();
    for (row, line) in lines.iter_mut().skip(1).enumerate() {
        let rest = line.split_once(',').unwrap().1;
        *line = format!("{},{rest}", stamp(row));
    }
    joined(&lines)
}

#[test]
fn repeated_stamps_are_reported_and_their_rows_kept() {
    let recording = read(&stamped(|row| match row {
        100 => "990".to_owned(),
        300 | 301 => "2990".to_owned(),
        _ => (10 * row).to_string(),
    }));
    let found = finding(&recording, "duplicate-time");
    assert_eq!(found.lines, [[102, 102], [302, 303]]);
    assert_eq!(found.count, 3);
    close(recording.timing.mean_rate_hz.unwrap(), 100.0, 0.5);
    unharmed(&recording);
}

#[test]
fn bursts_are_times_of_arrival() {
    let recording = read(&stamped(|row| (100 * (row / 10)).to_string()));
    finding(&recording, "burst-time");
    close(recording.timing.rate_hz().unwrap(), 100.0, 2.0);
    let t = recording.time_s.as_ref().unwrap();
    assert!(t.windows(2).all(|w| w[1] > w[0]));
    unharmed(&recording);
}

#[test]
fn a_rate_other_than_the_claimed_one_is_reported() {
    let mut bytes = b"Fs,100\n".to_vec();
    bytes.extend(stamped(|row| (16 * row).to_string()));
    let recording = read(&bytes);
    let found = finding(&recording, "rate-mismatch");
    assert!(found.message.contains("62.50 Hz"), "{}", found.message);
    assert_eq!(recording.timing.nominal_rate_hz, Some(100.0));
    close(recording.timing.rate_hz().unwrap(), 62.5, 1e-9);
    unharmed(&recording);
}

#[test]
fn rows_read_faster_than_the_sensor_measures_are_reported() {
    let mut lines = lines();
    for i in (1..ROWS).step_by(2) {
        let values = lines[i].split_once(',').unwrap().1.to_owned();
        let stamp = lines[i + 1].split_once(',').unwrap().0.to_owned();
        lines[i + 1] = format!("{stamp},{values}");
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "repeated-rows").count, ROWS as u64 / 2);
}
