//! The whole method, in order: read this first.
//!
//! Recordings are cut into placements, the placements sorted into faces, the
//! parameters estimated from the six faces, the result held against everything
//! that can show it wrong, and told with its uncertainty.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, calibrate};
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! // Six mean readings, one a row: the shortest session there is.
//! let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
//!            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
//! let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
//! let options = CalibrateOptions { gravity: gravical::gravity::Gravity::given(9.81)?, ..Default::default() };
//! let file = calibrate(&session, &options)?.file;
//! assert!((file.accelerometer.bias[0] - 0.385).abs() < 1e-12);
//! assert!((file.accelerometer.scale[2] - 1.018669).abs() < 1e-6);
//! # Ok::<(), gravical::Error>(())
//! ```

use crate::calibration_file::{
    AccelerometerSection, CalibrationFile, Covariance, FORMAT, InputFile, PlacementTilt,
    SensorInfo, TemperatureRange, TiltSource, creation_time,
};
use crate::estimate::ferraris;
use crate::gravity::Gravity;
use crate::recording::{AccelUnit, Finding, Recording, Severity};
use crate::segment::{Placement, SegmentOptions, Segmentation, segment};
use crate::validate::{checks, errors, predicted};
use crate::{Error, Result};

/// How to calibrate.
#[derive(Debug, Clone, Default)]
pub struct CalibrateOptions {
    /// How the session is cut.
    pub segment: SegmentOptions,
    /// Local gravity; default: standard.
    pub gravity: Gravity,
    /// Tilt of the placements, degrees (sd of each of two components); default:
    /// 1 is assumed.
    pub placement_tilt_deg: Option<f64>,
    /// Which sensor it is.
    pub sensor: SensorInfo,
    /// The command line, for the record.
    pub command: Option<String>,
}

/// Tilt of a box on a table, degrees (sd of each component).
pub const ASSUMED_TILT_DEG: f64 = 1.0;

/// So many times the assumed tilt is more than chance and a good board explain.
pub const UNUSUAL_TILT: f64 = 1.6;

impl CalibrateOptions {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        let wrong = |what: String| Err(Error::usage("option-range", what));
        let turn = self.segment.turn_angle_deg;
        if !(turn.is_finite() && turn.abs() >= 30.0) {
            return wrong(format!("--turn-angle of {turn}°: at least 30° are needed"));
        }
        if let Some(tilt) = self.placement_tilt_deg
            && !(0.0..=10.0).contains(&tilt)
        {
            return wrong(format!("--placement-tilt of {tilt}°: 0 to 10 is possible"));
        }
        if self.segment.rows == Some(0) {
            return wrong("--rows 0 takes no rows".to_owned());
        }
        Ok(())
    }
}

/// A calibration and the session that it comes from.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// What is written to the file and shown.
    pub file: CalibrationFile,
    /// The placements and turns.
    pub segmentation: Segmentation,
}

