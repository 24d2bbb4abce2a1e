use super::*;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{
    CalibrationFile, Grade, GyroscopeSection, InputFile, InputRole, ReferenceSource,
    TemperatureModel,
};
use crate::figure::{Axis, Figure, Panel, Role, Series};
use crate::motion::{Ends, Motion, MotionOptions, Move, Span, motion};
use crate::recording::{Finding, FindingKind, ReadOptions, Recording, read, read_bytes};
use serde_json::Value;

/// A push along x between two rests.
fn recording() -> Recording {
    let mut text = String::from("time_s,ax_mps2,ay_mps2,az_mps2\n");
    for i in 0..1200_u32 {
        let t = f64::from(i) * 0.01;
        let push = if (5.0..7.0).contains(&t) {
            (std::f64::consts::PI * (t - 5.0)).sin()
        } else {
            0.0
        };
        let noise = f64::from(i * 7919 % 13) * 1e-3;
        text.push_str(&format!(
            "{t:.2},{:.5},{noise:.5},{:.5}\n",
            push + noise,
            9.8 + noise
        ));
    }
    read_bytes(
        text.as_bytes(),
        "push <script>.csv",
        &ReadOptions::default(),
    )
    .unwrap()
}

fn moved() -> (Motion, Recording) {
    let recording = recording();
    let motion = motion(&recording, None, &MotionOptions::default()).unwrap();
    (motion, recording)
}

fn file() -> CalibrationFile {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/simulated-six-position"
    );
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "csv"));
    paths.sort();
    let recordings: Vec<Recording> = paths
        .iter()
        .map(|p| read(p, &ReadOptions::default()).unwrap())
        .collect();
    calibrate(&recordings, &CalibrateOptions::default())
        .unwrap()
        .file
}

/// Every number that names its place has the value that stands there.
fn agrees(page: &str, json: &Value) -> usize {
    let mut count = 0;
    for part in page.split("data-k=\"").skip(1) {
        let key = part.split('"').next().unwrap();
        let rest = &part[key.len()..];
        let there = json
            .pointer(key)
            .unwrap_or_else(|| panic!("no {key} in the JSON"));
        match rest.strip_prefix("\" data-v=\"") {
            Some(v) => {
                let shown: f64 = v.split('"').next().unwrap().parse().unwrap();
                assert_eq!(there.as_f64(), Some(shown), "{key}");
                count += 1;
            }
            None => assert!(there.is_null(), "{key}"),
        }
    }
    count
}

#[test]
fn numbers_are_those_of_the_json() {
    let file = file();
    let page = calibration_html(&file, &crate::figure::calibration::figures(&file, None));
    let json: Value = serde_json::from_str(&file.to_json().unwrap()).unwrap();
    assert!(agrees(&page, &json) > 100);
    let (motion, recording) = moved();
    let page = motion_html(
        &motion.result,
        &recording,
        &crate::figure::motion::figures(&motion),
        Provenance::default(),
    );
    let json = serde_json::to_value(&motion.result).unwrap();
    assert!(agrees(&page, &json) > 20);
}

#[test]
fn nothing_comes_from_elsewhere() {
    let file = file();
    let page = calibration_html(&file, &[]);
    for word in ["http://", "https://", "@import", "url(", " src="] {
        let foreign = page.matches(word).count();
        // The name of SVG's own elements is an address that nobody fetches.
        let own = if word == "http://" {
            page.matches("http://www.w3.org/").count()
        } else {
            0
        };
        assert_eq!(foreign, own, "{word}");
    }
}

