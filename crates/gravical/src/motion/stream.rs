//! Motion of a recording of any size: one pass, flat memory, no look-ahead.
//!
//! The first 256 KiB tell how the recording is written, its units, and the noise of
//! the sensor where it rests in them; the samples then go through
//! [`gravical_core::motion`] one by one. What a rest tells of the move before it
//! cannot be had, nor bands: both look back from the far end.

mod sink;
mod smooth;
mod stepper;
#[cfg(test)]
mod tests;
mod tracker;

use std::io::Write;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::motion::{FirstRest, Motion as Core, MotionConfig, Removal};
use gravical_core::still::{Plan, RestNoise};

use super::anchors::RandomWalk;
use super::assumed::{Applied, directions, doubts};
use super::prepare::{Prepared, gap_s, prepare, times};
use super::result::MotionVerdict;
use super::samples::Samples;
use super::still::{Rests, find_rests};
use super::table::{Layout, time_decimals};
use super::{
    Calibrated, GravityMisfit, GravityRemoval, MotionOptions, MotionResult, NoiseAtRest, Rates,
    words,
};
use crate::apply::drift::Drift;
use crate::apply::sensor::Sensor;
use crate::output::BlockWriter;
use crate::recording::file::{OpenFile, ReadFile, open_rows};
use crate::recording::monitor::refuse_unit_change;
use crate::recording::names::Role;
use crate::recording::open::Input;
use crate::recording::{Finding, FindingKind, ReadOptions, Recording, read_bytes};
use crate::{Error, Result};

pub use stepper::{MotionStepper, Readings};

use sink::Pipeline;
use smooth::Chain;
use tracker::MoveTracker;

/// Motion that was computed in one pass.
#[derive(Debug, Clone)]
pub struct Streamed {
    /// What is said. Null is what looks back: uncertainties, budget, drift of a
    /// recording at rest, the result without the calibration.
    pub result: MotionResult,
    /// The first rows, by which units and noise were judged.
    pub head: Recording,
}

/// Velocity and position of the recording `input`, sample by sample; the table goes
/// to `out` where one is wanted. `name` stands in messages.
///
/// Memory is flat: a few MiB, whatever the size. Of the options those that need the
/// whole recording count nothing: bands, clock error, gravity, edges of filters.
///
/// # Errors
///
/// Those of [`super::motion`] and of reading, for the first 256 KiB; `not-causal`
/// (usage) for a filter that needs samples to come; what reading and writing report.
pub fn motion_stream(
    input: Input,
    name: &str,
    read: &ReadOptions,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
    out: Option<&mut dyn Write>,
) -> Result<Streamed> {
    options.validate()?;
    read.validate()?;
    let mut file = open_rows(input, name, Role::Recording, read, None)?;
    let begin = Begin::new(&file, name, read, calibration, options)?;
    let drift = calibration.and_then(|c| {
        let layout = &file.format.layout;
        Drift::new(
            c.file,
            &file.head(),
            layout,
            file.rows.facts().celsius,
            layout.has_gyro(),
            &mut Vec::new(),
        )
    });
    let mut findings = begin.findings.clone();
    let assumed = *file.rows.facts();
    let stamped = assumed.stamp_reading.is_some();
    let mut pipeline = begin.pipeline(stamped, options, out.is_some(), &mut findings)?;
    let mut sensor = Sensor::of(begin.accel, begin.gyro, options.axes).with_drift(drift);
    let mut nowhere = std::io::sink();
    let mut out = BlockWriter::new(out.unwrap_or(&mut nowhere));
    if let Some(layout) = pipeline.table {
        layout.header(&mut out.bytes);
    }
    while let Some(row) = file.rows.next_row()? {
        let calibrated = sensor.calibrate(row.values, row.line);
        pipeline.row(&row, calibrated, &mut out.bytes);
        out.write_if_full()?;
    }
    let mut done = file.finish()?;
    refuse_unit_change(&done.finished.summary.found, read, name)?;
    out.finish()?;
    let mut all_findings = std::mem::take(&mut done.findings);
    all_findings.extend(assumed.contradicted_by(&done.finished.summary.facts));
    all_findings.extend(done.finished.findings());
    all_findings.append(&mut findings);
    let drift = sensor.drift.as_ref();
    drift.map(|d| d.finish(&mut all_findings));
    let result = begin.result(pipeline, &done, calibration, options, all_findings);
    Ok(Streamed {
        result,
        head: begin.recording,
    })
}

