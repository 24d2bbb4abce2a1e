use super::*;

fn evaluated(raw: Vec<f64>) -> Timed {
    let claims = Claims {
        unit: None,
        nominal_rate_hz: None,
        temperature_span_c: 0.0,
    };
    judge(&raw, &claims, |row| row as u64 + 1, |_| None)
}

fn gap_at(at: usize) -> impl Fn(usize) -> Option<BreakKind> {
    move |row| (row == at).then_some(BreakKind::NamedGap)
}

fn break_at(at: usize) -> impl Fn(usize) -> Option<BreakKind> {
    move |row| (row == at).then_some(BreakKind::Pause)
}

fn kinds(timed: &Timed) -> Vec<&str> {
    timed.findings.iter().map(|f| f.kind.name()).collect()
}

#[test]
fn rate_of_coarse_stamps_is_right_despite_resets_and_gaps() {
    // Whole seconds at 100 Hz, a reset, a gap of 1000 s.
    let second = |i: i32| f64::from(i / 100);
    let raw = (0..5030)
        .map(second)
        .chain((0..6000).map(second))
        .chain((0..3000).map(|i| 1060.0 + second(i)))
        .collect();
    let timed = evaluated(raw);
    let rate = timed.summary.timing.rate_hz().unwrap();
    assert!((rate - 100.0).abs() < 1.0, "{rate}");
}

#[test]
fn a_step_back_is_not_a_wrap() {
    // 10 Hz in ms: rows that come 0.8 s late, and a clock set back by a second.
    for back in [800.0, 1000.0] {
        let raw = (0..300)
            .map(|i| 100.0 * f64::from(i) - if i >= 150 { back } else { 0.0 })
            .collect();
        let kinds_of = kinds(&evaluated(raw)).join(" ");
        assert!(kinds_of.contains("bad-stamps"), "{back}: {kinds_of}");
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
        let timed = evaluated(paused(rows, pauses_s));
        assert_eq!(kinds(&timed), ["gap", "missing-samples"], "{pauses_s:?}");
        let rate = timed.summary.timing.rate_hz().unwrap();
        assert!((rate - 100.0).abs() < 0.1, "{rate}");
    }
    // Buffers of 30 rows every 2 s are bursts.
    let timed = evaluated(paused(30, &[2.0; 12]));
    assert!(kinds(&timed).contains(&"burst-time"));
    // So are buffers with nearly equal stamps.
    let raw = (0..300).map(|i| f64::from(i / 100) * 1e3 + f64::from(i % 7));
    assert!(kinds(&evaluated(raw.collect())).contains(&"burst-time"));
}

#[test]
fn temperature_range_resolves_an_ambiguous_unit() {
    let raw: Vec<f64> = (0..5000).map(|i| 505_700.0 * f64::from(i)).collect();
    let claims = |span| Claims {
        unit: None,
        nominal_rate_hz: None,
        temperature_span_c: span,
    };
    let warm = judge(&raw, &claims(70.0), |r| r as u64, |_| None);
    assert_eq!(warm.summary.timing.unit, Some(TimeUnit::Microsecond));
    let plain = judge(&raw, &claims(0.0), |r| r as u64, |_| None);
    assert_eq!(plain.summary.timing.unit, Some(TimeUnit::Nanosecond));
    assert_eq!(kinds(&plain), ["time-unit-assumed"]);
}

#[test]
fn a_step_back_after_a_named_gap_is_a_restart() {
    // The first stamp after the gap is a minute after the reset.
    let mut raw: Vec<f64> = (0..100).map(|i| 100_000.0 + 10.0 * f64::from(i)).collect();
    raw.extend((0..100).map(|i| 60_000.0 + 10.0 * f64::from(i)));
    let claims = Claims {
        unit: None,
        nominal_rate_hz: None,
        temperature_span_c: 0.0,
    };
    let timed = judge(&raw, &claims, |row| row as u64, gap_at(100));
    assert_eq!(kinds(&timed), ["restarted-time"]);
    assert!(timed.time_s.unwrap().is_sorted());
    // Elsewhere it is a step back.
    assert_eq!(kinds(&evaluated(raw.clone())), ["bad-stamps"]);
    assert_eq!(
        kinds(&judge(&raw, &claims, |row| row as u64, gap_at(99))),
        ["bad-stamps"]
    );
}

#[test]
fn samples_in_a_pause_are_not_missing() {
    let claims = Claims {
        unit: None,
        nominal_rate_hz: None,
        temperature_span_c: 0.0,
    };
    // 2 s, a pause of 4 s, 2 s with three samples lost.
    let mut raw: Vec<f64> = (0..200).map(|i| 10.0 * f64::from(i)).collect();
    raw.extend((0..200).map(|i| 6000.0 + 10.0 * f64::from(i)));
    raw.drain(300..303);
    let timed = judge(&raw, &claims, |row| row as u64 + 1, break_at(200));
    assert_eq!(kinds(&timed), ["missing-samples"]);
    assert_eq!(timed.findings[0].count, 3);
    assert!((timed.summary.timing.mean_rate_hz.unwrap() - 99.25).abs() < 0.1);
    assert!((timed.summary.timing.duration_s.unwrap() - 7.99).abs() < 1e-9);
    // After a named gap they are missing.
    let timed = judge(&raw, &claims, |row| row as u64, gap_at(200));
    assert_eq!(kinds(&timed), ["gap", "missing-samples"]);
    assert_eq!(timed.findings[1].count, 403);
    assert!(timed.summary.timing.mean_rate_hz.unwrap() < 50.0);
    // Blank lines without a pause of the clock have no effect.
    let timed = judge(&raw, &claims, |row| row as u64, break_at(100));
    assert_eq!(kinds(&timed), ["gap", "missing-samples"]);
}

#[test]
fn pauses_and_gaps_across_a_wrap_are_found() {
    let period = 4_294_967_296.0;
    let claims = Claims {
        unit: None,
        nominal_rate_hz: None,
        temperature_span_c: 0.0,
    };
    // 100 Hz in microseconds; a pause of 57 s across the wrap.
    let start = period - 20e6;
    let raw: Vec<f64> = (0..300)
        .map(|i| start + 1e4 * f64::from(i))
        .chain((0..300).map(|i| start + 60e6 + 1e4 * f64::from(i)))
        .map(|t| t % period)
        .collect();
    let timed = judge(&raw, &claims, |row| row as u64, break_at(300));
    assert_eq!(kinds(&timed), [] as [&str; 0]);
    assert!((timed.summary.timing.mean_rate_hz.unwrap() - 100.0).abs() < 0.1);
    let timed = judge(&raw, &claims, |row| row as u64, gap_at(300));
    assert_eq!(kinds(&timed), ["gap", "missing-samples"]);
    assert_eq!(timed.findings[1].count, 5700);
}
