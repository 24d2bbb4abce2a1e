//! From acceleration to velocity and position, with an error band.
//!
//! # Overview
//!
//! 1. `prepare`: units, drift with temperature, what is no measurement, calibration, time →
//!    [`gravical_motion::Samples`].
//! 2. `uncertainty`: how far the calibration may be off, and whether gravity at the rests contradicts it.
//! 3. `estimate`: the filter of [`gravical_motion`], or the procedure of the student report.
//! 4. `verdict`, `summary`, `result`, `track`: what is said, and the samples behind it.
//!
//! # Example
//!
//! ```
//! use gravical::motion::{MotionOptions, motion};
//! use gravical::recording::{ReadOptions, read};
//! use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate_to};
//!
//! let folder = tempfile::tempdir()?;
//! let options = SimulateOptions::new(Scenario::Line(LineOptions::default()));
//! simulate_to(&options, folder.path(), false)?;
//!
//! let recording = read(&folder.path().join("line.csv"), &ReadOptions::default())?;
//! let result = motion(&recording, None, &MotionOptions::default())?.result;
//! let moved = result.moves[0].displacement_m.unwrap_or_default();
//! assert!((moved[1] - 0.7).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod estimate;
mod options;
mod orientation;
mod prepare;
mod result;
mod summary;
mod track;
mod uncertainty;
mod verdict;

use std::ops::Range;
use std::path::Path;

use gravical_core::matrix3::norm;
use gravical_motion::{
    CalibrationUncertainty, ElementErrors, ForceCovariance, MotionOptions as EngineOptions,
    Samples, estimate_motion,
};

use crate::calibration_file::Calibration;
use crate::finding::{CalibrationCase, Case};
use crate::gravity::Gravity;
use crate::recording::{Finding, Meter, Recording};
use crate::{Error, Result};

use estimate::Estimate;
use prepare::{Prepared, prepare};
use uncertainty::{
    DATA_SHEET, UNSTATED, applied_twice, by_covariance, of_gyroscope, variance_of_magnitude,
};

#[doc(hidden)]
pub use gravical_motion::SampleState;
pub use options::{Intervals, MotionOptions, Procedure};
pub use orientation::{Attitude, OrientationJudgement, OrientationResult};
pub use result::*;
pub use track::MotionSample;
#[doc(hidden)]
pub use track::MotionTable;
pub use uncertainty::GravityMisfit;

/// Motion of a recording: the result, and the samples behind it.
#[derive(Debug, Clone)]
pub struct Motion {
    /// What is said.
    pub result: MotionResult,
    own: Estimate,
    /// By the nominal scales alone; none without a calibration.
    uncalibrated: Option<Estimate>,
    bands: bool,
}

/// Velocity and position of `recording`, by a `calibration` and the name it was given by.
///
/// # Errors
///
/// Input errors: `unit-mismatch` (a calibration for another unit, range or sensor), `unit-unknown`,
/// `rate-unknown`, `no-samples`. Usage: `option-range`, `rests-outside`. What only costs accuracy is a
/// finding: no gyroscope, a gap in a move. Without a rest there is a verdict, and no motion.
pub fn motion(
    recording: &Recording,
    calibration: Option<(&Calibration, &str)>,
    options: &MotionOptions,
) -> Result<Motion> {
    options.validate()?;
    recording.refuse_averaged("cut the hours of the motion out: `gravical convert` writes all")?;
    let file = calibration.map(|(file, _)| file);
    let mut findings = recording.findings.clone();
    let Prepared {
        samples,
        uncalibrated: plain,
        gyro_calibrated,
        per_mps2,
    } = prepare(recording, file, options, &mut findings)?;
    findings.extend(summary::rows_left_out(recording, &samples));
    let rests = options.rests.as_ref();
    let given = rests.map(|r| r.spans(&samples.time_s));
    let by_file = file.map(|file| Gravity {
        value_mps2: file.gravity_mps2,
        source: file.gravity_source,
    });
    let gravity = options.gravity.or(by_file).unwrap_or_default();
    let work = Work {
        recording,
        file,
        options,
        gravity,
        gyro_calibrated,
        per_mps2,
        rests: given.transpose()?,
    };
    let by_report = options.procedure == Procedure::Report;
    let (own, misfit) = if by_report {
        (Estimate::by_report(samples)?, None)
    } else {
        work.estimate(samples, plain.as_ref(), &mut findings)?
    };
    let uncalibrated = plain.map(|samples| {
        if by_report {
            return Estimate::by_report(samples);
        }
        let rests = own.motion.rests.clone();
        work.run(samples, DATA_SHEET.force(), Some(rests))
    });
    let uncalibrated = uncalibrated.transpose()?;

    let moves = summary::moves(&own, uncalibrated.as_ref(), options);
    let end = summary::end(&own, &moves, options);
    let rests = &own.motion.rests;
    let t = &own.samples.time_s;
    let visible_moves = summary::visible_moves(&own, options);
    let has_gyro = !own.samples.rate_rad_s.is_empty();
    findings.extend(summary::context_findings(has_gyro, &moves, options));
    if file.is_none()
        && let Some(rest) = rests.first()
    {
        let [x, y, z, ..] = own.samples.mean(rest);
        findings.extend(summary::size([x, y, z], &gravity));
    }
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| recording.name.clone());
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));

    let span = |rest: &Range<usize>| Span {
        start_s: t[rest.start],
        end_s: t[rest.end - 1],
    };
    let timing = &recording.clock;
    let [procedure, frame] = summary::procedure(options, has_gyro);
    let result = MotionResult {
        computation: Computation {
            input: recording.name.clone(),
            calibration: calibration.map(|(_, name)| name.to_owned()),
            procedure,
            rate_hz: Rates {
                nominal: timing.nominal_rate_hz,
                r#true: timing.mean_rate_hz.or(timing.median_rate_hz),
            },
            duration_s: t[t.len() - 1] - t[0],
            rows: recording.rows() as u64,
            rows_left_out: (recording.rows() - own.samples.len()) as u64,
            frame,
            rests: rests.iter().map(span).collect(),
        },
        verdict: MotionVerdict::new(&own, (&moves, &end), &visible_moves, misfit),
        noise: own.motion.noise,
        visible_speed_mps: own
            .motion
            .hidden_speed_mps()
            .filter(|_| !visible_moves.is_empty()),
        visible_moves,
        gravity_misfit: misfit,
        r#final: end,
        uncalibrated: uncalibrated.as_ref().map(|plain| FinalState {
            sigma_m: None,
            ..summary::end(plain, &moves, options)
        }),
        moves,
        findings,
    };
    Ok(Motion {
        result,
        bands: options.has_bands(),
        own,
        uncalibrated,
    })
}

