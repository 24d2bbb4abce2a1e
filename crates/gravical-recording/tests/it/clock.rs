//! Times and rates of stamps.

use gravical_recording::judge::{Clock, ClockOptions, clock};

fn judged(stamps: Vec<f64>) -> Clock {
    clock(stamps, ClockOptions::default()).unwrap()
}

fn is_rate(clock: &Clock, rate_hz: f64, tolerance: f64) -> bool {
    (clock.rate_hz / rate_hz - 1.0).abs() < tolerance
}

#[test]
fn the_rate_of_coarse_stamps_is_right_despite_resets_and_gaps() {
    // Whole seconds at 100 Hz, a reset, a gap of 1000 s.
    let second = |i: i32| f64::from(i / 100);
    let stamps = (0..5030)
        .map(second)
        .chain((0..6000).map(second))
        .chain((0..3000).map(|i| 1060.0 + second(i)))
        .collect();
    let clock = judged(stamps);
    assert!(is_rate(&clock, 100.0, 0.01), "{}", clock.rate_hz);
    assert!(clock.time_s.is_sorted());
}

#[test]
fn a_step_back_is_not_a_wrap() {
    // 10 Hz in ms: rows that come 0.8 s late, and a clock set back by a second.
    for back in [800.0, 1000.0] {
        let late = |i: i32| if i >= 150 { back } else { 0.0 };
        let clock = judged((0..300).map(|i| 100.0 * f64::from(i) - late(i)).collect());
        assert_eq!(clock.bad, [150], "{back}");
        assert!(clock.restarts.is_empty());
    }
}

/// `rows` rows at 100 Hz between the pauses; ms.
fn paused(rows: usize, pauses_s: &[f64]) -> Vec<f64> {
    let mut out = Vec::new();
    let mut start = 0.0;
    for pause in pauses_s.iter().chain(&[0.0]) {
        out.extend((0..rows).map(|i| start + 10.0 * i as f64));
        start += 10.0 * (rows as f64 - 1.0) + 1e3 * pause;
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
        assert!(clock.missing > 0.0 && clock.bunched.is_none());
        assert!(is_rate(&clock, 100.0, 0.001), "{}", clock.rate_hz);
    }
    // Buffers of 30 rows every 2 s are bursts; so are buffers with nearly equal stamps.
    assert!(judged(paused(30, &[2.0; 12])).bunched.is_some());
    let nearly_equal = (0..300).map(|i| f64::from(i / 100) * 1e3 + f64::from(i % 7));
    assert!(judged(nearly_equal.collect()).bunched.is_some());
}

#[test]
fn the_temperature_resolves_an_ambiguous_unit() {
    let stamps: Vec<f64> = (0..5000).map(|i| 505_700.0 * f64::from(i)).collect();
    let options = ClockOptions {
        temperature_span_c: 70.0,
        ..ClockOptions::default()
    };
    assert_eq!(clock(stamps.clone(), options).unwrap().unit_s, 1e-6);
    let plain = judged(stamps);
    assert!(plain.unit_s == 1e-9 && plain.is_unit_assumed);
}

#[test]
fn a_step_back_after_a_named_gap_is_a_restart() {
    // The first stamp after the gap is a minute after the reset.
    let mut stamps: Vec<f64> = (0..100).map(|i| 100_000.0 + 10.0 * f64::from(i)).collect();
    stamps.extend((0..100).map(|i| 60_000.0 + 10.0 * f64::from(i)));
    let at = |gaps: &[usize]| {
        let options = ClockOptions {
            gaps,
            ..ClockOptions::default()
        };
        clock(stamps.clone(), options).unwrap()
    };
    let restarted = at(&[100]);
    assert!(restarted.restarts == [100] && restarted.bad.is_empty());
    assert!(restarted.time_s.is_sorted());
    for elsewhere in [&[][..], &[99]] {
        let back = at(elsewhere);
        assert!(back.restarts.is_empty() && back.bad == [100]);
    }
}

#[test]
fn samples_in_a_pause_are_not_missing() {
    // 2 s, a pause of 4 s, 2 s with three samples lost.
    let mut stamps: Vec<f64> = (0..200).map(|i| 10.0 * f64::from(i)).collect();
    stamps.extend((0..200).map(|i| 6000.0 + 10.0 * f64::from(i)));
    stamps.drain(300..303);
    let at = |gaps: &[usize], pauses: &[usize]| {
        let options = ClockOptions {
            gaps,
            pauses,
            ..ClockOptions::default()
        };
        clock(stamps.clone(), options).unwrap()
    };
    let paused = at(&[], &[200]);
    assert_eq!(paused.missing, 3.0);
    assert!((paused.mean_rate_hz.unwrap() - 99.25).abs() < 0.1);
    assert!((paused.duration_s - 7.99).abs() < 1e-9);
    // After a named gap they are missing; blank lines elsewhere have no effect.
    assert_eq!(at(&[200], &[]).missing, 403.0);
    let elsewhere = at(&[], &[100]);
    assert!(elsewhere.gaps == [200] && elsewhere.mean_rate_hz.unwrap() < 50.0);
}

#[test]
fn pauses_and_gaps_across_a_wrap_are_found() {
    // 100 Hz in microseconds; a pause of 57 s across the wrap.
    let period = 4_294_967_296.0;
    let start = period - 20e6;
    let stamps: Vec<f64> = (0..300)
        .map(|i| start + 1e4 * f64::from(i))
        .chain((0..300).map(|i| start + 60e6 + 1e4 * f64::from(i)))
        .map(|t| t % period)
        .collect();
    let paused = ClockOptions {
        pauses: &[300],
        ..ClockOptions::default()
    };
    let paused = clock(stamps.clone(), paused).unwrap();
    assert!((paused.mean_rate_hz.unwrap() - 100.0).abs() < 0.1 && paused.missing == 0.0);
    assert_eq!(judged(stamps).missing, 5700.0);
}
