//! What is wrong with people's files, and what is said of it.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use gravical_recording::{Finding, ReadOptions, Reason, Recording, read_bytes};

use crate::support::{self, FACE_ROWS, RATE_HZ, has, has_rate, is_near, read, six_faces, try_read};

/// Milliseconds and g, the header given.
fn table(header: &str, cells: impl Fn(usize, [f64; 3]) -> String) -> String {
    let rows = six_faces(3).into_iter().enumerate();
    let rows = rows.map(|(k, r)| cells(k, r.accel_g) + "\n");
    format!("{header}\n{}", rows.collect::<String>())
}

fn plain(k: usize, [x, y, z]: [f64; 3]) -> String {
    format!("{},{x:.5},{y:.5},{z:.5}", 40 * k)
}

#[test]
fn clocks_are_dates_steps_and_whole_seconds() {
    for stamp in [
        (|k| format!("01-Mar-2024 10:00:{:06.3}", k as f64 / RATE_HZ)) as fn(usize) -> String,
        |k| format!("00:{:05.2}", k as f64 / RATE_HZ),
        |k| format!("{}", 39 + k % 3),
        |k| format!("10:00:{:02}", k / 25),
        |k| format!("{}", (65_400 + 40 * k) % 65_536),
    ] {
        let text = table("t,ax,ay,az", |k, [x, y, z]| {
            format!("{},{x:.5},{y:.5},{z:.5}", stamp(k))
        });
        let recording = read(&text, "");
        assert!(has_rate(&recording, RATE_HZ), "{}", stamp(1));
        let time_s = recording.time_s.as_ref().unwrap();
        let mut steps = time_s.windows(2).map(|w| w[1] - w[0]);
        assert!(steps.all(|s| is_near(s, 0.04, 0.01)), "{}", stamp(1));
    }
}

fn found<'a>(recording: &'a Recording, kind: &str) -> &'a Finding {
    support::finding(recording, kind).unwrap()
}

#[test]
fn one_bad_stamp_is_mended_and_missing_rows_are_counted() {
    let text = table("ms,ax,ay,az", |k, [x, y, z]| {
        let late = if k >= 200 { 400 } else { 0 };
        let stamp = if k == 77 { 999_999 } else { 40 * k + late };
        format!("{stamp},{x:.5},{y:.5},{z:.5}")
    });
    let recording = read(&text, "");
    assert!(has_rate(&recording, RATE_HZ));
    assert_eq!(found(&recording, "bad-stamps").lines, [[79, 79]]);
    assert_eq!(found(&recording, "gap").lines, [[202, 202]]);
    let missing = found(&recording, "missing-samples");
    assert!(missing.message.starts_with("10 samples"), "{missing:?}");
    assert!(is_near(recording.time_s.unwrap()[77], 3.08, 1e-9));
}

#[test]
fn a_hung_sensor_is_set_aside_and_values_that_repeat_otherwise_are_kept() {
    let rows = six_faces(3);
    let accel = |k: usize| rows[k].accel_g;
    let at =
        |k: usize, [x, y, z]: [f64; 3], d: usize| format!("{},{x:.d$},{y:.d$},{z:.d$}", 40 * k);
    let header = "ms,ax,ay,az";
    let hung = table(header, |k, a| match k {
        60..120 => at(k, accel(60), 5),
        _ => at(k, a, 5),
    });
    let recording = read(&hung, "");
    assert_eq!(recording.ledger.count(Reason::Hung), 59);
    assert_eq!(recording.breaks, [61]);
    // By rounding, and by slow updates.
    let coarse = table(header, |k, a| at(k, a, 2));
    let slow = table(header, |k, _| at(k, accel(k / 25 * 25), 5));
    for text in [coarse, slow] {
        assert_eq!(read(&text, "").ledger.count(Reason::Hung), 0);
    }
}

