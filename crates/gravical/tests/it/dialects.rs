//! Text formats that the harness of writings does not draw.

use gravical::recording::parse_columns;

use crate::support::*;

const ROWS: usize = 300;

fn text() -> String {
    report_lines(HEADER, ROWS).join("\n") + "\n"
}

#[test]
fn an_unnamed_index_column_does_not_shift_the_channels() {
    // R's write.table and pandas write no name for the index.
    let plain = read(text().as_bytes());
    let rows = report_lines(HEADER, ROWS).into_iter().skip(1).enumerate();
    let rows: String = rows.map(|(i, row)| format!("{i},{row}\n")).collect();
    for header in [format!(",{HEADER}"), HEADER.to_owned()] {
        let recording = read(format!("{header}\n{rows}").as_bytes());
        assert_eq!(
            (&recording.accel, &recording.gyro),
            (&plain.accel, &plain.gyro)
        );
        assert_eq!(recording.temperature_c, plain.temperature_c);
        assert_eq!(recording.time_s, plain.time_s);
    }
}

#[test]
fn columns_by_name_and_in_order() {
    let plain = read(text().as_bytes());
    let by_name = |spec: &str| read_options(|o| o.columns = Some(parse_columns(spec).unwrap()));
    // x and y are swapped by name; other columns are assigned automatically.
    let [x, y, z] = &plain.accel;
    for spec in ["ax=aY (m/s^2),ay=aX (m/s^2),temp=-", "_,ay,ax,az,-"] {
        let given = read_with(text().as_bytes(), &by_name(spec));
        assert_eq!(given.accel.each_ref(), [y, x, z], "{spec}");
        assert_eq!((&given.gyro, &given.time_s), (&plain.gyro, &plain.time_s));
        assert!(given.temperature_c.is_none());
    }
    let given = read_with(text().as_bytes(), &by_name("gx=-,gy=-,gz=-"));
    assert!(given.gyro.is_none() && given.temperature_c.is_some());
}
