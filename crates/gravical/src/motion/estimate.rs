//! Samples and what the engine makes of them.

use std::ops::Range;

use gravical_motion::{
    CalibrationUncertainty, MotionOptions as EngineOptions, RestNoise, SampleState, Samples,
    estimate_motion,
};

use super::options::MotionOptions;
use super::report_procedure::ReportProcedure;

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
    /// By the filter. Rests that are `known` are not searched.
    pub fn new(
        samples: Samples,
        options: &MotionOptions,
        calibration: CalibrationUncertainty,
        noise: Option<RestNoise>,
        known: Option<&[Range<usize>]>,
    ) -> Self {
        let engine = EngineOptions {
            calibration,
            rests_s: rests_s(&samples, options, known),
            noise,
            ..engine_options(options)
        };
        let motion = estimate_motion(&samples, &engine);
        let is_open = !options.zero_velocity;
        Estimate {
            samples,
            motion,
            report: None,
            v0_mps: options.v0_mps.filter(|_| is_open).unwrap_or_default(),
            p0_m: options.p0_m,
        }
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

/// What the engine is asked for, without what the recording says.
pub(super) fn engine_options(options: &MotionOptions) -> EngineOptions {
    EngineOptions {
        max_stance_rate_rad_s: options.stance_rate_rad_s.unwrap_or(0.0),
        rests_s: options.rests_s.as_ref().map(|spans| {
            let finite = spans.iter().map(|(from, to)| (*from, to.min(f64::MAX)));
            finite.collect()
        }),
        causal: options.causal,
        zero_velocity: options.zero_velocity,
        ..EngineOptions::default()
    }
}

/// Rests that are not searched: those that are `known`, or given by the user.
fn rests_s(
    samples: &Samples,
    options: &MotionOptions,
    known: Option<&[Range<usize>]>,
) -> Option<Vec<(f64, f64)>> {
    let t = samples.time_s();
    if let Some(spans) = known {
        return Some(spans.iter().map(|s| (t[s.start], t[s.end - 1])).collect());
    }
    let last = t.last().copied().unwrap_or_default();
    let given = options.rests_s.as_ref()?;
    Some(
        given
            .iter()
            .map(|(from, to)| (*from, to.min(last)))
            .collect(),
    )
}
