//! The true error of a simulated sensor with the result.

use gravical::calibration_file::CalibrationFile;
use gravical::core::matrix3;
use gravical::fit::model::sphere;
use gravical::live::Event;
use gravical::numfmt::milli_g;
use gravical::simulate::Truth;

/// Directions over which the error of ‖a‖ is averaged.
const DIRECTIONS: usize = 400;

/// The event and its sentence, for a recording in m/s².
pub fn truth_event(truth: &Truth, file: &CalibrationFile) -> (Event, String) {
    let sensor = &truth.accelerometer;
    let found = &file.accelerometer;
    let warm_c = file.temperature_c.map_or(0.0, |t| t.mean - 25.0);
    let bias: [f64; 3] =
        std::array::from_fn(|i| sensor.bias_mps2[i] + warm_c * sensor.bias_drift_mps2_per_c[i]);
    let error = |matrix: &[[f64; 3]; 3], offset: &[f64; 3]| {
        let squares = sphere(DIRECTIONS).map(|up| {
            let force = (up * truth.gravity_mps2).into();
            let raw = matrix3::add(&matrix3::mul_vec(&sensor.matrix, &force), &bias);
            let a = matrix3::mul_vec(matrix, &matrix3::sub(&raw, offset));
            (matrix3::norm(&a) - truth.gravity_mps2).powi(2)
        });
        milli_g((squares.sum::<f64>() / DIRECTIONS as f64).sqrt())
    };
    let norm_error_mg = error(&found.matrix, &found.bias);
    let before_mg = error(&matrix3::identity(), &[0.0; 3]);
    let text = format!(
        "The truth: error of ‖a‖ {norm_error_mg:.2} mg rms with this calibration, {before_mg:.1} mg without."
    );
    let event = Event::Truth {
        norm_error_mg,
        before_mg,
    };
    (event, text)
}
