//! Drift of a channel with temperature, from the sensor at rest (a soak).

use std::collections::BTreeMap;

/// The drift of a channel is predictable if each direction explains this share of the variance of
/// the other.
const MIN_R2: f64 = 0.7;

/// A drift below this multiple of the standard errors of the means is not significant.
const NOISE_OF_DRIFT: f64 = 2.0;
/// Smallest number of bins in each direction.
const MIN_BINS: usize = 6;

/// Direction of a temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// Falling.
    Cooling,
    /// Rising.
    Warming,
}

/// Mean readings over some seconds at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Number of the rest; each has its own offset.
    pub rest: usize,
    /// Direction of the temperature.
    pub direction: Direction,
    /// Temperature, °C.
    pub t_c: f64,
    /// Readings of the channels, in any unit.
    pub readings: [f64; 6],
}

/// A drift in proportion to temperature, and how well it predicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Unit of the readings per °C.
    pub per_c: f64,
    /// R² on the means while warming of the slope fitted to those while cooling.
    pub r2_cooling_to_warming: f64,
    /// R² the other way round.
    pub r2_warming_to_cooling: f64,
    /// The means vary by more than their noise.
    pub significant: bool,
}

impl Drift {
    /// True if each direction predicts the other.
    pub fn is_predictable(&self) -> bool {
        self.r2_cooling_to_warming.min(self.r2_warming_to_cooling) >= MIN_R2
    }
}

/// Direction of each of the temperatures `t_c` (in order of time): it changes at the extreme from
/// which the temperature has come back by `turn_c`. Empty if it never changes by that much.
pub fn detect_directions(t_c: &[f64], turn_c: f64) -> Vec<Direction> {
    let mut turns: Vec<(usize, Direction)> = Vec::new();
    let (mut lowest, mut highest) = (0, 0);
    for (i, t) in t_c.iter().enumerate() {
        if *t < t_c[lowest] {
            lowest = i;
        }
        if *t > t_c[highest] {
            highest = i;
        }
        let before = turns.last().map(|turn| turn.1);
        let turn = if t - t_c[lowest] >= turn_c && before != Some(Direction::Warming) {
            (lowest, Direction::Warming)
        } else if t_c[highest] - t >= turn_c && before != Some(Direction::Cooling) {
            (highest, Direction::Cooling)
        } else {
            continue;
        };
        turns.push(turn);
        (lowest, highest) = (i, i);
    }
    let Some(&(_, first)) = turns.first() else {
        return Vec::new();
    };
    let mut directions = vec![first; t_c.len()];
    for (start, direction) in turns {
        directions[start..].fill(direction);
    }
    directions
}

/// Fits the drift of one channel (0 to 5) at rest, and tests it by predicting one direction of the
/// temperature from the other. Random folds, or folds within one direction, would not test it:
/// neighbours in time agree whatever the cause of their drift. `None` where the blocks determine
/// nothing.
pub fn fit_drift(blocks: &[Block], channel: usize) -> Option<Drift> {
    let bins = mean_by_degree(blocks, channel);
    let of_direction = |direction| -> Vec<Bin> {
        let bins = bins.iter().filter(|b| b.direction == direction);
        bins.copied().collect()
    };
    let (cooling, warming) = (
        of_direction(Direction::Cooling),
        of_direction(Direction::Warming),
    );
    if cooling.len().min(warming.len()) < MIN_BINS {
        return None;
    }
    let means: Vec<f64> = bins.iter().map(|b| b.mean).collect();
    let variance = squares(&subtract_offsets(&bins, &means)) / bins.len() as f64;
    let noise = variance_of_means(&bins);
    Some(Drift {
        per_c: fit_slope(&bins)?,
        r2_cooling_to_warming: predict_r2(&cooling, &warming)?,
        r2_warming_to_cooling: predict_r2(&warming, &cooling)?,
        significant: variance > NOISE_OF_DRIFT.powi(2) * noise,
    })
}

