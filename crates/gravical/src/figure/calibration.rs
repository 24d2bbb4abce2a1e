//! Figures of a calibration.

use crate::calibration_file::CalibrationFile;
use crate::recording::Recording;
use crate::segment::Segmentation;

use super::{Axis, Figure, Panel, Role, Series};

/// The recordings behind a calibration, and how they were cut.
#[derive(Debug, Clone, Copy)]
pub struct Session<'a> {
    /// The recordings.
    pub recordings: &'a [Recording],
    /// Placements and turns.
    pub segmentation: &'a Segmentation,
}

/// All figures that a calibration allows, in the order of a report. Without the
/// session the raw captures are left out.
#[must_use]
pub fn figures(file: &CalibrationFile, session: Option<Session<'_>>) -> Vec<Figure> {
    let _ = session;
    vec![norm(file)]
}

/// ‖a‖ of each placement.
fn norm(file: &CalibrationFile) -> Figure {
    let positions = &file.accelerometer.positions;
    let names: Vec<String> = positions.iter().map(|p| p.label.clone()).collect();
    let x: Vec<f64> = (0..names.len()).map(|i| i as f64).collect();
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let after = positions.iter().map(|p| length(p.calibrated)).collect();
    let panel = Panel::new(Axis::names("placement", names), Axis::new("‖a‖", "m/s²"))
        .with(Series::rule(
            "local gravity",
            Role::Reference,
            file.gravity_mps2,
        ))
        .with(Series::points("calibrated", Role::Calibrated, x, after));
    Figure::new("norm", "Magnitude at rest", "…").with(panel)
}
