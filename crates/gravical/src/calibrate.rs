//! The whole method, in order: read this first.
//!
//! Recordings are divided into poses, the parameters are estimated from face poses and free
//! poses, the result is tested against poses that the fit did not use, and reported with its
//! uncertainty.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, Method, calibrate};
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! // Six mean readings, one a row: the shortest session there is.
//! let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
//!            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
//! let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
//! let mut options = CalibrateOptions { gravity: gravical::gravity::Gravity::given(9.81)?, ..Default::default() };
//! options.estimate.method = Method::Ferraris;
//! let file = calibrate(&session, &options)?.file;
//! assert!((file.accelerometer.bias[0] - 0.385).abs() < 1e-12);
//! assert!((file.accelerometer.scale[2] - 1.018669).abs() < 1e-6);
//! # Ok::<(), gravical::Error>(())
//! ```

mod checks;
mod estimate;
#[doc(hidden)]
pub mod ferraris;
#[doc(hidden)]
pub mod gyro;
mod section;
mod session;
mod verdict;

use gravical_core::matrix3;
use serde::Deserialize;

use crate::calibration_file::{
    AccelerometerSection, CalibrationFile, FORMAT, GyroMethod, InputFile, RecordingTime,
    RecordingTimeSource, SensorInfo, TemperatureRange, creation_time,
};
use crate::finding::{after, after_losses};
use crate::gravity::Gravity;
use crate::poses::{SegmentOptions, Segmentation, segment};
use crate::recording::{AccelUnit, Finding, FindingKind, Recording, Severity, common_serial};
use crate::temperature::{enough_poses, for_calibration, from_poses};
use crate::utc::UtcTime;
use crate::{Error, Result};

use estimate::accelerometer;
use session::Session;

pub use crate::calibration_file::Method;
pub use estimate::{EstimateOptions, Prior};
pub(crate) use section::DRIFT_MPS2_PER_C;

/// How to calibrate.
#[derive(Debug, Clone, Default)]
pub struct CalibrateOptions {
    /// How the session is cut.
    pub segment: SegmentOptions,
    /// Local gravity; default: standard.
    pub gravity: Gravity,
    /// How the accelerometer is estimated.
    pub estimate: EstimateOptions,
    /// Which sensor it is.
    pub sensor: SensorInfo,
    /// When the session was recorded; default: the first time stamp, if it is a date.
    pub recorded: Option<UtcTime>,
    /// The command line, for the record.
    pub command: Option<String>,
    /// Files beside the recordings that these options come from, as a section list;
    /// for the record.
    pub other_inputs: Vec<InputFile>,
    /// Soak recordings of the same sensor, for a temperature model; default:
    /// from the session itself where it spans enough.
    pub thermal: Vec<Recording>,
}

/// What is stored in a calibration beside the numbers.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct RecordOptions {
    /// Name or serial number of the sensor, stored
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "TEXT", hide_short_help = true)
    )]
    pub sensor_id: Option<String>,
    /// Type of the sensor, stored
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "TEXT", hide_short_help = true)
    )]
    pub sensor_model: Option<String>,
    /// Date (UTC), stored [default: by the time stamps]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "DATE", hide_short_help = true)
    )]
    pub recorded: Option<UtcTime>,
}

impl RecordOptions {
    /// The sensor.
    pub fn sensor(&self) -> SensorInfo {
        SensorInfo {
            id: self.sensor_id.clone(),
            model: self.sensor_model.clone(),
        }
    }
}

