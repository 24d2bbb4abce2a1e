//! One pass against the recording as a whole: the same object, number by number.

use std::path::Path;

use serde_json::Value;

use super::*;
use crate::calibration_file::CalibrationFile;
use crate::motion::motion;
use crate::recording::open::from_reader;
use crate::simulate::{LineOptions, Scenario, SimulateOptions, simulate, write};

/// A line of 0.7 m in 2 s between long rests: some 5200 rows at 100 Hz.
fn line(seed: u64) -> String {
    let scenario = LineOptions {
        rest_s: 25.0,
        ..LineOptions::default()
    };
    let mut options = SimulateOptions::new(Scenario::Line(scenario));
    options.seed = seed;
    let folder = tempfile::tempdir().unwrap();
    write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
    let text = std::fs::read_to_string(folder.path().join("line.csv")).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.to_owned() + "\n").collect()
}

/// A calibration with a matrix that is no diagonal one, in m/s².
fn calibration() -> CalibrationFile {
    CalibrationFile::parse(
        br#"{
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2",
        "from_gyr_unit": "deg/s", "cal_type": "Ferraris",
        "K_a": [[1.02, 0.01, 0], [0, 0.99, 0.02], [0, 0, 1.01]], "b_a": [0.1, -0.2, 0.05],
        "R_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
        "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
    }"#,
    )
    .unwrap()
}

