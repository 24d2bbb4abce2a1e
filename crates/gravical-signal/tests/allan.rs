//! Allan deviations beside those of allantools (`tests/reference/allantools`).

use gravical_signal::allan_variances;
use serde_json::Value;

const REFERENCE: &str = include_str!("../../../tests/reference/allantools/oadev.json");

/// The series of `make.py`.
fn series(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut walk = 0.0;
    let value = |_| {
        walk += 0.002 * uniform();
        9.8 + walk + uniform()
    };
    (0..count).map(value).collect()
}

#[test]
fn allan_deviations_are_those_of_allantools() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let values = series(number(&reference["count"]) as usize);
    assert_eq!(values[0], number(&reference["first"][0]));
    assert_eq!(values[values.len() - 1], number(&reference["last"]));
    let own = allan_variances(&[&values], 1.0);
    let theirs = reference["octaves"].as_array().unwrap();
    assert_eq!(own.len(), theirs.len());
    for (own, theirs) in own.iter().zip(theirs) {
        assert_eq!(own.tau_s, number(&theirs["m"]));
        let off = own.variance.sqrt() / number(&theirs["deviation"]) - 1.0;
        assert!(off.abs() < 1e-10, "{own:?}: {off:e}");
    }
}
