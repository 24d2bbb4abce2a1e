//! Rows after those that are judged are read as all rows judged together.

use std::io::Cursor;

use gravical_recording::{Batch, Error, Later, ReadOptions, Recording, sniff};

use crate::support::*;

/// Channels and times of measurements, and those of them before which the recording breaks.
type Measured = (Vec<Vec<f64>>, Vec<usize>);

/// Reads the first rows to judge by, then the others.
fn read_in_two(
    header: &str,
    rows: &[String],
    first: usize,
) -> (Recording, Result<Measured, Error>) {
    let text = |rows: &[String]| format!("{header}\n{}\n", rows.join("\n"));
    let head = text(&rows[..first]);
    let format = sniff(&head, "", &ReadOptions::default()).unwrap();
    let batch =
        |text: String| -> Batch { format.batches(Cursor::new(text)).next().unwrap().unwrap() };
    let head = batch(head);
    let head_lines = head.lines.last().unwrap() - 1;
    let (recording, mut later) = Later::judge(&format, head).unwrap();
    let mut rest = batch(text(&rows[first..]));
    rest.lines.iter_mut().for_each(|line| *line += head_lines);
    let readings = later.read(&mut rest);
    let measured = readings.map(|readings| {
        let axes = readings.accel.iter().chain(readings.gyro.iter().flatten());
        let kept = |axis: &Vec<f64>| {
            let kept = axis.iter().zip(&readings.is_measured).filter(|(_, m)| **m);
            kept.map(|(v, _)| *v).collect()
        };
        let before = |row: &usize| readings.is_measured[..*row].iter().filter(|m| **m).count();
        let breaks = readings.breaks.iter().map(before).collect();
        (axes.chain(&readings.time_s).map(kept).collect(), breaks)
    });
    (recording, measured)
}

fn assert_reads_alike(header: &str, rows: &[String], first: usize) {
    let whole = read(&format!("{header}\n{}\n", rows.join("\n")), "");
    let (head, later) = read_in_two(header, rows, first);
    let (later, breaks) = later.unwrap();
    let channels = |r: &Recording| {
        let axes = r.accel.iter().chain(r.gyro.iter().flatten());
        axes.chain(&r.time_s).cloned().collect::<Vec<_>>()
    };
    for ((whole, head), later) in channels(&whole).iter().zip(channels(&head)).zip(&later) {
        let joined = [head, later.clone()].concat();
        assert_eq!(whole.len(), joined.len(), "{header}");
        let same = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-9;
        assert!(whole.iter().zip(&joined).all(same), "{header}");
    }
    assert!(!later[0].is_empty());
    let breaks = breaks.into_iter().map(|row| head.rows() + row);
    let joined: Vec<usize> = head.breaks.iter().copied().chain(breaks).collect();
    assert_eq!(whole.breaks, joined, "{header}");
}

/// Counts of a sensor on its six faces, at 16384 per g.
fn counts(of: impl Fn(usize, [i32; 6]) -> String) -> Vec<String> {
    let rows = six_faces(3).into_iter().enumerate();
    rows.map(|(i, row)| {
        let accel = row.accel_g.map(|v| (16_384.0 * v).round() as i32);
        let gyro = row.gyro_deg_s.map(|v| (131.0 * v).round() as i32);
        of(i, [accel[0], accel[1], accel[2], gyro[0], gyro[1], gyro[2]])
    })
    .collect()
}

fn joined(cells: &[i32]) -> String {
    let cells: Vec<String> = cells.iter().map(i32::to_string).collect();
    cells.join(",")
}

#[test]
fn later_rows_are_read_as_all_rows_together() {
    let header = "t_ms,ax,ay,az,gx,gy,gz";
    let unsigned = counts(|i, v| format!("{},{}", 40 * i, joined(&v.map(|v| v & 0xffff))));
    assert_reads_alike(header, &unsigned, 200);
    let shifted = counts(|i, v| {
        let accel = [v[0] / 4 + 32_768, v[1] / 4 + 32_768, v[2] / 4 + 32_768];
        format!("{},{}", 40 * i, joined(&accel))
    });
    assert_reads_alike("t_ms,ax,ay,az", &shifted, 200);
    let two_sensors =
        counts(|i, v| format!("{},0,{}\n{},1,5,6,7,1,2,3", 40 * i, joined(&v), 40 * i));
    assert_reads_alike("t_ms,I,ax,ay,az,gx,gy,gz", &two_sensors, 200);
    let slow = counts(|i, [x, y, z, ..]| match i % 3 {
        0 => format!("{},{x},{y},{z}", 40 * i),
        _ => format!("{},{x},{y},", 40 * i),
    });
    assert_reads_alike("t_ms,ax,ay,az", &slow, 200);
    let zeros = counts(|i, v| match i {
        120..130 | 250.. => format!("{},0,0,0,0,0,0", 40 * i),
        _ => format!("{},{}", 40 * i, joined(&v)),
    });
    assert_reads_alike(header, &zeros, 200);
    let hung = counts(|i, v| match i {
        220..250 => format!("{},5,6,16384,7,8,9", 40 * i),
        _ => format!("{},{}", 40 * i, joined(&v)),
    });
    assert_reads_alike(header, &hung, 200);
}

