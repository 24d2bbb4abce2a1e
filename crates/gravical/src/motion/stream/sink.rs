//! Row after row through the pipeline, and into the table.

use gravical_core::motion::{Motion, Phase};

use super::smooth::Chain;
use super::tracker::{MotionState, MoveTracker};
use crate::motion::table::{ATTITUDE_DECIMALS, DECIMALS};
use crate::recording::LineSpans;
use crate::recording::rows::Row;
use crate::scan::write_fixed;

/// Samples that are kept: rests are found up to 2 kHz.
pub(super) const KEPT: usize = 2048;

/// Columns of the table.
const HEADER: &str = "t_s,ax_mps2,ay_mps2,az_mps2,still,qw,qx,qy,qz,\
    lin_ax_mps2,lin_ay_mps2,lin_az_mps2,vx_mps,vy_mps,vz_mps,px_m,py_m,pz_m\n";

/// What goes on from row to row.
pub(super) struct State {
    pub motion: Box<Motion<f64, Chain, KEPT>>,
    /// Seconds from row to row, where they have no time of their own.
    pub step_s: Option<f64>,
    pub rows: u64,
    pub tracker: MoveTracker,
    pub last_s: f64,
    pub first_s: f64,
    pub samples: u64,
    /// A break before the next row.
    pub parted: bool,
    pub left_out: LineSpans,
}

/// What becomes of each row.
pub(super) struct Pipeline {
    pub state: State,
    /// Rests that are given, s.
    pub given: Option<Vec<(f64, f64)>>,
    /// Rests are looked for or given.
    pub knows_rests: bool,
    /// The samples at the start are one.
    pub starts_at_rest: bool,
    /// A longer step is a gap, s.
    pub gap_s: f64,
    /// Without a gyroscope its values count nothing.
    pub with_gyro: bool,
    /// Decimals of the time in the table; none without a table.
    pub table: Option<u32>,
}

impl Pipeline {
    pub fn new(state: State, gap_s: f64, with_gyro: bool, table: Option<u32>) -> Self {
        Pipeline {
            state,
            given: None,
            knows_rests: false,
            starts_at_rest: false,
            gap_s,
            with_gyro,
            table,
        }
    }

    fn write(&self, t_s: f64, decimals: u32, out: &mut Vec<u8>) {
        let motion = &self.state.motion;
        put(out, &[t_s], decimals);
        put(out, &motion.force_mps2(), DECIMALS);
        out.extend_from_slice(match self.knows_rests {
            true if resting(motion.phase(), self.starts_at_rest) => b"1,",
            true => b"0,",
            false => b",",
        });
        put(out, &motion.attitude(), ATTITUDE_DECIMALS);
        put(out, &motion.acceleration_mps2(), DECIMALS);
        put(out, &motion.velocity_mps(), DECIMALS);
        put(out, &motion.position_m(), DECIMALS);
        // The last comma ends the line.
        if let Some(end) = out.last_mut() {
            *end = b'\n';
        }
    }
}

#[inline]
fn put(out: &mut Vec<u8>, values: &[f64], decimals: u32) {
    for value in values {
        write_fixed(out, *value, decimals);
        out.push(b',');
    }
}

pub(super) fn resting(phase: Phase, starts_at_rest: bool) -> bool {
    phase == Phase::Resting || (phase == Phase::Start && starts_at_rest)
}

impl Pipeline {
    /// What stands before the first row of the table.
    pub fn header(&self) -> &'static [u8] {
        match self.table {
            Some(_) => HEADER.as_bytes(),
            None => b"",
        }
    }

    /// A row, calibrated; its line of the table goes to `out`.
    #[inline]
    pub fn row(&mut self, row: &Row<'_>, calibrated: [f64; 6], out: &mut Vec<u8>) {
        let state = &mut self.state;
        let t_s = match state.step_s {
            Some(step_s) => step_s * state.rows as f64,
            None => row.t_s,
        };
        state.rows += 1;
        state.parted |= row.restarted || (!row.before.is_empty() && state.samples > 0);
        let [a, b, c, d, e, f] = calibrated;
        let rate = if self.with_gyro { [d, e, f] } else { [0.0; 3] };
        let sum = a + b + c + rate[0] + rate[1] + rate[2];
        let h_s = if state.samples == 0 {
            0.0
        } else {
            t_s - state.last_s
        };
        // Also false for a stamp that is none.
        if !(sum.is_finite() && h_s >= 0.0 && t_s.is_finite()) {
            state.left_out.push(row.line);
            return;
        }
        if state.samples == 0 {
            state.first_s = t_s;
        } else if state.parted || h_s > self.gap_s {
            state.tracker.lose(h_s);
            state.motion.interrupt();
        }
        (state.parted, state.last_s) = (false, t_s);
        state.samples += 1;
        let given_rest = self
            .given
            .as_ref()
            .map(|spans| spans.iter().any(|(from, to)| t_s >= *from && t_s <= *to));
        state
            .motion
            .update_calibrated([a, b, c], rate, h_s, given_rest);
        let phase = state.motion.phase();
        state.tracker.see(&MotionState {
            t_s,
            phase,
            rests: resting(phase, self.starts_at_rest),
            velocity: state.motion.velocity_mps(),
            position: state.motion.position_m(),
            taken_back: state.motion.taken_back(),
            overruled: state.motion.overruled(),
        });
        if let Some(decimals) = self.table {
            self.write(t_s, decimals, out);
        }
    }
}
