//! Regularity of the time stamps: even steps, uneven steps and gaps.

use std::ops::Range;

use crate::recording::Recording;

/// Steps that differ from the usual one by more than this share are uneven: it displaces a slope
/// within a window by half of that share, which is small compared with noise.
const EVEN_SHARE: f64 = 0.05;

/// For time stamps with a coarse resolution, steps that differ by more than this share are
/// uneven: 1.5 steps are a lost sample.
const UNEVEN_SHARE: f64 = 0.45;

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

/// Consecutive samples without a gap.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stretch {
    pub rows: Range<usize>,
    /// Rows, counted from the first, whose step from the row before is uneven.
    pub uneven: Vec<usize>,
}

/// Numbers of gaps and of steps back.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Splits {
    pub gaps: usize,
    pub backward: usize,
}

impl Clock {
    /// Steps longer than `gap_steps` usual steps are gaps.
    pub fn of(recording: &Recording, gap_steps: f64) -> Self {
        Self::new(
            recording.timing.rate_hz(),
            recording.time_s.as_deref(),
            gap_steps,
        )
    }

    /// From time stamps, of which the first 2000 are examined, and their rate, Hz.
    pub fn new(rate_hz: Option<f64>, time_s: Option<&[f64]>, gap_steps: f64) -> Self {
        let step_s = rate_hz.map_or(1.0, |rate| 1.0 / rate);
        let digit_s = time_s.map_or(0.0, |t| digit_s(t, step_s));
        Clock {
            step_s,
            tolerance_s: (EVEN_SHARE * step_s).max(digit_s.min(UNEVEN_SHARE * step_s)),
            gap_s: gap_steps * step_s,
        }
    }

    /// Largest deviation of an even step, s.
    pub fn even_s(&self) -> f64 {
        // Allows for rounding of the time stamps.
        self.tolerance_s * (1.0 + 1e-6)
    }

    /// Splits time stamps at gaps and steps back.
    pub fn stretches(&self, time_s: &[f64], splits: &mut Splits) -> Vec<Stretch> {
        let mut out = Vec::new();
        let (mut from, mut uneven) = (0, Vec::new());
        let tolerance = self.even_s();
        for (i, pair) in time_s.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if (step - self.step_s).abs() <= tolerance {
                continue;
            }
            let row = i + 1;
            if step < 0.0 || step > self.gap_s {
                splits.gaps += usize::from(step > 0.0);
                splits.backward += usize::from(step < 0.0);
                let uneven = std::mem::take(&mut uneven);
                out.push(Stretch {
                    rows: from..row,
                    uneven,
                });
                from = row;
            } else {
                uneven.push(row - from);
            }
        }
        if from < time_s.len() {
            out.push(Stretch {
                rows: from..time_s.len(),
                uneven,
            });
        }
        out
    }
}

/// Resolution of the time stamps, s: 1e-3 if all are whole milliseconds. A deviation from even
/// spacing by no more than this is rounding. 0 if they are finer than 1 ns.
fn digit_s(time_s: &[f64], step_s: f64) -> f64 {
    let some: Vec<f64> = time_s
        .iter()
        .copied()
        .filter(|t| t.is_finite())
        .take(2000)
        .collect();
    (0..=9)
        .map(|digits| 10.0_f64.powi(-digits))
        .find(|digit| {
            some.iter().all(|t| {
                let off = (t - digit * (t / digit).round()).abs();
                off < 1e-4 * digit.min(step_s)
            })
        })
        .unwrap_or(0.0)
}

/// Interpolates missing time stamps evenly between their neighbours; returns their number.
pub(super) fn fill_stamps(time_s: &mut [f64], step_s: f64) -> usize {
    let known: Vec<usize> = (0..time_s.len())
        .filter(|i| time_s[*i].is_finite())
        .collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        for (i, t) in time_s.iter_mut().enumerate() {
            *t = i as f64 * step_s;
        }
        return time_s.len();
    };
    for pair in known.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let slope = (time_s[b] - time_s[a]) / (b - a) as f64;
        for i in a + 1..b {
            time_s[i] = time_s[a] + (i - a) as f64 * slope;
        }
    }
    for i in 0..first {
        time_s[i] = time_s[first] - (first - i) as f64 * step_s;
    }
    for i in last + 1..time_s.len() {
        time_s[i] = time_s[last] + (i - last) as f64 * step_s;
    }
    time_s.len() - known.len()
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
        let mut splits = Splits::default();
        let found = CLOCK.stretches(&time, &mut splits);
        assert_eq!((splits.gaps, splits.backward), (1, 1));
        let rows: Vec<_> = found.iter().map(|s| s.rows.clone()).collect();
        assert_eq!(rows, [0..5, 5..7, 7..10]);
        assert_eq!(found[0].uneven, [3]);
        assert_eq!(found[1].uneven, [0; 0]);
        assert_eq!(found[2].uneven, [2]);
        assert!(CLOCK.stretches(&[], &mut splits).is_empty());
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
        let mut time = [none, 1.0, none, none, 1.3, none];
        assert_eq!(fill_stamps(&mut time, 0.1), 4);
        for (t, want) in time.iter().zip([0.9, 1.0, 1.1, 1.2, 1.3, 1.4]) {
            assert!((t - want).abs() < 1e-12);
        }
        let mut time = [none, none];
        assert_eq!(fill_stamps(&mut time, 0.5), 2);
        assert_eq!(time, [0.0, 0.5]);
    }
}
