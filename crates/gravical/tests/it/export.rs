//! Every exported file, read or compiled and used by its target's own formula, calibrates like the
//! calibration it was made from: on a thousand random vectors, to 1e-6 of full scale.

mod autopilot;
#[path = "../../../../tests/support/calibration.rs"]
mod calibration;
mod code;
mod ros;

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use gravical::calibration_file::Calibration;
use gravical::export::{Export, ExportOptions, TARGETS, Target, export, export_noise};
use gravical::finding::Advice;
use gravical::noise::NoiseResult;
use gravical::recording::{AccelUnit, GyroUnit};
use serde_json::json;

use crate::support::*;
use calibration::{G, made};

type Vector = [f64; 3];

/// An MPU6050 at ±2 g and ±250 °/s, in counts.
fn in_counts() -> Calibration {
    calibration::in_counts(16384.0, 131.0)
}

/// A sensor that reads g and °/s.
fn in_g() -> Calibration {
    let mut file = made(1.0 / G, 1.0);
    file.accelerometer.input_unit = AccelUnit::StandardGravity;
    file.gyroscope.as_mut().unwrap().input_unit = GyroUnit::DegreePerSecond;
    file
}

/// The usual options with a change.
fn options_with(change: impl FnOnce(&mut ExportOptions)) -> ExportOptions {
    let mut options = ExportOptions::default();
    change(&mut options);
    options
}

fn export_to(
    file: &Calibration,
    target: &str,
    options: &ExportOptions,
) -> gravical::Result<Export> {
    export(file, Target::find(target).unwrap(), options)
}

fn written(file: &Calibration, target: &str) -> Export {
    export_to(file, target, &ExportOptions::default()).unwrap()
}

/// A thousand vectors of whole numbers over the range of 16 bits, or of `size`.
fn vectors(seed: u64, size: f64) -> Vec<Vector> {
    let mut noise = Noise::new(seed);
    let mut one = || ((2.0 * noise.uniform() - 1.0) * 32000.0).round() * (size / 32000.0);
    (0..1000).map(|_| [one(), one(), one()]).collect()
}

/// What the library makes of them.
fn calibrated(file: &Calibration, accel: &[Vector], gyro: &[Vector]) -> Vec<[Vector; 2]> {
    let g = file.gyroscope_calibration().unwrap();
    let a = file.accelerometer_calibration();
    let both = |(accel, gyro): (&Vector, &Vector)| {
        let force = a.apply(*accel);
        [force, g.apply(*gyro, force)]
    };
    accel.iter().zip(gyro).map(both).collect()
}

/// Six numbers a line, accelerometer and gyroscope, against `wanted`.
fn agree(out: &str, wanted: &[[Vector; 2]]) {
    let row = |line: &str| -> [Vector; 2] {
        let numbers = line.split_whitespace().map(|w| w.parse().unwrap());
        let [x, y, z, u, v, w] = numbers.collect::<Vec<f64>>()[..] else {
            panic!("{line}")
        };
        [[x, y, z], [u, v, w]]
    };
    agree_rows(&out.lines().map(row).collect::<Vec<_>>(), wanted);
}

/// To 1e-6 of the largest.
fn agree_rows(rows: &[[Vector; 2]], wanted: &[[Vector; 2]]) {
    assert_eq!(rows.len(), wanted.len());
    for sensor in 0..2 {
        let all = wanted.iter().flat_map(|w| w[sensor]);
        let most = all.fold(0.0_f64, |m, v| m.max(v.abs()));
        for (row, wanted) in rows.iter().zip(wanted) {
            for i in 0..3 {
                close(row[sensor][i], wanted[sensor][i], 1e-6 * most);
            }
        }
    }
}

fn times(m: &[f64], v: Vector) -> Vector {
    assert_eq!(m.len(), 9);
    std::array::from_fn(|i| (0..3).map(|j| m[3 * i + j] * v[j]).sum())
}

