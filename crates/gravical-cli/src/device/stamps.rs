//! Follows the board's clock, row by row: how many rows are missing where it jumps.

use std::collections::VecDeque;

/// The usual step is the median of this many.
const STEPS: usize = 31;
/// 2³²: a 32-bit counter restarts from zero here.
const WRAP: f64 = 4_294_967_296.0;
/// A jump of more usual steps than this is a gap; the reader of recordings has the same
/// limit.
const GAP_STEPS: f64 = 4.5;

/// This many successive jumps of similar length are no gaps, but the usual step.
const JUMPS_OF_A_STEP: usize = 5;
/// Lengths are similar up to this factor.
const ALIKE: f64 = 1.5;

/// The stamps of the last rows.
#[derive(Debug, Clone, Default)]
pub struct Stamps {
    last: Option<f64>,
    steps: VecDeque<f64>,
    /// The step that the board reports.
    reported: Option<f64>,
    /// The last successive jumps of similar length.
    jumps: Vec<f64>,
}

impl Stamps {
    /// Takes the stamp of the next row, if it has one: rows that are missing before it; none when
    /// the clock runs backwards, because it restarted.
    pub fn next(&mut self, stamp: Option<f64>) -> Option<u64> {
        stamp.map_or(Some(0), |stamp| self.jump(stamp))
    }

    /// Rows that are missing by the clock; none when it restarted.
    fn jump(&mut self, stamp: f64) -> Option<u64> {
        let Some(last) = self.last.replace(stamp) else {
            return Some(0);
        };
        let mut step = stamp - last;
        if step < 0.0 && (0.95 * WRAP..WRAP).contains(&last) && (0.0..0.05 * WRAP).contains(&stamp)
        {
            step += WRAP;
        }
        if step < 0.0 {
            self.steps.clear();
            self.jumps.clear();
            return None;
        }
        if let Some(usual) = self.usual()
            && step > GAP_STEPS * usual
            && !self.is_usual_jump(step)
        {
            return Some((step / usual).round() as u64 - 1);
        }
        self.jumps.clear();
        if step > 0.0 {
            self.steps.push_back(step);
            if self.steps.len() > STEPS {
                self.steps.pop_front();
            }
        }
        Some(0)
    }

    /// The board has new settings: its step from here on, in units of the stamp; none where
    /// the step has to be learned.
    pub fn steps_are(&mut self, step: Option<f64>) {
        self.steps.clear();
        self.jumps.clear();
        self.reported = step.filter(|step| step.is_finite() && *step > 0.0);
    }

    /// Whether `step` is the last of several similar jumps: then they are the usual step.
    fn is_usual_jump(&mut self, step: f64) -> bool {
        let alike = |last: &f64| step < ALIKE * last && *last < ALIKE * step;
        if !self.jumps.last().is_none_or(alike) {
            self.jumps.clear();
        }
        self.jumps.push(step);
        if self.jumps.len() < JUMPS_OF_A_STEP {
            return false;
        }
        self.steps_are(None);
        // The caller adds this one.
        self.steps.extend([step; 2]);
        true
    }

    /// The usual step, once it is known.
    fn usual(&self) -> Option<f64> {
        if self.reported.is_some() {
            return self.reported;
        }
        let mut steps: Vec<f64> = self.steps.iter().copied().collect();
        steps.sort_unstable_by(f64::total_cmp);
        (steps.len() >= 3).then(|| steps.get(steps.len() / 2).copied())?
    }
}