/// Rows at rest, and from line 152 on something else: each is an error with the line and the command
/// that cuts the file there.
#[test]
fn rows_in_another_unit_or_other_columns_are_refused_with_the_cut() {
    let rows = six_faces(3);
    let line = |k: usize| {
        let pose = &rows[4 * FACE_ROWS + k % FACE_ROWS];
        let accel = pose.accel_g.map(|v| v * 16_384.0);
        let gyro = pose.gyro_deg_s.map(|w| w * 131.0);
        [accel, gyro].concat()
    };
    let text = |change: &dyn Fn(&mut Vec<f64>)| {
        let lines = (0..400).map(|k| {
            let mut cells = line(k);
            if k >= 150 {
                change(&mut cells);
            }
            let cells: Vec<String> = cells.iter().map(|v| v.round().to_string()).collect();
            format!("{},{}\n", 40 * k, cells.join(","))
        });
        format!("ms,ax,ay,az,gx,gy,gz\n{}", lines.collect::<String>())
    };
    let shifted = text(&|cells| cells.rotate_right(1));
    let other_range = text(&|cells| cells[..3].iter_mut().for_each(|v| *v /= 4.0));
    for (text, code) in [(shifted, "shifted-columns"), (other_range, "unit-changed")] {
        let error = try_read(text.clone().into_bytes(), "log.csv").unwrap_err();
        assert_eq!(error.code(), code);
        assert_eq!(error.location().unwrap().line, Some(152));
        let hint = error.hint().unwrap();
        assert!(hint.contains("`sed '2,151d' FILE > after.csv`"), "{hint}");
        // What the commands write is read.
        let lines: Vec<&str> = text.lines().collect();
        let after = [&lines[..1], &lines[151..]].concat();
        for part in [&lines[..151], &after] {
            let is_read = try_read(part.join("\n").into_bytes(), "log.csv").is_ok();
            assert!(is_read, "{code}");
        }
    }
}

/// What is too long is cut where the error says, and the first part is read.
#[test]
fn more_than_fits_is_refused_with_the_number_of_lines_that_fit() {
    let row = |k: usize| format!("{},{}.25,0.5,9.75\n", 10 * k, k % 7);
    let text = "ms,ax,ay,az\n".to_owned() + &(0..100_000).map(row).collect::<String>();
    let options = ReadOptions {
        max_bytes: Some(6_000_000),
        ..ReadOptions::default()
    };
    let read = |text: &str| read_bytes(text.as_bytes(), "long.csv", &options);
    let error = read(&text).unwrap_err();
    assert_eq!(error.code(), "too-large");
    let words: Vec<&str> = error.message().split(' ').collect();
    let lines = words[words.iter().position(|w| *w == "lines").unwrap() - 1];
    let lines: usize = lines.parse().unwrap();
    assert!((40_000..80_000).contains(&lines), "{error}");
    let cut = format!("cut the file and read the parts: `sed '{lines},$d'");
    assert!(error.hint().unwrap().starts_with(&cut));
    let first: Vec<&str> = text.lines().take(lines - 1).collect();
    assert_eq!(read(&first.join("\n")).unwrap().rows(), lines - 2);
}

#[test]
fn a_dead_thermometer_loses() {
    let text = table("ms,AHT_tmp[C],ax,ay,az,gtemp", |k, a| {
        format!("{},40.5", plain(k, a).replacen(',', ",0.00,", 1))
    });
    assert_eq!(read(&text, "").temperature_c.unwrap()[0], 40.5);
}

#[test]
fn the_head_states_a_rate() {
    let head = "1617000000.00,1617000000.00,1617000000.00\n25.0,25.0,25.0";
    let text = table(head, |_, a| {
        let [x, y, z] = a.map(|g| (g * 64.0).round());
        format!("{x},{y},{z}")
    });
    let recording = read(&text, "ACC.csv");
    assert!(has_rate(&recording, RATE_HZ));
    assert_eq!(recording.units.accel.lsb_per_g, Some(64.0));
    assert_eq!(recording.rows(), 6 * FACE_ROWS);
}

#[test]
fn what_stands_before_rows_that_are_set_aside_is_no_break_of_others() {
    let text = "ax,ay,az\n1,2,9\n\n1,2.1,9\n\n1,2.2,9\n\n\n0,0,0\n";
    let recording = read(text, "");
    assert_eq!((recording.rows(), &recording.breaks[..]), (3, &[1, 2][..]));
    // A board that was reset often reads zeros first.
    let text = table("ms,ax,ay,az", |k, [x, y, z]| match k {
        0..150 => format!("{},{x:.5},{y:.5},{z:.5}", 50_000 + 40 * k),
        150 => "12,0,0,0".to_owned(),
        _ => format!("{},{x:.5},{y:.5},{z:.5}", 12 + 40 * (k - 150)),
    });
    assert_eq!(read(&text, "").breaks, [150]);
}

