//! The report's session: six raw means, and its three error figures.

use crate::support::*;

pub const MEANS: &str = "\
label,ax,ay,az
-x,-9.43,-0.27,0.92
+x,10.20,-0.04,-0.10
-y,0.46,-9.99,0.39
+y,0.29,9.73,0.49
-z,-0.05,-0.08,-9.54
+z,0.83,-0.18,10.42
";

#[test]
fn six_raw_means_give_the_reports_parameters_and_errors() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "means.csv", MEANS);
    let file = calibrate(
        folder.path(),
        "means.csv --gravity 9.81 --method ferraris",
        0,
    );
    let a = &file["accelerometer"];
    for (got, want) in numbers(&a["bias"]).iter().zip([0.385, -0.130, 0.440]) {
        close(*got, want, 1e-12);
    }
    let scale = [1.001552, 1.005178, 1.018669];
    for (got, want) in numbers(&a["scale"]).iter().zip(scale) {
        close(*got, want, 5e-7);
    }
    let e = &a["errors"];
    close(e["rms"].as_f64().unwrap(), 0.01338, 5e-6);
    close(e["max"].as_f64().unwrap(), 0.02931, 5e-6);
    close(e["mean_norm"].as_f64().unwrap(), 0.01785, 5e-6);

    // A row that is a mean carries no noise: nothing is known of the covariance.
    assert!(a["covariance"].is_null());
    assert!(a["predicted_norm_error_mps2"].is_null());
    assert_eq!(file["gravity_source"], "given");
    assert_eq!(file["verdict"]["grade"], "not-verifiable");
}
