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
fn backward_stamps_are_reported() {
    let recording = read(&stamped(|row| {
        let t = if row == 250 { 10 * row - 35 } else { 10 * row };
        t.to_string()
    }));
    assert_eq!(finding(&recording, "bad-stamps").lines, [[252, 252]]);
    close(recording.timing.rate_hz().unwrap(), 100.0, 0.5);
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
fn a_wrapped_counter_is_unwrapped() {
    for (unit, step) in [("ms", 10_u64), ("us", 10_000)] {
        let start = (1_u64 << 32) - 200 * step;
        let bytes = stamped(|row| ((start + row as u64 * step) % (1 << 32)).to_string());
        let text = String::from_utf8(bytes).unwrap();
        let recording = read(text.replace("(ms)", &format!("({unit})")).as_bytes());
        close(recording.timing.duration_s.unwrap(), 5.99, 1e-6);
        assert!(recording.breaks.is_empty());
        unharmed(&recording);
    }
}

#[test]
fn a_reset_of_the_board_is_a_break() {
    let recording = read(&stamped(|row| {
        let t = if row < 300 {
            50_000 + 10 * row
        } else {
            150 + 10 * (row - 300)
        };
        t.to_string()
    }));
    assert_eq!(finding(&recording, "restarted-time").lines, [[302, 302]]);
    assert_eq!(recording.breaks, [300]);
    unharmed(&recording);
}

#[test]
fn a_gap_is_reported_with_its_length() {
    let recording = read(&stamped(|row| {
        (10 * row + if row >= 400 { 700 } else { 0 }).to_string()
    }));
    let found = finding(&recording, "gap");
    assert_eq!(found.lines, [[402, 402]]);
    assert!(found.message.contains("0.710 s"), "{}", found.message);
    finding(&recording, "missing-samples");
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

#[test]
fn the_assumed_unit_of_stamps_is_reported() {
    let header = HEADER.replace(" (ms)", "");
    let recording = read(&joined(&report_lines(&header, ROWS)));
    assert_eq!(recording.timing.unit, Some(TimeUnit::Millisecond));
    let given = ReadOptions {
        time_unit: Some(TimeUnit::Millisecond),
        ..ReadOptions::default()
    };
    let recording = read_with(&joined(&report_lines(&header, ROWS)), &given);
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
}
