//! Every defect that real recordings have, one at a time: it is named, with its
//! lines, every line is accounted for, and the mean does not suffer.

use gravical::inspect::inspect;
use gravical::recording::{AccelUnit, Aside, GyroUnit, ReadOptions, Recording, Severity, TimeUnit};
use gravical::segment::face::AxisMap;
use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate, write};

use crate::support::*;

const ROWS: usize = 600;

fn lines() -> Vec<String> {
    report_lines(HEADER, ROWS)
}

fn joined(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

/// The undamaged recording, and that it is clean.
fn clean() -> Recording {
    let recording = read(&joined(&lines()));
    assert_eq!(recording.rows(), ROWS);
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
    recording
}

/// All rows survived as they were.
fn unharmed(recording: &Recording) {
    let clean = clean();
    assert_eq!(recording.accel, clean.accel);
    assert_eq!(recording.gyro, clean.gyro);
}

/// Rows were lost, the mean moved by less than a fifth of the noise of a row.
fn nearly_unharmed(recording: &Recording) {
    let clean = accel_means(&clean());
    for (got, want) in accel_means(recording).into_iter().zip(clean) {
        close(got, want, 0.006);
    }
}

#[test]
fn latin_1_header_is_read_and_named() {
    let mut bytes = Vec::new();
    let header = HEADER.replace("rad/s", "°/s");
    for c in header.chars() {
        bytes.push(u8::try_from(c).unwrap());
    }
    bytes.push(b'\n');
    bytes.extend(joined(&lines()[1..]));
    let recording = read(&bytes);
    assert_eq!(finding(&recording, "not-utf8").lines, [[1, 1]]);
    assert_eq!(
        recording.gyro_scale.unwrap().unit,
        GyroUnit::DegreePerSecond
    );
    unharmed(&recording);
}

#[test]
fn nul_bytes_before_the_header_are_taken_out() {
    let mut bytes = vec![0; 37];
    bytes.extend(joined(&lines()));
    let recording = read(&bytes);
    assert_eq!(finding(&recording, "nul-bytes").lines, [[1, 1]]);
    unharmed(&recording);
}

#[test]
fn nul_bytes_among_the_rows_are_taken_out() {
    let mut lines = lines();
    lines[40] = format!("\0\0{}", lines[40]);
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "nul-bytes").lines, [[41, 41]]);
    unharmed(&recording);
}

#[test]
fn repeated_headers_are_breaks_not_rows() {
    let mut lines = lines();
    lines.insert(201, HEADER.to_owned());
    lines.insert(402, HEADER.to_owned());
    let recording = read(&joined(&lines));
    let found = finding(&recording, "repeated-header");
    assert_eq!(found.lines, [[202, 202], [403, 403]]);
    assert_eq!(found.severity, Severity::Warning);
    assert_eq!(recording.breaks, [200, 400]);
    unharmed(&recording);
}

#[test]
fn blank_rows_are_breaks() {
    let mut lines = lines();
    for blank in ["", ",,,,,,,", "   "] {
        lines.insert(301, blank.to_owned());
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "blank-rows").lines, [[302, 304]]);
    assert_eq!(recording.breaks, [300]);
    assert_eq!(recording.line(299), 301);
    assert_eq!(recording.line(300), 305);
    unharmed(&recording);
}

#[test]
fn metadata_before_the_header_are_kept_apart() {
    let mut all = vec![
        "Device: MPU6050 on a board".to_owned(),
        "Firmware,1.3".to_owned(),
        String::new(),
    ];
    all.extend(lines());
    let recording = read(&joined(&all));
    assert_eq!(finding(&recording, "metadata-lines").count, 2);
    assert_eq!(recording.ledger.lines_aside(Aside::Blank).count(), 1);
    unharmed(&recording);
}

#[test]
fn comments_among_the_rows_are_kept_apart() {
    let mut lines = lines();
    lines.insert(100, "# the cat walked by".to_owned());
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "comment-lines").lines, [[101, 101]]);
    unharmed(&recording);
}

#[test]
fn a_named_gap_is_a_break_that_says_why() {
    let mut lines = lines();
    lines.insert(
        301,
        "# gap: unplugged: 12 rows are missing, 0.1 s".to_owned(),
    );
    let recording = read(&joined(&lines));
    let gap = finding(&recording, "named-gap");
    assert_eq!((gap.lines.as_slice(), gap.count), (&[[302, 302]][..], 1));
    assert!(
        gap.message.contains("unplugged: 12 rows"),
        "{}",
        gap.message
    );
    assert_eq!(recording.findings.len(), 1);
    assert_eq!(recording.breaks, [300]);
    unharmed(&recording);
}