#[test]
fn names_are_no_markup() {
    let (mut motion, recording) = moved();
    let evil = "</script><img src=x onerror=alert(1)>\"'&\u{0}";
    motion
        .result
        .findings
        .push(Finding::warning(FindingKind::Other, evil).in_file(evil));
    motion.result.frame = evil.to_owned();
    let panel = Panel::new(Axis::new(evil, "s"), Axis::new("y", evil))
        .titled(evil)
        .with(Series::line(
            evil,
            Role::Raw,
            vec![0.0, 1.0],
            vec![0.0, 1.0],
        ));
    let figure = Figure::new("odd", evil, evil).with(panel);
    let input = InputFile {
        path: evil.to_owned(),
        sha256: None,
        role: InputRole::Reference,
    };
    let origin = Provenance {
        command: Some(evil),
        other_inputs: &[input],
    };
    let page = motion_html(&motion.result, &recording, &[figure], origin);
    assert!(!page.contains("<img") && !page.contains("push <script>"));
    assert_eq!(page.matches("</script>").count(), 1);
}

#[test]
fn long_results_are_cut_and_say_so() {
    let (mut motion, recording) = moved();
    let one: Move = Move {
        start_s: 0.0,
        end_s: 1.0,
        ends: Ends::RestToRest,
        displacement_m: Some([0.1; 3]),
        uncalibrated_m: Some([0.2; 3]),
        sigma_m: Some([0.01; 3]),
        peak_speed_mps: Some(1.0),
        path_m: Some(0.3),
        velocity_error_mps: None,
        missing_tilt_deg: None,
        closure_sigmas: None,
        usable: true,
        reason: Some("a reason of some length, as reasons are".to_owned()),
    };
    motion.result.moves = vec![one; 10_000];
    motion.result.still = vec![
        Span {
            start_s: 0.0,
            end_s: 1.0
        };
        10_000
    ];
    motion.result.findings = vec![Finding::new(FindingKind::Gap, "x".repeat(300)); 10_000];
    // Ten figures of half a megabyte each: some do not fit.
    let x: Vec<f64> = (0..40_000).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|v| (v * 0.7).sin()).collect();
    let figures: Vec<Figure> =
        (0..20)
            .map(|i| {
                let panel = Panel::new(Axis::new("t", "s"), Axis::new("y", "m"))
                    .with(Series::line("a", Role::Raw, x.clone(), y.clone()));
                Figure::new(&format!("f{i}"), "F", "").with(panel)
            })
            .collect();
    let page = motion_html(&motion.result, &recording, &figures, Provenance::default());
    assert!(page.len() < 5_000_000, "{} bytes", page.len());
    assert!(page.contains("… and 9800 more"));
    assert!(page.contains("would make the page too large"));
}

#[test]
fn at_rest_nothing_is_added_up_and_a_long_drift_is_round() {
    let rows = (0..3000).map(|i| format!("{:.2},0.0{},0,9.8\n", 0.01 * f64::from(i), i % 7));
    let text = format!(
        "time_s,ax_mps2,ay_mps2,az_mps2\n{}",
        rows.collect::<String>()
    );
    let recording = read_bytes(text.as_bytes(), "rest.csv", &ReadOptions::default()).unwrap();
    let mut motion = motion(&recording, None, &MotionOptions::default()).unwrap();
    assert!(motion.result.moves.is_empty() && motion.result.budget_m.is_some());
    let drift = motion.result.static_drift.as_mut().unwrap();
    drift.position_m = [-2_484_252_593.0, 0.5, 12.0];
    drift.predicted_sigma_m = [25_192_777_403.0, 0.1, 3.0];
    let page = motion_html(&motion.result, &recording, &[], Provenance::default());
    assert!(!page.contains("id=\"budget\"") && !page.contains("along its worst axis"));
    let table = part(&page, "drift");
    assert!(table.contains(">−2.5e9<") && table.contains(">2.5e10<") && table.contains(">0.50<"));
}

#[test]
fn every_grade_and_no_placement() {
    let mut file = file();
    for grade in [Grade::Good, Grade::Fair, Grade::Poor, Grade::NotVerifiable] {
        file.verdict.grade = grade;
        assert!(calibration_html(&file, &[]).contains(grade.name()));
    }
    file.accelerometer.positions.clear();
    file.accelerometer.budget = None;
    file.accelerometer.deviations = None;
    file.gyroscope = None;
    file.findings.clear();
    file.inputs.clear();
    let page = calibration_html(&file, &[]);
    let text = page.split("<script>").next().unwrap();
    assert!(text.contains("Nothing odd was found") && !text.contains("NaN"));
}

