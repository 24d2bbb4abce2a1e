use super::*;
use crate::document::Detail;
use crate::figure::{Axis, Figure, Panel, Role, Series};
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{InputFile, InputRole};
use gravical::motion::{Motion, MotionOptions};
use gravical::recording::{ReadOptions, Recording, read, read_bytes};

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

#[test]
fn what_may_be_missing() {
    let csv = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/demo/poses/poses.csv"
    );
    let recording = read(std::path::Path::new(csv), &ReadOptions::default()).unwrap();
    let options = CalibrateOptions::default();
    let mut file = calibrate(&[recording], &options).unwrap().calibration;
    file.poses.clear();
    file.reliability.budget = None;
    file.accelerometer.covariance = None;
    file.gyroscope = None;
    file.findings.clear();
    file.inputs.clear();
    let text = calibration(&file, None, &[]).to_text(Detail::Full);
    assert!(text.contains("Findings\n  None.") && !text.contains("NaN"));
}

#[test]
fn names_are_no_markup() {
    let evil = "</script><img src=x onerror=alert(1)>\"'&|`\u{0}\n# a";
    let recording = push();
    let mut motion = moved(&recording);
    let json = serde_json::json!({
        "kind": evil, "severity": "note", "message": evil, "file": evil,
    });
    motion
        .result
        .findings
        .push(serde_json::from_value(json).unwrap());
    motion.result.computation.frame = evil.to_owned();
    motion.result.moves[0].unusable = Some(evil.to_owned());
    let line = Series::line(evil, Role::Raw, [[0.0, 0.0], [1.0, 1.0]], &[]);
    let axes = [
        Axis::new(evil, "", [0.0, 1.0]),
        Axis::rows([evil.to_owned()]),
    ];
    let panel = Panel::new(evil, evil, axes, [line]);
    let figures = [Figure::new("velocity", evil, evil, [panel])];
    let input = InputFile {
        path: evil.to_owned(),
        sha256: None,
        role: InputRole::Other,
    };
    let document = super::motion(&motion.result, &recording, &figures).with_provenance(
        evil,
        Some(evil),
        evil,
        &[input],
    );
    let page = document.to_html();
    assert!(!page.contains("<img") && !page.contains("push <script>"));
    assert_eq!(page.matches("</script>").count(), 1);
    // A drawing of its own is XML whatever its names are.
    let drawing = crate::figure::standalone(&figures[0]);
    assert!(!drawing.contains("<img"));
    let options = roxmltree::ParsingOptions::default();
    roxmltree::Document::parse_with_options(&drawing, options).unwrap();
}