#[test]
fn seconds_and_nanoseconds_are_one_stamp_across_a_gap() {
    let text = table("stamp.sec,stamp.nanosec,ax,ay,az", |k, [x, y, z]| {
        let ns = 40_000_000 * k as u64 + if k >= 112 { 3_410_000_000 } else { 0 };
        let (sec, below) = (ns / 1_000_000_000, ns % 1_000_000_000);
        format!("{sec},{below},{x:.5},{y:.5},{z:.5}")
    });
    let recording = read(&text, "");
    let gap = found(&recording, "gap");
    assert!(gap.message.contains("3.450 s"), "{gap:?}");
}

#[test]
fn a_download_cut_off_yields_what_it_holds() {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    let text = table("ms,ax,ay,az", plain);
    packer.write_all(text.as_bytes()).unwrap();
    let packed = packer.finish().unwrap();
    let recording = try_read(packed[..packed.len() / 2].to_vec(), "cut.csv.gz").unwrap();
    assert!(recording.rows() > 50 && recording.format.describe().starts_with("gzip, "));
    let cut = found(&recording, "truncated-file");
    assert_eq!(cut.file.as_deref(), Some("cut.csv.gz"));
    // The blocks of a tape are filled with zeros; a log goes on in another member.
    let padded = [&packed[..], &[0; 700], &packed, &[0; 300]].concat();
    let recording = try_read(padded, "padded.csv.gz").unwrap();
    assert_eq!(recording.rows(), 2 * 6 * FACE_ROWS);
    assert!(!has(&recording, "truncated-file"));
}

/// What is neither gravity nor a measurement decides on no unit.
#[test]
fn units_are_not_told_by_coincidence_motion_or_invalid_samples() {
    let counts = |k: usize, a: [f64; 3], per_g: f64| {
        let [x, y, z] = a.map(|g| (g * per_g).round());
        format!("{},{x},{y},{z}", 40 * k)
    };
    // Between mg and 1024 counts per g nothing decides.
    let text = table("ms,x,y,z", |k, a| counts(k, a, 1030.0));
    let unknown = read(&text, "");
    assert_eq!(unknown.units.accel.unit.name(), "unknown");
    let units = found(&unknown, "unit-unknown").options.iter();
    let units: Vec<&str> = units.map(|advice| advice.value.as_str()).collect();
    assert_eq!(units, ["mg", "counts"]);
    // A walk is no gravity of another full scale in g, nor of the counts that happen to be near.
    for (per_g, digits) in [(1.0, 4), (3000.0, 0)] {
        let text = table("ms,x,y,z", |k, _| {
            let t = k as f64;
            let (x, y) = (0.5 * (1.3 * t).sin(), 0.4 * (0.9 * t).cos());
            let walk = [x, y, -1.3 + 0.7 * (1.7 * t).sin()].map(|v| per_g * v);
            let [x, y, z] = walk.map(|v| format!("{v:.digits$}"));
            format!("{},{x},{y},{z}", 40 * k)
        });
        let walk = read(&text, "");
        let message = &found(&walk, "unit-unknown").message;
        let is_told = message.starts_with("the sensor is never at rest");
        assert!(is_told, "{message}");
    }
    // Of a driver that marks what it could not read.
    let text = table("ms,ax,ay,az", |k, a| match k % 60 {
        7 => format!("{},-32768,5,16384", 40 * k),
        _ => counts(k, a, 16_384.0),
    });
    let recording = read(&text, "");
    assert_eq!(recording.units.accel.lsb_per_g, Some(16_384.0));
    assert_eq!(found(&recording, "empty-cells").count, 5);
    assert!(!has(&recording, "clipped"));
    assert!(recording.accel[0][7].is_nan());
}

/// Zeros of an accelerometer that was not read are no value that holds, however many they are.
#[test]
fn a_dead_accelerometer_is_no_rest() {
    let text = table("ms,ax,ay,az,gx,gy,gz", |k, a| {
        let row = if k % 90 < 30 { [0.0; 3] } else { a };
        format!("{},{}.5,-0.3,0.2", plain(k, row), k % 7)
    });
    let recording = read(&text, "");
    assert!(found(&recording, "zero-rows").count > 50);
    assert!(recording.accel[2][95..115].iter().all(|v| v.is_nan()));
}
