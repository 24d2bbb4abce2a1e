//! Files of `gravical-calibration/2`, whose numbers stood in other places. To go with the next change of the format.

use serde_json::{Map, Value, json};

use super::types::FORMAT;

/// Value of `format` that is still read.
pub(super) const OLDER: &str = "gravical-calibration/2";

/// Places of the numbers that stood beside the parameters of the accelerometer, and their names now.
const RELIABILITY: [[&str; 2]; 8] = [
    ["predicted_norm_error_mps2", "predicted_mps2"],
    ["worst_direction", "worst_direction"],
    ["leave_one_out_rms_mps2", "left_out_rms_mps2"],
    ["undetected", "undetected"],
    ["pose_tilt_deg", "pose_tilt_deg"],
    ["fit", "fit"],
    ["next_poses", "next_poses"],
    ["budget", "budget"],
];

/// The same file in the format of today.
pub(super) fn upgraded(mut file: Value) -> Value {
    let mut none = Map::new();
    let accelerometer = file.get_mut("accelerometer").and_then(Value::as_object_mut);
    let accelerometer = accelerometer.unwrap_or(&mut none);
    let mut reliability = Map::new();
    for [before, now] in RELIABILITY {
        if let Some(value) = accelerometer.remove(before) {
            reliability.insert(now.to_owned(), value);
        }
    }
    let next = reliability
        .get_mut("next_poses")
        .and_then(Value::as_array_mut);
    for pose in next.into_iter().flatten().filter_map(Value::as_object_mut) {
        if let Some(value) = pose.remove("predicted_norm_error_mps2") {
            pose.insert("predicted_mps2".to_owned(), value);
        }
    }
    let poses = accelerometer.remove("poses").unwrap_or(json!([]));
    let gravity_sd = accelerometer
        .remove("gravity_sd_mps2")
        .unwrap_or(json!(0.0));
    if let Some(file) = file.as_object_mut() {
        let drift = file.remove("temperature_model").unwrap_or(Value::Null);
        file.extend([
            ("format".to_owned(), json!(FORMAT)),
            ("reliability".to_owned(), Value::Object(reliability)),
            ("poses".to_owned(), poses),
            ("gravity_sd_mps2".to_owned(), gravity_sd),
            ("drift".to_owned(), drift),
        ]);
    }
    file
}
