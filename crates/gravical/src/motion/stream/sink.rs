//! Row after row through the pipeline, and into the table.

use gravical_core::motion::{Motion, Phase};

use super::smooth::Chain;
use super::tracker::{MotionState, MoveTracker};
use crate::motion::MotionSample;
use crate::motion::plan::missing_s;
use crate::motion::table::Layout;
use crate::recording::LineSpans;
use crate::recording::rows::Row;

/// Samples that are kept: rests are found up to 2 kHz.
pub(super) const KEPT: usize = 2048;

/// What becomes of each row, and what goes on from row to row.
pub(super) struct Pipeline {
    /// Rests that are given, s.
    pub given: Option<Vec<(f64, f64)>>,
    /// Rests are looked for or given.
    pub knows_rests: bool,
    /// The samples at the start are one.
    pub starts_at_rest: bool,
    /// A longer step is a gap, s.
    pub gap_s: f64,
    /// From a sample to the next, s.
    pub usual_step_s: f64,
    /// Without a gyroscope its values count nothing.
    pub with_gyro: bool,
    /// None without a table.
    pub table: Option<Layout>,
    /// Seconds from row to row, where they have no time of their own.
    pub step_s: Option<f64>,
    pub motion: Box<Motion<f64, KEPT>>,
    pub smooth: Chain,
    pub tracker: MoveTracker,
    pub rows: u64,
    pub samples: u64,
    pub first_s: f64,
    pub last_s: f64,
    /// A break before the next row.
    pub parted: bool,
    pub left_out: LineSpans,
}

impl Pipeline {
    /// Whether the sensor rests after the last row.
    pub fn rests(&self) -> bool {
        match self.motion.phase() {
            Phase::Resting => true,
            Phase::Start => self.starts_at_rest,
            _ => false,
        }
    }

    /// A row, calibrated; its line of the table goes to `out`.
    #[inline]
    pub fn row(&mut self, row: &Row<'_>, calibrated: [f64; 6], out: &mut Vec<u8>) {
        let t_s = match self.step_s {
            Some(step_s) => step_s * self.rows as f64,
            None => row.t_s,
        };
        self.rows += 1;
        self.parted |= row.restarted || (!row.before.is_empty() && self.samples > 0);
        let [a, b, c, d, e, f] = calibrated;
        let rate = if self.with_gyro { [d, e, f] } else { [0.0; 3] };
        let sum = a + b + c + rate[0] + rate[1] + rate[2];
        let h_s = if self.samples == 0 {
            0.0
        } else {
            t_s - self.last_s
        };
        // Also false for a stamp that is none.
        if !(sum.is_finite() && h_s >= 0.0 && t_s.is_finite()) {
            self.left_out.push(row.line);
            return;
        }
        if self.samples == 0 {
            self.first_s = t_s;
        } else if self.parted || h_s > self.gap_s {
            self.tracker.lose(h_s, missing_s(h_s, self.usual_step_s));
            self.motion.interrupt();
            self.smooth.reset();
        }
        (self.parted, self.last_s) = (false, t_s);
        self.samples += 1;
        let given_rest = self
            .given
            .as_ref()
            .map(|spans| spans.iter().any(|(from, to)| t_s >= *from && t_s <= *to));
        let force = [a, b, c];
        let smoothed = self.smooth.update(force);
        self.motion
            .update_calibrated(force, smoothed, rate, h_s, given_rest);
        let phase = self.motion.phase();
        let rests = self.rests();
        let (velocity, position) = (self.motion.velocity_mps(), self.motion.position_m());
        self.tracker.see(&MotionState {
            t_s,
            phase,
            rests,
            velocity,
            position,
            taken_back: self.motion.taken_back(),
            overruled: self.motion.overruled(),
        });
        if let Some(layout) = self.table {
            let sample = MotionSample {
                t_s,
                raw_mps2: [f64::NAN; 3],
                force_mps2: self.motion.force_mps2(),
                still: rests,
                attitude: self.motion.attitude(),
                acceleration_mps2: self.motion.acceleration_mps2(),
                velocity_mps: velocity,
                position_m: position,
                sigma_velocity_mps: [f64::NAN; 3],
                sigma_position_m: [f64::NAN; 3],
            };
            layout.row(out, &sample, self.knows_rests.then_some(rests));
        }
    }
}
