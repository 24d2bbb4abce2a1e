//! The whole method, in order: read this first.
//!
//! Recordings are divided into poses, the parameters are estimated from face poses and free
//! poses, the result is tested against poses that the fit did not use, and reported with its
//! uncertainty.
//!
//! # Example
//!
//! ```
//! # use gravical_calibrate as gravical;
//! use gravical::calibrate::{CalibrateOptions, Method, calibrate};
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! // Six mean readings, one a row: the shortest session there is.
//! let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
//!            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
//! let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
//! let mut options = CalibrateOptions { gravity: gravical::gravity::Gravity::given(9.81)?, ..Default::default() };
//! options.estimate.method = Method::Ferraris;
//! let file = calibrate(&session, &options)?.calibration;
//! assert!((file.accelerometer.bias[0] - 0.385).abs() < 1e-12);
//! assert!((file.accelerometer.scale()[2] - 1.018669).abs() < 1e-6);
//! # Ok::<(), gravical::Error>(())
//! ```

mod checks;
mod estimate;
mod ferraris;
mod gyro;
mod section;
mod session;

use gravical_judge::utc::UtcTime;
use serde::Deserialize;

use crate::calibration_file::{
    Calibration, FORMAT, InputFile, InputRole, RecordingTime, Reliability, SensorInfo,
    TemperatureRange, creation_time,
};
use crate::finding::after;
use crate::gravity::Gravity;
use crate::poses::{SegmentOptions, Segmentation, segment};
use crate::recording::{Finding, Recording, Severity, after_losses, common_serial};
use crate::temperature::{enough_poses, for_calibration, from_poses};
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
    /// Which sensor it is, and when the session was recorded; default: what the recordings say.
    pub record: RecordOptions,
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
    /// Name or serial number of the sensor, stored; folder: the session's name
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

impl CalibrateOptions {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        let tilt = self.estimate.pose_tilt_deg.unwrap_or_default();
        if (0.0..=10.0).contains(&tilt) {
            return Ok(());
        }
        let what = format!("{tilt}° is not possible; 0 to 10° is");
        Err(Error::range("pose_tilt", what))
    }
}

/// A calibration and the session that it comes from.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// What is written to the file and shown.
    pub calibration: Calibration,
    /// The placements and turns.
    pub segmentation: Segmentation,
}

/// Calibrates a sensor from the recordings of one session.
///
/// # Errors
///
/// Input errors with the next thing to do: those of [`segment`];
/// `underdetermined`, `missing-face`, `singular`, `sensors-differ`, `no-such-pose` of the
/// accelerometer, `calibration-values` for numbers that no sensor has. A result that fails a quality gate is no
/// error: its verdict is `poor`.
pub fn calibrate(recordings: &[Recording], options: &CalibrateOptions) -> Result<Calibrated> {
    options.validate()?;
    let sensor_id = match &options.record.sensor_id {
        Some(id) => Some(id.clone()),
        None => common_serial(recordings)?,
    };

    // Where did the sensor lie still, and which face was up?
    let lost = |error| after_losses(error, recordings);
    let mut segmentation = segment(recordings, &options.segment).map_err(lost)?;
    // Does the joint fit tell the drift with temperature, or what lay still while it changed?
    let fits_drift = options.thermal.is_empty()
        && options.estimate.method == Method::Joint
        && enough_poses(&segmentation.poses);
    let mut drift = if fits_drift {
        None
    } else {
        for_calibration(recordings, &options.thermal, &mut segmentation)?
    };

    // M and b of u = M a + b, and their covariance.
    let session = Session {
        recordings,
        segmentation: &segmentation,
        options,
    };
    let estimate = accelerometer(&session, fits_drift)
        .map_err(|error| after(error, &segmentation.unused))
        .map_err(lost)?;
    if let Some(test) = estimate.drift_test {
        drift = from_poses(recordings, test, estimate.drift(), &mut segmentation);
    }
    let session = Session {
        recordings,
        segmentation: &segmentation,
        options,
    };
    let gyroscope = gyro::of_session(&session, &estimate.calibration);

    let placements = &segmentation.poses;
    let mut inputs = InputFile::of(recordings);
    inputs.extend(options.other_inputs.iter().cloned());
    let soak = InputFile::of(&options.thermal).into_iter();
    let role = InputRole::Soak;
    inputs.extend(soak.map(|file| InputFile { role, ..file }));
    let first = || recordings.iter().filter_map(Recording::recorded_at).min();
    let recorded = options.record.recorded.or_else(first);
    let mut file = Calibration {
        format: FORMAT.to_owned(),
        created: creation_time(),
        tool: gravical_recording::output::TOOL.to_owned(),
        recorded: recorded.map(|time| RecordingTime { time }),
        sensor: SensorInfo {
            id: sensor_id,
            model: options.record.sensor_model.clone(),
        },
        gravity_mps2: options.gravity.value_mps2,
        gravity_source: options.gravity.source,
        gravity_sd_mps2: options.gravity.uncertainty_mps2(),
        temperature_c: TemperatureRange::of(placements.iter().filter_map(|p| p.temperature_c)),
        accelerometer: estimate.accelerometer.clone(),
        gyroscope: gyroscope.section,
        // What do the placements say of the result, and what can they not say?
        reliability: Reliability {
            budget: section::budget(&session, &estimate),
            ..estimate.reliability.clone()
        },
        poses: section::poses(&session, &estimate),
        drift,
        inputs,
        findings: Vec::new(),
        command: options.command.clone(),
    };

    // Everything odd, gathered; the verdict follows from it.
    let read = recordings.iter().flat_map(|r| &r.findings);
    let mut findings: Vec<Finding> = read.chain(&segmentation.findings).cloned().collect();
    findings.extend(checks::inputs(recordings));
    findings.extend(checks::names(&options.segment.axes, placements));
    findings.extend(checks::accelerometer(&file, &estimate, &session));
    findings.extend(options.gravity.finding());
    findings.extend(gyroscope.findings);
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity == Severity::Warning));
    file.findings = findings;
    // Numbers that no sensor has make no calibration.
    let check = file.check();
    check.map_err(|error| {
        lost(error.with_hint("`gravical inspect` shows what is in the recording"))
    })?;
    Ok(Calibrated {
        calibration: file,
        segmentation,
    })
}
