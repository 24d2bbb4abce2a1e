//! Clocks of files.

use gravical_recording::Recording;

use crate::support::{Row, finding, has, has_rate, is_near, read, six_faces};

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
