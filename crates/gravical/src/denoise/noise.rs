//! Noise of channels at rest, accumulated row by row.

use std::ops::Range;

/// Deviations of the channels from their mean in each of some intervals, pooled.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    intervals: Vec<Range<usize>>,
    channels: [Pooled; 6],
}

/// Number of values whose mean is computed before their squares.
const PIECE: usize = 1 << 14;

#[derive(Debug, Clone, Default)]
struct Pooled {
    /// The interval of the next value.
    at: usize,
    /// Values of the interval, and those before them: their number, mean, and sum of squared
    /// deviations.
    values: Vec<f64>,
    count: f64,
    mean: f64,
    squares: f64,
    /// Of all intervals before.
    all_squares: f64,
    freedom: f64,
}

impl Noise {
    /// Of the rows of ascending `intervals`.
    pub fn new(intervals: Vec<Range<usize>>) -> Self {
        Noise {
            intervals,
            channels: Default::default(),
        }
    }

    /// Adds the `values` of these `channels` in these `rows`, which ascend from call to call.
    pub fn add(&mut self, channels: &[usize], rows: &[usize], values: &[Vec<f64>]) {
        for (c, values) in channels.iter().zip(values) {
            let pooled = &mut self.channels[*c];
            for (row, value) in rows.iter().zip(values) {
                while let Some(interval) = self.intervals.get(pooled.at)
                    && *row >= interval.start
                {
                    if *row < interval.end {
                        pooled.push(*value);
                        break;
                    }
                    pooled.close();
                    pooled.at += 1;
                }
            }
        }
    }

    /// √(Σ(x − mean of its interval)²/Σ(n − 1)) of each axis of a sensor, whose first channel is
    /// `first`; `None` if an axis has no interval of two values.
    pub fn sigma(&mut self, first: usize) -> Option<[f64; 3]> {
        let mut sigmas = [0.0; 3];
        for (sigma, pooled) in sigmas.iter_mut().zip(&mut self.channels[first..]) {
            pooled.close();
            if pooled.freedom == 0.0 {
                return None;
            }
            *sigma = (pooled.all_squares / pooled.freedom).sqrt();
        }
        Some(sigmas)
    }
}

impl Pooled {
    #[inline]
    fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.values.push(value);
            if self.values.len() == PIECE {
                self.add_piece();
            }
        }
    }

    /// Merges mean and squares of the values with those before (T. F. Chan, G. H. Golub and R. J.
    /// LeVeque, The American Statistician 37, 1983).
    fn add_piece(&mut self) {
        let n = self.values.len() as f64;
        if n == 0.0 {
            return;
        }
        let mean = self.values.iter().sum::<f64>() / n;
        let squares = self
            .values
            .iter()
            .map(|v| (v - mean) * (v - mean))
            .sum::<f64>();
        self.values.clear();
        if self.count == 0.0 {
            (self.count, self.mean, self.squares) = (n, mean, squares);
            return;
        }
        let (off, count) = (mean - self.mean, self.count + n);
        self.squares += squares + off * off * self.count * n / count;
        self.mean += off * n / count;
        self.count = count;
    }

    /// Ends the interval.
    fn close(&mut self) {
        self.add_piece();
        if self.count >= 2.0 {
            self.all_squares += self.squares;
            self.freedom += self.count - 1.0;
        }
        (self.count, self.mean, self.squares) = (0.0, 0.0, 0.0);
    }
}
