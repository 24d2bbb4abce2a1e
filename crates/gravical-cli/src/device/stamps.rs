//! The board's clock and the numbers of its frames, followed row by row: how many rows
//! are missing where they jump.

use std::collections::VecDeque;

/// Steps that the usual one is the median of.
const KEPT: usize = 31;
/// 2³²: where a 32-bit counter begins again.
const WRAP: f64 = 4_294_967_296.0;
/// A jump of more usual steps than this is a gap, as the reader of recordings has it.
const GAP_STEPS: f64 = 4.5;

/// So many jumps after each other, each about as long as the one before, are no gaps: the
/// board steps so.
const LEARNED_ANEW: usize = 5;
/// As long as the one before: by this factor at most.
const ALIKE: f64 = 1.5;

/// What a row says of those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// It goes on, and so many rows are missing.
    On {
        /// By the clock.
        jump: u64,
        /// By the numbers of frames; none where there is nothing to tell it by.
        lost: Option<u64>,
    },
    /// The clock runs backwards: it started anew.
    Anew,
}

/// Follows stamps and numbers.
#[derive(Debug, Clone, Default)]
pub struct Stamps {
    last: Option<f64>,
    /// The number of the last frame, modulo 256.
    sequence: Option<u8>,
    steps: VecDeque<f64>,
    /// What the board says of it.
    said: Option<f64>,
    /// The last jumps, alike, with nothing between them.
    jumps: Vec<f64>,
}

impl Stamps {
    /// Takes the stamp and the number of the next row.
    pub fn see(&mut self, stamp: f64, sequence: Option<u8>) -> Step {
        let before = std::mem::replace(&mut self.sequence, sequence);
        let Some(jump) = self.jump(stamp) else {
            return Step::Anew;
        };
        let lost = before.zip(sequence).map(|(before, now)| {
            let lost = now.wrapping_sub(before).wrapping_sub(1);
            lost_frames(u64::from(lost), jump)
        });
        Step::On { jump, lost }
    }

    /// Rows that are missing by the clock; none when it started anew.
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
            && !self.is_no_jump(step)
        {
            return Some((step / usual).round() as u64 - 1);
        }
        self.jumps.clear();
        if step > 0.0 {
            self.steps.push_back(step);
            if self.steps.len() > KEPT {
                self.steps.pop_front();
            }
        }
        Some(0)
    }

    /// The board is set anew: its steps are as long from here on, in units of the stamp;
    /// none: as long as they turn out to be.
    pub fn steps_are(&mut self, step: Option<f64>) {
        self.steps.clear();
        self.jumps.clear();
        self.said = step.filter(|step| step.is_finite() && *step > 0.0);
    }

    /// Whether `step` is but the last of many: then they are the usual ones.
    fn is_no_jump(&mut self, step: f64) -> bool {
        let alike = |last: &f64| step < ALIKE * last && *last < ALIKE * step;
        if !self.jumps.last().is_none_or(alike) {
            self.jumps.clear();
        }
        self.jumps.push(step);
        if self.jumps.len() < LEARNED_ANEW {
            return false;
        }
        self.steps_are(None);
        // The one at hand is pushed by the caller.
        self.steps.extend([step; 2]);
        true
    }

    /// The usual step, once it can be told.
    fn usual(&self) -> Option<f64> {
        if self.said.is_some() {
            return self.said;
        }
        let mut steps: Vec<f64> = self.steps.iter().copied().collect();
        steps.sort_unstable_by(f64::total_cmp);
        (steps.len() >= 3).then(|| steps.get(steps.len() / 2).copied())?
    }
}

/// The number nearest to `jump` that is `lost` modulo 256: the sequence says it exactly,
/// the clock how often it went round.
fn lost_frames(lost: u64, jump: u64) -> u64 {
    lost + (jump.saturating_sub(lost) + 128) / 256 * 256
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_usual_step_that_is_none_is_learned_anew() {
        let run = |from: f64, step: f64, n: u32| (0..n).map(move |i| from + step * f64::from(i));
        // What had waited comes at once, then rows at their own time.
        assert_eq!(steps(run(0.0, 1.0, 5).chain(run(14.0, 10.0, 50))), [9; 4]);
        // One out of two is missing now and then: gaps, as long as they differ.
        let odd = [100.0, 200.0, 120.0, 230.0, 110.0, 300.0, 100.0];
        let mut at = 90.0;
        let sparse = odd.map(|step| {
            at += step;
            at
        });
        assert_eq!(steps(run(0.0, 10.0, 10).chain(sparse)).len(), 7);
        // The board says it.
        let mut clock = Stamps::default();
        clock.steps_are(Some(10.0));
        assert_eq!([0.0, 100.0].map(|s| clock.jump(s))[1], Some(9));
        clock.steps_are(Some(50.0));
        for stamp in run(150.0, 50.0, 9) {
            assert_eq!(clock.jump(stamp), Some(0));
        }
        // It may be wrong.
        let jumps = run(1000.0, 500.0, 30).filter(|s| clock.jump(*s) != Some(0));
        assert_eq!(jumps.count(), 4);
        clock.steps_are(Some(f64::NAN));
        assert_eq!(clock.said, None);
    }

    /// In place of a number of rows.
    const ANEW: u64 = u64::MAX;

    fn steps(stamps: impl IntoIterator<Item = f64>) -> Vec<u64> {
        let mut clock = Stamps::default();
        let jumps = stamps.into_iter().map(|s| clock.jump(s).unwrap_or(ANEW));
        jumps.filter(|jump| *jump > 0).collect()
    }

    #[test]
    fn jumps_wraps_and_resets() {
        let run = |from: f64, n: u32| (0..n).map(move |i| from + 10.0 * f64::from(i));
        assert!(steps(run(0.0, 100)).is_empty());
        // Rows 50 to 69 are not there.
        assert_eq!(steps(run(0.0, 50).chain(run(700.0, 9))), [20]);
        assert_eq!(steps(run(9000.0, 50).chain(run(120.0, 9))), [ANEW]);
        let wrapped = run(WRAP - 200.0, 60).map(|s| s % WRAP);
        assert!(steps(wrapped).is_empty());
        // Three lost at the wrap are too few for a gap, twenty are not.
        let lost = run(WRAP - 200.0, 15).chain(run(WRAP + 150.0, 9));
        assert_eq!(steps(lost.map(|s| s % WRAP)), [20]);
        // Repeats, jitter, nothing.
        assert!(steps([0.0, 0.0, 10.0, 19.0, 31.0, 31.0, 40.0]).is_empty());
        assert_eq!(steps([1e300, 2.0]), [ANEW]);
    }

    #[test]
    fn sequences_say_what_is_lost() {
        let mut stamps = Stamps::default();
        let mut see = |sequence| match stamps.see(0.0, sequence) {
            Step::On { lost, .. } => lost,
            Step::Anew => panic!("the clock stands still"),
        };
        assert_eq!(see(Some(254)), None);
        assert_eq!(see(Some(255)), Some(0));
        assert_eq!(see(Some(0)), Some(0));
        assert_eq!(see(Some(4)), Some(3));
        assert_eq!(see(Some(4)), Some(255));
        assert_eq!(see(None), None);
        for (lost, jump, is) in [
            (3, 0, 3),
            (3, 4, 3),
            (10, 300, 266),
            (250, 250, 250),
            (1, 513, 513),
            (255, 254, 255),
        ] {
            assert_eq!(lost_frames(lost, jump), is, "{lost} {jump}");
        }
    }
}
