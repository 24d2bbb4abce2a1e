//! The steps that the values of a recording are written in.

use crate::resolution;

/// No MEMS sensor reads more, m/s² and rad/s: a value beyond is not a measurement.
const MAX_FORCE_MPS2: f64 = 1e4;
const MAX_RATE_RAD_S: f64 = 1e3;
/// Values that a step is taken from: enough that most neighbouring ones occur.
const MAX_VALUES: usize = 200_000;

/// Steps that the values of each channel are written in, m/s² and rad/s; 0 where they are all the same.
///
/// Take it from values in the sensor's own axes: a cross-axis matrix mixes the steps.
pub fn resolutions(force_mps2: &[[f64; 3]], rate_rad_s: &[[f64; 3]]) -> [f64; 6] {
    std::array::from_fn(|c| {
        let column = [force_mps2, rate_rad_s][c / 3];
        let max = [MAX_FORCE_MPS2, MAX_RATE_RAD_S][c / 3];
        let values = column.iter().map(|v| v[c % 3]).filter(|v| v.abs() < max);
        resolution(values.take(MAX_VALUES))
    })
}
