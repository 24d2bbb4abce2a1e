//! The state of the recording for the person who records: rate, magnitude, the side that is up; in one
//! line.

use gravical::core::matrix3::norm;
use gravical::poses::face::Face;
use gravical::recording::{AccelScale, Recording};
use serde::Serialize;

/// Magnitude and direction are means over this time, s.
const RECENT_S: f64 = 0.5;
/// Columns of the status line.
const MAX_COLUMNS: usize = 79;

/// The recording at one moment.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Status {
    /// Rows stored.
    pub rows: u64,
    /// Since the first row, without pauses, s.
    pub elapsed_s: f64,
    /// Rows are not stored.
    pub paused: bool,
    /// Lines rejected so far.
    pub rejected: u64,
    /// Rows a second, by their stamps.
    pub rate_hz: Option<f64>,
    /// Magnitude of the mean acceleration of the last half second, in the unit of the file.
    pub norm: Option<f64>,
    #[serde(skip)]
    pub accel: Option<AccelScale>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<f64>,
    /// The face that is nearest to up: `+x`.
    pub up: Option<String>,
}

impl Status {
    /// Adds what the last rows say.
    pub fn observe(&mut self, recording: &Recording) {
        self.rate_hz = recording.timing.rate_hz();
        let rows = (RECENT_S * self.rate_hz.unwrap_or(1.0)).ceil().max(1.0);
        let mean = recording.accel.each_ref().map(|axis| {
            let recent = axis.iter().rev().take(rows as usize).copied();
            let recent: Vec<f64> = recent.filter(|v| v.is_finite()).collect();
            recent.iter().sum::<f64>() / recent.len() as f64
        });
        self.norm = Some(norm(&mean)).filter(|norm| norm.is_finite());
        self.up = self.norm.map(|_| Face::nearest(mean).0.name());
        self.accel = Some(recording.accel_scale);
        let temperatures = recording.temperature_c.iter().flatten();
        self.temperature_c = temperatures.copied().rfind(|t| t.is_finite());
    }

    /// One line of at most 79 columns: what is needed most comes first, and the rest where there is
    /// room.
    pub fn line(&self) -> String {
        let mut parts = vec![
            format!("{:.1} s", self.elapsed_s),
            format!("{} rows", self.rows),
        ];
        parts.extend(self.paused.then(|| "PAUSED".to_owned()));
        parts.extend(self.rate_hz.map(|rate| format!("{rate:.1} Hz")));
        parts.extend(self.norm.map(|norm| {
            // In m/s², or as it stands in a file of unknown unit.
            match self.accel.and_then(|accel| accel.nominal()) {
                Some(per_mps2) => format!("‖a‖ {:.2} m/s²", norm / per_mps2),
                None => format!("‖a‖ {norm:.2}"),
            }
        }));
        parts.extend(self.up.as_ref().map(|up| format!("up: {up}")));
        parts.extend((self.rejected > 0).then(|| format!("{} rejected", self.rejected)));
        parts.extend(self.temperature_c.map(|t| format!("{t:.1} °C")));
        while parts.join("  ").chars().count() > MAX_COLUMNS && parts.pop().is_some() {}
        parts.join("  ")
    }
}
