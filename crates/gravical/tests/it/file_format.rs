//! The calibration file: its schema and its compatibility.

use std::path::Path;

use gravical::calibration_file::{CalibrationFile, to_imucal};
use gravical::live::Message;
use gravical::noise::NoiseResult;
use gravical::recording::AccelUnit;
use serde_json::{Value, json};

use crate::support::*;

/// `GRAVICAL_BLESS=1 cargo test -p gravical schema` updates them.
#[test]
fn the_schema_files_are_up_to_date() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    for (name, schema) in [
        (
            "gravical-calibration-2.schema.json",
            CalibrationFile::schema(),
        ),
        ("gravical-live-1.schema.json", Message::schema()),
        ("gravical-noise-1.schema.json", NoiseResult::schema()),
    ] {
        let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        let path = docs.join(name);
        if std::env::var_os("GRAVICAL_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let there = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            there == text,
            "docs/{name} is stale; GRAVICAL_BLESS=1 rewrites it"
        );
    }
}

fn sample() -> CalibrationFile {
    calibrated(&six_files(&Sensor::default(), 600), &given_gravity()).file
}

#[test]
fn all_specified_keys_are_written() {
    let written = serde_json::to_value(sample()).unwrap();
    for pointer in [
        "/format",
        "/created",
        "/tool",
        "/sensor/id",
        "/sensor/model",
        "/gravity_mps2",
        "/gravity_source",
        "/temperature_c",
        "/accelerometer/method",
        "/accelerometer/input_unit",
        "/accelerometer/output_unit",
        "/accelerometer/bias/2",
        "/accelerometer/matrix/2/2",
        "/accelerometer/scale/2",
        "/accelerometer/orientation/2/2",
        "/accelerometer/covariance/parameters/11",
        "/accelerometer/covariance/values/11/11",
        "/accelerometer/poses/5/label",
        "/accelerometer/poses/5/kind",
        "/accelerometer/poses/5/source",
        "/accelerometer/poses/5/rows",
        "/accelerometer/poses/5/raw/2",
        "/accelerometer/poses/5/expected/2",
        "/accelerometer/poses/5/calibrated/2",
        "/accelerometer/poses/5/error/2",
        "/accelerometer/poses/5/error_norm",
        "/accelerometer/poses/5/tilt_deg",
        "/accelerometer/errors/rms",
        "/accelerometer/errors/max",
        "/accelerometer/errors/mean_norm",
        "/accelerometer/scale_deviation_percent/2",
        "/accelerometer/degrees_of_freedom",
        "/accelerometer/leave_one_out_rms_mps2",
        "/accelerometer/predicted_norm_error_mps2",
        "/accelerometer/pose_tilt_deg/value",
        "/accelerometer/pose_tilt_deg/source",
        "/gyroscope",
        "/inputs/5/path",
        "/inputs/5/sha256",
        "/findings",
        "/verdict/grade",
        "/verdict/reasons",
    ] {
        assert!(written.pointer(pointer).is_some(), "{pointer}");
    }
    assert_eq!(written["format"], "gravical-calibration/2");
    assert_eq!(written["accelerometer"]["poses"][0]["kind"], "face");
    assert_eq!(written["verdict"]["grade"], "not-verifiable");
    assert_eq!(
        written["accelerometer"]["covariance"]["parameters"],
        json!([
            "m_xx", "m_xy", "m_xz", "m_yx", "m_yy", "m_yz", "m_zx", "m_zy", "m_zz", "bias_x",
            "bias_y", "bias_z"
        ])
    );
}

#[test]
fn writing_and_reading_is_exact() {
    let file = sample();
    let text = file.to_json().unwrap();
    let back = CalibrationFile::parse(text.as_bytes()).unwrap();
    assert_eq!(file, back);
    assert_eq!(back.to_json().unwrap(), text);
}

#[test]
fn fields_of_a_later_version_are_ignored() {
    let file = sample();
    let mut value = serde_json::to_value(&file).unwrap();
    value["humidity_model"] = json!({"slope": [1, 2, 3]});
    value["accelerometer"]["condition"] = json!(3.2);
    value["accelerometer"]["poses"][0]["humidity"] = json!(0.4);
    value["accelerometer"]["bias_sd"] = json!([0.1, 0.1, 0.1]);
    value["verdict"]["next_pose"] = json!([0, 0.7, 0.7]);
    let schema = CalibrationFile::schema();
    assert!(jsonschema::is_valid(&schema, &value), "open to new fields");
    let back = CalibrationFile::parse(value.to_string().as_bytes()).unwrap();
    assert_eq!(file, back);
}

#[test]
fn files_without_a_temperature_model_are_read() {
    let file = sample();
    let mut value = serde_json::to_value(&file).unwrap();
    assert!(
        value
            .as_object_mut()
            .unwrap()
            .remove("temperature_model")
            .is_some()
    );
    assert!(jsonschema::is_valid(&CalibrationFile::schema(), &value));
    assert_eq!(
        CalibrationFile::parse(value.to_string().as_bytes()).unwrap(),
        file
    );
}

