//! A calibration from a folder of them: of the same sensor, the last one before the recording.

use crate::support::*;

/// Calibrations of two sensors, the first one twice, and a recording.
fn calibrated() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::create_dir(at.join("cals")).unwrap();
    for (seed, sensor, date) in [
        (1, "left", "2026-03-01"),
        (2, "left", "2026-05-01"),
        (3, "right", "2026-04-01"),
    ] {
        let line = format!("simulate poses -o s{seed} --seed {seed} --hold 2 --free 2 -q");
        ends(at, &line, 0);
        let line = format!(
            "calibrate s{seed}/poses.csv -q --sensor-id {sensor} --recorded {date} -o cals/{sensor}-{date}.json"
        );
        ends(at, &line, 0);
    }
    write(at, "cals/notes.json", "{}");
    ends(at, "simulate line -o line --seed 1 --rest 2 -q", 0);
    // The same on days, by time stamps in seconds since 1970.
    let text = read(at, "line/line.csv");
    for (name, start_s) in [
        ("january", 1_767_225_600.0),
        ("april", 1_776_211_200.0),
        ("june", 1_780_272_000.0),
    ] {
        let row = |line: &str| {
            let (time, rest) = line.split_once(',').unwrap();
            let time = match time.parse::<f64>() {
                Ok(ms) => format!("{:.3}", start_s + ms / 1000.0),
                Err(_) => "t_s".to_owned(),
            };
            format!("{time},{rest}\n")
        };
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        let rows: String = rows.map(row).collect();
        write(at, &format!("{name}.csv"), &rows);
    }
    folder
}

#[test]
fn the_last_of_the_sensor_before_the_recording_is_taken() {
    let folder = calibrated();
    let at = folder.path();
    let done = |line: &str| ends(at, line, 0);
    let read = |name: &str| std::fs::read(at.join(name)).unwrap();
    for (input, sensor, expected) in [
        ("april.csv", "left", "left-2026-03-01"),
        ("june.csv", "left", "left-2026-05-01"),
        ("line/line.csv", "left", "left-2026-05-01"),
        ("line/line.csv", "right", "right-2026-04-01"),
    ] {
        let line = format!("apply cals {input} -o a.csv --force --sensor-id {sensor}");
        let err = done(&line).err;
        let said = native(&format!("Calibration: cals/{expected}.json, the last"));
        assert!(err.contains(&said), "{err}");
        assert_eq!(err.contains("has no date"), input.contains("line"), "{err}");
        done(&format!(
            "apply cals/{expected}.json {input} -o b.csv --force"
        ));
        assert!(read("a.csv") == read("b.csv"), "{input}");
    }
    let moved = done("motion april.csv -c cals --sensor-id left --json");
    let file = native("cals/left-2026-03-01.json");
    assert_eq!(moved.json()["calibration"], file);
    done("check cals s3/poses.csv --sensor-id right --json");
    // Of one sensor no name is needed.
    std::fs::remove_file(at.join("cals/right-2026-04-01.json")).unwrap();
    let applied = done("apply cals line/line.csv -o a.csv --force --json --quiet");
    let file = native("cals/left-2026-05-01.json");
    assert_eq!(applied.json()["calibration"], file);
}

#[test]
fn a_calibration_that_might_be_the_one_is_not_passed_over() {
    let folder = calibrated();
    let at = folder.path();
    let apply = "apply cals line/line.csv -o a.csv --force --sensor-id left";
    let cut = std::fs::read_to_string(at.join("cals/left-2026-05-01.json")).unwrap();
    write(at, "cals/left-2026-05-01.json", &cut[..cut.len() / 2]);
    let run = ends(at, apply, 3);
    assert!(run.err.contains("left-2026-05-01.json"), "{}", run.err);
    // Calibrations without a sensor may be of several.
    for seed in [1, 2] {
        let line = format!("calibrate s{seed}/poses.csv -q -o unnamed/{seed}.json");
        std::fs::create_dir_all(at.join("unnamed")).unwrap();
        ends(at, &line, 0);
    }
    let run = ends(at, "apply unnamed line/line.csv -o b.csv", 2);
    assert!(run.err.contains("code: sensor-id-missing"), "{}", run.err);
    std::fs::remove_file(at.join("unnamed/2.json")).unwrap();
    ends(at, "apply unnamed line/line.csv -o b.csv", 0);
}

/// Calls, the code of each refusal, and what it names.
const REFUSED: &str = "\
apply cals line/line.csv -o a.csv | sensor-id-missing | right-2026-04-01.json: right
apply cals line/line.csv -o a.csv --sensor-id foot | no-calibration | left-2026-03-01.json: left
apply cals january.csv -o a.csv --sensor-id right | no-calibration | 2026-04-01
motion raw/line.csv -c cals --sensor-id left | no-calibration | in counts, 16384 per g
apply cals/left-2026-03-01.json line/line.csv -o a.csv --sensor-id left | origin-unused | this is a file
apply line line/line.csv -o a.csv | no-calibration | no calibration is in this folder";

#[test]
fn what_fits_nothing_is_refused_with_what_is_there() {
    let folder = calibrated();
    let at = folder.path();
    ends(at, "simulate line -o raw --seed 1 --rest 2 --raw -q", 0);
    for row in REFUSED.lines() {
        let [line, code, there] = row.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        let run = run_in(at, words(line));
        assert!([2, 3].contains(&run.code), "{line}\n{}", run.err);
        for said in [format!("code: {code}"), there.to_owned()] {
            assert!(run.err.contains(&said), "{line}\n{}", run.err);
        }
    }
}
