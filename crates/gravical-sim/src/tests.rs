//! Files and options.

use super::*;

fn still_for(duration_s: f64) -> Scenario {
    Scenario::Static(StaticOptions { duration_s })
}

#[test]
fn nothing_is_written_if_one_target_exists() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("truth.json"), "mine").unwrap();
    let options = SimulateOptions::new(still_for(1.0));
    assert!(simulate_to(&options, folder.path(), false).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn options_out_of_range_are_reported() {
    let mut options = SimulateOptions::new(still_for(10.0));
    options.rate_hz = f64::NAN;
    let error = simulate(&options).unwrap_err();
    assert_eq!(error.category(), gravical_judge::Category::Usage);
    assert!(error.message().contains("rate"));
    options.rate_hz = 100.0;
    options.sensor.accel_range_g = 3;
    assert!(simulate(&options).unwrap_err().message().contains("3 g"));
    let mut options = SimulateOptions::new(still_for(86_400.0));
    options.rate_hz = 1000.0;
    assert!(simulate(&options).unwrap_err().message().contains("rows"));
}