fn less(a: Vector, b: &[f64]) -> Vector {
    assert_eq!(b.len(), 3);
    std::array::from_fn(|i| a[i] - b[i])
}

/// The vectors as lines of a program's input.
fn lines(accel: &[Vector], gyro: &[Vector]) -> String {
    let row = |([x, y, z], [u, v, w]): (&Vector, &Vector)| format!("{x} {y} {z} {u} {v} {w}\n");
    accel.iter().zip(gyro).map(row).collect()
}

/// Output of a program; none where it is not installed, which fails on a build server.
fn output(program: &str, args: &[&str], folder: &Path, input: &str) -> Option<String> {
    let mut command = Command::new(program);
    command.args(args).current_dir(folder);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = match command.stderr(Stdio::piped()).spawn() {
        Ok(child) => child,
        Err(e) => {
            assert!(std::env::var_os("CI").is_none(), "{program}: {e}");
            println!("skipped: {program}: {e}");
            return None;
        }
    };
    let mut stdin = child.stdin.take().unwrap();
    // In a thread: the program answers while it reads.
    let input = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let done = child.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    let [out, err] = [done.stdout, done.stderr].map(|b| String::from_utf8(b).unwrap());
    assert!(done.status.success(), "{program} {args:?}\n{err}{out}");
    Some(out)
}