/// The noise that rests are found with, at the rate of the samples.
fn rest_noise(rests: &Rests, samples: &Samples, rate_hz: f64) -> Option<RestNoise<f64>> {
    let accel = rests.accel?;
    let gyro = rests.gyro.filter(|_| samples.rate_rad_s.is_some());
    let left: [f64; 6] = std::array::from_fn(|c| match c {
        0..3 => accel.rounding[c].powi(2),
        _ => gyro.map_or(0.0, |g| g.rounding[c - 3].powi(2)),
    });
    let noise = RestNoise::new(accel.sigma, accel.vif, gyro.map(|g| (g.sigma, g.vif)));
    Some(noise.with_rounding(&Plan::new(rate_hz), &samples.resolution, &left))
}

/// What the first rows tell.
struct Begin {
    recording: Recording,
    accel: Calibration<f64>,
    gyro: Option<GyroscopeCalibration<f64>>,
    noise: Option<NoiseAtRest>,
    rest_noise: Option<RestNoise<f64>>,
    rested: bool,
    rate_hz: f64,
    gap_s: f64,
    time_decimals: u32,
    bias_mps2: f64,
    gyro_scale: f64,
    findings: Vec<Finding>,
    gravity_misfit: Option<GravityMisfit>,
}

impl Begin {
    fn new(
        file: &OpenFile,
        name: &str,
        read: &ReadOptions,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
    ) -> Result<Self> {
        Self::of(
            read_bytes(file.head_bytes(), name, read)?,
            calibration,
            options,
        )
    }

    fn of(
        mut recording: Recording,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
    ) -> Result<Self> {
        let Prepared {
            samples,
            nominal,
            mut findings,
            scales,
            ..
        } = prepare(&mut recording.clone(), calibration, options)?;
        let rests = find_rests(&samples, options.rests_s.as_deref());
        let walk = RandomWalk::new(rests.accel.as_ref(), rests.gyro.as_ref(), &samples);
        let applied = Applied {
            file: calibration.map(|c| c.file),
            scales: &scales,
            samples: &samples,
            nominal: nominal.as_ref(),
            walk,
        };
        let mut directions = directions(&applied, &rests.spans, options);
        let doubts = doubts(&applied, &rests.spans, &directions, &recording, options);
        directions.extend(doubts.directions);
        findings.extend(doubts.findings);
        // Root of the sum of squares over the directions, mean of the axes.
        let mean = |of: &dyn Fn(&super::parameters::Direction) -> [f64; 3]| -> f64 {
            let sum: f64 = directions.iter().flat_map(|d| of(d).map(|v| v * v)).sum();
            (sum / 3.0).sqrt()
        };
        let step_s = samples.median_step_s();
        let rate_hz = if step_s > 0.0 { 1.0 / step_s } else { 0.0 };
        let all = times(&mut recording)?;
        Ok(Begin {
            accel: scales.accel,
            gyro: scales.gyro,
            noise: NoiseAtRest::of(&rests),
            rest_noise: rest_noise(&rests, &samples, rate_hz),
            rested: !rests.spans.is_empty(),
            rate_hz,
            gap_s: gap_s(&all),
            time_decimals: time_decimals(&all),
            bias_mps2: mean(&|d| d.force(&[0.0; 3])),
            gyro_scale: mean(&|d| d.rate(&[1.0; 3])),
            findings,
            gravity_misfit: doubts.misfit,
            recording,
        })
    }

    /// Seconds from row to row, where the rows' own time is not known.
    fn step_s(&self) -> Result<f64> {
        let timing = &self.recording.timing;
        match timing.mean_rate_hz.or(timing.rate_hz()) {
            Some(rate_hz) => Ok(1.0 / rate_hz),
            None => Err(Error::input(
                "rate-unknown",
                "there are no usable time stamps",
            )),
        }
    }

