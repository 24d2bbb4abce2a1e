use serde_json::Value;

use super::*;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{CalibrationFile, Grade};
use crate::inspect::inspect;
use crate::poses::face::AxisMap;
use crate::poses::rests::find_rests;
use crate::poses::sections::Section;
use crate::recording::read_bytes;
use crate::simulate::{
    PosesOptions, Scenario, SimulateOptions, SoakOptions, StaticOptions, simulate, write,
};
use crate::temperature::study;

/// Forces an excerpt, with room for everything it needs.
const SMALL: Bounds = Bounds {
    whole: 1000,
    ..BOUNDS
};

/// The files written for a scenario.
fn texts(scenario: Scenario) -> Vec<(String, String)> {
    let mut options = SimulateOptions::new(scenario);
    options.seed = 5;
    let folder = tempfile::tempdir().unwrap();
    let paths = write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
    let csv = paths.iter().filter(|p| p.extension().unwrap() == "csv");
    csv.map(|path| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read_to_string(path).unwrap())
    })
    .collect()
}

fn poses(hold_s: f64) -> (String, String) {
    texts(Scenario::Poses(PosesOptions { hold_s, free: 6 })).remove(0)
}

fn whole((name, text): &(String, String)) -> Recording {
    read_bytes(text.as_bytes(), name, &ReadOptions::default()).unwrap()
}

fn excerpt((name, text): &(String, String), bounds: Bounds) -> Recording {
    let source = Reopenable::Memory(text.as_bytes().into());
    let recording = read_from(&mut { source }, name, &ReadOptions::default(), bounds).unwrap();
    assert!(recording.is_excerpt());
    recording
}

fn inspected(recording: &Recording) -> Value {
    serde_json::to_value(inspect(recording, &AxisMap::default())).unwrap()
}

/// The calibration or the error.
fn calibrated(recordings: &[Recording]) -> Result<CalibrationFile> {
    let mut file = calibrate(recordings, &CalibrateOptions::default())?.file;
    file.created = String::new();
    Ok(file)
}

#[test]
fn a_soak_gives_equal_drift() {
    let soak = texts(Scenario::Static(StaticOptions {
        duration_s: 300.0,
        soak: Some(SoakOptions::default()),
    }));
    let (a, b) = (whole(&soak[0]), excerpt(&soak[0], SMALL));
    let json = |recording| serde_json::to_value(study(&[recording]).unwrap()).unwrap();
    assert_eq!(json(a), json(b));
    // A range of less than 5 °C is an error.
    let flat = poses(4.0);
    let why = |r| study(&[r]).unwrap_err().code().to_owned();
    let short = excerpt(&flat, SMALL);
    assert_eq!((why(whole(&flat)), why(short)).0, "temperature-span");
    assert_eq!(why(excerpt(&flat, SMALL)), "temperature-span");
}

fn kinds(recording: &Recording) -> Vec<FindingKind> {
    recording.findings.iter().map(|f| f.kind).collect()
}

#[test]
fn ends_of_long_static_intervals_are_stored() {
    let session = poses(20.0);
    let tight = Bounds {
        still_rows: 12 * 600,
        ..SMALL
    };
    let (a, b) = (whole(&session), excerpt(&session, tight));
    assert!(b.rows() < a.rows() / 2, "{} of {}", b.rows(), a.rows());
    assert!(kinds(&b).contains(&FindingKind::PosesShortened));
    assert_eq!(find_rests(&a).spans.len(), find_rests(&b).spans.len());
    let (x, y) = (calibrated(&[a]).unwrap(), calibrated(&[b]).unwrap());
    // Fewer rows test a pose less well.
    for file in [&x, &y] {
        assert!(matches!(file.verdict.grade, Grade::Good | Grade::Fair));
    }
    let motions = |f: &CalibrationFile| f.gyroscope.as_ref().unwrap().method;
    assert_eq!(motions(&x), motions(&y));
    for i in 0..3 {
        let off = (x.accelerometer.bias[i] - y.accelerometer.bias[i]).abs();
        assert!(off < 2e-3, "{off}");
    }
}