/// What a computation is of.
struct Work<'a> {
    recording: &'a Recording,
    file: Option<&'a Calibration>,
    options: &'a MotionOptions,
    gravity: Gravity,
    gyro_calibrated: bool,
    per_mps2: f64,
    /// Rests that are given, in samples.
    rests: Option<Vec<Range<usize>>>,
}

impl Work<'_> {
    /// The estimate by the filter, and how far gravity at its rests is off the calibration. Where that, or the
    /// recording, contradicts the calibration, it is computed again with an error of that size.
    fn estimate(
        &self,
        samples: Samples,
        plain: Option<&Samples>,
        findings: &mut Vec<Finding>,
    ) -> Result<(Estimate, Option<GravityMisfit>)> {
        let Some(file) = self.file else {
            // Gravity itself may show more than a data sheet allows.
            let off = norm(&typical(&samples)) / self.gravity.value_mps2 - 1.0;
            let errors = ElementErrors {
                scale: DATA_SHEET.scale.max(off.abs()),
                ..DATA_SHEET
            };
            let own = self.run(samples, errors.force(), self.rests.clone())?;
            return Ok((own, None));
        };
        let (section, axes) = (&file.accelerometer, &self.options.axes);
        // How far the parameters may be off, before the rests are asked.
        let covariance = match section.covariance_of_parameters() {
            Some(covariance) => by_covariance(section, &covariance, axes),
            None => {
                findings.push(Case::CovarianceUnknown.finding());
                UNSTATED.force()
            }
        };
        let own = self.run(samples, covariance, self.rests.clone())?;
        // Where gravity is that of the calibration, its error is the same in both.
        let known = file.sensor().filter(|_| self.options.gravity.is_none());
        let known = known.map(|s| by_covariance(section, &s.covariance, axes));
        let known = known.unwrap_or(covariance);
        let gravity_mps2 = self.gravity.value_mps2;
        let worst = |samples: &Samples| GravityMisfit::worst(&own, samples, &known, gravity_mps2);
        let (misfit, raw_misfit) = (worst(&own.samples), plain.and_then(worst));
        let mut doubts = ForceCovariance::zeros();
        if let Some(misfit) = misfit.filter(|m| m.contradicts) {
            doubts += misfit.covariance();
        }
        // Raw columns of the same name show other gravity than calibrated ones.
        let by_board = self.recording.format.is_calibrated_by_board();
        let named =
            self.recording.format.is_calibrated() && raw_misfit.is_none_or(|raw| !raw.contradicts);
        if by_board || named {
            doubts += applied_twice(section, self.per_mps2, axes);
            let finding = CalibrationCase::CalibratedForMotion { by_board }.finding();
            findings.push(finding.advise("calibration", ""));
        }
        if doubts == ForceCovariance::zeros() {
            return Ok((own, misfit));
        }
        let own = self.run(own.samples, covariance + doubts, self.rests.clone())?;
        Ok((own, misfit))
    }

    /// An estimate by the filter, between `rests` or those that it finds, unless it was stopped.
    fn run(
        &self,
        samples: Samples,
        covariance: ForceCovariance,
        rests: Option<Vec<Range<usize>>>,
    ) -> Result<Estimate> {
        let options = self.options;
        let by_calibration = variance_of_magnitude(&covariance, &typical(&samples));
        let own = self.file.filter(|_| self.gyro_calibrated);
        let by_gravity = self.gravity.uncertainty_mps2();
        let engine = EngineOptions {
            calibration: CalibrationUncertainty {
                force: covariance,
                rate: of_gyroscope(own, &options.axes),
                gravity_sd_mps2: by_calibration.sqrt().hypot(by_gravity),
            },
            no_stances: options.no_stances,
            rests,
            stopped: options.meter.as_ref().map(Meter::flag),
        };
        let motion = estimate_motion(&samples, &engine);
        if options.meter.as_ref().is_some_and(Meter::is_stopped) {
            let stopped = std::io::Error::other("its motion was stopped");
            return Err(Error::io(Path::new(&self.recording.name), stopped));
        }
        Ok(Estimate { samples, motion })
    }
}

/// Median of each axis, m/s²: about gravity.
fn typical(samples: &Samples) -> [f64; 3] {
    std::array::from_fn(|c| {
        let mut axis: Vec<f64> = samples.force_mps2.iter().map(|f| f[c]).collect();
        gravical_signal::stats::median(&mut axis).unwrap_or_default()
    })
}
