//! Real recordings with known results.

use std::path::Path;

use serde_json::Value;

use crate::support::*;

const SESSION: &str = "imucal-ferraris/example_ferraris_session.csv";
const SECTIONS: &str = "imucal-ferraris/example_ferraris_session_list.json";

/// K, R and b of both sensors and the g-sensitivity against a file in imucal's
/// form; its K_g is per °/s, ours per rad/s.
fn agrees_with_imucal(calibration: &Value, imucal: &Value, relative: f64) {
    let diagonal = |key: &str| -> Vec<f64> {
        (0..3)
            .map(|i| imucal[key][i][i].as_f64().unwrap())
            .collect()
    };
    let (a, g) = (&calibration["accelerometer"], &calibration["gyroscope"]);
    agree(&numbers(&a["scale"]), &diagonal("K_a"), relative, "K_a");
    agree(
        &numbers(&a["bias"]),
        &numbers(&imucal["b_a"]),
        relative,
        "b_a",
    );
    agree(
        &numbers(&a["orientation"]),
        &numbers(&imucal["R_a"]),
        relative,
        "R_a",
    );
    let per_degree: Vec<f64> = numbers(&g["scale"])
        .iter()
        .map(|k| k * std::f64::consts::PI / 180.0)
        .collect();
    agree(&per_degree, &diagonal("K_g"), relative, "K_g");
    agree(
        &numbers(&g["bias"]),
        &numbers(&imucal["b_g"]),
        relative,
        "b_g",
    );
    agree(
        &numbers(&g["orientation"]),
        &numbers(&imucal["R_g"]),
        relative,
        "R_g",
    );
    agree(
        &numbers(&g["g_sensitivity"]),
        &numbers(&imucal["K_ga"]),
        relative,
        "K_ga",
    );
}

#[test]
fn imucals_session_with_sections_equals_imucal() {
    let Some(data) = data() else { return };
    let line =
        format!("{SESSION} --sections {SECTIONS} --rate 102.4 --gravity 9.81 --method ferraris");
    let file = calibrate(&data, &line, 0);

    // The digits that were published with the recording.
    let (a, g) = (&file["accelerometer"], &file["gyroscope"]);
    let published: [(&Value, [f64; 3], f64, &str); 4] = [
        (
            &a["scale"],
            [0.9967458650887003, 1.0024376185894108, 1.0233953475452096],
            1.0,
            "K_a",
        ),
        (
            &a["bias"],
            [0.5371174244458201, -0.6162029930860964, 0.3988673423902682],
            1.0,
            "b_a",
        ),
        (
            &g["scale"],
            [1.0279243264288036, 0.9824277738468916, 0.9983104874451514],
            std::f64::consts::PI / 180.0,
            "K_g",
        ),
        (
            &g["bias"],
            [
                -0.5996686296674446,
                -0.36984313466306884,
                0.0587739354671091,
            ],
            1.0,
            "b_g",
        ),
    ];
    for (got, want, factor, what) in published {
        let got: Vec<f64> = numbers(got).iter().map(|v| v * factor).collect();
        agree(&got, &want, 1e-9, what);
    }

    // All of it, by the real imucal.
    let reference = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/reference/imucal/example_ferraris_session.json");
    let reference = std::fs::read_to_string(reference).unwrap();
    agrees_with_imucal(&file, &serde_json::from_str(&reference).unwrap(), 1e-9);
    assert_eq!(file["verdict"]["grade"], "not-verifiable");
    assert!(
        file["inputs"][0]["sha256"]
            .as_str()
            .is_some_and(|s| s.len() == 64),
        "{}",
        file["inputs"]
    );
}

#[test]
fn imucals_session_without_sections_comes_out_nearly_the_same() {
    let Some(data) = data() else { return };
    let file = calibrate(&data, &format!("{SESSION} --rate 102.4 --gravity 9.81"), 0);
    let a = &file["accelerometer"];
    let scale = [0.9967458650887003, 1.0024376185894108, 1.0233953475452096];
    let bias = [0.5371174244458201, -0.6162029930860964, 0.3988673423902682];
    for i in 0..3 {
        close(a["scale"][i].as_f64().unwrap() / scale[i], 1.0, 1e-3);
        close(a["bias"][i].as_f64().unwrap(), bias[i], 0.02);
    }
    let mut found = faces(&file);
    found.sort();
    found.dedup();
    assert_eq!(found, ["+x", "+y", "+z", "-x", "-y", "-z"]);
    // The turns were found: the gyroscope is as good as with sections.
    let k_g = [1.0279243264288036, 0.9824277738468916, 0.9983104874451514];
    for i in 0..3 {
        let got = file["gyroscope"]["scale"][i].as_f64().unwrap();
        close(got * std::f64::consts::PI / 180.0 / k_g[i], 1.0, 2e-3);
    }
}

