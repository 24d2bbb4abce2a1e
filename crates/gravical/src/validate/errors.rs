//! Errors of the placements: what each read, what it should have read.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;

use crate::calibration_file::{FitErrors, PoseKind, PoseResult};
use crate::estimate::accelerometer::Use;
use crate::segment::Placement;

/// One entry a placement: faces against ±g on their axis, oblique ones against
/// gravity's length along their own direction. `offset` is added back to the
/// raw means, so that they are the file's own numbers. Means are in channels of
/// the board, faces in axes of the case: the calibration leads from one to the
/// other.
#[must_use]
pub fn poses(
    placements: &[Placement],
    uses: &[Use],
    calibration: &Calibration<f64>,
    gravity: f64,
    offset: f64,
) -> Vec<PoseResult> {
    placements
        .iter()
        .enumerate()
        .map(|(index, placement)| {
            let calibrated = calibration.apply(placement.mean);
            let own = &uses[index];
            let face = own.face;
            let length = matrix3::norm(&calibrated).max(f64::MIN_POSITIVE);
            let expected = match face {
                Some(face) => face.direction().map(|d| d * gravity),
                None => calibrated.map(|c| c / length * gravity),
            };
            let error = std::array::from_fn(|i| calibrated[i] - expected[i]);
            PoseResult {
                label: face.map_or_else(|| placement.label.clone(), |f| f.name()),
                kind: match face {
                    Some(_) => PoseKind::Face,
                    None => PoseKind::Free,
                },
                source: placement.source.clone(),
                rows: placement.count as u64,
                lines: placement.lines,
                raw: placement.mean.map(|m| m + offset),
                expected,
                calibrated,
                error,
                error_norm: matrix3::norm(&error),
                tilt_deg: own.tilt_deg.map(|(tilt, _)| tilt),
                tilt_sd_deg: own.tilt_deg.and_then(|(_, sd)| sd),
                magnitude_error_mps2: Some(length - gravity),
                left_out_error_mps2: own.left_out_error,
                left_out_sd_mps2: own.left_out_sd,
                fitted: own.fitted,
            }
        })
        .collect()
}

/// RMS over all components, largest component and mean norm of the errors of
/// the fitted faces.
#[must_use]
pub fn fit_errors(poses: &[PoseResult]) -> Option<FitErrors> {
    let faces: Vec<&PoseResult> = poses.iter().filter(|p| p.kind == PoseKind::Face).collect();
    if faces.is_empty() {
        return None;
    }
    let components: Vec<f64> = faces.iter().flat_map(|p| p.error).collect();
    Some(FitErrors {
        rms: (components.iter().map(|e| e * e).sum::<f64>() / components.len() as f64).sqrt(),
        max: components.iter().fold(0.0, |m, e| m.max(e.abs())),
        mean_norm: faces.iter().map(|p| p.error_norm).sum::<f64>() / faces.len() as f64,
    })
}

/// RMS of ‖a‖ − g over the oblique placements, which took no part in a fit of
/// six faces, m/s², and their number.
#[must_use]
pub fn free_norm_error(poses: &[PoseResult], gravity: f64) -> Option<(f64, usize)> {
    let off: Vec<f64> = poses
        .iter()
        .filter(|p| p.kind == PoseKind::Free && !p.fitted)
        .map(|p| matrix3::norm(&p.calibrated) - gravity)
        .collect();
    (!off.is_empty()).then(|| {
        let squares: f64 = off.iter().map(|e| e * e).sum();
        ((squares / off.len() as f64).sqrt(), off.len())
    })
}
