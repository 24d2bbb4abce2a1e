//! Cells without a value.

use std::fmt::Write as _;

use gravical::recording::TimeUnit;

use crate::support::*;

#[test]
fn impossible_temperatures_are_empty_cells() {
    // Steps of 500: 4000 rows in 2 s, if they are microseconds, which 3300 °C would exclude.
    let text = |driver: &str| {
        let mut text = "t,ax,ay,az,temp (C)\n".to_owned();
        for i in 0..4000 {
            let t_c = match i {
                1000 => driver.to_owned(),
                _ => format!("25.{}", i % 3),
            };
            writeln!(text, "{},0.0{},0.1,9.8{},{t_c}", 500 * i, i % 7, i % 5).unwrap();
        }
        text
    };
    for driver in ["-3276.80", "-999", "1e9"] {
        let recording = read(text(driver).as_bytes());
        assert_eq!(recording.timing.unit, Some(TimeUnit::Microsecond));
        let temperatures = recording.temperature_c.as_ref().unwrap();
        assert!(temperatures[1000].is_nan() && temperatures[1001] == 25.2);
        let empty = finding(&recording, "empty-cells");
        assert_eq!((empty.count, &empty.lines[..]), (1, &[[1002, 1002]][..]));
        assert!(empty.message.contains("1 of them outside -60 to 150 °C"));
    }
    let empty = read(text("").as_bytes());
    assert!(!finding(&empty, "empty-cells").message.contains("outside"));
}

#[test]
fn a_missing_sensor_number_does_not_mix_two_sensors() {
    let mut text = "t_ms,I,AccX,AccY,AccZ\n".to_owned();
    for i in 0..200 {
        for sensor in 0..2 {
            let number = match (i, sensor) {
                (50, 1) => String::new(),
                _ => sensor.to_string(),
            };
            let z = 9.8 + 0.1 * f64::from(sensor) + 0.001 * f64::from(i % 5);
            writeln!(text, "{},{number},0.1,0.2,{z:.3}", 10 * i).unwrap();
        }
    }
    let recording = read(text.as_bytes());
    finding(&recording, "several-sensors");
    assert_eq!(finding(&recording, "other-sensor").count, 200);
    assert!(recording.accel[2].iter().all(|z| *z < 9.85));
}

#[test]
fn a_sparse_file_may_write_null() {
    for word in ["", "nan", "null", "NA", "-"] {
        let mut text = "t_ms,ax,ay,az,gx,gy,gz,temp\n".to_owned();
        for i in 0..200 {
            let values = ["0.1", "0.2", "9.8", "0.01", "0.02", "0.03", "25.1"];
            let cell = |channel: usize| match i % 7 == channel {
                true => values[channel],
                false => word,
            };
            let cells: Vec<&str> = (0..7).map(cell).collect();
            writeln!(text, "{},{}", 10 * i, cells.join(",")).unwrap();
        }
        let recording = read(text.as_bytes());
        assert_eq!(recording.rows(), 200, "{word}");
    }
}