#[test]
fn all_nine_sections_of_imucals_session_are_found() {
    let Some(data) = data() else { return };
    let run = run_in(
        &data,
        words(&format!("inspect {SESSION} --rate 102.4 --json")),
    );
    assert_eq!(run.code, 0);
    let looked = &run.json()["recordings"][0];
    let sections = std::fs::read_to_string(data.join(SECTIONS)).unwrap();
    let sections: Value = serde_json::from_str(&sections).unwrap();
    for (label, rows) in sections.as_object().unwrap() {
        let row = |v: &Value| v.as_u64().unwrap();
        let (from, to) = (row(&rows["start"]), row(&rows["end"]));
        let (axis, what) = label.split_once('_').unwrap();
        let list = if what == "rot" {
            "turns"
        } else {
            "static_intervals"
        };
        let sign = if what == "p" { "+" } else { "-" };
        let found = looked[list].as_array().unwrap().iter().any(|span| {
            let common = row(&span["end_row"])
                .min(to)
                .saturating_sub(row(&span["start_row"]).max(from));
            let right = if what == "rot" {
                span["axis"] == axis
            } else {
                span["face"] == format!("{sign}{axis}")
            };
            // More than half of what a person marked.
            right && 2 * common > to - from
        });
        assert!(found, "{label} {from}..{to}");
    }
}

#[test]
fn the_annotated_session_equals_the_published_calibration() {
    let Some(data) = data() else { return };
    let line =
        "imucal-ferraris/annotated_session.csv --rate 204.8 --gravity 9.81 --method ferraris";
    let published =
        std::fs::read_to_string(data.join("imucal-ferraris/published_example_cal.json")).unwrap();
    // The turns went the other way: poor, but written all the same.
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("cal.json");
    let file = calibrate(&data, &format!("{line} -o {}", target.display()), 4);
    agrees_with_imucal(&file, &serde_json::from_str(&published).unwrap(), 1e-9);
    assert_eq!(file["accelerometer"]["input_unit"], "counts");
    assert_eq!(file["gyroscope"]["input_unit"], "counts");
    assert_eq!(file["verdict"]["grade"], "poor");
    let reported = finding(&file, "turned-other-way")["message"]
        .as_str()
        .unwrap();
    assert!(reported.contains("--turn-angle 360"), "{reported}");
    let written: Value = serde_json::from_str(&std::fs::read_to_string(target).unwrap()).unwrap();
    assert_eq!(written["accelerometer"], file["accelerometer"]);

    // As it tells: turned round, the same numbers and a right-handed gyroscope.
    let right = calibrate(&data, &format!("{line} --turn-angle 360"), 0);
    for i in 0..3 {
        close(
            right["gyroscope"]["orientation"][i][i].as_f64().unwrap(),
            1.0,
            1e-3,
        );
    }
}

#[test]
fn airbrakes_six_files_are_six_faces_without_the_lift() {
    let Some(data) = data() else { return };
    let folder = data.join("airbrakes-sixmoves");
    let file = calibrate(&data, "airbrakes-sixmoves --method ferraris", 0);
    assert_eq!(file["accelerometer"]["input_unit"], "g");
    let names = [
        ("xplus", "+x"),
        ("xminus", "-x"),
        ("yplus", "+y"),
        ("yminus", "-y"),
        ("zplus", "+z"),
        ("zminus", "-z"),
    ];
    assert_eq!(poses(&file).len(), 6);
    for (name, face) in names {
        let position = poses(&file)
            .iter()
            .find(|p| {
                p["source"]
                    .as_str()
                    .unwrap()
                    .ends_with(&format!("{name}.csv"))
            })
            .unwrap_or_else(|| panic!("{name}"));
        assert_eq!(position["label"], face);
        assert_eq!(position["kind"], "face");

        // Within 8 mg of the first 200 rows, which are at rest.
        let text = std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
        let rows: Vec<[f64; 3]> = text
            .lines()
            .skip(1)
            .map(|l| {
                let cells: Vec<f64> = l.split(',').skip(1).map(|c| c.parse().unwrap()).collect();
                [cells[0], cells[1], cells[2]]
            })
            .collect();
        let raw = numbers(&position["raw"]);
        for (i, got) in raw.iter().enumerate() {
            let start: f64 = rows[..200].iter().map(|r| r[i]).sum::<f64>() / 200.0;
            close(*got, start, 0.008);
        }

        // The hold ends before ‖a‖ leaves 1 ± 0.05 g for good.
        let used = held_lines(&data, name);
        let norm = |r: &[f64; 3]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
        let lift = leaves_for_good(&rows.iter().map(norm).collect::<Vec<_>>());
        assert!(
            used.1 <= lift + 2,
            "{name}: hold to line {}, lift at row {lift}",
            used.1
        );
        assert!(used.1 - used.0 + 1 >= 100, "{name}: {used:?}");
    }
    let tilt = finding(&file, "pose-tilt")["message"].as_str().unwrap();
    let tilts: Vec<f64> = poses(&file)
        .iter()
        .map(|p| p["tilt_deg"].as_f64().unwrap())
        .collect();
    for t in tilts {
        assert!((0.3..=4.0).contains(&t), "{t}");
        assert!(tilt.contains(&format!("{t:.1}°")), "{t} in {tilt}");
    }
    assert_eq!(finding(&file, "pose-tilt")["severity"], "warning");
    // The licence in the folder is named, not read as a recording.
    let licence = finding(&file, "no-recording")["file"].as_str().unwrap();
    assert!(licence.ends_with("LICENSE.txt"), "{licence}");
}

