//! A gyroscope in a separate file.

use gravical::Error;
use gravical::recording::source::Named;
use gravical::recording::{ReadOptions, Recording, join_gyroscope};

use crate::support::*;

/// `rows` samples at 100 Hz from `from_s` on, four columns without a header.
fn four_columns(from_s: f64, rows: usize, values: impl Fn(f64) -> [f64; 3]) -> String {
    let row = |i: usize| {
        let t = from_s + 0.01 * i as f64;
        let [x, y, z] = values(t);
        format!("{t:.4} {x:.4} {y:.4} {z:.4}\n")
    };
    (0..rows).map(row).collect()
}

fn gravity(_: f64) -> [f64; 3] {
    [0.1, -0.2, 9.8]
}

/// A rate for which linear interpolation is exact.
fn ramp(t: f64) -> [f64; 3] {
    [t, -2.0 * t, 10.0 + t]
}

fn accel(from_s: f64, rows: usize) -> Recording {
    read(four_columns(from_s, rows, gravity).as_bytes())
}

fn join(recording: &mut Recording, gyro: &str) -> Result<(), Error> {
    let options = ReadOptions::default();
    join_gyroscope(
        recording,
        Named::Bytes("gyro.txt".as_ref(), gyro.as_bytes()),
        &options,
    )
}

fn rates(recording: &Recording) -> &[Vec<f64>; 3] {
    recording.gyro.as_ref().unwrap()
}

#[test]
fn an_offset_between_the_files_is_preserved() {
    // The gyroscope starts 0.5 s later, between the stamps, and ends earlier.
    let mut recording = accel(5.0, 300);
    join(&mut recording, &four_columns(5.504, 200, ramp)).unwrap();
    let gyro = rates(&recording);
    for row in 0..300 {
        let t = 5.0 + 0.01 * row as f64;
        let covered = (5.504..=7.494).contains(&t);
        assert_eq!(gyro[0][row].is_finite(), covered, "{t}");
        if covered {
            // The file has four decimals.
            close(gyro[0][row], t, 1e-4);
            close(gyro[2][row], 10.0 + t, 1e-4);
        }
    }
    let uncovered = finding(&recording, "gyro-uncovered");
    // 5.00 to 5.50 and 7.50 to 7.99.
    assert_eq!(uncovered.lines, [[1, 51], [251, 300]]);
    assert_eq!(uncovered.count, 101);
    assert!(uncovered.message.contains("33.7 %"), "{uncovered:?}");
}

#[test]
fn gaps_are_not_interpolated() {
    let mut recording = accel(0.01, 300);
    let text = four_columns(0.01, 300, ramp);
    // 100 samples are missing, and also three single ones.
    let is_kept = |i: &usize| !(100..200).contains(i) && ![20, 40, 41, 42].contains(i);
    let lines = text.split_inclusive('\n').enumerate();
    let kept = lines.filter(|(i, _)| is_kept(i)).map(|(_, line)| line);
    join(&mut recording, &kept.collect::<String>()).unwrap();
    let gyro = rates(&recording);
    let empty: Vec<usize> = (0..300).filter(|&i| gyro[0][i].is_nan()).collect();
    assert_eq!(empty, (100..200).collect::<Vec<_>>());
    close(gyro[0][20], 0.21, 1e-4);
    close(gyro[0][41], 0.42, 1e-4);
}

#[test]
fn files_without_stamps_are_joined_row_by_row() {
    let without = || read(b"ax,ay,az\n0,0,9.8\n0,0,9.7\n0,0.1,9.8\n");
    let mut recording = without();
    join(&mut recording, "1 2 3\n2 3 4\n3 4 6\n").unwrap();
    assert_eq!(rates(&recording)[0], [1.0, 2.0, 3.0]);
    finding(&recording, "gyro-row-by-row");
    let error = join(&mut without(), "1 2 3\n2 3 4\n").unwrap_err();
    assert_eq!(error.code(), "gyro-length");
}

#[test]
fn files_that_cannot_be_joined_are_errors() {
    let reset = four_columns(5.0, 60, ramp) + &four_columns(0.0, 60, ramp);
    let dated = "date,time,ax,ay,az\n".to_owned() + &"1/2/2024,12:00:00,1,2,3\n".repeat(9);
    for (text, code) in [
        (&*four_columns(500.0, 100, ramp), "gyro-overlap"),
        ("t,ax,ay,az\n1,2,3,4\n2,2,3,4\n", "no-gyroscope"),
        (&*dated, "no-gyroscope"),
        ("t,a,b,c\n1,2,3,4\n2,2,3,4\n", "no-gyroscope"),
        ("3 2 3 4\n2 2 3 4\n2 2 3 4\n", "no-gyroscope"),
        (&*four_columns(5.0, 100, |_| [0.0; 3]), "all-zero"),
        (&*reset, "gyro-restart"),
    ] {
        let mut recording = accel(5.0, 100);
        let error = join(&mut recording, text).unwrap_err();
        assert_eq!(error.code(), code);
        assert!(error.hint().is_some(), "{error}");
        assert!(recording.gyro.is_none() && recording.gyro_file.is_none());
    }
    let mut both = read(b"ax,ay,az,gx,gy,gz\n0,0,9.8,1,2,3\n0,0,9.7,1,2,4\n");
    let error = join(&mut both, "1 2 3\n2 3 4\n").unwrap_err();
    assert_eq!(error.code(), "gyro-twice");
}