    fn pipeline(
        &self,
        stamped: bool,
        options: &MotionOptions,
        table: bool,
        findings: &mut Vec<Finding>,
    ) -> Result<Pipeline> {
        let removal = match options.gravity_removal {
            GravityRemoval::InitialMean => Removal::InitialMean,
            GravityRemoval::Strapdown if self.gyro.is_some() => Removal::Strapdown,
            GravityRemoval::Strapdown | GravityRemoval::ConstantTilt => Removal::ConstantTilt,
        };
        let initial_mean = removal == Removal::InitialMean;
        let given = options.rests_s.clone();
        let plan = Plan::new(self.rate_hz);
        let fits = plan.onset_samples() < sink::KEPT;
        let searched = given.is_none() && self.rested && fits;
        // With the mean off and velocity left alone nothing asks for rests.
        let wanted = !initial_mean || options.zero_velocity;
        let noise = self.rest_noise.filter(|_| searched && wanted);
        let rests = noise.map(|noise| (plan, noise));
        let first_rest = if initial_mean || (given.is_none() && rests.is_none()) {
            FirstRest::Samples(options.initial_rows)
        } else {
            FirstRest::Found
        };
        if wanted && rests.is_none() && given.is_none() {
            let (why, what_next) = match fits {
                true => (
                    format!(
                        "the sensor does not rest in the first {} rows, from which its noise is estimated",
                        self.recording.rows()
                    ),
                    "hold it still for 2 s before the first move",
                ),
                false => (
                    format!(
                        "--causal finds no rests at {:.0} Hz, since it keeps {} samples, less than the second that it needs",
                        self.rate_hz,
                        sink::KEPT
                    ),
                    "leave --causal out, give the rests with --rests, or record at 2 kHz or less",
                ),
            };
            findings.push(Finding::new(
                FindingKind::NoStaticInterval,
                format!(
                    "{why}: the first {} rows count as one rest, others are not found, and nothing corrects the drift; {what_next}",
                    options.initial_rows
                ),
            ));
        }
        let config = MotionConfig {
            removal,
            first_rest,
            zero_velocity: options.zero_velocity,
            rests,
            velocity_mps: options.v0_mps.unwrap_or_default(),
            position_m: options.p0_m,
            bias_mps2: self.bias_mps2,
            gyro_scale: self.gyro_scale,
            tilt_change_rad: options.tilt_change_deg.to_radians(),
            ..MotionConfig::strapdown()
        };
        let chain = Chain::design(&options.smooth, self.rate_hz)?;
        let motion =
            Core::new(config).map_err(|few| Error::usage("option-range", few.to_string()))?;
        let starts_at_rest = !initial_mean && first_rest != FirstRest::Found;
        Ok(Pipeline {
            knows_rests: starts_at_rest || rests.is_some() || given.is_some(),
            starts_at_rest,
            given,
            gap_s: self.gap_s,
            usual_step_s: 1.0 / self.rate_hz,
            with_gyro: self.gyro.is_some(),
            table: table.then_some(Layout {
                raw: false,
                bands: false,
                time_decimals: self.time_decimals,
            }),
            step_s: match stamped {
                true => None,
                false => Some(self.step_s()?),
            },
            motion: Box::new(motion),
            smooth: chain,
            tracker: MoveTracker::new(options.p0_m),
            rows: 0,
            samples: 0,
            first_s: 0.0,
            last_s: 0.0,
            parted: false,
            left_out: Default::default(),
        })
    }

    fn result(
        &self,
        done: Pipeline,
        read: &ReadFile,
        calibration: Option<Calibrated<'_>>,
        options: &MotionOptions,
        mut findings: Vec<Finding>,
    ) -> MotionResult {
        findings.extend(words::rows_left_out(&done.left_out));
        findings.extend(words::causal_rests(
            done.tracker.taken_back,
            &done.tracker.rests_at_speed,
        ));
        let (still, moves, end) = done.tracker.finish();
        let lost = moves.iter().filter(|m| !m.usable).count();
        if lost > 0 {
            findings.push(
                Finding::new(
                    FindingKind::MoveUnusable,
                    format!(
                        "{lost} of {} moves have a gap in them or come after one: how far they went is not known",
                        moves.len()
                    ),
                )
                .counting(lost as u64),
            );
        }
        let recording = &self.recording;
        for finding in &mut findings {
            finding.file.get_or_insert_with(|| recording.name.clone());
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
        let duration_s = done.last_s - done.first_s;
        let stamp_reading = read.finished.summary.facts.stamp_reading;
        let stamped = stamp_reading.is_some_and(|b| b.even_hz.is_none()) && duration_s > 0.0;
        MotionResult {
            input: recording.name.clone(),
            calibration: calibration.map(|c| c.name.to_owned()),
            verdict: MotionVerdict::of(&moves, &end, self.gravity_misfit),
            procedure: words::causal_procedure(options, self.gyro.is_some()),
            rate_hz: Rates {
                nominal: recording.timing.nominal_rate_hz,
                r#true: stamped.then(|| (done.samples.max(1) - 1) as f64 / duration_s),
            },
            duration_s,
            rows: read.finished.ledger.rows,
            rows_left_out: done.left_out.count(),
            frame: words::frame(options, false),
            rests: still,
            noise: self.noise,
            visible_moves: Vec::new(),
            gravity_misfit: self.gravity_misfit,
            moves,
            r#final: end,
            uncalibrated: None,
            static_drift: None,
            budget_m: None,
            truth: None,
            findings,
        }
    }
}
