//! Times of the samples between the stamps of the blocks.

use std::collections::VecDeque;

/// Number of stamps that can matter to the samples of a block: a stamp belongs to a sample near
/// either end of its block, or a little outside of it.
const KEPT: usize = 4;

/// The sample clock of a run of blocks without a gap.
///
/// Between the samples that two successive stamps belong to, samples are spaced evenly: the true
/// rate differs from the nominal one by some percent, and changes with temperature. Before the
/// first stamp and after the last one the nearest spacing continues; with a single stamp it is the
/// nominal one.
#[derive(Debug, Clone, Default)]
pub(super) struct RunClock {
    /// Sample of the run and its time, s.
    stamps: VecDeque<(i64, f64)>,
    period_s: f64,
    piece: Piece,
}

/// Samples up to `until`, spaced evenly.
#[derive(Debug, Clone, Copy)]
struct Piece {
    until: i64,
    sample: i64,
    time_s: f64,
    step_s: f64,
}

impl Default for Piece {
    fn default() -> Self {
        Piece {
            until: i64::MIN,
            sample: 0,
            time_s: f64::NAN,
            step_s: f64::NAN,
        }
    }
}

impl RunClock {
    /// Begins a run with the nominal period.
    pub fn begin(&mut self, period_s: f64) {
        *self = RunClock {
            period_s,
            ..RunClock::default()
        };
    }

    /// True if no stamp is known yet.
    pub fn is_empty(&self) -> bool {
        self.stamps.is_empty()
    }

    /// The stamp of the next block; samples and times rise.
    pub fn stamp(&mut self, sample: i64, time_s: f64) {
        if self.stamps.len() == KEPT {
            self.stamps.pop_front();
        }
        self.stamps.push_back((sample, time_s));
        self.piece = Piece::default();
    }

    /// Time of a sample of the run, s; samples come in rising order.
    #[inline]
    pub fn time_s(&mut self, sample: i64) -> f64 {
        if sample >= self.piece.until {
            self.piece = self.piece_of(sample);
        }
        let piece = &self.piece;
        piece.time_s + (sample - piece.sample) as f64 * piece.step_s
    }

    #[cold]
    fn piece_of(&self, sample: i64) -> Piece {
        let stamps = &self.stamps;
        // The last stamp at which a piece can begin and that is not after the sample.
        let begins = stamps.iter().take(stamps.len().saturating_sub(1)).skip(1);
        let at = begins.take_while(|(from, _)| *from <= sample).count();
        let (Some(&(from, time_s)), next) = (stamps.get(at), stamps.get(at + 1)) else {
            return Piece::default();
        };
        let is_last = at + 2 >= stamps.len();
        Piece {
            until: match next {
                Some((to, _)) if !is_last => *to,
                _ => i64::MAX,
            },
            sample: from,
            time_s,
            step_s: next.map_or(self.period_s, |(to, at_s)| {
                (at_s - time_s) / (to - from) as f64
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_run_between_stamps() {
        let mut clock = RunClock::default();
        clock.begin(0.01);
        clock.stamp(0, 100.0);
        assert!((clock.time_s(5) - 100.05).abs() < 1e-9);
        // A sample of 10.2 ms, then one of 9.8 ms.
        clock.stamp(10, 100.102);
        clock.stamp(20, 100.2);
        let times: Vec<f64> = (-5..30).map(|sample| clock.time_s(sample)).collect();
        let expected = |sample: i64| match sample {
            ..10 => 100.0 + 0.0102 * sample as f64,
            _ => 100.102 + 0.0098 * (sample - 10) as f64,
        };
        for (time, sample) in times.iter().zip(-5..) {
            assert!((time - expected(sample)).abs() < 1e-9, "{sample}: {time}");
        }
    }
}