/// A soak in two poses, for a model of the drift.
fn with_temperature_model() -> CalibrationFile {
    let rows = |up: f64| {
        let mut csv = String::from("t_s,ax (m/s^2),ay (m/s^2),az (m/s^2),temp (C)\n");
        for i in 0..6000 {
            let t_s = 0.1 * f64::from(i);
            let x = 0.2 * (t_s - 300.0).abs() - 30.0;
            let wobble = 0.005 * (2.4 * f64::from(i)).sin();
            let az = 2e-3 * x + up * 9.8 + wobble;
            csv += &format!(
                "{t_s:.1},{:.5},{:.5},{az:.5},{:.2}\n",
                wobble,
                -wobble,
                20.0 + x
            );
        }
        read(csv.as_bytes())
    };
    let model = gravical::temperature::study(&[rows(1.0), rows(-1.0)]).unwrap();
    assert!(model.channel("az").unwrap().coefficients[0] > 1.9e-3);
    CalibrationFile {
        temperature_model: Some(model),
        ..sample()
    }
}

#[test]
fn a_temperature_model_round_trips_exactly() {
    let file = with_temperature_model();
    validate(&file);
    let back = CalibrationFile::parse(file.to_json().unwrap().as_bytes()).unwrap();
    assert_eq!(file, back);
}

#[test]
fn a_temperature_model_that_cannot_be_applied_is_refused() {
    let with = |change: fn(&mut Value)| {
        let mut value = serde_json::to_value(with_temperature_model()).unwrap();
        change(&mut value["temperature_model"]);
        CalibrationFile::parse(value.to_string().as_bytes())
            .unwrap_err()
            .code()
    };
    assert_eq!(
        with(|m| m["range_c"] = json!([50.0, -10.0])),
        "calibration-values"
    );
    assert_eq!(
        with(|m| m["channels"][0]["channel"] = json!("mx")),
        "calibration-values"
    );
    assert_eq!(
        with(|m| m["channels"][0]["channel"] = json!("az")),
        "calibration-values"
    );
    assert_eq!(
        with(|m| m["reference_c"] = json!(null)),
        "calibration-syntax"
    );
}

#[test]
fn a_file_of_another_format_is_refused() {
    for (format, word) in [
        ("gravical-calibration/1", "before 0.1.0"),
        ("gravical-calibration/3", "this program reads"),
    ] {
        let mut value = serde_json::to_value(sample()).unwrap();
        value["format"] = json!(format);
        let error = CalibrationFile::parse(value.to_string().as_bytes()).unwrap_err();
        assert_eq!(error.code(), "calibration-format");
        assert!(error.is_input());
        assert!(error.message().contains(word), "{error}");
    }
}

#[test]
fn invalid_values_are_refused() {
    let with = |change: fn(&mut Value)| {
        let mut value = serde_json::to_value(sample()).unwrap();
        change(&mut value);
        CalibrationFile::parse(value.to_string().as_bytes())
            .unwrap_err()
            .code()
    };
    assert_eq!(
        with(|v| v["accelerometer"]["matrix"][1] = v["accelerometer"]["matrix"][0].clone()),
        "calibration-values"
    );
    assert_eq!(
        with(|v| v["accelerometer"]["bias"] = json!([1.0, 2.0])),
        "calibration-syntax"
    );
    assert_eq!(
        with(|v| v["accelerometer"]["bias"] = json!(null)),
        "calibration-syntax"
    );
    assert_eq!(
        with(|v| drop(v.as_object_mut().unwrap().remove("accelerometer"))),
        "calibration-syntax"
    );
    for (text, line) in [("{", Some(1)), ("", None), ("{\n \"format\": \n}", Some(3))] {
        let error = CalibrationFile::parse(text.as_bytes()).unwrap_err();
        assert_eq!(error.code(), "calibration-syntax", "{text:?}");
        if line.is_some() {
            assert_eq!(error.location().unwrap().line, line, "{text:?}");
        }
    }
}

#[test]
fn imucal_files_round_trip() {
    let file = sample();
    let text = to_imucal(&file).unwrap();
    let back = CalibrationFile::parse(text.as_bytes()).unwrap();
    validate(&back);
    let (a, b) = (&file.accelerometer, &back.accelerometer);
    assert_eq!((a.bias, a.scale), (b.bias, b.scale));
    assert_eq!(a.orientation, b.orientation);
    for (x, y) in a.matrix.iter().flatten().zip(b.matrix.iter().flatten()) {
        close(*x, *y, 1e-12);
    }
    assert_eq!(b.input_unit, AccelUnit::MetrePerSecondSquared);
    assert!(back.gyroscope.is_none());
}

#[test]
fn the_creation_time_can_be_set() {
    // Set for the whole process: no other test here depends on it.
    let file = sample();
    assert!(file.created.ends_with('Z'), "{}", file.created);
    assert!(file.created.len() == "2025-01-01T00:00:00Z".len());
}
