//! What a verdict may say, against virtual sensors whose truth is known.

use gravical::calibrate::CalibrateOptions;
use gravical::gravity::Gravity;
use gravical::simulate::{PosesOptions, Scenario, SimulateOptions, simulate};
use gravical_core::matrix3;

use crate::support::*;
use crate::truth::recordings;

/// Six faces and twelve free poses at the equator, calibrated without a word about
/// where that was: the scale is off by 0.27 %, 1.8 standard deviations of what is
/// known of gravity.
#[test]
fn assumed_gravity_is_in_the_interval_of_the_scale_and_in_the_predicted_error() {
    let mut simulated = SimulateOptions::new(Scenario::Poses(PosesOptions {
        hold_s: 4.0,
        free: 12,
    }));
    simulated.gravity_mps2 = 9.780;
    let simulation = simulate(&simulated).unwrap();
    let session = recordings(&simulation);
    let assumed = calibrated(&session, &CalibrateOptions::default())
        .file
        .accelerometer;
    let given = CalibrateOptions {
        gravity: Gravity::given(9.780).unwrap(),
        ..CalibrateOptions::default()
    };
    let given = calibrated(&session, &given).file.accelerometer;
    let truth = matrix3::row_norms(&simulation.truth.accelerometer.matrix);
    let sd = assumed.deviations.unwrap().scale;
    for i in 0..3 {
        let z = (assumed.scale[i] - truth[i]) / sd[i];
        assert!((-1.96..-1.5).contains(&z), "{i}: {z}");
    }
    // Whatever the sensor, gravity adds its own 15 mm/s² in every direction.
    let [with, without] = [assumed, given].map(|a| a.predicted_norm_error_mps2.unwrap());
    close((with * with - without * without).sqrt(), 0.015, 2e-4);
}