/// Writes a file into `folder`.
fn save(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_target_refuses_options_and_names_that_it_cannot_use() {
    let named = |name: &str| options_with(|o| o.name = Some(name.to_owned()));
    let long = "n".repeat(49);
    let names = [
        "", "9lives", "a-b", "a b", "a__b", "_a", "größe", "x*/y", &long,
    ];
    let names = names.map(|name| ("c", named(name), "export-name"));
    let others = [
        ("ros", named("imu"), "export-option"),
        (
            "c",
            options_with(|o| o.device_id = Some(1)),
            "export-option",
        ),
        ("ros-noise", ExportOptions::default(), "noise-unknown"),
        ("kalibr", ExportOptions::default(), "noise-unknown"),
    ];
    let scales = [0.0, -1.0, f64::NAN].into_iter().flat_map(|bad| {
        let [mut accel, mut gyro] = [(); 2].map(|()| ExportOptions::default());
        accel.counts_per_g = Some(bad);
        gyro.counts_per_deg_s = Some(bad);
        [accel, gyro].map(|options| ("arduino", options, "export-option"))
    });
    for (target, options, code) in names.into_iter().chain(others).chain(scales) {
        let error = export_to(&in_g(), target, &options).unwrap_err();
        assert_eq!(error.code(), code, "{target} {options:?}");
    }
}

#[test]
fn counts_of_unknown_scale_go_only_where_counts_are_taken() {
    let mut file = in_counts();
    file.accelerometer.nominal_scale = None;
    for target in &TARGETS {
        let result = export(&file, target, &ExportOptions::default());
        let code = result.as_ref().err().map(|e| e.code());
        let wanted = match target.name {
            "ros" | "ros2" | "px4" | "ardupilot" => Some("export-unit"),
            "kalibr" | "ros-noise" => Some("noise-unknown"),
            _ => None,
        };
        assert_eq!(code, wanted, "{}", target.name);
    }
}

#[test]
fn what_a_target_cannot_hold_is_said_and_a_text_from_outside_stays_in_its_comment() {
    let mut file = in_g();
    file.sensor.id = Some("*/ int x; /* \\\nimport os\n# ö $name$".to_owned());
    for target in &TARGETS {
        let Ok(result) = export(&file, target, &ExportOptions::default()) else {
            continue;
        };
        let said = result.notes.join(" ");
        let loses = target.holds.contains("no gyroscope");
        assert_eq!(loses, said.contains("Without the gyroscope"));
        let loses = target.holds.contains("no cross-axis terms");
        assert_eq!(loses, said.contains("mg rms"), "{said}");
        if target.name != "gravical" {
            let text = result.text;
            assert!(!text.contains("*/ int") && !text.contains("\nimport os\n"));
            assert!(!text.contains(['\\', '$']), "{}", target.name);
        }
    }
}

#[test]
fn kalibr_reads_every_key_and_what_is_unknown_is_refused_or_a_limit() {
    let section = |k: Option<f64>| -> NoiseResult {
        let estimate = |value: f64| json!({ "value": value, "low": value, "high": value });
        let limit = json!({ "term": "K", "reason": "", "at_most": 2e-4 });
        let channel = |(i, name): (usize, &str)| {
            json!({ "channel": name, "unit": "", "adev": [], "n": estimate(1e-3 * (i + 1) as f64),
                "k": k.map(estimate), "not_observable": [limit] })
        };
        let channels = ["ax", "ay", "az", "gx", "gy", "gz"].into_iter().enumerate();
        let channels: Vec<_> = channels.map(channel).collect();
        let noise = json!({ "format": "", "tool": "", "inputs": [], "description": "",
            "rate_hz": 100.0, "recorded_s": 7200.0, "used_s": 7200.0, "static_intervals": 1,
            "segments": 1, "channels": channels, "findings": [] });
        serde_json::from_value(noise).unwrap()
    };
    let written = |noise: &NoiseResult, target: &str, upper_limit: bool| {
        let options = options_with(|o| o.upper_limit = upper_limit);
        export_noise(noise, Target::find(target).unwrap(), &options)
    };
    let kalibr = |noise: &NoiseResult, upper_limit| written(noise, "kalibr", upper_limit);
    // The random walk is not asked for; the variance of white noise is N² times the rate of 100 Hz.
    let ros = written(&section(None), "ros-noise", false).unwrap().text;
    let accel = "\nlinear_acceleration_covariance: [1.00000000e-4, 0.0, 0.0, 0.0, 4.00000000e-4, 0.0, 0.0, 0.0, 9.00000000e-4]\n";
    let gyro = "\nangular_velocity_covariance: [1.60000000e-3, 0.0,";
    assert!(ros.contains(accel) && ros.contains(gyro), "{ros}");
    let text = kalibr(&section(Some(1e-5)), false).unwrap().text;
    let keys = text.lines().filter(|l| !l.starts_with('#'));
    let keys: Vec<&str> = keys.map(|l| l.split("  #").next().unwrap()).collect();
    let expected = "rostopic: /imu0
update_rate: 100.0000
accelerometer_noise_density: 3.0000e-3
accelerometer_random_walk: 1.0000e-5
gyroscope_noise_density: 6.0000e-3
gyroscope_random_walk: 1.0000e-5";
    assert_eq!(keys.join("\n"), expected);
    let error = kalibr(&section(None), false).unwrap_err();
    assert_eq!(error.code(), "noise-unknown");
    assert_eq!(error.options(), [Advice::new("upper_limit", "true")]);
    let limited = kalibr(&section(None), true).unwrap();
    let limit = "2.0000e-4  # m/s^3/sqrt(Hz), upper limit";
    assert!(limited.text.contains(limit) && limited.notes.len() == 2);
    let mut without_gyro = section(Some(1e-5));
    without_gyro.channels.truncate(3);
    assert!(kalibr(&without_gyro, true).is_err());
}

#[test]
fn every_target_is_in_the_docs() {
    let docs = include_str!("../../../../docs/exports.md");
    let (_, table) = docs.split_once("\n## Targets\n").unwrap();
    let (table, rest) = table.split_once("\n## ").unwrap();
    for target in &TARGETS {
        let row = format!("\n| `{}` | ", target.name);
        assert!(table.contains(&row), "docs/exports.md forgets {row}");
        // What is a file of gravical or imucal is read by them.
        let is_read = ["gravical", "imucal"].contains(&target.name);
        let item = format!("\n- `{}`: ", target.name);
        assert!(is_read || rest.contains(&item), "how to load {item}");
    }
    let rows = table.lines().filter(|l| l.starts_with("| `"));
    assert_eq!(rows.count(), TARGETS.len(), "a target that is not there");
}
