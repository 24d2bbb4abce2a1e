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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_step_is_learned() {
        let run = |from: f64, step: f64, n: u32| (0..n).map(move |i| from + step * f64::from(i));
        // Buffered rows arrive at once, then rows at their own times.
        assert_eq!(steps(run(0.0, 1.0, 5).chain(run(14.0, 10.0, 50))), [9; 4]);
        // Rows are missing often: gaps, as long as their lengths differ.
        let odd = [100.0, 200.0, 120.0, 230.0, 110.0, 300.0, 100.0];
        let mut at = 90.0;
        let sparse = odd.map(|step| {
            at += step;
            at
        });
        assert_eq!(steps(run(0.0, 10.0, 10).chain(sparse)).len(), 7);
        // The step that the board reports.
        let mut clock = Stamps::default();
        clock.steps_are(Some(10.0));
        assert_eq!([0.0, 100.0].map(|s| clock.jump(s))[1], Some(9));
        clock.steps_are(Some(50.0));
        for stamp in run(150.0, 50.0, 9) {
            assert_eq!(clock.jump(stamp), Some(0));
        }
        // The reported step is wrong.
        let jumps = run(1000.0, 500.0, 30).filter(|s| clock.jump(*s) != Some(0));
        assert_eq!(jumps.count(), 4);
        clock.steps_are(Some(f64::NAN));
        assert_eq!(clock.reported, None);
    }

    /// A restart, in place of a number of rows.
    const RESTART: u64 = u64::MAX;

    fn steps(stamps: impl IntoIterator<Item = f64>) -> Vec<u64> {
        let mut clock = Stamps::default();
        let jumps = stamps.into_iter().map(|s| clock.jump(s).unwrap_or(RESTART));
        jumps.filter(|jump| *jump > 0).collect()
    }

    #[test]
    fn jumps_wraps_and_resets() {
        let run = |from: f64, n: u32| (0..n).map(move |i| from + 10.0 * f64::from(i));
        assert!(steps(run(0.0, 100)).is_empty());
        // Rows 50 to 69 are missing.
        assert_eq!(steps(run(0.0, 50).chain(run(700.0, 9))), [20]);
        assert_eq!(steps(run(9000.0, 50).chain(run(120.0, 9))), [RESTART]);
        let wrapped = run(WRAP - 200.0, 60).map(|s| s % WRAP);
        assert!(steps(wrapped).is_empty());
        // Three lost at the wrap are too few for a gap, twenty are not.
        let lost = run(WRAP - 200.0, 15).chain(run(WRAP + 150.0, 9));
        assert_eq!(steps(lost.map(|s| s % WRAP)), [20]);
        // Repeated stamps and jitter are no gaps.
        assert!(steps([0.0, 0.0, 10.0, 19.0, 31.0, 31.0, 40.0]).is_empty());
        assert_eq!(steps([1e300, 2.0]), [RESTART]);
    }
}
