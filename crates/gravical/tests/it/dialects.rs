//! Text formats that the harness of writings does not draw.

use gravical::recording::{ReadOptions, Recording, parse_columns};

use crate::support::*;

const ROWS: usize = 300;

fn text() -> String {
    report_lines(HEADER, ROWS).join("\n") + "\n"
}

/// Checks that the bytes are read as the plain file, with `how` in the description.
fn reads_alike(bytes: &[u8], how: &str) -> Recording {
    let plain = read(text().as_bytes());
    let recording = read(bytes);
    assert_eq!(recording.accel, plain.accel);
    assert_eq!(recording.gyro, plain.gyro);
    assert_eq!(recording.temperature_c, plain.temperature_c);
    assert_eq!(recording.time_s, plain.time_s);
    assert!(
        recording.description.contains(how),
        "{how} in {}",
        recording.description
    );
    recording
}

#[test]
fn an_unnamed_index_column_does_not_shift_the_channels() {
    // R's write.table and pandas write no name for the index.
    let mut lines = text()
        .lines()
        .map(str::to_owned)
        .collect::<Vec<_>>()
        .into_iter();
    let header = lines.next().unwrap();
    let rows: Vec<String> = lines.enumerate().map(|(i, l)| format!("{i},{l}")).collect();
    for header in [format!(",{header}"), header] {
        reads_alike(
            format!("{header}\n{}\n", rows.join("\n")).as_bytes(),
            "comma",
        );
    }
}

#[test]
fn columns_by_name_and_in_order() {
    let plain = read(text().as_bytes());
    let by_name = |spec: &str| ReadOptions {
        columns: Some(parse_columns(spec).unwrap()),
        ..ReadOptions::default()
    };
    // x and y are swapped by name; other columns are assigned automatically.
    let given = read_with(
        text().as_bytes(),
        &by_name("ax=aY (m/s^2),ay=aX (m/s^2),temp=-"),
    );
    assert_eq!(given.accel[0], plain.accel[1]);
    assert_eq!(given.accel[1], plain.accel[0]);
    assert_eq!(given.accel[2], plain.accel[2]);
    assert_eq!((&given.gyro, &given.time_s), (&plain.gyro, &plain.time_s));
    assert!(given.temperature_c.is_none());
    let given = read_with(text().as_bytes(), &by_name("gx=-,gy=-,gz=-"));
    assert!(given.gyro.is_none() && given.temperature_c.is_some());
    let given = read_with(text().as_bytes(), &by_name("_,ay,ax,az,-"));
    assert_eq!(given.accel[0], plain.accel[1]);
    assert_eq!((&given.gyro, &given.time_s), (&plain.gyro, &plain.time_s));
    assert!(given.temperature_c.is_none());
}

#[test]
fn one_of_two_sensors_in_two_header_rows_can_be_chosen() {
    let mut text =
        "sensor,left,left,left,right,right,right\naxis,acc_x,acc_y,acc_z,acc_x,acc_y,acc_z\n"
            .to_owned();
    for i in 0..100 {
        let n = f64::from(i % 5) * 0.01;
        text.push_str(&format!("{i},0.1,{n},9.8,9.7,0.2,{n}\n"));
    }
    let first = read(text.as_bytes());
    finding(&first, "several-sensors");
    close(accel_means(&first)[2], 9.8, 1e-9);
    let spec = "ax=right.acc_x,ay=right.acc_y,az=right.acc_z";
    for options in [
        ReadOptions {
            columns: Some(parse_columns(spec).unwrap()),
            ..ReadOptions::default()
        },
        ReadOptions {
            sensor: Some("right".to_owned()),
            ..ReadOptions::default()
        },
    ] {
        let given = read_with(text.as_bytes(), &options);
        close(accel_means(&given)[0], 9.7, 1e-9);
        assert!(!kinds(&given).contains(&"several-sensors"));
    }
}
