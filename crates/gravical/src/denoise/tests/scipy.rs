//! Comparison with results of scipy.

use super::*;

fn reference() -> Value {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/reference/scipy/filters.json"
    );
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

#[test]
fn savitzky_golay_equals_scipy() {
    let file = reference();
    let x = numbers(&file["x"]);
    let mut seen = 0;
    for case in file["savgol"].as_array().unwrap() {
        let whole = |key: &str| case[key].as_u64().unwrap() as usize;
        let spec = format!("savgol:{},{}", whole("window"), whole("order"));
        // Even windows have no middle.
        let is_ours = case["edge"] == "interp" && whole("window") % 2 == 1;
        if !is_ours || whole("derivative") > 0 {
            continue;
        }
        let mut y = x[..whole("n")].to_vec();
        designed(&spec, 100.0).apply(&mut y);
        let off = off(&y, &numbers(&case["y"]));
        assert!(off < 1e-12, "{spec}: {off:e}");
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn moving_average_equals_scipy() {
    let file = reference();
    let x = numbers(&file["x"]);
    for case in file["mean"].as_array().unwrap() {
        let spec = format!("mean:{}", case["window"]);
        if case["edge"] != "interp" {
            continue;
        }
        let mut y = x[..150].to_vec();
        designed(&spec, 100.0).apply(&mut y);
        let off = off(&y, &numbers(&case["y"]));
        assert!(off < 1e-12, "{spec}: {off:e}");
    }
}

#[test]
fn butterworth_equals_scipy() {
    let file = reference();
    let x = numbers(&file["x"]);
    let mut worst = 0.0_f64;
    for case in file["butter"].as_array().unwrap() {
        let spec = case["spec"].as_str().unwrap();
        if spec.contains('-') {
            // A band-pass.
            continue;
        }
        let filter = designed(spec, 100.0);
        let gain = filter.noise_gain().unwrap();
        let theirs = case["noise_gain"].as_f64().unwrap();
        assert!(
            (gain / theirs - 1.0).abs() < 1e-9,
            "{spec}: {gain} {theirs}"
        );
        if case["y"].is_null() {
            continue;
        }
        let mut y = x.clone();
        filter.apply(&mut y);
        let off = off(&y, &numbers(&case["y"]));
        worst = worst.max(off);
        assert!(off < 1e-10, "{spec}: {off:e}");
    }
    println!("largest difference {worst:e}");
}
