//! What is kept of a result, and how far it may move.

/// How far a column may move.
pub enum Tolerance {
    Equal,
    /// A tenth of the standard deviation in this column of the same row.
    Sigma(&'static str),
    /// This share of the value.
    Share(f64),
    Seconds(f64),
}
use Tolerance::{Equal, Seconds, Share, Sigma};

/// A column of the rows of `verb`: its name, where its values are in the result (`*` stands for
/// every entry of a list, a `#` at the end for the length of the list), its tolerance.
pub struct Column(
    pub &'static str,
    pub &'static str,
    pub &'static str,
    pub Tolerance,
);

#[rustfmt::skip]
pub const COLUMNS: &[Column] = &[
    Column("*", "faults", "/findings/*/kind", Equal),
    Column("*", "error", "/code", Equal),
    Column("*", "rows", "/rows", Equal),
    Column("inspect", "error", "/errors/*/code", Equal),
    Column("inspect", "faults", "/recordings/0/findings/*/kind", Equal),
    Column("inspect", "rows", "/recordings/0/row_counts/rows", Equal),
    Column("inspect", "lines", "/recordings/0/row_counts/lines", Equal),
    Column("inspect", "unit", "/recordings/0/accelerometer/unit", Equal),
    Column("inspect", "gyro_unit", "/recordings/0/gyroscope/unit", Equal),
    Column("inspect", "rate_hz", "/recordings/0/timing/mean_rate_hz", Share(1e-3)),
    Column("inspect", "poses", "/recordings/0/static_intervals/#", Equal),
    Column("inspect", "faces", "/recordings/0/static_intervals/*/face", Equal),
    Column("calibrate", "grade", "/verdict/grade", Equal),
    Column("calibrate", "unit", "/accelerometer/input_unit", Equal),
    Column("calibrate", "method", "/accelerometer/method", Equal),
    Column("calibrate", "poses", "/poses/#", Equal),
    Column("calibrate", "bias", "/accelerometer/bias", Sigma("bias_sd")),
    Column("calibrate", "bias_sd", "/accelerometer/deviations/bias", Share(0.05)),
    Column("calibrate", "scale", "/accelerometer/scale", Sigma("scale_sd")),
    Column("calibrate", "scale_sd", "/accelerometer/deviations/scale", Share(0.05)),
    Column("calibrate", "matrix", "/accelerometer/matrix", Sigma("matrix_sd")),
    Column("calibrate", "left_out_mps2", "/reliability/left_out_rms_mps2", Share(0.05)),
    Column("calibrate", "predicted_mps2", "/reliability/predicted_mps2", Share(0.05)),
    Column("calibrate", "worst_mps2", "/reliability/worst_direction/error_mps2", Share(0.05)),
    Column("calibrate", "undetected_mps2", "/reliability/undetected/effect_mps2", Share(0.05)),
    Column("calibrate", "gyro_unit", "/gyroscope/input_unit", Equal),
    Column("calibrate", "gyro_bias", "/gyroscope/bias", Share(1e-3)),
    Column("calibrate", "gyro_matrix", "/gyroscope/matrix", Share(1e-3)),
    Column("check", "judgement", "/verdict/judgement", Equal),
    Column("check", "poses", "/static_intervals/#", Equal),
    Column("check", "rms_mps2", "/rms_mps2", Share(0.05)),
    Column("check", "p_value", "/test/p_value", Share(0.1)),
    Column("compare", "judgement", "/verdict/judgement", Equal),
    Column("compare", "norm_mps2", "/magnitude/norm_rms_mps2", Share(0.05)),
    Column("compare", "p_value", "/magnitude/test/p_value", Share(0.1)),
    Column("compare", "angle_deg", "/orientation/angle_deg", Share(0.05)),
    Column("apply", "unit", "/accelerometer/unit", Equal),
    Column("apply", "columns", "/columns", Equal),
    Column("convert", "unit", "/accelerometer/unit", Equal),
    Column("convert", "columns", "/columns", Equal),
    Column("motion", "judgement", "/verdict/judgement", Equal),
    Column("motion", "rate_hz", "/rate_hz/true", Share(1e-3)),
    Column("motion", "rests_from_s", "/rests/*/start_s", Seconds(0.05)),
    Column("motion", "rests_to_s", "/rests/*/end_s", Seconds(0.05)),
    Column("motion", "ends", "/moves/*/ends", Equal),
    Column("motion", "displacement_m", "/moves/*/displacement_m", Sigma("sigma_m")),
    Column("motion", "sigma_m", "/moves/*/sigma_m", Share(0.05)),
    Column("noise", "n", "/channels/*/n/value", Share(0.05)),
    Column("noise", "b", "/channels/*/b/value", Share(0.05)),
    Column("noise", "k", "/channels/*/k/value", Share(0.05)),
    Column("noise", "intervals", "/static_intervals", Equal),
    Column("denoise", "sigma", "/filters/*/sigma", Share(1e-6)),
    Column("denoise", "segments", "/segments", Equal),
];
