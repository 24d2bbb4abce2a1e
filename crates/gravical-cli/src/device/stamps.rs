//! The board's clock, followed row by row: how many rows are missing where it jumps.

/// Steps that the usual one is the median of.
const KEPT: usize = 31;
/// 2³²: where a 32-bit counter begins again.
const WRAP: f64 = 4_294_967_296.0;
/// A jump of more usual steps than this is a gap, as the reader of recordings has it.
const GAP_STEPS: f64 = 4.5;

/// What a stamp says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// It follows the one before, as far as can be told.
    Follows,
    /// The clock jumped: so many rows are missing.
    Missing(u64),
    /// The clock runs backwards: it started anew.
    Anew,
}

/// Follows stamps.
#[derive(Debug, Clone, Default)]
pub struct Stamps {
    last: Option<f64>,
    steps: std::collections::VecDeque<f64>,
}

impl Stamps {
    /// Takes the next stamp.
    pub fn see(&mut self, stamp: f64) -> Step {
        let Some(last) = self.last.replace(stamp) else {
            return Step::Follows;
        };
        let mut step = stamp - last;
        if step < 0.0 && (0.95 * WRAP..WRAP).contains(&last) && (0.0..0.05 * WRAP).contains(&stamp)
        {
            step += WRAP;
        }
        if step < 0.0 {
            return Step::Anew;
        }
        match self.usual() {
            Some(usual) if step > GAP_STEPS * usual => {
                Step::Missing((step / usual).round() as u64 - 1)
            }
            _ => {
                if step > 0.0 {
                    self.steps.push_back(step);
                    if self.steps.len() > KEPT {
                        self.steps.pop_front();
                    }
                }
                Step::Follows
            }
        }
    }

    /// The usual step, once it can be told.
    fn usual(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self.steps.iter().copied().collect();
        steps.sort_unstable_by(f64::total_cmp);
        (steps.len() >= 3).then(|| steps.get(steps.len() / 2).copied())?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(stamps: impl IntoIterator<Item = f64>) -> Vec<Step> {
        let mut clock = Stamps::default();
        stamps
            .into_iter()
            .map(|s| clock.see(s))
            .filter(|s| *s != Step::Follows)
            .collect()
    }

    #[test]
    fn jumps_wraps_and_resets() {
        let run = |from: f64, n: u32| (0..n).map(move |i| from + 10.0 * f64::from(i));
        assert_eq!(steps(run(0.0, 100)), []);
        // Rows 50 to 69 are not there.
        assert_eq!(
            steps(run(0.0, 50).chain(run(700.0, 9))),
            [Step::Missing(20)]
        );
        assert_eq!(steps(run(9000.0, 50).chain(run(120.0, 9))), [Step::Anew]);
        let wrapped = run(WRAP - 200.0, 60).map(|s| s % WRAP);
        assert_eq!(steps(wrapped), []);
        // Three lost at the wrap are too few for a gap, twenty are not.
        let lost = run(WRAP - 200.0, 15).chain(run(WRAP + 150.0, 9));
        assert_eq!(steps(lost.map(|s| s % WRAP)), [Step::Missing(20)]);
        // Repeats, jitter, nothing.
        assert_eq!(steps([0.0, 0.0, 10.0, 19.0, 31.0, 31.0, 40.0]), []);
        assert_eq!(steps([1e300, 2.0]), [Step::Anew]);
    }
}
