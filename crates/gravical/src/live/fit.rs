//! The calibration of a session, as an event.

use gravical_core::matrix3::norm;

use crate::Result;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::CalibrationFile;
use crate::poses::SegmentOptions;
use crate::poses::sections::Section;
use crate::recording::Recording;
use crate::recording::units::GyroUnit;

use super::event::{Fit, FittedPose, GyroFit, Stage};
use super::{LiveOptions, Pose, mg};

/// From this many poses on, a fit is tried.
pub(super) const FIRST_FIT: usize = 4;
/// From this many poses on it is complete.
pub(super) const FULL_FIT: usize = 6;

/// Calibrates with the poses at `sections` of the recording.
///
/// # Errors
///
/// Those of [`calibrate`].
pub(super) fn fit(
    recording: &Recording,
    sections: Vec<Section>,
    options: &LiveOptions,
) -> Result<CalibrationFile> {
    let options = CalibrateOptions {
        segment: SegmentOptions {
            sections: Some(sections),
            ..SegmentOptions::default()
        },
        gravity: options.gravity,
        sensor: options.sensor.clone(),
        ..CalibrateOptions::default()
    };
    Ok(calibrate(std::slice::from_ref(recording), &options)?.file)
}

/// The name of a pose in a section list: it claims no face, so that the data decide.
pub(super) fn section_label(pose: u32) -> String {
    format!("pose {pose}")
}

impl Fit {
    /// The figures of a calibration of `poses`, in their order.
    #[must_use]
    pub fn of(file: &CalibrationFile, poses: &[Pose]) -> Self {
        let section = &file.accelerometer;
        let to_mps2 = |units: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| mg(units[i] / section.scale[i]))
        };
        let fitted = |(result, pose): (&crate::calibration_file::PoseResult, &Pose)| FittedPose {
            pose: pose.pose,
            face: pose.face.clone(),
            up: result.calibrated.map(|c| c / norm(&result.calibrated)),
            error_mg: mg(norm(&result.calibrated) - file.gravity_mps2),
            left_out_mg: result.left_out_error_mps2.map(mg),
        };
        let suspect = section.contradiction();
        Fit {
            stage: if poses.len() < FULL_FIT {
                Stage::Rough
            } else {
                Stage::Full
            },
            bias_mg: to_mps2(section.bias),
            bias_sd_mg: section.deviations.map(|d| to_mps2(d.bias)),
            scale_percent: section.scale_deviation_percent,
            predicted_mg: section.predicted_norm_error_mps2.map(|e| 2.0 * mg(e)),
            worst_mg: section.worst_direction.as_ref().map(|w| mg(w.error_mps2)),
            leave_one_out_mg: section.leave_one_out_rms_mps2.map(mg),
            undetected_mg: section.undetected.as_ref().map(|u| mg(u.effect_mps2)),
            grade: file.verdict.grade,
            gyroscope: file.gyroscope.as_ref().map(|gyro| GyroFit {
                method: gyro.method,
                bias_deg_s: (gyro.input_unit != GyroUnit::Unknown).then(|| gyro.bias_deg_s()),
                motions: gyro.motions.map_or(0, |m| m.used),
            }),
            poses: section.poses.iter().zip(poses).map(fitted).collect(),
            suspect: suspect.and_then(|(index, _)| Some(poses.get(index)?.pose)),
        }
    }
}
