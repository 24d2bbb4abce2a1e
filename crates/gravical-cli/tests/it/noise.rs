//! `gravical noise`, and what takes its result.

use serde_json::Value;

use crate::support::*;

#[test]
fn noise_of_a_recording_at_rest_and_its_uses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for line in [
        "simulate static -o rest --duration 300 --temperature-rise 0 --quiet",
        "noise rest/static.csv -o noise.json",
        "noise rest/static.csv --to kalibr --upper-limit -o imu.yaml --quiet",
        "simulate poses -o poses --free 3 --quiet",
        "calibrate poses/poses.csv --gravity 9.80665 --noise noise.json -o cal.json --quiet",
        "simulate line -o line --quiet",
        "simulate static -o short --duration 5 --quiet",
    ] {
        ends(path, line, 0);
    }
    let json: Value = serde_json::from_str(&read(path, "noise.json")).unwrap();
    assert_eq!(json["format"], "gravical-noise/1");
    jsonschema::validate(&gravical::noise::NoiseResult::schema(), &json).unwrap();
    assert!(read(path, "imu.yaml").contains("gyroscope_random_walk: "));
    let yaml = ends(path, "export cal.json --to kalibr --upper-limit", 0).out;
    assert!(yaml.contains("gyroscope_random_walk: "), "{yaml}");
    let line = "motion line/line.csv --noise noise.json -o track.csv --verbose";
    let said = ends(path, line, 0).err;
    assert!(said.contains("noise-used"), "{said}");
    // Refused without K.
    for (line, said) in [
        (
            "noise rest/static.csv --to kalibr -o k.yaml",
            "--upper-limit",
        ),
        ("noise short/static.csv", "not-at-rest"),
        (
            "motion line/line.csv --noise rest/truth.json",
            "gravical noise",
        ),
    ] {
        let err = ends(path, line, 3).err;
        assert!(err.contains(said), "{line}: {err}");
    }
}
