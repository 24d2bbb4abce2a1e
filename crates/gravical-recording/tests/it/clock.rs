//! Times and rates of stamps.

use gravical_recording::Recording;
use gravical_recording::judge::{ClockOptions, Times, clock};

use crate::support::{Row, finding, has, has_rate, is_near, read, six_faces};

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

/// A file of 300 rows: above them `header`, if there is one; `row` gives what stands before and behind
/// the acceleration.
fn file(header: &str, separator: &str, row: impl Fn(usize) -> [String; 2]) -> String {
    let rows = six_faces(4);
    let line = |(k, r): (usize, &Row)| {
        let accel = r.accel_g.map(|v| format!("{:.4}", 9.80665 * v));
        let [before, behind] = row(k);
        let cells = [before, accel.join(separator), behind];
        let cells = cells.iter().filter(|c| !c.is_empty());
        cells.cloned().collect::<Vec<_>>().join(separator) + "\n"
    };
    let rows: String = rows.iter().enumerate().map(line).collect();
    format!("{header}{rows}")
}

fn gaps(recording: &Recording) -> usize {
    finding(recording, "gap").map_or(0, |f| f.lines.len())
}

/// 10 Hz from 23:59:50 on the last of March.
fn tenths(k: usize) -> (bool, String) {
    let tenths = 863_900 + k;
    let (is_next, of_day) = (tenths >= 864_000, tenths % 864_000);
    let (s, f) = (of_day / 10, of_day % 10);
    let time = format!("{:02}:{:02}:{:02}.{f}00", s / 3600, s / 60 % 60, s % 60);
    (is_next, time)
}

#[test]
fn date_and_time_in_two_columns_are_one_clock() {
    for [day, next] in [
        ["2024-03-31", "2024-04-01"],
        ["31/03/2024", "01/04/2024"],
        ["03/31/2024", "04/01/2024"],
        ["31.03.2024", "01.04.2024"],
        ["31-MAR-2024", "01-APR-2024"],
    ] {
        for separator in ["\t", ",", ";", " "] {
            for (zone, is_apart) in [("", false), (" UTC", false), ("", true)] {
                let row = |k: usize| {
                    let (is_next, time) = tenths(k);
                    let day = (if is_next { next } else { day }).to_owned();
                    let zone = if separator == " " { "" } else { zone };
                    if is_apart {
                        [day, time]
                    } else {
                        [format!("{day}{separator}{time}{zone}"), String::new()]
                    }
                };
                let names = ["Date", "Time", "ax", "ay", "az"].join(separator) + "\n";
                let apart = ["Date", "ax", "ay", "az", "Time"].join(separator) + "\n";
                for header in ["", if is_apart { &apart } else { &names }] {
                    let text = file(header, separator, row);
                    let recording = read(&text, "desk.csv");
                    let about = &text[..100];
                    let start = recording.recorded_at().map(|t| t.to_string());
                    assert!(has_rate(&recording, 10.0), "{:?}\n{about}", recording.clock);
                    let is_it = start.is_some_and(|s| s.starts_with("2024-03-31T23:59:50"));
                    assert!(is_it, "{about}");
                    assert_eq!(gaps(&recording), 0, "{about}");
                    assert!(is_near(recording.accel[0][0], 10.0, 0.1), "{about}");
                }
            }
        }
    }
}

/// Columns in front of the acceleration, and the cells of a row in them.
type Clock = (&'static str, fn(usize) -> String);

const CLOCKS: [(Clock, f64, usize, Option<&str>); 8] = [
    // Bursts of 300 ms, and pauses of 72 s.
    (("time_s,", bursts), 10.0, 5, Some("burst-time")),
    (("Time (h),", hours), 10.0, 0, None),
    // A run of absurd stamps.
    (("time_ms,", absurd), 10.0, 0, Some("bad-stamps")),
    (
        ("Time [frames],", tenths_ms),
        10.0,
        0,
        Some("time-unit-unknown"),
    ),
    (("# Data Rate: 100 Hz\n", |_| String::new()), 100.0, 0, None),
    (
        ("# Start time: 0, Unix epoch 00:00:15\ntime_ms,", tenths_ms),
        10.0,
        0,
        None,
    ),
    // A counter of rows beside the clock.
    (
        ("t,time,", |k| format!("{k},{}", 1000 + 100 * k + k % 3)),
        10.0,
        0,
        None,
    ),
    (("year,month,day,hour,minute,second,", date), 10.0, 0, None),
];

fn tenths_ms(k: usize) -> String {
    (100 * k).to_string()
}

fn hours(k: usize) -> String {
    format!("{:.8}", k as f64 / 36_000.0)
}

fn absurd(k: usize) -> String {
    match k {
        100..107 => "4294967295".to_owned(),
        _ => tenths_ms(k),
    }
}

fn bursts(k: usize) -> String {
    let [pause, burst, row] = [k / 50, k % 50 / 3, k % 50 % 3].map(|n| n as f64);
    format!("{:.2}", 77.0 * pause + 0.3 * burst + 0.02 * row)
}

fn date(k: usize) -> String {
    format!("2024,3,31,23,59,{}.{}", 10 + k / 10, k % 10)
}

#[test]
fn clocks_of_many_writings_are_read() {
    for ((header, cells), rate_hz, gaps_there, odd) in CLOCKS {
        let text = file(&format!("{header}ax,ay,az\n"), ",", |k| {
            [cells(k), String::new()]
        });
        let recording = read(&text, "desk.csv");
        let clock = &recording.clock;
        assert!(has_rate(&recording, rate_hz), "{header}{clock:?}");
        assert_eq!(gaps(&recording), gaps_there, "{header}");
        let start = recording.recorded_at().map(|t| t.to_string());
        let is_dated = start.is_some_and(|s| s.starts_with("2024-03-31T23:59:10"));
        assert_eq!(is_dated, header.starts_with("year"), "{header}");
        for kind in ["burst-time", "bad-stamps", "time-unit-unknown"] {
            assert_eq!(has(&recording, kind), odd == Some(kind), "{header}{kind:?}");
        }
    }
}