/// Calibrates a sensor from the recordings of one session by Ferraris' method.
///
/// # Errors
///
/// Input errors with the next thing to do: those of [`segment`], `missing-face`,
/// `same-face-twice`, `left-handed`, `missing-gyro`, `rate-unknown`,
/// `not-finite`. A result that fails a quality gate is no error: its verdict is
/// `poor`.
pub fn calibrate(recordings: &[Recording], options: &CalibrateOptions) -> Result<Calibrated> {
    options.validate()?;

    // Where did the sensor lie still, and which face was up?
    let segmentation = segment(recordings, &options.segment)?;
    let faces = ferraris::sort_into_faces(&segmentation.placements, recordings)?;

    // K, R and b of u = K R a + b.
    let gravity = options.gravity.value_mps2;
    let names = options
        .segment
        .faces_by_name
        .then_some(&options.segment.axes);
    let fit = ferraris::accelerometer(&faces, gravity, names)?;

    // Their covariance, from the noise of the means and the tilt of the
    // placements.
    let face_angle = fit.face_angle_rms_deg(&faces);
    let tilt = placement_tilt(options.placement_tilt_deg, face_angle);
    let covariance = fit.covariance(&faces, gravity, tilt.value.to_radians());

    // The gyroscope from the pauses and the known turns.
    let angle = options.segment.turn_angle_deg.to_radians();
    let gyroscope = ferraris::gyroscope(
        recordings,
        &segmentation,
        &faces,
        &fit.calibration,
        gravity,
        angle,
        &options.segment.axes,
    )?;

    // What do the fitted placements say, and what do they not?
    let offset = recordings.first().map_or(0.0, |r| r.zero_offset);
    let positions = errors::positions(
        &segmentation.placements,
        &faces,
        &fit.calibration,
        gravity,
        offset,
    );
    let nominal = recordings.first().and_then(|r| r.accel_scale.nominal());
    let mut accelerometer = AccelerometerSection {
        method: "ferraris".to_owned(),
        input_unit: recordings
            .first()
            .map_or(AccelUnit::Unknown, |r| r.accel_scale.unit),
        output_unit: AccelUnit::MetrePerSecondSquared,
        // A zero offset is only a way of reading; what is applied to the file's
        // own numbers carries it in the bias.
        bias: fit.calibration.bias.map(|b| b + offset),
        matrix: fit.calibration.matrix,
        scale: fit.parameters.scale,
        orientation: fit.parameters.orientation,
        covariance: covariance.as_ref().map(|c| Covariance {
            parameters: Covariance::parameter_names(),
            values: c.iter().map(|row| row.to_vec()).collect(),
        }),
        errors: errors::fit_errors(&positions),
        positions,
        scale_deviation_percent: nominal
            .map(|n| fit.parameters.scale.map(|k| 100.0 * (k / n - 1.0))),
        degrees_of_freedom: (faces.placements() as u32).saturating_sub(6),
        leave_one_out_rms_mps2: None,
        predicted_norm_error_mps2: None,
        placement_tilt_deg: Some(tilt),
    };
    accelerometer.predicted_norm_error_mps2 = covariance
        .as_ref()
        .and_then(|c| predicted::norm_error(&fit.calibration.matrix, c, gravity));

    // Everything odd, gathered; the verdict follows from it.
    let mut findings: Vec<Finding> = recordings
        .iter()
        .flat_map(|r| r.findings.iter().cloned())
        .collect();
    findings.extend(segmentation.findings.iter().cloned());
    findings.extend(gyroscope.findings);
    findings.extend(options.gravity.finding());
    findings.extend(checks::inputs(recordings));
    findings.extend(checks::accelerometer(
        &accelerometer,
        &faces,
        &segmentation.placements,
        offset,
        face_angle,
    ));
    findings.extend(checks::names(
        &options.segment.axes,
        &segmentation.placements,
        options.segment.faces_by_name,
    ));
    let verdict = checks::verdict(&accelerometer, &findings);
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity == Severity::Warning));

    let file = CalibrationFile {
        format: FORMAT.to_owned(),
        created: creation_time(),
        tool: concat!("gravical ", env!("CARGO_PKG_VERSION")).to_owned(),
        sensor: options.sensor.clone(),
        gravity_mps2: gravity,
        gravity_source: options.gravity.source,
        temperature_c: temperature(&segmentation.placements),
        accelerometer,
        gyroscope: gyroscope.section,
        inputs: recordings
            .iter()
            .map(|r| InputFile {
                path: r.name.clone(),
                sha256: r.sha256.clone(),
            })
            .collect(),
        findings,
        verdict,
        command: options.command.clone(),
    };
    Ok(Calibrated { file, segmentation })
}

/// The tilt that the uncertainty is computed with. Faces that lie further off
/// than the usual tilt explains are not believed to be better than they look:
/// an angle of rms α has two components of sd α/√2.
fn placement_tilt(given: Option<f64>, face_angle_rms_deg: f64) -> PlacementTilt {
    let seen = face_angle_rms_deg / std::f64::consts::SQRT_2;
    let (value, source) = match given {
        Some(value) => (value, TiltSource::Given),
        None if seen > ASSUMED_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (ASSUMED_TILT_DEG, TiltSource::Assumed),
    };
    PlacementTilt { value, source }
}

fn temperature(placements: &[Placement]) -> Option<TemperatureRange> {
    let some: Vec<f64> = placements.iter().filter_map(|p| p.temperature_c).collect();
    (!some.is_empty()).then(|| TemperatureRange {
        mean: some.iter().sum::<f64>() / some.len() as f64,
        min: some.iter().copied().fold(f64::INFINITY, f64::min),
        max: some.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}
