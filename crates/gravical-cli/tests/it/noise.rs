//! `gravical noise`, and what takes its result.

use serde_json::Value;

use crate::support::*;

#[test]
fn noise_of_a_recording_at_rest_and_its_uses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let done = |line: &str| ends(path, line, 0);
    done("simulate static -o rest --duration 300 --temperature-rise 0 --quiet");
    done("noise rest/static.csv -o noise.json");
    let json: Value = serde_json::from_str(&read(path, "noise.json")).unwrap();
    assert_eq!(json["format"], "gravical-noise/1");
    jsonschema::validate(&gravical::noise::NoiseResult::schema(), &json).unwrap();

    // Kalibr: refused without K, then with limits.
    let refused = ends(path, "export noise.json --to kalibr -o imu.yaml", 3);
    assert!(refused.err.contains("--upper-limit"), "{}", refused.err);
    done("export noise.json --to kalibr --upper-limit -o imu.yaml");
    let yaml = read(path, "imu.yaml");
    assert!(yaml.contains("gyroscope_random_walk: "), "{yaml}");
    ends(path, "export noise.json --to c --upper-limit", 2);

    done("simulate static -o short --duration 5 --quiet");
    let refused = ends(path, "noise short/static.csv", 3);
    assert!(refused.err.contains("not-at-rest"), "{}", refused.err);
    let refused = ends(path, "export rest/truth.json --to kalibr", 3);
    assert!(refused.err.contains("gravical noise"), "{}", refused.err);
}
