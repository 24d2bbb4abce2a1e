//! The calibration file: its schema and its compatibility.

use std::path::Path;

use gravical::calibration_file::CalibrationFile;
use gravical::noise::NoiseResult;
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
fn fields_of_later_and_of_earlier_versions() {
    let file = sample();
    let mut value = serde_json::to_value(&file).unwrap();
    value["humidity_model"] = json!({"slope": [1, 2, 3]});
    value["accelerometer"]["poses"][0]["humidity"] = json!(0.4);
    value["verdict"]["next_pose"] = json!([0, 0.7, 0.7]);
    let model = value.as_object_mut().unwrap().remove("temperature_model");
    assert!(model.is_some());
    let schema = CalibrationFile::schema();
    assert!(jsonschema::is_valid(&schema, &value), "open to new fields");
    let back = CalibrationFile::parse(value.to_string().as_bytes()).unwrap();
    assert_eq!(file, back);
    assert_eq!(back.to_json().unwrap(), file.to_json().unwrap());
}

#[test]
fn what_cannot_be_applied_is_refused() {
    let with = |change: fn(&mut Value)| {
        let mut value = serde_json::to_value(sample()).unwrap();
        value["temperature_model"] = json!({
            "reference_c": 15.0, "reference_source": "session", "range_c": [10.0, 30.0], "inputs": [],
            "channels": [{
                "channel": "az", "input_unit": "m/s^2", "verdict": "corrected", "reason": "",
                "order": 1, "coefficients": [0.02]
            }]
        });
        change(&mut value);
        let error = CalibrationFile::parse(value.to_string().as_bytes()).unwrap_err();
        assert!(error.is_input());
        error.code()
    };
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 5] = [
        ("calibration-values", |v| {
            v["temperature_model"]["range_c"] = json!([50.0, -10.0])
        }),
        ("calibration-values", |v| {
            v["temperature_model"]["channels"][0]["channel"] = json!("mx")
        }),
        ("calibration-syntax", |v| {
            v["temperature_model"]["reference_c"] = json!(null)
        }),
        ("calibration-syntax", |v| {
            v["accelerometer"]["bias"] = json!([1.0, 2.0])
        }),
        ("calibration-format", |v| {
            v["format"] = json!("gravical-calibration/1")
        }),
    ];
    for (code, change) in cases {
        assert_eq!(with(change), code);
    }
}
