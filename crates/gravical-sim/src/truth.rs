//! True values of a simulation, for comparison with the results of a calibration or of a motion.

use serde::Serialize;

use crate::options::SimulateOptions;

/// True values of a simulation. Times are true seconds since the first row of the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// `gravical-truth/1`.
    pub format: String,
    /// Name and version of the program.
    pub tool: String,
    /// The seed.
    pub seed: u64,
    /// Local gravity, m/s².
    pub gravity_mps2: f64,
    /// The accelerometer.
    pub accelerometer: AccelerometerTruth,
    /// The gyroscope.
    pub gyroscope: GyroscopeTruth,
    /// The recordings, in chronological order.
    pub files: Vec<FileTruth>,
    /// All options used.
    pub options: SimulateOptions,
}

/// u = M f + b + drift·(T − 25 °C).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AccelerometerTruth {
    /// M, row-major, dimensionless: reading in m/s² per m/s².
    pub matrix: [[f64; 3]; 3],
    /// Bias at 25 °C, m/s².
    pub bias_mps2: [f64; 3],
    /// Drift of the bias, m/s² per °C.
    pub bias_drift_mps2_per_c: [f64; 3],
    /// Allan N, m/s/√s.
    pub noise_mps_rts: f64,
    /// One count, m/s².
    pub lsb_mps2: f64,
}

/// v = M ω + b + K f, f the specific force in m/s².
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GyroscopeTruth {
    /// M, row-major, dimensionless: reading in rad/s per rad/s.
    pub matrix: [[f64; 3]; 3],
    /// Bias, rad/s.
    pub bias_rad_s: [f64; 3],
    /// K, row-major, rad/s per m/s².
    pub g_sensitivity_rad_s_per_mps2: [[f64; 3]; 3],
    /// Allan N, rad/√s.
    pub noise_rad_rts: f64,
    /// One count, rad/s.
    pub lsb_rad_s: f64,
}

/// One recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FileTruth {
    /// File name.
    pub name: String,
    /// Rows written.
    pub rows: usize,
    /// Rows lost.
    pub dropped_rows: usize,
    /// Rows with a value at the end of its range.
    pub clipped_rows: usize,
    /// Time stamp of the first row before jitter, ms.
    pub first_stamp_ms: u64,
    /// Poses, in order.
    pub poses: Vec<PoseTruth>,
    /// Movements between the poses that are not turns on the table.
    pub moves: Vec<MoveTruth>,
}

/// Kind of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseKind {
    /// On a face, with a tilt.
    Face,
    /// Any attitude.
    Free,
    /// Rest before or after a move or turn; on a face, with a tilt.
    Rest,
}

/// A static interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoseTruth {
    /// `+x` … `-z` (the axis that points up), `free1` …, `rest1` ….
    pub label: String,
    /// Kind of the pose.
    pub kind: PoseKind,
    /// Unit vector up in the sensor frame, including the tilt.
    pub up: [f64; 3],
    /// Angle between `up` and the face, °; null for a free pose.
    pub tilt_deg: Option<f64>,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// A change of position or attitude between two poses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MoveTruth {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Displacement in the world, m. The world has z up and x along the horizontal component of
    /// the sensor's x at the first rest (of y if x points up).
    pub displacement_m: [f64; 3],
}