#[test]
fn without_a_header_the_numbers_tell_the_columns() {
    let recording = read(&joined(&lines()[1..]));
    let found = finding(&recording, "columns-guessed");
    assert!(
        found.message.contains("t,ax,ay,az,temp,gx,gy,gz"),
        "{}",
        found.message
    );
    assert_eq!(recording.accel_scale.unit, AccelUnit::MetrePerSecondSquared);
    unharmed(&recording);
}

#[test]
fn gyro_columns_first_are_not_taken_for_acceleration() {
    let clean = clean();
    let gyro = clean.gyro.as_ref().unwrap();
    for header in ["gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z\n", ""] {
        let mut text = header.to_owned();
        for row in 0..ROWS {
            let a = clean.accel_at(row);
            let g: [f64; 3] = std::array::from_fn(|i| gyro[i][row]);
            text.push_str(&format!(
                "{},{},{},{},{},{}\n",
                g[0], g[1], g[2], a[0], a[1], a[2]
            ));
        }
        unharmed(&read(text.as_bytes()));
    }
}

#[test]
fn empty_cells_are_counted_and_left_out_of_means() {
    let mut lines = lines();
    for at in [50, 51, 52] {
        let mut cells: Vec<&str> = lines[at].split(',').collect();
        cells[3] = "";
        lines[at] = cells.join(",");
    }
    lines[60] = lines[60]
        .split(',')
        .enumerate()
        .map(|(i, c)| if i == 1 { "NaN" } else { c })
        .collect::<Vec<_>>()
        .join(",");
    let recording = read(&joined(&lines));
    let found = finding(&recording, "empty-cells");
    assert_eq!(found.count, 4);
    assert!(found.message.contains("az 3"), "{}", found.message);
    assert_eq!(recording.rows(), ROWS);
    assert!(recording.accel[2][49].is_nan() && recording.accel[0][59].is_nan());
    nearly_unharmed(&recording);
}

/// Replaces the stamps by `stamp(row)`.
fn stamped(stamp: impl Fn(usize) -> String) -> Vec<u8> {
    let mut lines = lines();
    for (row, line) in lines.iter_mut().skip(1).enumerate() {
        let rest = line.split_once(',').unwrap().1;
        *line = format!("{},{rest}", stamp(row));
    }
    joined(&lines)
}

#[test]
fn repeated_stamps_are_named_and_their_rows_kept() {
    let recording = read(&stamped(|row| match row {
        100 => "990".to_owned(),
        300 | 301 => "2990".to_owned(),
        _ => (10 * row).to_string(),
    }));
    let found = finding(&recording, "duplicate-time");
    assert_eq!(found.lines, [[102, 102], [302, 303]]);
    assert_eq!(found.count, 3);
    close(recording.timing.mean_rate_hz.unwrap(), 100.0, 0.5);
    unharmed(&recording);
}

#[test]
fn backward_stamps_are_named() {
    let recording = read(&stamped(|row| {
        let t = if row == 250 { 10 * row - 35 } else { 10 * row };
        t.to_string()
    }));
    assert_eq!(finding(&recording, "backward-time").lines, [[252, 252]]);
    close(recording.timing.rate_hz().unwrap(), 100.0, 0.5);
    unharmed(&recording);
}

#[test]
fn bursts_are_times_of_arrival() {
    let recording = read(&stamped(|row| (100 * (row / 10)).to_string()));
    finding(&recording, "burst-time");
    close(recording.timing.rate_hz().unwrap(), 100.0, 2.0);
    let t = recording.time_s.as_ref().unwrap();
    assert!(t.windows(2).all(|w| w[1] > w[0]));
    unharmed(&recording);
}

#[test]
fn a_wrapped_counter_is_unwrapped() {
    for (unit, step) in [("ms", 10_u64), ("us", 10_000)] {
        let start = (1_u64 << 32) - 200 * step;
        let bytes = stamped(|row| ((start + row as u64 * step) % (1 << 32)).to_string());
        let text = String::from_utf8(bytes).unwrap();
        let recording = read(text.replace("(ms)", &format!("({unit})")).as_bytes());
        assert_eq!(
            finding(&recording, "wrapped-time").lines,
            [[202, 202]],
            "{unit}"
        );
        close(recording.timing.duration_s.unwrap(), 5.99, 1e-6);
        assert!(recording.breaks.is_empty());
        unharmed(&recording);
    }
}