/// First and last line of the hold of a file, from what `calibrate` says: at rest, or, where a hand
/// moved it too much, the longest quiet part.
fn held_lines(data: &Path, name: &str) -> (usize, usize) {
    let run = run_in(data, words("calibrate airbrakes-sixmoves --json"));
    let file = run.json();
    let reported = file["findings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|f| f["file"].as_str().is_some_and(|file| file.contains(name)))
        .find(|f| f["kind"] == "motion-left-out" || f["kind"] == "unsteady-pose")
        .unwrap_or_else(|| panic!("{name}: nothing left out"));
    let message = reported["message"].as_str().unwrap();
    let (_, span) = message.split_once(" lines ").unwrap();
    let lines: Vec<usize> = span
        .split(|c: char| !c.is_ascii_digit())
        .filter_map(|n| n.parse().ok())
        .take(2)
        .collect();
    (lines[0], lines[1])
}

/// The row from which the mean of the next 0.1 s stays outside 1 ± 0.05 g or
/// comes back only for a moment: the start of the lift.
fn leaves_for_good(norms: &[f64]) -> usize {
    let outside = |n: &f64| (n - 1.0).abs() > 0.05;
    norms.iter().position(outside).unwrap_or(norms.len())
}

#[test]
fn tomisuarez_raw_counts_of_an_mpu6050() {
    let Some(data) = data() else { return };
    let path = "tomisuarez-mpu6050/calibration.csv";
    let looked = run_in(&data, words(&format!("inspect {path} --json"))).json();
    let looked = &looked["recordings"][0];
    assert_eq!(looked["accelerometer"]["unit"], "counts");
    assert_eq!(looked["accelerometer"]["lsb_per_g"], 16384.0);
    assert_eq!(looked["timing"]["nominal_rate_hz"], 100.0);

    let file = calibrate(&data, &format!("{path} --method ferraris"), 0);
    let a = &file["accelerometer"];
    assert_eq!(a["input_unit"], "counts");
    let mut found = faces(&file);
    found.sort();
    assert_eq!(found, ["+x", "+y", "+z", "-x", "-y", "-z"]);
    assert_eq!(poses(&file).len(), 10, "four oblique poses");
    for (got, want) in numbers(&a["bias"]).iter().zip([699.0, -345.0, -1830.0]) {
        close(*got, want, 15.0);
    }
    let tilt = finding(&file, "face-tilt")["message"].as_str().unwrap();
    assert!(tilt.contains("-x lies 11"), "{tilt}");
    assert_eq!(file["verdict"]["grade"], "not-verifiable");
}

#[test]
fn tomisuarez_without_the_minus_z_hold_says_which_face_is_missing() {
    let Some(data) = data() else { return };
    let text = std::fs::read_to_string(data.join("tomisuarez-mpu6050/calibration.csv")).unwrap();
    // Five lines before the first row: four of metadata and the header.
    let cut: String = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(5 + 4100..5 + 4500).contains(i))
        .map(|(_, l)| format!("{l}\n"))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "cut.csv", &cut);
    let run = run_in(
        folder.path(),
        words("calibrate cut.csv --method ferraris --json -o cal.json"),
    );
    assert_eq!(run.code, 3, "{}", run.out);
    let error = run.json();
    assert_eq!(error["code"], "missing-face");
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("missing: -z"), "{message}");
    assert!(message.contains("cut.csv"), "{message}");
    let hint = error["hint"].as_str().unwrap();
    assert!(hint.contains("z down"), "{hint}");
    assert!(!folder.path().join("cal.json").exists());
}

#[test]
fn a_sensor_that_never_lies_still_is_refused() {
    let Some(data) = data() else { return };
    let run = run_in(
        &data,
        words("calibrate mjs513-handheld/acc_A.txt.gz --json"),
    );
    assert_eq!((run.code, run.error_code().as_str()), (3, "never-static"));
}

#[test]
fn imucals_files_are_read_and_written_back_with_equal_values() {
    let Some(data) = data() else { return };
    for name in [
        "published_example_cal.json",
        "legacy_calibration_pre_2.0.json",
    ] {
        let path = format!("imucal-ferraris/{name}");
        let text = std::fs::read_to_string(data.join(&path)).unwrap();
        let before: Value = serde_json::from_str(&text).unwrap();
        let run = run_in(&data, words(&format!("export {path} --to imucal")));
        assert_eq!(run.code, 0, "{}", run.err);
        let after = run.json();
        for key in ["K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g"] {
            agree(&numbers(&after[key]), &numbers(&before[key]), 1e-15, key);
        }
        for key in ["acc_unit", "from_acc_unit", "cal_type"] {
            assert_eq!(
                after[key],
                *before.get(key).unwrap_or(&Value::Null),
                "{key}"
            );
        }
        let ours = run_in(&data, words(&format!("export {path} --to gravical")));
        assert_eq!(ours.code, 0);
        ours.calibration();
    }
}
