//! Samples in pieces without a gap, and statistics of short blocks of them.

use std::ops::Range;

/// A step longer than this many periods, and than [`MIN_GAP_S`], is a gap: lost rows up to that length
/// are bridged by the trapezoid.
const MIN_GAP_PERIODS: f64 = 5.0;
/// A slow motion does not change more within this time than a trapezoid follows.
const MIN_GAP_S: f64 = 0.1;
/// No IMU is read more often in a second.
const MAX_BLOCK_LEN: usize = 1_000_000;
/// Neighbouring values closer than this, SI, differ by rounding of the computation only.
const MIN_STEP: f64 = 1e-9;

/// Samples of an IMU.
#[derive(Debug, Clone, Copy)]
pub struct Channels<'a> {
    /// Times, s, increasing.
    pub time_s: &'a [f64],
    /// Specific force, m/s², one for each time.
    pub force_mps2: &'a [[f64; 3]],
    /// Angular rate, rad/s, one for each time; empty without a gyroscope.
    pub rate_rad_s: &'a [[f64; 3]],
    /// Usual step, s: [`sampling_period`].
    pub period_s: f64,
    /// Spans without a gap: [`pieces`].
    pub pieces: &'a [Range<usize>],
    /// Steps that the channels are written in, SI; 0 where they are fine: [`resolution`].
    pub resolution: [f64; 6],
}

impl Channels<'_> {
    /// All channels of a sample; the rate is zero without a gyroscope.
    pub fn sample(&self, i: usize) -> [f64; 6] {
        let [x, y, z] = self.force_mps2[i];
        let [p, q, r] = self.rate_rad_s.get(i).copied().unwrap_or_default();
        [x, y, z, p, q, r]
    }

    /// Three channels, or six with a gyroscope.
    pub fn count(&self) -> usize {
        if self.rate_rad_s.is_empty() { 3 } else { 6 }
    }

    /// Mean of the channels; zero over an empty span.
    pub fn mean(&self, span: &Range<usize>) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for i in span.clone() {
            let x = self.sample(i);
            (0..6).for_each(|c| sum[c] += x[c]);
        }
        sum.map(|s| s / span.len().max(1) as f64)
    }

    /// The piece that holds a sample.
    pub fn piece(&self, i: usize) -> Range<usize> {
        let after = self.pieces.partition_point(|p| p.end <= i);
        self.pieces.get(after).cloned().unwrap_or(i..i + 1)
    }
}

/// Statistics of a few neighbouring samples.
#[derive(Debug, Clone)]
pub struct Block {
    /// Its samples.
    pub span: Range<usize>,
    /// Mean of each channel.
    pub mean: [f64; 6],
    /// Variance of each channel (n − 1).
    pub variance: [f64; 6],
    /// Largest minus smallest value of each channel.
    pub range: [f64; 6],
}

impl Block {
    /// Variance of the three axes of a sensor together: 0 accelerometer, 1 gyroscope.
    pub fn total_variance(&self, sensor: usize) -> f64 {
        self.variance[3 * sensor..3 * sensor + 3].iter().sum()
    }

    pub(crate) fn new(channels: &Channels<'_>, span: Range<usize>) -> Block {
        let mean = channels.mean(&span);
        let mut variance = [0.0; 6];
        let (mut low, mut high) = ([f64::MAX; 6], [f64::MIN; 6]);
        for i in span.clone() {
            let x = channels.sample(i);
            for c in 0..6 {
                variance[c] += (x[c] - mean[c]).powi(2);
                (low[c], high[c]) = (low[c].min(x[c]), high[c].max(x[c]));
            }
        }
        let freedom = span.len().saturating_sub(1).max(1) as f64;
        Block {
            mean,
            variance: variance.map(|v| v / freedom),
            range: std::array::from_fn(|c| high[c] - low[c]),
            span,
        }
    }
}

/// Samples in a block of `seconds`, at least five: a variance of fewer says little.
pub fn block_len(period_s: f64, seconds: f64) -> usize {
    rounded(seconds / period_s.max(f64::MIN_POSITIVE)).clamp(5, MAX_BLOCK_LEN)
}

/// The nearest number of steps; halves are rounded up, however the last digit of a rate is written.
pub(crate) fn rounded(steps: f64) -> usize {
    (steps + 1e-6).round() as usize
}

/// Whole blocks of `size` samples inside `span`, none of them across a gap.
pub fn blocks(channels: &Channels<'_>, span: &Range<usize>, size: usize) -> Vec<Block> {
    let mut out = Vec::new();
    let first = channels.pieces.partition_point(|p| p.end <= span.start);
    for piece in &channels.pieces[first..] {
        if piece.start >= span.end {
            break;
        }
        let (mut from, end) = (piece.start.max(span.start), piece.end.min(span.end));
        while from + size <= end {
            out.push(Block::new(channels, from..from + size));
            from += size;
        }
    }
    out
}

/// Median step of the times, s; 0 with fewer than two.
pub fn sampling_period(time_s: &[f64]) -> f64 {
    quantile(time_s.windows(2).map(|w| w[1] - w[0]).collect(), 0.5)
}

/// True if a step of the times is a gap. The last digit of a time decides nothing.
fn is_gap(step_s: f64, period_s: f64) -> bool {
    step_s > (1.0 + 1e-6) * (MIN_GAP_PERIODS * period_s).max(MIN_GAP_S)
}

/// Spans between gaps, and `breaks`: samples, in order, before which something is missing whatever the times
/// say.
pub fn pieces(time_s: &[f64], period_s: f64, breaks: &[usize]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut from = 0;
    for i in 1..=time_s.len() {
        if i == time_s.len()
            || is_gap(time_s[i] - time_s[i - 1], period_s)
            || breaks.binary_search(&i).is_ok()
        {
            out.push(from..i);
            from = i;
        }
    }
    out
}

/// Step that values are written in: most neighbouring ones of those that occur are one apart. 0 if
/// they are all the same.
pub fn resolution(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]);
    quantile(steps.filter(|d| *d > MIN_STEP).collect(), 0.5)
}

/// The value that a fraction `q` of all is at most; 0 without values.
pub fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let k = ((values.len() - 1) as f64 * q) as usize;
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}