#[test]
fn a_reset_of_the_board_is_a_break() {
    let recording = read(&stamped(|row| {
        let t = if row < 300 {
            50_000 + 10 * row
        } else {
            150 + 10 * (row - 300)
        };
        t.to_string()
    }));
    assert_eq!(finding(&recording, "restarted-time").lines, [[302, 302]]);
    assert_eq!(recording.breaks, [300]);
    unharmed(&recording);
}

#[test]
fn a_gap_is_named_with_its_length() {
    let recording = read(&stamped(|row| {
        (10 * row + if row >= 400 { 700 } else { 0 }).to_string()
    }));
    let found = finding(&recording, "gap");
    assert_eq!(found.lines, [[402, 402]]);
    assert!(found.message.contains("0.710 s"), "{}", found.message);
    finding(&recording, "missing-samples");
    unharmed(&recording);
}

#[test]
fn a_rate_that_is_not_the_claimed_one_is_named() {
    let mut bytes = b"Fs,100\n".to_vec();
    bytes.extend(stamped(|row| (16 * row).to_string()));
    let recording = read(&bytes);
    let found = finding(&recording, "rate-mismatch");
    assert!(found.message.contains("62.50 Hz"), "{}", found.message);
    assert_eq!(recording.timing.nominal_rate_hz, Some(100.0));
    close(recording.timing.rate_hz().unwrap(), 62.5, 1e-9);
    unharmed(&recording);
}

#[test]
fn a_tail_of_zeros_is_set_aside() {
    let mut lines = lines();
    for i in 0..40 {
        lines.push(format!("{},0,0,0,0,0,0,0", 6120 + 10 * i));
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "zero-tail").lines, [[602, 641]]);
    unharmed(&recording);
}

#[test]
fn a_half_written_last_line_is_set_aside() {
    let mut bytes = joined(&lines());
    bytes.extend(b"6120,0.3051,-0.2");
    let recording = read(&bytes);
    let found = finding(&recording, "torn-line");
    assert_eq!(found.lines, [[602, 602]]);
    assert!(
        found.message.contains("6120,0.3051,-0.2"),
        "{}",
        found.message
    );
    unharmed(&recording);
}

#[test]
fn two_lines_run_together_and_garbage_are_set_aside() {
    let mut lines = lines();
    let next = lines.remove(101);
    lines[100].push_str(&next);
    lines[200] = lines[200].replacen(',', ",x?", 1);
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "too-many-fields").lines, [[101, 101]]);
    assert_eq!(finding(&recording, "not-a-number").lines, [[201, 201]]);
    assert_eq!(recording.rows(), ROWS - 3);
    nearly_unharmed(&recording);
}

#[test]
fn a_header_of_g_over_mps2_loses() {
    let recording = read(&joined(&report_lines(&HEADER.replace("m/s^2", "g"), ROWS)));
    let found = finding(&recording, "unit-mismatch");
    assert!(
        found.message.contains("the header says g"),
        "{}",
        found.message
    );
    assert_eq!(recording.accel_scale.unit, AccelUnit::MetrePerSecondSquared);
    unharmed(&recording);
}

#[test]
fn a_header_of_degrees_over_radians_loses_to_the_turns_of_gravity() {
    // The report's format does that: g and °/s over m/s² and rad/s.
    let options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions {
        continuous: true,
        hold_s: 4.0,
        ..Default::default()
    }));
    let folder = tempfile::tempdir().unwrap();
    let paths = write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
    let recording = gravical::recording::read(&paths[0], &ReadOptions::default()).unwrap();
    assert_eq!(
        recording.gyro_scale.unwrap().unit,
        GyroUnit::DegreePerSecond
    );
    let looked = inspect(&recording, &AxisMap::default());
    assert_eq!(looked.gyroscope.unwrap().unit, GyroUnit::RadianPerSecond);
    let mismatches = looked.findings.iter().filter(|f| f.kind == "unit-mismatch");
    assert_eq!(mismatches.count(), 2, "accelerometer and gyroscope");
    let turns: String = looked.turns.iter().map(|t| t.axis).collect();
    assert_eq!(turns, "xyz");
}

/// Counts of an MPU6050 at ±`range` g, at rest with z up, with a bump that
/// would go beyond the range where `clip`.
fn counts(range: f64, clip: bool) -> Vec<u8> {
    let sensor = Sensor {
        unit: 32768.0 / range / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for (i, row) in sensor
        .hold([0.0, 0.0, 1.0], ROWS, 3)
        .into_iter()
        .enumerate()
    {
        let z = if clip && (300..310).contains(&i) {
            32767.0
        } else {
            row[2]
        };
        text.push_str(&format!("{},{:.0},{:.0},{z:.0}\n", 10 * i, row[0], row[1]));
    }
    text.into_bytes()
}

#[test]
fn clipped_samples_are_named_with_their_lines() {
    let recording = read(&counts(2.0, true));
    let found = finding(&recording, "clipped");
    assert_eq!(found.lines, [[302, 311]]);
    assert!(found.message.starts_with("az"), "{}", found.message);

    // In physical units the end of the range shows as repeats of one value.
    let mut lines = lines();
    for line in &mut lines[101..121] {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[3] = "19.6127";
        *line = cells.join(",");
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "clipped").lines, [[102, 121]]);
}