#[test]
fn rows_left_out_are_reported() {
    let session = poses(4.0);
    let few = Bounds {
        still_rows: 8 * BOUNDS.least,
        ..SMALL
    };
    let b = excerpt(&session, few);
    let stills = find_rests(&b).spans;
    assert_eq!(stills.len(), 8);
    assert!(kinds(&b).contains(&FindingKind::IntervalsLeftOut));

    let few = Bounds {
        motions: 4,
        ..SMALL
    };
    let b = excerpt(&session, few);
    let reported = b
        .findings
        .iter()
        .find(|f| f.kind == FindingKind::MotionsLeftOut);
    assert_eq!(reported.unwrap().count, 7);
    let moves = crate::poses::turns::motions(&b, &find_rests(&b).spans);
    assert_eq!(moves.len(), 4);
}

#[test]
fn static_intervals_of_a_very_long_recording_are_found() {
    let session = poses(4.0);
    let a = find_rests(&whole(&session)).spans;
    for (blocks, at_once) in [(200, 1 << 14), (200, 70), (100, 70)] {
        let long = Bounds {
            blocks,
            at_once,
            ..SMALL
        };
        let b = excerpt(&session, long);
        let found = find_rests(&b).spans;
        let rows = found
            .iter()
            .map(|s| b.row_in_file(s.start)..b.row_in_file(s.end - 1) + 1);
        let rows: Vec<Range<usize>> = rows.collect();
        // The blocks begin elsewhere, and those at the ends are left out of one of them only.
        let near = |a: usize, b: usize| a.abs_diff(b) <= 40;
        let alike = a
            .iter()
            .zip(&rows)
            .all(|(a, b)| near(a.start, b.start) && near(a.end, b.end));
        assert!(a.len() == rows.len() && alike, "{a:?} {rows:?}");
    }
}

#[test]
fn a_pipe_is_read_again_from_its_copy() {
    let (name, text) = poses(4.0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, &text).unwrap();
    let options = ReadOptions::default();
    let read = |source| read_from(&mut { source }, "-", &options, SMALL).unwrap();
    let pipe = read(Reopenable::Spooled(path.clone(), None));
    assert!(pipe.is_excerpt());
    assert_eq!(inspected(&pipe), inspected(&read(Reopenable::of(&path))));
}

#[test]
fn sections_of_a_long_recording_name_rows_of_the_file() {
    let (name, text) = poses(4.0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let options = ReadOptions::default();
    let read = |wanted: &[Range<usize>], whole| {
        read_rows_from(Reopenable::of(&path), &path, &options, wanted, whole).unwrap()
    };
    let all = read(&[], usize::MAX);
    assert!(!all.is_excerpt());
    let stills = find_rests(&all).spans;
    let with_motion = |pair: &[Range<usize>]| pair[0].start..pair[1].end;
    // From the third one on, and not to the end.
    let wanted: Vec<Range<usize>> = stills[2..11].windows(2).map(with_motion).collect();
    let some = read(&wanted, 1000);
    assert!(some.is_excerpt() && some.rows() < all.rows());
    assert_eq!(some.rows_in_file(), all.rows());
    let file = |recording: &Recording, stills: &[Range<usize>]| {
        let section = |(i, rows): (usize, &Range<usize>)| Section {
            label: format!("pose {i}"),
            rows: rows.clone(),
        };
        let mut options = CalibrateOptions::default();
        options.segment.sections = Some(stills.iter().enumerate().map(section).collect());
        let mut file = calibrate(std::slice::from_ref(recording), &options)?.file;
        file.created = String::new();
        file.inputs = Vec::new();
        serde_json::to_value(file).map_err(|e| crate::Error::input("json", e.to_string()))
    };
    assert_eq!(
        file(&all, &stills[2..11]).unwrap(),
        file(&some, &stills[2..11]).unwrap()
    );
    let error = file(&some, &stills[..11]).unwrap_err();
    assert_eq!(error.code(), "rows-not-kept");
}