fn lean(
    bytes: &[u8],
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Option<Streamed> {
    let input = from_reader(Box::new(std::io::Cursor::new(bytes.to_vec())), false).unwrap();
    assert!(fits(options));
    end_of(
        input,
        "a.csv",
        &ReadOptions::default(),
        calibration,
        options,
    )
}

/// Numbers alike to 1e-9 of them, all else the same.
fn alike(a: &Value, b: &Value, at: &str) {
    match (a, b) {
        (Value::Object(x), Value::Object(y)) => {
            let (keys, others): (Vec<_>, Vec<_>) = (x.keys().collect(), y.keys().collect());
            assert_eq!(keys, others, "{at}");
            x.iter()
                .for_each(|(k, v)| alike(v, &y[k], &format!("{at}/{k}")));
        }
        (Value::Array(x), Value::Array(y)) => {
            assert_eq!(x.len(), y.len(), "{at}: {a} {b}");
            let pairs = x.iter().zip(y).enumerate();
            pairs.for_each(|(i, (x, y))| alike(x, y, &format!("{at}/{i}")));
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            assert!(
                (x - y).abs() <= 1e-9 * x.abs().max(y.abs()),
                "{at}: {x} {y}"
            );
        }
        _ => assert_eq!(a, b, "{at}"),
    }
}

/// Whether one pass was enough; then the result is that of the recording as a whole.
fn compared(bytes: &[u8], file: Option<&CalibrationFile>, options: &MotionOptions) -> bool {
    let calibrated = file.map(|file| Calibrated {
        file,
        name: "c.json",
    });
    let Some(pass) = lean(bytes, calibrated, options) else {
        return false;
    };
    let recording = read_bytes(bytes, "a.csv", &ReadOptions::default()).unwrap();
    let whole = motion(&recording, calibrated, options).unwrap().result;
    let [a, b] = [&pass.result, &whole].map(|r| serde_json::to_value(r).unwrap());
    alike(&a, &b, "");
    assert_eq!(pass.head.accel_scale, recording.accel_scale);
    assert_eq!(pass.head.description, recording.description);
    true
}

fn smooth(text: &str) -> MotionOptions {
    MotionOptions {
        smooth: match text {
            "" => Vec::new(),
            filter => vec![filter.parse().unwrap()],
        },
        ..MotionOptions::report()
    }
}

/// All ways to ask for it.
#[track_caller]
fn all_ways(text: &str) {
    let file = calibration();
    let far = MotionOptions {
        p0_m: [1.0, -2.0, 0.5],
        still_rows: 321,
        clock_error: 0.01,
        wobble_deg: 2.0,
        axes: "z,x,y".parse().unwrap(),
        ..MotionOptions::report()
    };
    let thrown = MotionOptions {
        v0_mps: Some([1.0, 0.0, -0.5]),
        bands: false,
        ..smooth("savgol:6,3")
    };
    let options = [
        MotionOptions::report(),
        smooth(""),
        smooth("savgol:101,4"),
        smooth("mean:7"),
        far,
        thrown,
    ];
    for options in &options {
        for file in [None, Some(&file)] {
            assert!(compared(text.as_bytes(), file, options), "{options:?}");
        }
    }
}

/// The lines without some, or with others in their place.
fn changed(text: &str, change: impl Fn(usize, &str) -> Option<String>) -> String {
    let lines = text.lines().enumerate();
    let kept = lines.filter_map(|(i, line)| match i {
        0 => Some(line.to_owned()),
        i => change(i, line),
    });
    kept.map(|line| line + "\n").collect()
}

fn cells(line: &str, change: impl Fn(usize, &str) -> String) -> String {
    let cells = line.split(',').enumerate().map(|(i, cell)| change(i, cell));
    cells.collect::<Vec<_>>().join(",")
}

#[test]
fn a_clean_recording() {
    let text = line(1);
    assert!(text.len() > 1 << 18, "more than the head");
    all_ways(&text);
    // All of it is in the head.
    all_ways(&changed(&text, |i, line| {
        (i < 1500).then(|| line.to_owned())
    }));
    all_ways(&changed(&text, |i, line| {
        (i < 300).then(|| line.to_owned())
    }));
}

#[test]
fn without_a_gyroscope_and_without_stamps() {
    let text = line(2);
    let accel = |line: &str| line.split(',').take(4).collect::<Vec<_>>().join(",");
    let four: String = text.lines().map(|l| accel(l) + "\n").collect();
    all_ways(&four);
    let three = |line: &str| {
        line.split(',')
            .skip(1)
            .take(3)
            .collect::<Vec<_>>()
            .join(",")
    };
    let rest: String = text.lines().map(|l| three(l) + "\n").collect();
    all_ways(&format!("# rate: 100 Hz\n{rest}"));
}

#[test]
fn lost_rows_breaks_and_gaps() {
    let text = line(3);
    all_ways(&changed(&text, |i, line| {
        (i % 97 != 5).then(|| line.to_owned())
    }));
    for at in [100, 499, 505, 1800, 4150] {
        // A gap, one at which the filter begins anew and the motion does not, a blank
        // line, the header once more, and a piece that is shorter than the window.
        all_ways(&changed(&text, |i, line| {
            (!(at..at + 30).contains(&i)).then(|| line.to_owned())
        }));
        all_ways(&changed(&text, |i, line| match i {
            i if i == at => Some(format!("\n{line}")),
            i if i == at + 3 => Some(format!("{}\n{line}", text.lines().next().unwrap())),
            _ => Some(line.to_owned()),
        }));
    }
    all_ways(&changed(&text, |i, line| {
        (!(1500..1507).contains(&i)).then(|| line.to_owned())
    }));
}

#[test]
fn empty_cells_torn_lines_and_zeros_at_the_end() {
    let text = line(4);
    // A row without any value, one axis without, a run of them, the gyroscope.
    let holed = changed(&text, |i, line| {
        Some(cells(line, |k, cell| {
            let empty = match k {
                1..=3 if i % 701 == 7 => true,
                2 => i % 333 == 9 || (2000..2040).contains(&i),
                5 => i % 500 == 1,
                _ => false,
            };
            if empty {
                String::new()
            } else {
                cell.to_owned()
            }
        }))
    });
    all_ways(&holed);
    let torn = changed(&text, |i, line| match i {
        777 | 3333 => Some(line[..line.len() / 2].to_owned()),
        3900 => Some(format!("{line},1,2,3")),
        _ => Some(line.to_owned()),
    });
    all_ways(&torn);
    let tail = changed(&text, |i, line| {
        Some(cells(line, |k, cell| {
            let zero = i > 5000 && k > 0;
            if zero {
                "0".to_owned()
            } else {
                cell.to_owned()
            }
        }))
    });
    all_ways(&tail);
    // A frozen axis, and repeated rows.
    let odd = changed(&text, |i, line| {
        Some(cells(line, |k, cell| match k {
            1 if (1000..1300).contains(&i) => "0.5".to_owned(),
            _ => cell.to_owned(),
        }))
    });
    all_ways(&odd);
    // Most cells of an axis are empty: the last value holds, which is for all of it.
    let sparse = changed(&text, |i, line| {
        Some(cells(line, |k, cell| match k {
            1 if i % 3 != 0 => String::new(),
            _ => cell.to_owned(),
        }))
    });
    assert!(!compared(sparse.as_bytes(), None, &MotionOptions::report()));
}

#[test]
fn uneven_stamps() {
    let text = line(5);
    // By up to 1.2 ms, in microseconds; then rows with one stamp, and one that is
    // behind.
    let stamped = |off: &dyn Fn(usize) -> f64| {
        let body = changed(&text, |i, line| {
            let stamp = 1e4 * i as f64 + off(i);
            Some(cells(line, |k, cell| match k {
                0 => format!("{stamp:.0}"),
                _ => cell.to_owned(),
            }))
        });
        let header = body.lines().next().unwrap().to_owned();
        let named = header.replacen(header.split(',').next().unwrap(), "t_us", 1);
        body.replacen(&header, &named, 1)
    };
    let jitter = |i: usize| 2400.0 * ((i * 7919 % 1009) as f64 / 1009.0 - 0.5);
    all_ways(&stamped(&jitter));
    all_ways(&stamped(&|i| if i % 900 == 8 { -1e4 } else { 0.0 }));
    all_ways(&stamped(&|i| if i % 900 == 8 { -15e3 } else { 0.0 }));
    // Ten times as slow: there five steps are a gap.
    all_ways(&stamped(&|i| 9e4 * i as f64 + 10.0 * jitter(i)));
    all_ways(&stamped(&|i| {
        9e4 * i as f64 + if i > 3000 { 7e5 } else { 0.0 }
    }));
    // The clock is reset: that is for the recording as a whole.
    let reset = stamped(&|i| if i > 3000 { -30e6 } else { 0.0 });
    assert!(!compared(reset.as_bytes(), None, &MotionOptions::report()));
}

#[test]
fn what_is_no_recording_is_left_to_others() {
    let options = MotionOptions::report();
    let zeros: String = (0..5000).map(|i| format!("{i},0,0,0\n")).collect();
    for text in [
        String::new(),
        "t_ms,ax,ay,az\n0,0,0,9.8\n".to_owned(),
        "t_ms,ax,ay,az\n0,,,\n10,,,\n20,,,\n".to_owned(),
        format!("t_ms,ax,ay,az\n{zeros}"),
    ] {
        assert!(
            lean(text.as_bytes(), None, &options).is_none(),
            "{text:.40}"
        );
    }
    for value in ["0.5", "1e90"] {
        let rows: String = (0..3000)
            .map(|i| format!("{},0,{value},9.8\n", 10 * i))
            .collect();
        let text = format!("t_ms,ax,ay,az\n{rows}");
        let _ = compared(text.as_bytes(), None, &options);
    }
    // Another unit later on than in the first rows.
    let text = line(6);
    let other = changed(&text, |i, line| {
        Some(cells(line, |k, cell| match (k, cell.parse::<f64>()) {
            (1..=3, Ok(v)) if i > 2500 => format!("{:.5}", 0.102 * v),
            _ => cell.to_owned(),
        }))
    });
    let _ = compared(other.as_bytes(), None, &options);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.csv");
    let end = |path: &Path, options: &MotionOptions| {
        motion_end(path, &ReadOptions::default(), None, options).unwrap()
    };
    assert!(end(&path, &options).is_none());
    std::fs::write(&path, &text).unwrap();
    assert!(end(&path, &options).is_some());
    assert!(end(&path, &MotionOptions::default()).is_none());
    assert!(end(folder.path(), &options).is_none());
}

#[test]
fn real_recordings() {
    let Some(data) = std::env::var_os("GRAVICAL_DATA") else {
        return;
    };
    let mut pending = vec![std::path::PathBuf::from(data)];
    let (mut passed, mut left) = (Vec::new(), Vec::new());
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
                continue;
            }
            let Ok(bytes) = std::fs::read(&path) else {
                continue;
            };
            let read = read_bytes(&bytes, "a.csv", &ReadOptions::default());
            let known = read.is_ok_and(|r| motion(&r, None, &MotionOptions::report()).is_ok());
            if !known {
                continue;
            }
            let list = match compared(&bytes, None, &MotionOptions::report()) {
                true => &mut passed,
                false => &mut left,
            };
            list.push(path);
        }
    }
    eprintln!("passed {passed:#?}\nleft {left:#?}");
    assert!(passed.len() > left.len(), "{left:#?}");
}
