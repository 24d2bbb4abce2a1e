//! A calibration on the board: the sketch with an exported header, and what the header's functions
//! cost.
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

#[path = "../board/mod.rs"]
mod board;
mod cost;
#[path = "../../../../tests/support/calibration.rs"]
#[allow(dead_code)] // the tests of the library use more of it
mod made;

use std::path::{Path, PathBuf};
use std::process::Command;

use board::{at_rest, build_with, notices, on, rows};
use gravical::calibration_file::Calibration;
use gravical::export::{ExportOptions, Target, export};
use gravical::recording::{AccelUnit, BoardSettings, GyroUnit, ReadOptions, read_bytes};
use made::G;
use virtual_board::sensor::Reading;

const LSB_PER_G: f64 = 16384.0;
const LSB_PER_DEG_S: f64 = 65.5;

fn calibration() -> Calibration {
    made::in_counts(LSB_PER_G, LSB_PER_DEG_S)
}

/// The header of a sketch for a range of the accelerometer.
fn header(file: &Calibration, counts_per_g: Option<f64>) -> String {
    let options = ExportOptions {
        counts_per_g,
        counts_per_deg_s: counts_per_g.map(|_| LSB_PER_DEG_S),
        ..ExportOptions::default()
    };
    let target = Target::find("arduino").unwrap();
    export(file, target, &options).unwrap().text
}

/// An empty folder of this test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The sketch with a header of the calibration; none without a compiler.
fn firmware(name: &str) -> Option<PathBuf> {
    let folder = folder(name);
    let path = folder.join("mysensor.h");
    std::fs::write(&path, header(&calibration(), Some(LSB_PER_G))).unwrap();
    build_with(&folder, Some(&path)).map(|(elf, said)| {
        eprintln!("{}", said.trim());
        elf
    })
}

/// Flat on the table for a second, with the noise by which it is no sensor that hung, then through both
/// ranges to their ends.
fn sweep(time_s: f64) -> Reading {
    let s = time_s - 1.0;
    if s < 0.0 {
        let noise = 2e-3 * (1e4 * time_s).sin();
        return Reading {
            accel_mps2: [noise, 0.0, G],
            ..Reading::default()
        };
    }
    let swing = |amplitude: f64, hz: f64| amplitude * (std::f64::consts::TAU * hz * s).sin();
    Reading {
        accel_mps2: [(2.1, 0.31), (-1.9, 0.43), (1.5, 0.57)].map(|(g, hz)| swing(g * G, hz)),
        gyro_deg_s: [swing(520.0, 0.37), swing(-480.0, 0.53), swing(300.0, 0.71)],
        temperature_c: 25.0 + 0.1 * s,
    }
}

/// Counts of both sensors.
fn counts(reading: &Reading) -> [[f64; 3]; 2] {
    let count = |v: f64| v.round().clamp(-32768.0, 32767.0);
    [
        reading.accel_mps2.map(|v| count(v / G * LSB_PER_G)),
        reading.gyro_deg_s.map(|v| count(v * LSB_PER_DEG_S)),
    ]
}

#[test]
fn board_and_host_calibrate_alike() {
    let file = calibration();
    let Some(elf) = firmware("calibrated") else {
        return;
    };
    let mut board = on(&elf, sweep);
    let text = board.text(12.0);
    let text = &text[..=text.rfind('\n').unwrap()];

    let sent = rows(text);
    assert!(sent.len() > 1100, "{}", sent.len());
    let accelerometer = file.accelerometer_calibration();
    let gyroscope = file.gyroscope_calibration().unwrap();
    let calibrated = |reading: &Reading| -> [[f64; 3]; 2] {
        let [accel, gyro] = counts(reading);
        let force = accelerometer.apply(accel);
        [force, gyroscope.apply(gyro, force)]
    };
    let host: Vec<[[f64; 3]; 2]> = board.fed.borrow().iter().map(calibrated).collect();
    // The first samples may have been ready before the settings were said. Where the swing is
    // fast, one sample off would be a hundred times the tolerance.
    let off = |first: usize| -> f64 {
        let pairs = sent.iter().zip(&host[first..]);
        let apart = pairs.map(|(b, [h, _])| (b[1] - h[0]).abs());
        apart.fold(0.0, f64::max)
    };
    let first = (0..8).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
    let (mut accel, mut gyro) = (0.0_f64, 0.0_f64);
    let mut largest = 0.0_f64;
    for (board, [force, rate]) in sent.iter().zip(&host[first..]) {
        let norm = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let apart = norm([0, 1, 2].map(|i| board[1 + i] - force[i]));
        // Near free fall the last digit of the board's text is more than that.
        accel = accel.max(apart / norm(*force).max(0.5 * G));
        largest = largest.max(norm(*force));
        let off = [0, 1, 2].map(|i| (board[5 + i] - rate[i]).abs());
        gyro = off.into_iter().fold(gyro, f64::max);
    }
    eprintln!("board and host: {accel:.1e} of ||a||, {gyro:.1e} rad/s, up to {largest:.1} m/s^2");
    assert!(largest > 2.5 * G);
    assert!(accel < 1e-5, "{accel}");
    // 10⁻⁵ of ±500 °/s.
    assert!(gyro < 1e-5 * 500_f64.to_radians(), "{gyro}");
}

