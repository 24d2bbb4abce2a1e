//! Samples and what the engine makes of them.

use std::ops::Range;

use gravical_motion::{
    CalibrationUncertainty, MotionOptions as EngineOptions, RestNoise, SampleState, Samples,
    estimate_motion,
};
use gravical_signal::detect_rests;

use super::options::MotionOptions;
use crate::recording::Meter;

/// Rows that the mean of the student report is over.
const ROWS: usize = 500;
/// What a rest may miss of them at its end: half a block of the detector, s.
const MISSED_S: f64 = 0.1;

/// An estimate, and the samples that it is of.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub samples: Samples,
    pub motion: gravical_motion::Motion,
    /// In its place, where the procedure of the report was asked for.
    pub report: Option<ReportProcedure>,
    /// Velocity and position that are added.
    pub v0_mps: [f64; 3],
    pub p0_m: [f64; 3],
}

impl Estimate {
    /// By the filter, between `rests` or those that it finds.
    pub fn new(
        samples: Samples,
        options: &MotionOptions,
        calibration: CalibrationUncertainty,
        noise: Option<RestNoise>,
        rests: Option<Vec<Range<usize>>>,
    ) -> Self {
        let engine = EngineOptions {
            // Given rests imply that the whole recording is known.
            causal: options.causal && rests.is_none(),
            rests,
            noise,
            ..engine_options(options, calibration)
        };
        Estimate {
            motion: estimate_motion(&samples, &engine),
            samples,
            report: None,
            v0_mps: options.v0_mps.unwrap_or_default(),
            p0_m: options.p0_m,
        }
    }

    /// Its rests in other samples of the same rows.
    pub fn rests_in(&self, samples: &Samples) -> Vec<Range<usize>> {
        let rows = self.samples.rows();
        let at = |row: usize| samples.rows().partition_point(|r| *r < row);
        let rests = self.motion.rests.iter();
        rests
            .map(|rest| at(rows[rest.start])..at(rows[rest.end - 1] + 1))
            .filter(|rest| !rest.is_empty())
            .collect()
    }

    /// By the procedure of the student report.
    pub fn by_report(samples: Samples, options: &MotionOptions) -> Self {
        Estimate {
            report: Some(ReportProcedure::new(&samples)),
            samples,
            motion: gravical_motion::Motion::default(),
            v0_mps: [0.0; 3],
            p0_m: options.p0_m,
        }
    }

    /// One state for each sample.
    pub fn states(&self) -> Box<dyn Iterator<Item = SampleState> + '_> {
        let states: Box<dyn Iterator<Item = SampleState> + '_> = match &self.report {
            Some(report) => Box::new(report.states(&self.samples)),
            None => Box::new(self.motion.states(&self.samples)),
        };
        let time_s = self.samples.time_s();
        Box::new(states.zip(time_s).map(|(mut state, t)| {
            for c in 0..3 {
                state.velocity_mps[c] += self.v0_mps[c];
                state.position_m[c] += self.p0_m[c] + self.v0_mps[c] * (t - time_s[0]);
            }
            state
        }))
    }
}

/// What the engine is asked for.
pub(super) fn engine_options(
    options: &MotionOptions,
    calibration: CalibrationUncertainty,
) -> EngineOptions {
    EngineOptions {
        calibration,
        max_stance_rate_rad_s: options.stance_rate.0.unwrap_or(0.0),
        causal: options.causal,
        zero_velocity: options.updates_at_rests(),
        stopped: options.meter.as_ref().map(Meter::flag),
        ..EngineOptions::default()
    }
}

/// The procedure of the student report: the mean of the first rows off, trapezoid.
#[derive(Debug, Clone)]
pub(super) struct ReportProcedure {
    mean_mps2: [f64; 3],
    /// The first time within the averaged rows at which it moves, s.
    pub moves_at_s: Option<f64>,
}

impl ReportProcedure {
    pub fn new(samples: &Samples) -> Self {
        let t = samples.time_s();
        let force = &samples.force_mps2()[..ROWS.min(t.len())];
        let mean = |c: usize| force.iter().map(|f| f[c]).sum::<f64>() / force.len() as f64;
        let rests = detect_rests(&samples.channels());
        let rested = rests.first().filter(|rest| rest.start == 0);
        let moved = t.get(rested.map_or(0, |rest| rest.end)).copied();
        let averaged_until_s = t[force.len() - 1];
        ReportProcedure {
            mean_mps2: std::array::from_fn(mean),
            moves_at_s: moved.filter(|t| t + MISSED_S < averaged_until_s),
        }
    }

    /// Velocity and position of each sample; without bands, in the axes of the sensor.
    pub fn states<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = SampleState> + 'a {
        let mut state = SampleState {
            attitude: [1.0, 0.0, 0.0, 0.0],
            acceleration_mps2: [0.0; 3],
            velocity_mps: [0.0; 3],
            position_m: [0.0; 3],
            ..SampleState::UNKNOWN
        };
        let time_s = samples.time_s();
        let mut last_s = time_s[0];
        time_s
            .iter()
            .zip(samples.force_mps2())
            .map(move |(t, force)| {
                let h = t - last_s;
                for c in 0..3 {
                    let before = state.acceleration_mps2[c];
                    state.acceleration_mps2[c] = force[c] - self.mean_mps2[c];
                    let faster = 0.5 * (before + state.acceleration_mps2[c]) * h;
                    state.position_m[c] += (state.velocity_mps[c] + 0.5 * faster) * h;
                    state.velocity_mps[c] += faster;
                }
                last_s = *t;
                state
            })
    }
}
