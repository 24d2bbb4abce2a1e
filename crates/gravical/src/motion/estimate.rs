//! Samples and what the engine makes of them.

use std::ops::Range;

use gravical_motion::{
    Budget, CalibrationUncertainty, Ends, Motion, MotionOptions as EngineOptions, Move, PathNode,
    Samples, estimate_motion,
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
    pub motion: Motion,
}

impl Estimate {
    /// By the filter, between `rests` or those that it finds.
    pub fn new(
        samples: Samples,
        options: &MotionOptions,
        calibration: CalibrationUncertainty,
        rests: Option<Vec<Range<usize>>>,
    ) -> Self {
        let engine = EngineOptions {
            calibration,
            stances: !options.no_stances,
            // Given rests imply that the whole recording is known.
            causal: options.causal && rests.is_none(),
            rests,
            stopped: options.meter.as_ref().map(Meter::flag),
        };
        Estimate {
            motion: estimate_motion(&samples, &engine),
            samples,
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
    pub fn by_report(samples: Samples) -> Self {
        Estimate {
            motion: report_motion(&samples),
            samples,
        }
    }
}

/// The procedure of the student report: the mean of the first rows off, trapezoid. One move in the axes of the
/// sensor, without rests and bands.
fn report_motion(samples: &Samples) -> Motion {
    let (t, force) = (samples.time_s(), samples.force_mps2());
    let rows = &force[..ROWS.min(t.len())];
    let mean = |c: usize| rows.iter().map(|f| f[c]).sum::<f64>() / rows.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(mean);
    let mut node = PathNode {
        sample: 0,
        position_m: [0.0; 3],
        position_sd_m: [f64::NAN; 3],
        velocity_mps: [0.0; 3],
        velocity_sd_mps: [f64::NAN; 3],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };
    let mut path = vec![node.clone()];
    for i in 1..t.len() {
        let h = t[i] - t[i - 1];
        for c in 0..3 {
            let faster = (0.5 * (force[i - 1][c] + force[i][c]) - mean[c]) * h;
            node.position_m[c] += (node.velocity_mps[c] + 0.5 * faster) * h;
            node.velocity_mps[c] += faster;
        }
        node.sample = i;
        path.push(node.clone());
    }
    let whole = Move {
        samples: 0..node.sample,
        duration_s: t[node.sample] - t[0],
        displacement_m: node.position_m,
        covariance_m2: [[f64::NAN; 3]; 3],
        budget: Budget::default(),
        ends: Ends::Free,
        closure: None,
        stances: 0,
        replaced: 0,
        unusable: None,
    };
    Motion {
        moves: vec![whole],
        path,
        ..Motion::default()
    }
}

/// The first time within the rows of the mean at which the sensor moves, s.
pub(super) fn moves_in_mean_at_s(samples: &Samples) -> Option<f64> {
    let t = samples.time_s();
    let rests = detect_rests(&samples.channels());
    let rested = rests.first().filter(|rest| rest.start == 0);
    let moved = t.get(rested.map_or(0, |rest| rest.end)).copied();
    let averaged_until_s = t[ROWS.min(t.len()) - 1];
    moved.filter(|t| t + MISSED_S < averaged_until_s)
}