/// The text of one part of a page, from its id to the next heading of its level.
fn part<'a>(page: &'a str, id: &str) -> &'a str {
    let from = page.split(&format!("id=\"{id}\"")).nth(1).unwrap();
    from.split("<section").next().unwrap()
}

#[test]
fn a_placement_that_took_no_part_says_why() {
    let mut file = file();
    let page = calibration_html(&file, &[]);
    assert!(part(&page, "method").contains("Every placement took part in the fit."));
    for (at, label) in [(0, "still 3"), (1, "still 30"), (2, "+x")] {
        file.accelerometer.positions[at].label = label.to_owned();
        file.accelerometer.positions[at].fitted = false;
    }
    file.findings = vec![
        Finding::note(FindingKind::Other, "all of it is fine"),
        Finding::warning(
            FindingKind::Other,
            "still 30: 52 mg off, moved while it was held",
        ),
        Finding::new(
            FindingKind::ClippedHold,
            "still 3 reaches the end of the range",
        ),
    ];
    let page = calibration_html(&file, &[]);
    let list = part(&page, "method");
    assert!(!list.contains("Every placement took part"));
    for line in [
        // The label as a whole, wherever it stands in the list.
        "<li><strong>still 3</strong>: still 3 reaches the end of the range</li>",
        "<li><strong>still 30</strong>: still 30: 52 mg off, moved while it was held</li>",
        "<li><strong>+x</strong>: its findings say why</li>",
    ] {
        assert!(list.contains(line), "{line}");
    }
    // By the thousand they are cut.
    let one = file.accelerometer.positions[0].clone();
    file.accelerometer.positions = vec![one; 1000];
    let page = calibration_html(&file, &[]);
    assert!(part(&page, "method").contains("… and 800 more"));
}

#[test]
fn what_is_pasted_says_what_is_not_in_it() {
    let mut file = file();
    let paste = |file: &CalibrationFile| {
        let page = calibration_html(file, &[]);
        let block = page.split("class=\"paste\"").nth(1).unwrap().to_owned();
        let text = block.split_once('>').unwrap().1.split("</pre>").next();
        text.unwrap().to_owned()
    };
    let (drift, above) = ("gravical apply takes it off", "stands above");
    file.gyroscope = None;
    file.temperature_model = None;
    let plain = paste(&file);
    assert!(!plain.contains(drift) && !plain.contains(above) && !plain.contains("wx"));
    // The numbers are those of the file, to the last digit of an f32.
    let pasted: f32 = plain
        .split_once("ax = ")
        .and_then(|(_, rest)| rest.split_once(' '))
        .and_then(|(number, _)| number.parse().ok())
        .unwrap();
    assert_eq!(pasted, file.accelerometer.matrix[0][0] as f32);

    file.gyroscope = Some(GyroscopeSection::default());
    let with = paste(&file);
    assert!(with.contains("wx = ") && with.contains("gx, gy, gz: raw") && !with.contains(above));
    let mut coupled = GyroscopeSection::default();
    coupled.g_sensitivity[1][2] = 1e-4;
    file.gyroscope = Some(coupled);
    let with = paste(&file);
    assert!(with.contains(above) && !with.contains("wx = "));

    file.temperature_model = Some(TemperatureModel {
        reference_c: 25.0,
        reference_source: ReferenceSource::Session,
        range_c: [10.0, 40.0],
        poses: 1,
        sweeps: Vec::new(),
        channels: Vec::new(),
        inputs: Vec::new(),
    });
    assert!(paste(&file).contains(drift));
}

#[test]
fn the_script_is_small() {
    let size = page::script().len();
    assert!(size < 20_000, "{size}");
}
