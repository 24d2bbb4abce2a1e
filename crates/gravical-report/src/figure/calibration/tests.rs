use super::*;
use crate::figure::{Arrangement, Series, svg};
use gravical::calibrate::Method;
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::numfmt::milli_g;
use gravical::recording::{ReadOptions, read, read_bytes};
use gravical::simulate::{
    PosesOptions, Scenario, SimulateOptions, SixPositionOptions, simulate_to,
};

fn session(scenario: Scenario) -> Vec<Recording> {
    let folder = tempfile::tempdir().unwrap();
    let options = SimulateOptions::new(scenario);
    let (_, files) = simulate_to(&options, folder.path(), false).unwrap();
    let csv = |p: &&std::path::PathBuf| p.extension().is_some_and(|e| e == "csv");
    let read = |p: &std::path::PathBuf| read(p, &ReadOptions::default()).unwrap();
    files.iter().filter(csv).map(read).collect()
}

fn of(recordings: &[Recording]) -> (CalibrationFile, Vec<Figure>) {
    let done = calibrate(recordings, &CalibrateOptions::default()).unwrap();
    let segmentation = &done.segmentation;
    let session = Session {
        recordings,
        segmentation,
    };
    let figures = figures(&done.file, Some(session));
    (done.file, figures)
}

fn named<'a>(figures: &'a [Figure], name: &str) -> &'a Figure {
    figures.iter().find(|f| f.name == name).unwrap()
}

fn series<'a>(figure: &'a Figure, panel: usize, name: &str) -> &'a Series {
    let all = &figure.panels[panel].series;
    all.iter().find(|s| s.name == name).unwrap()
}

fn well_formed(figures: &[Figure]) {
    for figure in figures {
        assert!(NAMES.contains(&figure.name.as_str()));
        assert!(!figure.caption.is_empty() && !figure.panels.is_empty());
        for text in svg::inline(figure).iter().chain([&svg::standalone(figure)]) {
            roxmltree::Document::parse(text).unwrap();
            assert!(
                !text.contains("NaN") && !text.contains("no values"),
                "{}",
                figure.name
            );
        }
    }
}

#[test]
fn six_files_have_all_figures_with_the_numbers_of_the_file() {
    let recordings = session(Scenario::SixPosition(SixPositionOptions::default()));
    let (file, figures) = of(&recordings);
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, NAMES);
    well_formed(&figures);
    let a = &file.accelerometer;

    let norm = named(&figures, "norm");
    assert_eq!(norm.panels.len(), 2);
    let after = &series(norm, 0, "calibrated").y;
    for (p, got) in a.poses.iter().zip(after) {
        let off = p.magnitude_error_mps2.unwrap();
        assert!((got - (file.gravity_mps2 + off)).abs() < 1e-12);
    }
    // The raw magnitude by the nominal scale; the files are in m/s².
    let before = &series(norm, 0, "before").y;
    for (p, got) in a.poses.iter().zip(before) {
        assert!((got - norm_of(p.raw)).abs() < 1e-9);
    }
    let residuals = named(&figures, "residuals");
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (p, got) in a.poses.iter().zip(&series(residuals, 0, name).y) {
            assert!((got - 1e3 * p.error[axis]).abs() < 1e-12);
        }
    }
    let tilt = series(named(&figures, "tilt"), 0, "tilt");
    let tilts: Vec<f64> = a.poses.iter().filter_map(|p| p.tilt_deg).collect();
    assert_eq!(tilt.y, tilts);
    let parameters = named(&figures, "parameters");
    assert_eq!(parameters.arrangement, Arrangement::Beside);
    assert_eq!(series(parameters, 0, "value").y, a.bias);
    let deviation = a.scale_deviation_percent.unwrap();
    assert_eq!(series(parameters, 1, "value").y, deviation);
    let budget = named(&figures, "budget");
    let combined = a.budget.as_ref().unwrap().combined_mps2;
    assert_eq!(series(budget, 0, "combined").y, [milli_g(combined)]);
    let sphere = named(&figures, "sphere");
    let placed = sphere.panels.iter().flat_map(|p| &p.series);
    let placed: usize = placed.filter(|s| s.name == "pose").map(|s| s.x.len()).sum();
    assert_eq!((sphere.panels.len(), placed), (2, 6));
    let captures = named(&figures, "captures");
    assert_eq!(captures.panels.len(), 3);
    assert_eq!(captures.panels[0].stretches.len(), 6);
    let rows: usize = recordings.iter().map(Recording::rows).sum();
    assert_eq!(series(captures, 1, "raw").samples, rows);
    // One after the other, none on top of another.
    let known: Vec<f64> = series(captures, 1, "raw")
        .x
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    assert!(known.is_sorted());
}

#[test]
fn free_poses_show_what_was_left_out_of_the_fit() {
    let recordings = session(Scenario::Poses(PosesOptions::default()));
    let (file, figures) = of(&recordings);
    well_formed(&figures);
    let residuals = named(&figures, "residuals");
    let left_out = series(residuals, 1, "left out of the fit");
    for (p, got) in file.accelerometer.poses.iter().zip(&left_out.y) {
        match p.left_out_error_mps2 {
            Some(e) => assert_eq!(*got, milli_g(e)),
            None => assert!(got.is_nan()),
        }
    }
    let next = named(&figures, "sphere")
        .panels
        .iter()
        .flat_map(|p| &p.series);
    let next: usize = next
        .filter(|s| s.name == "would help")
        .map(|s| s.x.len())
        .sum();
    assert_eq!(next, file.accelerometer.proposed_poses().len());
}

#[test]
fn means_alone_and_files_without_their_session() {
    let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
               -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let recordings = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default()).unwrap()];
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let done = calibrate(&recordings, &options).unwrap();
    let session = Session {
        recordings: &recordings,
        segmentation: &done.segmentation,
    };
    let all = figures(&done.file, Some(session));
    well_formed(&all);
    // A row that is a mean has no noise; nothing is known of the uncertainty.
    assert!(all.iter().all(|f| f.name != "noise" && f.name != "budget"));
    let without = figures(&done.file, None);
    well_formed(&without);
    assert!(without.iter().all(|f| f.name != "captures"));
    assert!(without.iter().any(|f| f.name == "parameters"));
}

#[test]
fn many_recordings_share_the_points() {
    let rows = 4000;
    let text: String = (0..rows)
        .map(|i| format!("{},{},0,9.8\n", i, (i % 7) as f64 * 0.01))
        .collect();
    let text = format!("t_ms,ax,ay,az\n{text}");
    let one = read_bytes(text.as_bytes(), "a.csv", &ReadOptions::default()).unwrap();
    let all: Vec<Recording> = (0..20).map(|_| one.clone()).collect();
    let placed = captures::placed(&all);
    let lines = placed
        .iter()
        .map(|p| p.line(super::super::Role::Raw, "raw", |i| p.recording.accel[0][i]));
    let line = captures::joined(lines).unwrap();
    assert_eq!(line.samples, 20 * rows);
    assert!(line.x.len() < 20_000, "{}", line.x.len());
}
