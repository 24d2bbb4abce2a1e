use super::*;
use crate::figure::{Series, svg};
use gravical::motion::truth::{add_comparison, read_reference};
use gravical::motion::{MotionOptions, motion};
use gravical::recording::{ReadOptions, Recording, read, read_bytes};
use gravical::simulate::{LineOptions, Scenario, SimulateOptions, StaticOptions, simulate_to};

fn recording(scenario: Scenario) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let (_, files) = simulate_to(&SimulateOptions::new(scenario), folder.path(), false).unwrap();
    let csv = |p: &&std::path::PathBuf| p.extension().is_some_and(|e| e == "csv");
    read(files.iter().find(csv).unwrap(), &ReadOptions::default()).unwrap()
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
        for text in svg::inline(figure).iter().chain([&svg::standalone(figure)]) {
            roxmltree::Document::parse(text).unwrap();
            assert!(!text.contains("NaN"), "{}", figure.name);
        }
    }
}

#[test]
fn a_line_has_the_figures_of_its_track() {
    let recording = recording(Scenario::Line(LineOptions::default()));
    let motion = motion(&recording, None, &MotionOptions::default()).unwrap();
    let figures = figures(&motion);
    well_formed(&figures);
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    // One move: nothing to compare.
    let wanted = NAMES.into_iter().filter(|n| *n != "moves");
    assert_eq!(names, wanted.collect::<Vec<_>>());
    let track = motion.track();
    let position = named(&figures, "position");
    assert_eq!(position.panels.len(), 3);
    let own = series(position, 1, "without a calibration");
    let truth: Vec<f64> = track.position_m.iter().map(|p| p[1]).collect();
    assert_eq!(own.y, truth);
    let band = series(position, 1, "± 2σ");
    assert_eq!(
        band.high.last().copied(),
        Some(truth.last().unwrap() + 2.0 * track.sigma_position_m.last().unwrap()[1])
    );
    assert_eq!(
        position.panels[0].stretches.len(),
        motion.result.rests.len()
    );
    let plane = &named(&figures, "trajectory").panels[0];
    assert!(plane.equal && plane.x.label == "x" && plane.y.label == "y");
    let end = series(named(&figures, "trajectory"), 0, "end");
    let at = motion.result.r#final.position_m.unwrap();
    assert_eq!((end.x[0], end.y[0]), (at[0], at[1]));
    let budget = series(named(&figures, "budget"), 0, "part");
    let (_, parts) = motion.result.largest_budget().unwrap();
    let norm = gravical::core::matrix3::norm;
    let parts = [parts.noise, parts.calibration, parts.attitude].map(|p| norm(&p));
    let factor = if norm(&parts) < 0.5 { 1e3 } else { 1.0 };
    assert_eq!(budget.y, parts.map(|v| factor * v));
}

#[test]
fn a_reference_lies_over_the_result() {
    let recording = recording(Scenario::Line(LineOptions::default()));
    let mut motion = motion(&recording, None, &MotionOptions::default()).unwrap();
    // The result itself, a metre aside and 100 times more slowly sampled.
    let track = motion.track();
    let rows = track.t_s.iter().zip(&track.position_m).step_by(10);
    let rows: String = rows
        .map(|(t, p)| format!("{t},{},{},{}\n", p[0] + 1.0, p[1] + 1.0, p[2]))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("truth.csv");
    std::fs::write(&path, format!("t_s,px_m,py_m,pz_m\n{rows}")).unwrap();
    let reference = read_reference(&path, &recording, std::path::Path::new("line.csv")).unwrap();
    add_comparison(&mut motion, &reference).unwrap();
    let reference = motion.reference.as_ref().unwrap();
    let last = reference.position_m.last().unwrap();
    let own = motion.result.r#final.position_m.unwrap();
    for i in 0..3 {
        assert!((last[i] - own[i]).abs() < 2e-3, "{last:?} {own:?}");
    }
    let figures = figures(&motion);
    well_formed(&figures);
    assert_eq!(
        series(named(&figures, "position"), 2, "reference").y.len(),
        reference.t_s.len()
    );
    series(named(&figures, "trajectory"), 0, "reference");
}

#[test]
fn at_rest_there_is_the_acceleration() {
    let recording = recording(Scenario::Static(StaticOptions::default()));
    let motion = motion(&recording, None, &MotionOptions::default()).unwrap();
    let figures = figures(&motion);
    well_formed(&figures);
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["acceleration"]);
}

#[test]
fn constant_and_tiny_recordings_have_figures_without_nonsense() {
    for rows in [2, 40] {
        let text: String = (0..rows)
            .map(|i| format!("{},0,0,9.81\n", 10 * i))
            .collect();
        let text = format!("t_ms,ax,ay,az\n{text}");
        let recording = read_bytes(text.as_bytes(), "c.csv", &ReadOptions::default()).unwrap();
        if let Ok(motion) = motion(&recording, None, &MotionOptions::default()) {
            well_formed(&figures(&motion));
        }
    }
}

#[test]
fn the_plane_is_where_it_moves() {
    let extent = |high: [f64; 3]| Extent {
        low: [0.0; 3],
        high,
    };
    assert_eq!(plane::plane_of(&extent([1.0, 2.0, 1.5])), [0, 1]);
    assert_eq!(plane::plane_of(&extent([1.0, 2.0, 70.0])), [1, 2]);
    assert_eq!(plane::plane_of(&extent([1.0, 0.0, 70.0])), [0, 2]);
    assert_eq!(seconds(12.34, 20.0), "12.3 s");
    assert_eq!(seconds(120.4, 900.0), "120 s");
}
