use std::path::Path;

use super::*;
use crate::document::{Block, Cell, Detail, Document};
use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, InputFile, InputRole};
use gravical::check::CheckOptions;
use gravical::compare::compare;
use gravical::denoise::DenoiseOptions;
use gravical::motion::{Motion, MotionOptions, Move};
use gravical::recording::{Finding, FindingKind, ReadOptions, Recording, read, read_bytes};
use gravical::simulate::{PosesOptions, Scenario, SimulateOptions, simulate_to};

fn simulated(scenario: Scenario) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let (_, files) = simulate_to(&SimulateOptions::new(scenario), folder.path(), false).unwrap();
    read(&files[0], &ReadOptions::default()).unwrap()
}

fn poses() -> (CalibrationFile, Recording) {
    let recording = simulated(Scenario::Poses(PosesOptions {
        hold_s: 3.0,
        ..PosesOptions::default()
    }));
    let options = CalibrateOptions::default();
    let file = calibrate(std::slice::from_ref(&recording), &options)
        .unwrap()
        .file;
    (file, recording)
}

/// A push along x between two rests.
fn push() -> Recording {
    let mut text = String::from("time_s,ax_mps2,ay_mps2,az_mps2\n");
    for i in 0..1200_u32 {
        let t = f64::from(i) * 0.01;
        let s = (t - 5.0).clamp(0.0, 2.0) * std::f64::consts::PI;
        let noise = f64::from(i * 7919 % 13) * 1e-3;
        let (along, up) = (s.sin() + noise, 9.8 + noise);
        text.push_str(&format!("{t:.2},{along:.5},{noise:.5},{up:.5}\n"));
    }
    read_bytes(
        text.as_bytes(),
        "push <script>.csv",
        &ReadOptions::default(),
    )
    .unwrap()
}

fn moved(recording: &Recording) -> Motion {
    gravical::motion::motion(recording, None, &MotionOptions::default()).unwrap()
}

/// Rows are complete, and a terminal shows all of it; how many numbers there are.
fn numbers(document: &Document<'_>) -> usize {
    let blocks = document.sections.iter().flat_map(|s| &s.blocks);
    let tables = blocks.filter_map(|(_, block)| match block {
        Block::Table(table) => Some(table),
        _ => None,
    });
    let mut numbers = 0;
    for table in tables {
        for row in &table.rows {
            assert_eq!(row.len(), table.columns.len(), "{table:?}");
            numbers += row.iter().filter(|c| matches!(c, Cell::Number(..))).count();
        }
    }
    assert!(!document.to_text(Detail::Full).contains("NaN"));
    let text = document.to_text(Detail::Summary);
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    numbers
}

#[test]
fn a_calibration_has_its_figures() {
    let (file, _) = poses();
    let figures = crate::figure::calibration::figures(&file, None);
    assert!(file.gyroscope.is_some() && !figures.is_empty());
    let document = calibration(&file, Some(Path::new("my cal.json")), &figures);
    assert!(numbers(&document) > 100);
    let page = document.to_html();
    let drawn = page.matches("<figure id=\"figure-").count();
    assert_eq!(drawn, figures.len());
}

#[test]
fn what_may_be_missing() {
    let (mut file, _) = poses();
    file.accelerometer.poses.clear();
    file.accelerometer.budget = None;
    file.accelerometer.deviations = None;
    file.gyroscope = None;
    file.findings.clear();
    file.inputs.clear();
    let text = calibration(&file, None, &[]).to_text(Detail::Full);
    assert!(text.contains("Findings\n  None.") && !text.contains("NaN"));
}

#[test]
fn check_compare_and_denoise_have_their_tables() {
    let (file, recording) = poses();
    let recordings = std::slice::from_ref(&recording);
    let report = gravical::check::check(&file, "cal.json", recordings, &CheckOptions::default());
    let report = report.unwrap();
    assert!(numbers(&check(&report)) > 20);

    let result = compare(&file, &file, ["a.json", "b.json"]).unwrap();
    assert!(numbers(&comparison(&result)) > 30);

    let filters = ["hampel:7,3", "butter1:8,10.125Hz", "savgol:21,4", "mean:1"];
    let options = DenoiseOptions::new(filters.map(|f| f.parse().unwrap()));
    let summary = gravical::denoise::denoise(recording, &options)
        .unwrap()
        .summary;
    assert!(numbers(&denoise(&summary)) > 20);
}

#[test]
fn long_results_stay_small() {
    let recording = push();
    let mut motion = moved(&recording);
    let one: Move = Move {
        unusable: Some("a reason of some length, as reasons are".to_owned()),
        ..motion.result.moves[0].clone()
    };
    motion.result.moves = vec![one; 10_000];
    motion.result.findings = vec![Finding::new(FindingKind::Gap, "x".repeat(300)); 10_000];
    let page = super::motion(&motion.result, &recording, &[]).to_html();
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    assert_eq!(page.matches("… and 9800 more").count(), 2);
    assert!(page.contains("move 12 and 9988 more: not usable: a reason"));
}

#[test]
fn names_are_no_markup() {
    let evil = "</script><img src=x onerror=alert(1)>\"'&|`\u{0}\n# a";
    let recording = push();
    let mut motion = moved(&recording);
    let finding = Finding::new(FindingKind::Other, evil).in_file(evil);
    motion.result.findings.push(finding);
    motion.result.frame = evil.to_owned();
    motion.result.moves[0].unusable = Some(evil.to_owned());
    let line = Series::line(evil, Role::Raw, [(0.0, 0.0), (1.0, 1.0)]);
    let panel = Panel::new(evil, Axis::new(evil, "s"), Axis::new("y", evil), [line]);
    let figures = [Figure::new("velocity", evil, evil, [panel])];
    let input = InputFile {
        path: evil.to_owned(),
        sha256: None,
        role: InputRole::Reference,
    };
    let document =
        super::motion(&motion.result, &recording, &figures).with_provenance(&Provenance {
            tool: evil,
            command: Some(evil),
            created: evil,
            inputs: &[input],
        });
    let page = document.to_html();
    assert!(!page.contains("<img") && !page.contains("push <script>"));
    assert_eq!(page.matches("</script>").count(), 1);
    let text = document.to_markdown(Some("figures"));
    assert!(
        !text.contains("<img") || text.matches("<img").count() == text.matches("\\<img").count()
    );
    assert!(!text.contains("\n# a") && !text.contains('\0'), "{text}");
    // A drawing of its own is XML whatever its names are.
    let drawing = crate::figure::svg::standalone(&figures[0]);
    assert!(!drawing.contains("<img"));
    let options = roxmltree::ParsingOptions::default();
    roxmltree::Document::parse_with_options(&drawing, options).unwrap();
}
