//! Times and rates of stamps.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used)]

use gravical_judge::{ClockOptions, Times, clock};

fn judged(stamps: Vec<f64>) -> Times {
    clock(stamps, ClockOptions::default()).unwrap()
}

fn is_rate(clock: &Times, rate_hz: f64, tolerance: f64) -> bool {
    (clock.rate_hz / rate_hz - 1.0).abs() < tolerance
}

/// `rows` stamps from `start` on.
fn even(rows: i32, start: f64, step: f64) -> impl Iterator<Item = f64> {
    (0..rows).map(move |i| start + step * f64::from(i))
}

#[test]
fn the_rate_of_coarse_stamps_is_right_despite_resets_and_gaps() {
    // Whole seconds at 100 Hz, a reset, a gap of 1000 s.
    let seconds = |rows| even(rows, 0.0, 0.01);
    let late = even(3000, 1060.0, 0.01);
    let stamps = seconds(5030).chain(seconds(6000)).chain(late);
    let clock = judged(stamps.map(|t| (t + 1e-6).floor()).collect());
    assert!(is_rate(&clock, 100.0, 0.01), "{}", clock.rate_hz);
    assert!(clock.time_s.is_sorted());
}

#[test]
fn a_step_back_is_not_a_wrap() {
    // 10 Hz in ms: rows that come 0.8 s late, and a clock set back by a second.
    for back in [800.0, 1000.0] {
        let late = even(150, 15_000.0 - back, 100.0);
        let clock = judged(even(150, 0.0, 100.0).chain(late).collect());
        assert_eq!(clock.bad, [150], "{back}");
        assert!(clock.restarts.is_empty());
    }
}

/// `rows` rows at 100 Hz between the pauses; ms.
fn paused(rows: i32, pauses_s: &[f64]) -> Vec<f64> {
    let mut out = Vec::new();
    let mut start = 0.0;
    for pause in pauses_s.iter().chain(&[0.0]) {
        out.extend(even(rows, start, 10.0));
        start += 10.0 * f64::from(rows - 1) + 1e3 * pause;
    }
    out
}

#[test]
fn pauses_of_the_recorder_are_not_bursts() {
    for (rows, pauses_s) in [
        (100, &[5.0, 52.0][..]),
        (40, &[600.0][..]),
        (300, &[12.0, 31.0, 17.0, 55.0, 20.0, 90.0, 14.0]),
    ] {
        let clock = judged(paused(rows, pauses_s));
        assert_eq!(clock.gaps.len(), pauses_s.len());
        assert!(clock.missing > 0.0 && clock.bursty_steps.is_none());
        assert!(is_rate(&clock, 100.0, 0.001), "{}", clock.rate_hz);
    }
    // Buffers of 30 rows every 2 s are bursts; so are buffers with nearly equal stamps.
    assert!(judged(paused(30, &[2.0; 12])).bursty_steps.is_some());
    let nearly_equal = (0..300).map(|i| f64::from(i / 100) * 1e3 + f64::from(i % 7));
    assert!(judged(nearly_equal.collect()).bursty_steps.is_some());
}

#[test]
fn the_temperature_resolves_an_ambiguous_unit() {
    let stamps: Vec<f64> = even(5000, 0.0, 505_700.0).collect();
    let plain = judged(stamps.clone());
    assert!(plain.unit_s == 1e-9 && plain.is_unit_assumed);
    let options = ClockOptions {
        temperature_span_c: 70.0,
        ..ClockOptions::default()
    };
    assert_eq!(clock(stamps, options).unwrap().unit_s, 1e-6);
}

fn marked(stamps: &[f64], gaps: &[usize], pauses: &[usize]) -> Times {
    let options = ClockOptions {
        gaps,
        pauses,
        ..ClockOptions::default()
    };
    clock(stamps.to_vec(), options).unwrap()
}

#[test]
fn samples_in_a_pause_are_not_missing() {
    // 2 s, a pause of 4 s, 2 s with three samples lost.
    let mut stamps: Vec<f64> = even(200, 0.0, 10.0)
        .chain(even(200, 6000.0, 10.0))
        .collect();
    stamps.drain(300..303);
    let paused = marked(&stamps, &[], &[200]);
    assert_eq!(paused.missing, 3.0);
    assert!((paused.mean_rate_hz.unwrap() - 99.25).abs() < 0.1);
    assert!((paused.duration_s - 7.99).abs() < 1e-9);
    // After a named gap they are missing; blank lines elsewhere have no effect.
    assert_eq!(marked(&stamps, &[200], &[]).missing, 403.0);
    let elsewhere = marked(&stamps, &[], &[100]);
    assert!(elsewhere.gaps[0].0 == 200 && elsewhere.mean_rate_hz.unwrap() < 50.0);
    // 100 Hz in microseconds; a pause of 57 s across the wrap.
    let period = 4_294_967_296.0;
    let whole = even(300, period - 20e6, 1e4).chain(even(300, period + 40e6, 1e4));
    let stamps: Vec<f64> = whole.map(|t| t % period).collect();
    let paused = marked(&stamps, &[], &[300]);
    assert!((paused.mean_rate_hz.unwrap() - 100.0).abs() < 0.1 && paused.missing == 0.0);
    assert_eq!(judged(stamps).missing, 5700.0);
}
