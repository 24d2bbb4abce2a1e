//! Drift of a channel with temperature, from the sensor at rest (a soak).

use std::collections::BTreeMap;

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
    let mut directions = Vec::new();
    let mut now = None;
    let (mut lowest, mut highest) = (0, 0);
    for (i, t) in t_c.iter().enumerate() {
        if *t < t_c[lowest] {
            lowest = i;
        }
        if *t > t_c[highest] {
            highest = i;
        }
        let (start, next) = if t - t_c[lowest] >= turn_c && now != Some(Direction::Warming) {
            (lowest, Direction::Warming)
        } else if t_c[highest] - t >= turn_c && now != Some(Direction::Cooling) {
            (highest, Direction::Cooling)
        } else {
            continue;
        };
        directions.resize(start, now.unwrap_or(next));
        now = Some(next);
        (lowest, highest) = (i, i);
    }
    if let Some(last) = now {
        directions.resize(t_c.len(), last);
    }
    directions
}

/// Fits the drift of one channel (0 to 5) at rest, and tests it by predicting one direction of the
/// temperature from the other. Random folds, or folds within one direction, would not test it:
/// neighbours in time agree whatever the cause of their drift. `None` where the blocks determine
/// nothing.
pub fn fit_drift(blocks: &[Block], channel: usize) -> Option<Drift> {
    let bins = mean_by_degree(blocks, channel);
    let [cooling, warming] = [Direction::Cooling, Direction::Warming].map(|direction| {
        let bins = bins.iter().filter(|b| b.direction == direction);
        bins.copied().collect::<Vec<Bin>>()
    });
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

/// Mean over a degree of one direction of a rest. Bins have equal weight: a chamber stays long at
/// its ends, and the slope has to hold between them too.
#[derive(Debug, Clone, Copy)]
struct Bin {
    rest: usize,
    direction: Direction,
    t_c: f64,
    mean: f64,
}

fn mean_by_degree(blocks: &[Block], channel: usize) -> Vec<Bin> {
    let mut bins: BTreeMap<_, Vec<[f64; 2]>> = BTreeMap::new();
    for block in blocks {
        let reading = block.readings[channel];
        if reading.is_finite() && block.t_c.is_finite() {
            let key = (block.rest, block.direction, block.t_c.floor() as i64);
            bins.entry(key).or_default().push([block.t_c, reading]);
        }
    }
    let bin = |((rest, direction, _), blocks): (_, Vec<[f64; 2]>)| {
        let mean = |i: usize| blocks.iter().map(|b| b[i]).sum::<f64>() / blocks.len() as f64;
        Bin {
            rest,
            direction,
            t_c: mean(0),
            mean: mean(1),
        }
    };
    bins.into_iter().map(bin).collect()
}

/// Least squares with an offset for each rest. The offsets are eliminated by subtracting means from
/// both sides (Frisch and Waugh, Econometrica 1 (1933) 387).
fn fit_slope(bins: &[Bin]) -> Option<f64> {
    let x = subtract_offsets(bins, &[], |b| b.t_c);
    let y = subtract_offsets(bins, &[], |b| b.mean);
    let products: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
    (squares(&x) > 0.0).then(|| products / squares(&x))
}

/// 1 − Σ residuals² / Σ (mean − mean of its rest)² at the bins `to` of the slope fitted to the
/// bins `from`; `None` if nothing varies. A rest that is not in `from` has its own offset.
fn predict_r2(from: &[Bin], to: &[Bin]) -> Option<f64> {
    let per_c = fit_slope(from)?;
    let residuals = subtract_offsets(to, from, |b| b.mean - per_c * b.t_c);
    let r2 = 1.0 - squares(&residuals) / squares(&subtract_offsets(to, &[], |b| b.mean));
    r2.is_finite().then_some(r2)
}

/// A value of each of the `bins` less its mean over its rest: over those of that rest in `first` if there are
/// any, else in `bins`.
fn subtract_offsets(bins: &[Bin], first: &[Bin], value: impl Fn(&Bin) -> f64) -> Vec<f64> {
    let offset = |rest: usize| {
        let is_first = first.iter().any(|b| b.rest == rest);
        let own = if is_first { first } else { bins };
        let own = own.iter().filter(|b| b.rest == rest);
        own.clone().map(&value).sum::<f64>() / own.count() as f64
    };
    bins.iter().map(|b| value(b) - offset(b.rest)).collect()
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}
