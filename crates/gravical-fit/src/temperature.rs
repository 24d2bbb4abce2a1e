//! Drift of a channel with temperature, from the sensor at rest (a soak).

use std::collections::BTreeMap;

use nalgebra::DVector;

/// The drift of a channel is predictable if each direction explains this share of the variance of
/// the other.
const MIN_R2: f64 = 0.7;

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

/// Mean reading of a channel over some seconds at rest, or of such blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Number of the rest; each has its own offset.
    pub rest: usize,
    /// Direction of the temperature.
    pub direction: Direction,
    /// Temperature, °C.
    pub t_c: f64,
    /// Reading, in any unit.
    pub reading: f64,
}

/// A drift in proportion to temperature, and how well it predicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Unit of the readings per °C; none where one direction does not predict the other.
    pub per_c: Option<f64>,
    /// R² on the means while warming of the slope fitted to those while cooling.
    pub r2_cooling_to_warming: f64,
    /// R² the other way round.
    pub r2_warming_to_cooling: f64,
}

/// Direction of each of the temperatures `t_c` (in order of time): it changes at the extreme from
/// which the temperature has come back by `turn_c`. Empty if it never changes by that much.
pub fn detect_directions(t_c: &[f64], turn_c: f64) -> Vec<Direction> {
    let (mut directions, mut now) = (Vec::new(), None);
    let (mut lowest, mut highest) = (0, 0);
    for (i, t) in t_c.iter().enumerate() {
        lowest = if *t < t_c[lowest] { i } else { lowest };
        highest = if *t > t_c[highest] { i } else { highest };
        let (start, next) = if t - t_c[lowest] >= turn_c && now != Some(Direction::Warming) {
            (lowest, Direction::Warming)
        } else if t_c[highest] - t >= turn_c && now != Some(Direction::Cooling) {
            (highest, Direction::Cooling)
        } else {
            continue;
        };
        directions.resize(start, now.unwrap_or(next));
        (now, lowest, highest) = (Some(next), i, i);
    }
    now.map_or(Vec::new(), |last| {
        directions.resize(t_c.len(), last);
        directions
    })
}

/// Fits the drift of one channel at rest, and tests it by predicting one direction of the temperature from
/// the other. Random folds, or folds within one direction, would not test it: neighbours in time agree
/// whatever the cause of their drift. `None` where the blocks determine nothing.
pub fn fit_drift(blocks: impl Iterator<Item = Block>) -> Option<Drift> {
    let bins = mean_by_degree(blocks);
    let is_cooling = |bin: &Block| bin.direction == Direction::Cooling;
    let (cooling, warming): (Vec<_>, Vec<_>) = bins.iter().copied().partition(is_cooling);
    if cooling.len().min(warming.len()) < MIN_BINS {
        return None;
    }
    let per_c = fit_slope(&bins)?;
    let of_warming = predict_r2(&cooling, &warming)?;
    let of_cooling = predict_r2(&warming, &cooling)?;
    Some(Drift {
        per_c: (of_warming.min(of_cooling) >= MIN_R2).then_some(per_c),
        r2_cooling_to_warming: of_warming,
        r2_warming_to_cooling: of_cooling,
    })
}

/// Means over a degree of one direction of a rest. Bins have equal weight: a chamber stays long at
/// its ends, and the slope has to hold between them too.
fn mean_by_degree(blocks: impl Iterator<Item = Block>) -> Vec<Block> {
    let mut bins: BTreeMap<_, (Block, f64)> = BTreeMap::new();
    for block in blocks.filter(|b| b.reading.is_finite() && b.t_c.is_finite()) {
        let key = (block.rest, block.direction, block.t_c.floor() as i64);
        let (mean, count) = bins.entry(key).or_insert((block, 0.0));
        *count += 1.0;
        mean.t_c += (block.t_c - mean.t_c) / *count;
        mean.reading += (block.reading - mean.reading) / *count;
    }
    bins.into_values().map(|(mean, _)| mean).collect()
}

/// Least squares with an offset for each rest. The offsets are eliminated by subtracting means from
/// both sides (Frisch and Waugh, Econometrica 1 (1933) 387).
fn fit_slope(bins: &[Block]) -> Option<f64> {
    let x = subtract_offsets(bins, bins, |b| b.t_c);
    let y = subtract_offsets(bins, bins, |b| b.reading);
    (x.norm_squared() > 0.0).then(|| x.dot(&y) / x.norm_squared())
}

/// 1 − Σ residuals² / Σ (mean − mean of its rest)² at the bins `to` of the slope fitted to the
/// bins `from`; `None` if nothing varies. A rest that is not in `from` has its own offset.
fn predict_r2(from: &[Block], to: &[Block]) -> Option<f64> {
    let per_c = fit_slope(from)?;
    let residuals = subtract_offsets(to, from, |b| b.reading - per_c * b.t_c);
    let spread = subtract_offsets(to, to, |b| b.reading);
    let r2 = 1.0 - residuals.norm_squared() / spread.norm_squared();
    r2.is_finite().then_some(r2)
}

/// A value of each of the `bins` less its mean over its rest: over those of that rest in `first` if there are
/// any, else in `bins`.
fn subtract_offsets(
    bins: &[Block],
    first: &[Block],
    value: impl Fn(&Block) -> f64,
) -> DVector<f64> {
    let less_offset = |bin: &Block| {
        let own = |bins: &[Block]| -> Vec<f64> {
            bins.iter()
                .filter(|b| b.rest == bin.rest)
                .map(&value)
                .collect()
        };
        let known = Some(own(first)).filter(|own| !own.is_empty());
        let own = known.unwrap_or_else(|| own(bins));
        value(bin) - own.iter().sum::<f64>() / own.len() as f64
    };
    DVector::from_iterator(bins.len(), bins.iter().map(less_offset))
}
