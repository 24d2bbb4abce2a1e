use serde_json::Value;

use super::*;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{CalibrationFile, Grade};
use crate::check::{CheckOptions, check};
use crate::inspect::inspect;
use crate::recording::read_bytes;
use crate::segment::face::AxisMap;
use crate::segment::sections::Section;
use crate::segment::still::find_stills;
use crate::simulate::{
    PosesOptions, Scenario, SimulateOptions, SixPositionOptions, SoakOptions, StaticOptions,
    simulate, write,
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

fn excerpt((name, text): &(String, String), still: &StillOptions, bounds: Bounds) -> Recording {
    let source = Reopenable::Memory(text.as_bytes().into());
    let recording = read_from(
        &mut { source },
        name,
        &ReadOptions::default(),
        still,
        bounds,
    )
    .unwrap();
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

/// Inspection, calibration and check of excerpts equal those of the complete recordings.
fn check_equal_results(files: &[(String, String)]) -> Vec<Recording> {
    let all: Vec<Recording> = files.iter().map(whole).collect();
    let default = StillOptions::default();
    let some: Vec<Recording> = files
        .iter()
        .map(|file| excerpt(file, &default, SMALL))
        .collect();
    for (a, b) in all.iter().zip(&some) {
        assert_eq!(inspected(a), inspected(b));
    }
    let (a, b) = (calibrated(&all), calibrated(&some));
    let (Ok(a), Ok(b)) = (&a, &b) else {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
        return some;
    };
    let json = |file: &CalibrationFile| serde_json::to_value(file).unwrap();
    assert_eq!(json(a), json(b));
    let short = StillOptions::short_rests();
    let short: Vec<Recording> = files
        .iter()
        .map(|file| excerpt(file, &short, SMALL))
        .collect();
    let report = |recordings: &[Recording]| {
        let report = check(a, "cal.json", recordings, &CheckOptions::default()).unwrap();
        serde_json::to_value(report).unwrap()
    };
    assert_eq!(report(&all), report(&short));
    some
}

/// Applies `edit` to the data lines.
fn edited(
    (name, text): &(String, String),
    edit: impl Fn(usize, &str) -> String,
) -> (String, String) {
    let (mut out, mut row) = (String::new(), 0);
    for line in text.lines() {
        if line.starts_with(|c: char| c.is_ascii_digit()) {
            out += &edit(row, line);
            row += 1;
        } else {
            out += line;
            out += "\n";
        }
    }
    (name.clone(), out)
}

#[test]
fn a_continuous_session_gives_equal_results() {
    for hold_s in [1.3, 4.0] {
        check_equal_results(&[poses(hold_s)]);
    }
}

#[test]
fn six_files_give_equal_results() {
    let files = texts(Scenario::SixPosition(SixPositionOptions {
        hold_s: 20.0,
        ..SixPositionOptions::default()
    }));
    let some = check_equal_results(&files);
    assert_eq!(some.len(), 6);
    let turns = texts(Scenario::SixPosition(SixPositionOptions {
        hold_s: 5.0,
        continuous: true,
        ..SixPositionOptions::default()
    }));
    check_equal_results(&turns);
}

#[test]
fn gaps_and_breaks_give_equal_results() {
    let session = poses(4.0);
    let lost = edited(&session, |row, line| match row % 1500 {
        700..737 => String::new(),
        1499 => format!("{line}\n\n\n"),
        k if k % 311 == 0 => format!("{}\n", line.split(',').next().unwrap_or_default()),
        _ => format!("{line}\n"),
    });
    check_equal_results(&[lost]);
    // Segments, some of them never static or very short.
    let parts = edited(&session, |row, line| match row {
        450 | 460 | 620 | 625 | 1100 => format!("{line}\n\n\n"),
        _ => format!("{line}\n"),
    });
    check_equal_results(std::slice::from_ref(&parts));
    let named = (
        ("x.csv".to_owned(), parts.1.clone()),
        ("+y.csv".to_owned(), parts.1),
    );
    check_equal_results(&[named.0, named.1]);
}

#[test]
fn vibration_gives_equal_results() {
    let wave = |row: usize, size: f64| size * (0.7 * row as f64).sin() * (0.013 * row as f64).cos();
    for size in [0.4, 3.0, 30.0] {
        let rows = (0..6000).map(|i| {
            let up = 9.8 * f64::from(u8::from(i % 2000 < 1000));
            let v = wave(i, size);
            format!(
                "{},{:.3},{:.3},{:.3}\n",
                10 * i,
                v + up,
                0.5 * v,
                v + 9.8 - up
            )
        });
        let text = format!("t_ms,ax,ay,az\n{}", rows.collect::<String>());
        check_equal_results(&[("hand.csv".to_owned(), text)]);
    }
}

#[test]
fn a_soak_gives_equal_drift() {
    let soak = texts(Scenario::Static(StaticOptions {
        duration_s: 300.0,
        soak: Some(SoakOptions::default()),
    }));
    let still = StillOptions::default();
    let (a, b) = (whole(&soak[0]), excerpt(&soak[0], &still, SMALL));
    let json = |recording| serde_json::to_value(study(&[recording]).unwrap()).unwrap();
    assert_eq!(json(a), json(b));
    // A range of less than 5 °C is an error.
    let flat = poses(4.0);
    let why = |r| study(&[r]).unwrap_err().code().to_owned();
    let short = excerpt(&flat, &still, SMALL);
    assert_eq!((why(whole(&flat)), why(short)).0, "temperature-span");
    assert_eq!(why(excerpt(&flat, &still, SMALL)), "temperature-span");
}

#[test]
fn zero_rows_at_the_end_are_removed() {
    let mut session = poses(4.0);
    let stamp = session.1.lines().last().unwrap().split(',').next().unwrap();
    let stamp: u64 = stamp.parse().unwrap();
    let zeros = (1..70_000_u64).map(|i| format!("{},0,0,0,0,0,0,0\n", stamp + 10 * i));
    session.1 += &zeros.collect::<String>();
    let (a, b) = (
        whole(&session),
        excerpt(&session, &StillOptions::default(), SMALL),
    );
    assert_eq!(inspected(&a), inspected(&b));
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
    let (a, still) = (whole(&session), StillOptions::default());
    let b = excerpt(&session, &still, tight);
    assert!(b.rows() < a.rows() / 2, "{} of {}", b.rows(), a.rows());
    assert!(kinds(&b).contains(&FindingKind::PosesShortened));
    // Positions of the static intervals and number of motions are unchanged.
    let ends = |r: &Recording| -> Vec<[usize; 2]> {
        let spans = find_stills(r, &still).spans;
        let ends = |s: &Range<usize>| [s.start, s.end - 1].map(|row| r.row_in_file(row));
        spans.iter().map(ends).collect()
    };
    assert_eq!(ends(&a), ends(&b));
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
    let still = StillOptions::default();
    let few = Bounds {
        still_rows: 8 * BOUNDS.least,
        ..SMALL
    };
    let b = excerpt(&session, &still, few);
    let stills = find_stills(&b, &still).spans;
    assert_eq!(stills.len(), 8);
    assert!(kinds(&b).contains(&FindingKind::IntervalsLeftOut));
    let share = |r: &Recording| inspect(r, &AxisMap::default()).static_share;
    assert!((share(&b) - share(&whole(&session))).abs() < 1e-9);

    let few = Bounds {
        motions: 4,
        ..SMALL
    };
    let b = excerpt(&session, &still, few);
    let reported = b
        .findings
        .iter()
        .find(|f| f.kind == FindingKind::MotionsLeftOut);
    assert_eq!(reported.unwrap().count, 7);
    let moves = crate::segment::turns::motions(&b, &find_stills(&b, &still).spans);
    assert_eq!(moves.len(), 4);
    // The accelerometer's result is unchanged.
    let (x, y) = (calibrated(&[whole(&session)]), calibrated(&[b]));
    assert_eq!(x.unwrap().accelerometer.bias, y.unwrap().accelerometer.bias);
}

#[test]
fn static_intervals_of_a_very_long_recording_are_found() {
    let session = poses(4.0);
    let still = StillOptions::default();
    let a = find_stills(&whole(&session), &still).spans;
    for (blocks, at_once) in [(200, 1 << 14), (200, 70), (100, 70)] {
        let long = Bounds {
            blocks,
            at_once,
            ..SMALL
        };
        let b = excerpt(&session, &still, long);
        let found = find_stills(&b, &still).spans;
        let rows = found
            .iter()
            .map(|s| b.row_in_file(s.start)..b.row_in_file(s.end - 1) + 1);
        let rows: Vec<Range<usize>> = rows.collect();
        // The noise level is that of some of the blocks, so the ends can differ by a block.
        let near = |a: usize, b: usize| a.abs_diff(b) <= 20;
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
    let (still, options) = (StillOptions::default(), ReadOptions::default());
    let read = |source| read_from(&mut { source }, "-", &options, &still, SMALL).unwrap();
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
    let stills = find_stills(&all, &StillOptions::default()).spans;
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
