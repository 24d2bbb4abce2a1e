//! The steps that the values of a recording are written in.

/// No MEMS sensor reads more, m/s² and rad/s: a value beyond is not a measurement.
pub(crate) const MAX_FORCE_MPS2: f64 = 1e4;
pub(crate) const MAX_RATE_RAD_S: f64 = 1e3;
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

/// Neighbouring values closer than this, SI, differ by rounding of the computation only.
const MIN_STEP: f64 = 1e-9;

/// Step that values are written in: most neighbouring ones of those that occur are one apart. 0 if
/// they are all the same.
pub fn resolution(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]);
    quantile(steps.filter(|d| *d > MIN_STEP).collect(), 0.5)
}

/// The value that a fraction `q` of all is at most; 0 without values.
pub fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let k = ((values.len() - 1) as f64 * q) as usize;
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}