/// Mean over a degree of one direction of a rest. Bins have equal weight: a chamber stays long at
/// its ends, and the slope has to hold between them too.
#[derive(Debug, Clone, Copy)]
struct Bin {
    rest: usize,
    direction: Direction,
    t_c: f64,
    mean: f64,
    count: f64,
    /// Sum of the squared deviations of the blocks.
    squares: f64,
}

fn mean_by_degree(blocks: &[Block], channel: usize) -> Vec<Bin> {
    let mut bins: BTreeMap<_, Vec<&Block>> = BTreeMap::new();
    let reading = |block: &Block| block.readings[channel];
    for block in blocks {
        if reading(block).is_finite() && block.t_c.is_finite() {
            let key = (block.rest, block.direction, block.t_c.floor() as i64);
            bins.entry(key).or_default().push(block);
        }
    }
    let bin = |((rest, direction, _), blocks): (_, Vec<&Block>)| {
        let count = blocks.len() as f64;
        let mean = blocks.iter().map(|b| reading(b)).sum::<f64>() / count;
        Bin {
            rest,
            direction,
            t_c: blocks.iter().map(|b| b.t_c).sum::<f64>() / count,
            mean,
            count,
            squares: blocks.iter().map(|b| (reading(b) - mean).powi(2)).sum(),
        }
    };
    bins.into_iter().map(bin).collect()
}

/// Mean square of the standard errors of the bins, from the scatter of their blocks. Drift within a
/// bin is included, so it is not too small.
fn variance_of_means(bins: &[Bin]) -> f64 {
    let freedom: f64 = bins.iter().map(|b| b.count - 1.0).sum();
    let variance = bins.iter().map(|b| b.squares).sum::<f64>() / freedom.max(1.0);
    variance * bins.iter().map(|b| 1.0 / b.count).sum::<f64>() / bins.len() as f64
}

/// Least squares with an offset for each rest. The offsets are eliminated by subtracting means from
/// both sides (Frisch and Waugh, Econometrica 1 (1933) 387).
fn fit_slope(bins: &[Bin]) -> Option<f64> {
    let t_c: Vec<f64> = bins.iter().map(|b| b.t_c).collect();
    let means: Vec<f64> = bins.iter().map(|b| b.mean).collect();
    let (x, y) = (subtract_offsets(bins, &t_c), subtract_offsets(bins, &means));
    let products: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
    (squares(&x) > 0.0).then(|| products / squares(&x))
}

/// 1 − Σ residuals² / Σ (mean − mean of its rest)² at the bins `to` of the slope fitted to the
/// bins `from`; `None` if nothing varies. A rest that is not in `from` has its own offset.
fn predict_r2(from: &[Bin], to: &[Bin]) -> Option<f64> {
    let per_c = fit_slope(from)?;
    let remainders = |bins: &[Bin]| -> Vec<f64> {
        let remainder = |b: &Bin| b.mean - per_c * b.t_c;
        bins.iter().map(remainder).collect()
    };
    let left = remainders(to);
    let mut offsets = mean_by_rest(to, &left);
    offsets.extend(mean_by_rest(from, &remainders(from)));
    let residuals = to.iter().zip(left).map(|(b, v)| v - offsets[&b.rest]);
    let residuals: Vec<f64> = residuals.collect();
    let means: Vec<f64> = to.iter().map(|b| b.mean).collect();
    let r2 = 1.0 - squares(&residuals) / squares(&subtract_offsets(to, &means));
    r2.is_finite().then_some(r2)
}

fn mean_by_rest(bins: &[Bin], values: &[f64]) -> BTreeMap<usize, f64> {
    let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for (bin, value) in bins.iter().zip(values) {
        let (sum, count) = sums.entry(bin.rest).or_default();
        *sum += value;
        *count += 1.0;
    }
    let means = sums.into_iter().map(|(rest, (sum, n))| (rest, sum / n));
    means.collect()
}

fn subtract_offsets(bins: &[Bin], values: &[f64]) -> Vec<f64> {
    let means = mean_by_rest(bins, values);
    let rows = bins.iter().zip(values);
    rows.map(|(bin, value)| value - means[&bin.rest]).collect()
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}
