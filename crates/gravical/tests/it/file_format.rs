//! The calibration file: its schema and its compatibility.

use std::path::Path;

use gravical::Category;
use gravical::calibration_file::Calibration;
use gravical::noise::NoiseResult;
use serde_json::json;

use crate::support::*;

/// `GRAVICAL_BLESS=1 cargo test -p gravical schema` updates them.
#[test]
fn the_schema_files_are_up_to_date() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    for (name, schema) in [
        ("calibration-3", Calibration::schema()),
        ("noise-1", NoiseResult::schema()),
    ] {
        let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        let path = docs.join(format!("gravical-{name}.schema.json"));
        if std::env::var_os("GRAVICAL_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let is_same = std::fs::read_to_string(&path).is_ok_and(|there| there == text);
        assert!(is_same, "{name} is stale; GRAVICAL_BLESS=1 rewrites it");
    }
}

fn sample() -> Calibration {
    calibrated(&six_files(&Sensor::default(), 600), &given_gravity()).calibration
}

#[test]
fn fields_of_later_and_of_earlier_versions() {
    let file = sample();
    let mut value = serde_json::to_value(&file).unwrap();
    value["humidity_model"] = json!({"slope": [1, 2, 3]});
    value["poses"][0]["humidity"] = json!(0.4);
    value["verdict"] = json!("later");
    value["accelerometer"]["scale"] = json!(null);
    let model = value.as_object_mut().unwrap().remove("drift");
    assert!(model.is_some());
    let schema = Calibration::schema();
    assert!(jsonschema::is_valid(&schema, &value), "open to new fields");
    let back = Calibration::parse(value.to_string().as_bytes()).unwrap();
    assert_eq!(file, back);
    assert_eq!(back.to_json().unwrap(), file.to_json().unwrap());
    value["inputs"][0]["role"] = json!("of-2030");
    Calibration::parse(value.to_string().as_bytes()).unwrap();
}

/// Fields, values that cannot be applied, and the code or the field that the error names.
const REFUSED: &str = "\
/drift/range_c | [50, -10] | drift
/drift/channels/0/channel | \"mx\" | drift
/drift/reference_c | null | syntax
/drift/channels/0/per_c | null | drift
/accelerometer/bias | [1, 2] | syntax
/format | \"gravical-calibration/1\" | format
/gravity_mps2 | 981 | gravity_mps2
/accelerometer/matrix | [[0, 0, 0], [0, 0, 0], [0, 0, 0]] | accelerometer.matrix
/accelerometer/matrix | [[1, 2, 3], [4, 5, 6], [7, 8, 9]] | accelerometer.matrix
/accelerometer/bias/1 | 1e300 | accelerometer.bias
/accelerometer/nominal_scale | 0 | accelerometer.nominal_scale
/reliability/predicted_mps2 | -1 | reliability.predicted_mps2
/poses/0/left_out_sd_mps2 | -1 | poses.left_out_sd_mps2
/accelerometer/covariance/parameters/0 | \"bias_z\" | accelerometer.covariance.parameters
/accelerometer/covariance/values/3/3 | -1e-4 | accelerometer.covariance.values
/accelerometer/covariance/values/3/4 | 1 | accelerometer.covariance.values
/accelerometer/covariance/values/0 | [] | accelerometer.covariance.values
/gyroscope/matrix/0 | [0, 0, 0] | gyroscope.matrix
/gyroscope/g_sensitivity/2/1 | 1e300 | gyroscope.g_sensitivity
/gyroscope/covariance/parameters/0 | \"m_xx\" | gyroscope.covariance.parameters
/gyroscope/covariance/values | [[1, 2, 0], [2, 1, 0], [0, 0, 1]] | gyroscope.covariance.values";

#[test]
fn what_cannot_be_applied_is_refused_with_its_field() {
    let mut plain = serde_json::to_value(sample()).unwrap();
    plain["drift"] = json!({
        "reference_c": 15.0, "range_c": [10.0, 30.0],
        "channels": [{
            "channel": "az", "input_unit": "m/s^2", "verdict": "corrected", "reason": "",
            "per_c": 0.02
        }]
    });
    let identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    plain["gyroscope"] = json!({
        "input_unit": "rad/s", "output_unit": "rad/s", "bias": [0, 0, 0], "matrix": identity,
        "g_sensitivity": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
        "covariance": {
            "parameters": ["bias_x", "bias_y", "bias_z"],
            // A variance of zero is accepted.
            "values": [[1, 0, 0], [0, 1, 0], [0, 0, 0]]
        }
    });
    Calibration::parse(plain.to_string().as_bytes()).unwrap();
    for row in REFUSED.lines() {
        let [field, value, said] = row.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        let mut changed = plain.clone();
        *changed.pointer_mut(field).unwrap() = serde_json::from_str(value).unwrap();
        let error = Calibration::parse(changed.to_string().as_bytes()).unwrap_err();
        assert_eq!(error.category(), Category::Input, "{field}: {error}");
        let named = error.message().split(':').next().unwrap();
        let code = error.code().strip_prefix("calibration-").unwrap();
        assert_eq!(if code == "values" { named } else { code }, said, "{field}");
    }
}