impl CalibrateOptions {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        let wrong = |option, what: String| Err(Error::range(option, what));
        let turn = self.segment.turn_angle_deg;
        if !(turn.is_finite() && turn.abs() >= 30.0) {
            return wrong(
                "turn_angle",
                format!("{turn}° is too small; at least 30° are needed"),
            );
        }
        if let Some(tilt) = self.estimate.pose_tilt_deg
            && !(0.0..=10.0).contains(&tilt)
        {
            return wrong("pose_tilt", format!("{tilt}° is not possible; 0 to 10° is"));
        }
        if self.segment.rows == Some(0) {
            return wrong("rows", "0 takes no rows; give 1 or more".to_owned());
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

/// Calibrates a sensor from the recordings of one session.
///
/// # Errors
///
/// Input errors with the next thing to do: those of [`segment`];
/// `underdetermined`, `missing-face`, `left-handed`, `sensors-differ`, `no-such-pose` of the
/// accelerometer; `missing-gyro`, `rate-unknown`. A result
/// that fails a quality gate is no error: its verdict is `poor`.
pub fn calibrate(recordings: &[Recording], options: &CalibrateOptions) -> Result<Calibrated> {
    options.validate()?;
    let gravity = options.gravity.value_mps2;
    let sensor_id = match &options.sensor.id {
        Some(id) => Some(id.clone()),
        None => common_serial(recordings)?,
    };

    // Where did the sensor lie still, and which face was up?
    let lost = |error| after_losses(error, recordings.iter().map(|r| (&*r.name, &*r.findings)));
    let mut segmentation = segment(recordings, &options.segment).map_err(lost)?;
    // Does the joint fit tell the drift with temperature, or what lay still while it changed?
    let drift = options.thermal.is_empty()
        && options.estimate.method == Method::Joint
        && enough_poses(&segmentation.poses);
    let mut temperature_model = if drift {
        None
    } else {
        for_calibration(recordings, &options.thermal, &mut segmentation)?
    };

    // M and b of u = M a + b, and their covariance.
    let estimated = |segmentation: &Segmentation, drift: bool| {
        let session = Session {
            recordings,
            segmentation,
            axes: &options.segment.axes,
            faces_by_name: options.segment.faces_from.are_names(),
            gravity: &options.gravity,
            drift,
        };
        accelerometer(&session, &options.estimate)
            .map_err(|error| after(error, &segmentation.findings, FindingKind::NoStaticInterval))
            .map_err(lost)
    };
    let mut estimate = estimated(&segmentation, drift)?;
    if drift {
        temperature_model = estimate.drift_test.and_then(|test| {
            let drift = estimate.fit().and_then(gravical_fit::Fit::drift);
            from_poses(recordings, test, drift, &mut segmentation)
        });
        if temperature_model.is_none() {
            // The poses of one part of the session are all there are of some direction.
            temperature_model = for_calibration(recordings, &[], &mut segmentation)?;
            estimate = estimated(&segmentation, false)?;
        }
    }
    let placements = &segmentation.poses;

    // The gyroscope from the pauses and the known turns.
    let turns = match &estimate.faces {
        Some(faces) => gyro::turns::gyroscope(
            recordings,
            &segmentation,
            faces,
            &estimate.calibration,
            gravity,
            options.segment.turn_angle_deg.to_radians(),
            &options.segment.axes,
        )?,
        None => gyro::Gyroscope::default(),
    };
    // … else from the motions between the stills. Missing turns are reported only if the motions did
    // not calibrate the gyroscope.
    let mut gyroscope = turns;
    if gyroscope.section.is_none() {
        let missing = gyroscope.findings;
        gyroscope = gyro::of_session(recordings, &segmentation, &estimate.calibration);
        let method = gyroscope.section.as_ref().map(|s| s.method);
        if method != Some(GyroMethod::Motion) {
            gyroscope.findings.splice(0..0, missing);
        }
    }

    // What do the placements say of the result, and what can they not say?
    let offset = recordings.first().map_or(0.0, |r| r.zero_offset);
    let poses = section::poses(placements, &estimate, gravity, offset);
    let range = TemperatureRange::of(placements.iter().filter_map(|p| p.temperature_c));
    let nominal = recordings.first().and_then(|r| r.accel_scale.nominal());
    let scale = matrix3::row_norms(&estimate.model);
    let fitted = estimate.uses.iter().filter(|u| u.fitted).count() as u32;
    let mut accelerometer = AccelerometerSection {
        method: options.estimate.method,
        input_unit: recordings
            .first()
            .map_or(AccelUnit::Unknown, |r| r.accel_scale.unit),
        output_unit: AccelUnit::MetrePerSecondSquared,
        // A zero offset is only a way of reading; what is applied to the file's
        // own numbers carries it in the bias.
        bias: estimate.calibration.bias.map(|b| b + offset),
        matrix: estimate.calibration.matrix,
        scale,
        orientation: matrix3::scale_rows(&estimate.model, &scale.map(|k| 1.0 / k)),
        // The parameters of a magnitude are nine by a fit, six by the closed form.
        degrees_of_freedom: fitted.saturating_sub(if estimate.fit.is_some() { 9 } else { 6 }),
        poses,
        scale_deviation_percent: nominal.map(|n| scale.map(|k| 100.0 * (k / n - 1.0))),
        ..AccelerometerSection::default()
    };
    section::complete(&mut accelerometer, &estimate, &options.gravity, placements);

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
        &estimate,
        placements,
        offset,
    ));
    if !options.segment.faces_from.are_names() {
        findings.extend(checks::names(&options.segment.axes, placements));
    }
    if findings
        .iter()
        .any(|f| f.kind == FindingKind::GyroScaleFound)
    {
        // The motions have answered what the reader could not.
        findings.retain(|f| f.kind != FindingKind::GyroUnitUnverified);
    }
    let verdict = verdict::verdict(&accelerometer, &estimate, options.gravity.source, &findings);
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity == Severity::Warning));

    let mut inputs = InputFile::of(recordings);
    inputs.extend(options.other_inputs.iter().cloned());
    inputs.extend(InputFile::of_soak(&options.thermal));
    let file = CalibrationFile {
        format: FORMAT.to_owned(),
        created: creation_time(),
        tool: crate::TOOL.to_owned(),
        recorded: recorded(recordings, options),
        sensor: SensorInfo {
            id: sensor_id,
            model: options.sensor.model.clone(),
        },
        gravity_mps2: gravity,
        gravity_source: options.gravity.source,
        temperature_c: range,
        accelerometer,
        gyroscope: gyroscope.section,
        inputs,
        findings,
        verdict,
        command: options.command.clone(),
        temperature_model,
        noise: None,
    };
    Ok(Calibrated { file, segmentation })
}

/// When a session was recorded, as far as that is known.
pub(crate) fn recorded(
    recordings: &[Recording],
    options: &CalibrateOptions,
) -> Option<RecordingTime> {
    if let Some(time) = options.recorded {
        let source = RecordingTimeSource::Given;
        return Some(RecordingTime { time, source });
    }
    let first = recordings.iter().filter_map(Recording::recorded_at).min();
    first.map(|time| RecordingTime {
        time,
        source: RecordingTimeSource::TimeStamps,
    })
}
