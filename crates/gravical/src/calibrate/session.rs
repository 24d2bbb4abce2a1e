//! What the estimators need to know of a session.

use gravical_core::matrix3;

use crate::gravity::Gravity;
use crate::poses::Segmentation;
use crate::poses::face::AxisMap;
use crate::recording::Recording;

/// Recordings, poses, and what the user says of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Session<'a> {
    pub recordings: &'a [Recording],
    pub segmentation: &'a Segmentation,
    /// How the board sits in its case.
    pub axes: &'a AxisMap,
    /// Names of placements are believed, not data.
    pub faces_by_name: bool,
    pub gravity: &'a Gravity,
    /// The drift with temperature is tested, and fitted where it helps.
    pub drift: bool,
}

impl Session<'_> {
    pub fn nominal(&self) -> Option<f64> {
        self.recordings.first()?.accel_scale.nominal()
    }

    /// Input units per m/s²: nominal, or as gravity reads.
    pub fn scale(&self) -> f64 {
        let placements = self.segmentation.poses.iter();
        let mut lengths: Vec<f64> = placements.map(|p| matrix3::norm(&p.mean)).collect();
        let usual = || crate::stats::median(&mut lengths).unwrap_or(1.0) / self.gravity.value_mps2;
        self.nominal().unwrap_or_else(usual)
    }
}
