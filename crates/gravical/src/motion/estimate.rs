//! Samples and what the engine makes of them.

use std::ops::Range;

use gravical_motion::{
    CalibrationUncertainty, MotionOptions as EngineOptions, RestNoise, SampleState, Samples,
    estimate_motion,
};

use super::options::MotionOptions;
use super::report_procedure::ReportProcedure;
use crate::recording::Meter;

/// An estimate, and the samples that it is of.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub samples: Samples,
    pub motion: gravical_motion::Motion,
    /// In its place, where the procedure of the report was asked for.
    pub report: Option<ReportProcedure>,
    /// Velocity and position that are added.
    v0_mps: [f64; 3],
    p0_m: [f64; 3],
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
            // Who knows the rests knows the whole.
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

    /// Velocity that is added, m/s.
    pub fn v0_mps(&self) -> [f64; 3] {
        self.v0_mps
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