#[test]
fn the_reader_knows_that_the_board_calibrated() {
    let Some(elf) = firmware("calibrated-at-rest") else {
        return;
    };
    let mut board = on(&elf, at_rest());
    let text = board.text(6.0);
    let text = &text[..=text.rfind('\n').unwrap()];
    let said = notices(text);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains(", format 3, calibrated 20"), "{said:?}");
    let settings = BoardSettings::parse(said[0]).unwrap();
    assert!(settings.is_calibrated() && !settings.is_counts());
    let recording = read_bytes(text.as_bytes(), "board.csv", &ReadOptions::default()).unwrap();
    assert!(recording.format.is_calibrated() && recording.format.is_calibrated_by_board());
    assert_eq!(recording.units.accel.unit, AccelUnit::MetrePerSecondSquared);
    let gyro = recording.units.gyro.unwrap();
    assert_eq!(gyro.unit, GyroUnit::RadianPerSecond);
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
}

#[test]
fn raw_values_are_still_sent_and_other_ranges_are_not_calibrated() {
    let Some(elf) = firmware("calibrated-commands") else {
        return;
    };
    let mut board = on(&elf, |_| Reading::default());
    board.text(0.5);
    let mut say = |command: &str| board.say(command, 0.8);
    let refused = "# no calibration for this range: raw values, f0 f1, have all ranges";
    assert_eq!(notices(&say("a4\n")), [refused]);
    // Nothing has changed.
    assert!(say("?\n").contains("accelerometer +-2 g, gyroscope +-500 deg/s"));
    let raw = say("f1\n");
    let raw = rows(raw.rsplit_once("gz\n").unwrap().1);
    assert_eq!(raw[0][1..4], [0.0, 0.0, 16384.0]);
    assert!(say("a4\n").contains("accelerometer +-4 g"));
    assert!(say("f3\n").contains("# no calibration for this range"));
    assert!(say("a2\n").contains("accelerometer +-2 g"));
    assert!(say("f3\n").contains("format 3, calibrated "));

    // A sketch without a calibration says so.
    let mut board = board::board(&[]).unwrap();
    board.text(0.5);
    let text = board.say("f3\n", 0.5);
    assert_eq!(notices(&text), ["# no calibration in this sketch: f0 f1"]);
    assert!(rows(text.split_once('\n').unwrap().1).len() > 30);
}

/// What the compiler says of a header that is not for the sketch.
#[test]
fn a_header_for_other_values_is_refused_with_what_to_do() {
    if Command::new("avr-gcc").arg("--version").output().is_err() {
        eprintln!("skipped: no avr-gcc");
        return;
    }
    let range = "ACCEL_RANGE_G is not the range of the header";
    for (name, counts_per_g, what_to_do) in [
        ("other-range", Some(8192.0), range),
        ("no-counts", None, "with --counts-per-g 16384"),
    ] {
        let folder = folder(name);
        let path = folder.join("mysensor.h");
        std::fs::write(&path, header(&calibration(), counts_per_g)).unwrap();
        let said = board::build_refused(&folder, &path);
        assert!(said.contains(what_to_do), "{said}");
    }
}