#[test]
fn the_full_scale_is_recognised_in_counts() {
    for (range, lsb) in [(2.0, 16384.0), (4.0, 8192.0), (8.0, 4096.0), (16.0, 2048.0)] {
        let recording = read(&counts(range, false));
        assert_eq!(recording.accel_scale.unit, AccelUnit::Counts);
        assert_eq!(recording.accel_scale.lsb_per_g, Some(lsb));
        assert!(recording.findings.is_empty(), "{:?}", recording.findings);
    }
}

#[test]
fn a_wrong_full_scale_setting_is_named() {
    // ±4 g was set, ±2 g is claimed: taken as told, with a warning.
    let claim = |accel_unit| ReadOptions {
        accel_unit,
        accel_range_g: Some(2.0),
        ..ReadOptions::default()
    };
    for (unit, kind, words) in [
        (None, "range-mismatch", "that of ±4.000 g"),
        (Some(AccelUnit::Counts), "unit-mismatch", "0.53 g"),
    ] {
        let recording = read_with(&counts(4.0, false), &claim(unit));
        assert_eq!(recording.accel_scale.lsb_per_g, Some(16384.0));
        let message = &finding(&recording, kind).message;
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn a_frozen_axis_is_named() {
    let mut lines = lines();
    for line in &mut lines[201..351] {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[2] = "-0.1234";
        *line = cells.join(",");
    }
    let recording = read(&joined(&lines));
    let found = finding(&recording, "frozen-axis");
    assert_eq!(found.lines, [[202, 351]]);
    assert!(found.message.starts_with("ay"), "{}", found.message);
}

#[test]
fn rows_read_faster_than_the_sensor_measures_are_named() {
    let mut lines = lines();
    for i in (1..ROWS).step_by(2) {
        let values = lines[i].split_once(',').unwrap().1.to_owned();
        let stamp = lines[i + 1].split_once(',').unwrap().0.to_owned();
        lines[i + 1] = format!("{stamp},{values}");
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "repeated-rows").count, ROWS as u64 / 2);
}

#[test]
fn unsigned_counts_are_taken_about_their_middle() {
    let text: String = (0..400)
        .map(|i| format!("{},33000,33100,{}\n", 0.01 * f64::from(i), 49000 + i % 3))
        .collect();
    let recording = read(text.as_bytes());
    finding(&recording, "unsigned-counts");
    assert_eq!(recording.zero_offset, 32768.0);
    assert_eq!(recording.accel_scale.lsb_per_g, None, "no range is claimed");
    close(accel_means(&recording)[0], 232.0, 1e-9);
}

#[test]
fn stamps_of_unknown_unit_say_what_was_assumed() {
    let header = HEADER.replace(" (ms)", "");
    let recording = read(&joined(&report_lines(&header, ROWS)));
    assert_eq!(recording.timing.unit, Some(TimeUnit::Millisecond));
    let told = ReadOptions {
        time_unit: Some(TimeUnit::Millisecond),
        ..ReadOptions::default()
    };
    let recording = read_with(&joined(&report_lines(&header, ROWS)), &told);
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
}

#[test]
fn all_defects_together_still_balance() {
    let mut lines = lines();
    lines.insert(500, "500,1,2".to_owned());
    lines.insert(400, HEADER.to_owned());
    lines.insert(300, String::new());
    lines.insert(200, "# note".to_owned());
    lines.insert(100, "a,b,c,d,e,f,g,h".to_owned());
    lines.insert(0, "Fs,100".to_owned());
    let mut bytes = vec![0, 0];
    bytes.extend(joined(&lines));
    bytes.extend(b"6120,0,0,0,0,0,0,0\n6130,0,0,0,0,0,0,0\n61");
    let recording = read(&bytes);
    let sum = recording.ledger.sum();
    for reason in [
        "1 header",
        "1 metadata-lines",
        "1 comment-lines",
        "1 blank-rows",
        "1 repeated-header",
        "2 torn-line",
        "1 not-a-number",
        "2 zero-tail",
    ] {
        assert!(sum.contains(reason), "{reason} in {sum}");
    }
    unharmed(&recording);
}
