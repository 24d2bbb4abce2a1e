//! `gravical noise`, and what takes its result.

use serde_json::Value;

use crate::support::*;

fn run(folder: &std::path::Path, line: &str, code: i32) -> Run {
    let done = run_in(folder, words(line));
    assert_eq!(done.code, code, "{line}: {}", done.err);
    done
}

#[test]
fn noise_of_a_recording_at_rest_and_its_uses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(
        path,
        "simulate static -o rest --duration 300 --temperature-rise 0 --quiet",
        0,
    );
    let text = run(
        path,
        "noise rest/static.csv --part mpu6050 -o noise.json",
        0,
    )
    .out;
    assert!(text.starts_with("static.csv: accelerometer N "), "{text}");
    assert!(text.contains("N by data sheet, µg/√Hz"), "{text}");
    assert!(
        text.contains("not observable in 5.0 min: record at least"),
        "{text}"
    );
    let json: Value =
        serde_json::from_slice(&std::fs::read(path.join("noise.json")).unwrap()).unwrap();
    assert_eq!(json["format"], "gravical-noise/1");
    for channel in json["channels"].as_array().unwrap() {
        let gyroscope = channel["channel"].as_str().unwrap().starts_with('g');
        let truth = if gyroscope {
            0.005_f64.to_radians()
        } else {
            3.3e-3
        };
        let n = channel["n"]["value"].as_f64().unwrap();
        // Scale errors of up to 6 % are in the reading.
        assert!((n / truth - 1.0).abs() < 0.08, "{channel}");
    }
    let schema: Value = gravical::noise::NoiseResult::schema();
    jsonschema::validate(&schema, &json).unwrap();

    // Kalibr: refused without K, then with limits; the same from a calibration.
    let refused = run(path, "noise rest/static.csv --to kalibr -o imu.yaml", 3);
    assert!(refused.err.contains("--upper-limit"), "{}", refused.err);
    run(
        path,
        "noise rest/static.csv --to kalibr --upper-limit -o imu.yaml --quiet",
        0,
    );
    let yaml = std::fs::read_to_string(path.join("imu.yaml")).unwrap();
    assert!(yaml.contains("accelerometer_random_walk: ") && yaml.contains("rostopic: /imu0"));
    run(path, "simulate poses -o poses --free 3 --quiet", 0);
    run(
        path,
        "calibrate poses/poses.csv --gravity 9.80665 --noise noise.json -o cal.json --quiet",
        0,
    );
    let yaml = run(path, "export cal.json --to kalibr --upper-limit", 0).out;
    assert!(yaml.contains("calibrated = matrix"), "{yaml}");
    run(path, "export cal.json --to c --upper-limit", 2);

    // The bands of a move follow N.
    run(path, "simulate line -o line --quiet", 0);
    let band = |noise: &str| -> f64 {
        let line = format!("motion line/line.csv -c cal.json --json{noise}");
        let result: Value = serde_json::from_str(&run(path, &line, 0).out).unwrap();
        let noise = numbers(&result["moves"][0]["budget_m"]["noise"]);
        // What the clock leaves along the track does not depend on N.
        noise[2]
    };
    let by_rests = band("");
    let mut louder = json;
    for channel in louder["channels"].as_array_mut().unwrap() {
        for end in ["value", "low", "high"] {
            channel["n"][end] = (4.0 * channel["n"][end].as_f64().unwrap()).into();
        }
    }
    std::fs::write(path.join("louder.json"), louder.to_string()).unwrap();
    assert!((band(" --noise noise.json") / by_rests - 1.0).abs() < 0.3);
    // What drifts besides is the same.
    let louder = band(" --noise louder.json") / band(" --noise noise.json");
    assert!((3.5..4.0).contains(&louder), "{louder}");
    let said = run(
        path,
        "motion line/line.csv --noise noise.json -o track.csv --verbose",
        0,
    )
    .err;
    assert!(said.contains("noise-used"), "{said}");
}

#[test]
fn what_is_no_rest_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, "simulate static -o rest --duration 5 --quiet", 0);
    let refused = run(path, "noise rest/static.csv", 3);
    assert!(refused.err.contains("not-at-rest"), "{}", refused.err);
    let refused = run(path, "motion rest/static.csv --noise rest/truth.json", 3);
    assert!(refused.err.contains("gravical noise"), "{}", refused.err);
}