#[test]
fn a_run_of_zeros_goes_on_in_the_next_batch() {
    let rows = counts(|i, v| match i {
        198..203 => format!("{},0,0,0,1,2,3", 40 * i),
        _ => format!("{},{}", 40 * i, joined(&v)),
    });
    let (_, later) = read_in_two("t_ms,ax,ay,az,gx,gy,gz", &rows, 200);
    let accel_x = &later.unwrap().0[0];
    assert!(accel_x[..3].iter().all(|v| v.is_nan()) && accel_x[3].is_finite());
}

#[test]
fn rows_that_cannot_be_read_alike_end_the_reading() {
    let refused = |header: &str, rows: Vec<String>| {
        let (head, later) = read_in_two(header, &rows, 200);
        let contradiction = later.unwrap_err();
        let line = contradiction.location().unwrap().line.unwrap();
        (line - head.ledger.lines as u64, contradiction.code())
    };
    let header = "t_ms,ax,ay,az,gx,gy,gz";
    let unsigned_then_signed = counts(|i, v| {
        let cells = if i < 200 { v.map(|v| v & 0xffff) } else { v };
        format!("{},{}", 40 * i, joined(&cells))
    });
    assert_eq!(
        refused(header, unsigned_then_signed),
        (1, "encoding-changed")
    );
    // One byte of the bus is lost: each channel holds what the one before it held.
    let slipped = counts(|i, mut v| {
        if i >= 230 {
            v.rotate_right(1);
        }
        format!("{},{}", 40 * i, joined(&v))
    });
    assert_eq!(refused(header, slipped), (31, "shifted-columns"));
    let other_sensor = counts(|i, v| match i {
        0..200 => format!("{},0,{}\n{},1,5,6,7,1,2,3", 40 * i, joined(&v), 40 * i),
        _ => format!("{},1,5,6,7,1,2,3", 40 * i),
    });
    let header_of_two = "t_ms,I,ax,ay,az,gx,gy,gz";
    let ended = read_in_two(header_of_two, &other_sensor, 200)
        .1
        .unwrap_err();
    assert!(ended.message().contains("no row in the next 100 rows"));
    assert_eq!(refused(header_of_two, other_sensor), (1, "sensor-ended"));
    let pose = &six_faces(3)[..FACE_ROWS];
    let other_unit: Vec<String> = (0..400)
        .map(|i| {
            let unit = if i < 230 { 1.0 } else { 9.80665 };
            let a = pose[i % FACE_ROWS].accel_g.map(|v| unit * v);
            format!("{},{:.4},{:.4},{:.4}", 40 * i, a[0], a[1], a[2])
        })
        .collect();
    assert_eq!(refused("t_ms,ax,ay,az", other_unit), (31, "unit-changed"));
}

#[test]
fn what_later_rows_lack_is_told_and_steps_stay_steps() {
    let row = |i: usize| {
        let step = if i < 2000 { 39 + i % 3 } else { 40 };
        let y = if i == 3000 {
            String::new()
        } else {
            (i % 5).to_string()
        };
        format!("{step},{},{y},{}", i % 7, 16_384 - (i % 3) as i32)
    };
    let text = |rows: std::ops::Range<usize>| {
        let rows: Vec<String> = rows.map(row).collect();
        format!("t_ms,ax,ay,az\n{}\n", rows.join("\n"))
    };
    let head = text(0..2000);
    let format = sniff(&head, "", &ReadOptions::default()).unwrap();
    let batch = |text: String| format.batches(Cursor::new(text)).next().unwrap().unwrap();
    let (_, mut later) = Later::judge(&format, batch(head)).unwrap();
    let mut rest = batch(text(2000..6000) + "1,2\n");
    rest.lines.iter_mut().for_each(|line| *line += 2000);
    let readings = later.read(&mut rest).unwrap();
    assert!(is_near(readings.time_s.unwrap()[3999], 240.0, 0.1));
    let (ledger, findings) = later.finish();
    let kinds: Vec<&str> = findings.iter().map(|f| f.kind.name()).collect();
    assert_eq!(kinds, ["empty-cells", "torn-line"]);
    assert_eq!(ledger.total(), 2);
}

#[test]
fn the_clock_goes_on_while_rows_have_no_stamps() {
    let batch = |rows: std::ops::Range<usize>, is_stamped: bool| {
        let rows = rows.map(|i| {
            let stamp = if is_stamped {
                (40 * i).to_string()
            } else {
                String::new()
            };
            format!("{stamp},{},{},{}", i % 7, i % 5, 16_384 - (i % 3) as i32)
        });
        let rows: Vec<String> = rows.collect();
        format!("t_ms,ax,ay,az\n{}\n", rows.join("\n"))
    };
    let head = batch(0..2000, true);
    let format = sniff(&head, "", &ReadOptions::default()).unwrap();
    let rows = |first: u32, text: String| {
        let mut batch = format.batches(Cursor::new(text)).next().unwrap().unwrap();
        batch.lines.iter_mut().for_each(|line| *line += first);
        batch
    };
    let (_, mut later) = Later::judge(&format, rows(0, head)).unwrap();
    for unstamped in [2000..5000, 5000..8000] {
        let first = unstamped.start as u32;
        later
            .read(&mut rows(first, batch(unstamped, false)))
            .unwrap();
    }
    let readings = later
        .read(&mut rows(8000, batch(8000..9000, true)))
        .unwrap();
    let time_s = readings.time_s.unwrap();
    assert!(is_near(time_s[0], 320.0, 1e-6), "{}", time_s[0]);
    assert!(is_near(time_s[999], 359.96, 1e-6), "{}", time_s[999]);
}
