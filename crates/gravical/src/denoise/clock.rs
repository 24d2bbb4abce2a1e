//! Regularity of the time stamps: even steps, uneven steps and gaps.

/// Steps longer than this many usual steps are gaps: twice the window of the weakest smoothing.
const GAP_STEPS: f64 = 10.0;

/// Steps that differ from the usual one by more than this share are uneven: it displaces a slope
/// within a window by half of that share, which is small compared with noise.
const EVEN_SHARE: f64 = 0.05;

/// For time stamps with a coarse resolution, steps that differ by more than this share are
/// uneven: 1.5 steps are a lost sample.
const UNEVEN_SHARE: f64 = 0.45;

/// Number of time stamps from which their resolution is determined.
pub(super) const FIRST_STAMPS: usize = 2000;

/// The clock of a recording.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// The usual step, s (or rows, without time stamps and rate).
    pub step_s: f64,
    /// Largest deviation of an even step from it, s.
    pub tolerance_s: f64,
    /// Longer steps are gaps, s.
    pub gap_s: f64,
}

/// A step between time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Even,
    Uneven,
    Gap,
    Backward,
}

impl Step {
    /// Filters restart after it.
    pub fn parts(self) -> bool {
        matches!(self, Step::Gap | Step::Backward)
    }
}

/// Numbers of gaps and of steps back.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Splits {
    pub gaps: usize,
    pub backward: usize,
}

impl Clock {
    /// From the first time stamps, `None` without any, and their rate, Hz.
    pub fn new(rate_hz: Option<f64>, first_s: Option<&[f64]>) -> Self {
        let step_s = rate_hz.map_or(1.0, |rate| 1.0 / rate);
        let digit_s = first_s.map_or(0.0, |t| digit_s(t, step_s));
        Clock {
            step_s,
            tolerance_s: (EVEN_SHARE * step_s).max(digit_s.min(UNEVEN_SHARE * step_s)),
            gap_s: GAP_STEPS * step_s,
        }
    }

    /// The kind of the step from `before` to `now`, s.
    pub fn step(&self, before: f64, now: f64) -> Step {
        let step = now - before;
        // Allows for rounding of the time stamps.
        if (step - self.step_s).abs() <= self.tolerance_s * (1.0 + 1e-6) {
            Step::Even
        } else if step < 0.0 {
            Step::Backward
        } else if step > self.gap_s {
            Step::Gap
        } else {
            Step::Uneven
        }
    }
}

/// Resolution of the time stamps, s: 1e-3 if all are whole milliseconds. A deviation from even
/// spacing by no more than this is rounding. 0 if they are finer than 1 ns.
fn digit_s(time_s: &[f64], step_s: f64) -> f64 {
    (0..=9)
        .map(|digits| 10.0_f64.powi(-digits))
        .find(|digit| {
            time_s.iter().all(|t| {
                let off = (t - digit * (t / digit).round()).abs();
                off < 1e-4 * digit.min(step_s)
            })
        })
        .unwrap_or(0.0)
}

/// Time stamps with missing ones interpolated evenly between their neighbours; before the first and
/// after the last at the usual step.
pub(super) fn filled_stamps(time_s: &[f64], step_s: f64) -> Vec<f64> {
    let mut filled = time_s.to_vec();
    let mut known = (0..time_s.len()).filter(|row| time_s[*row].is_finite());
    let Some(first) = known.next() else {
        return (0..time_s.len()).map(|row| row as f64 * step_s).collect();
    };
    for row in 0..first {
        filled[row] = time_s[first] - (first - row) as f64 * step_s;
    }
    let mut last = first;
    for next in known {
        let step = (time_s[next] - time_s[last]) / (next - last) as f64;
        for row in last + 1..next {
            filled[row] = time_s[last] + (row - last) as f64 * step;
        }
        last = next;
    }
    for row in last + 1..time_s.len() {
        filled[row] = time_s[last] + (row - last) as f64 * step_s;
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: Clock = Clock {
        step_s: 0.01,
        tolerance_s: 0.001,
        gap_s: 0.1,
    };

    #[test]
    fn gaps_uneven_steps_and_steps_back_are_distinguished() {
        let time = [0.0, 0.01, 0.021, 0.05, 0.06, 0.3, 0.31, 0.2, 0.21, 0.21];
        let steps: Vec<Step> = time.windows(2).map(|t| CLOCK.step(t[0], t[1])).collect();
        use Step::{Backward, Even, Gap, Uneven};
        assert_eq!(
            steps,
            [Even, Even, Uneven, Even, Gap, Even, Backward, Even, Uneven]
        );
    }

    #[test]
    fn resolution_of_time_stamps_is_found() {
        let ms: Vec<f64> = (0..500)
            .map(|i| (3.5 * f64::from(i)).floor() * 1e-3)
            .collect();
        assert_eq!(digit_s(&ms, 3.5e-3), 1e-3);
        let hundredths: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
        assert_eq!(digit_s(&hundredths, 0.01), 0.01);
        let fine: Vec<f64> = (0..500).map(|i| f64::from(i) / 3e9).collect();
        assert_eq!(digit_s(&fine, 1.0 / 3e9), 0.0);
    }

    #[test]
    fn missing_time_stamps_are_interpolated() {
        let none = f64::NAN;
        let time = filled_stamps(&[none, 1.0, none, none, 1.3, none], 0.1);
        for (t, want) in time.iter().zip([0.9, 1.0, 1.1, 1.2, 1.3, 1.4]) {
            assert!((t - want).abs() < 1e-12);
        }
        assert_eq!(filled_stamps(&[none, none], 0.5), [0.0, 0.5]);
    }
}
