//! White noise of the rests, and what a move has beyond it.
//!
//! Wheels, hands and steps make a move rougher than the rests around it, and its displacement less
//! certain. What is faster than a motion of interest counts as white noise.

use std::f64::consts::PI;
use std::ops::Range;

use gravical_signal::{BLOCK_S, Block, MIN_VARIANCE, block_len, blocks, quantile};
use nalgebra::{DMatrix, Vector3};
use serde::Serialize;

use gravical_signal::Samples;

/// Samples that a variance takes.
const MIN_BLOCK_LEN: usize = 5;
/// Without a rest of so many, the noise is that of this fraction of the recording, where it is quietest.
const QUIETEST: f64 = 0.1;
/// Steps of the gyroscope's resolution hide a rate for about so long, s: a turn of a hand goes through
/// several steps within it.
const HIDDEN_RATE_S: f64 = 0.2;
/// Blocks of white noise differ by no more than its variance and so many standard deviations of it.
const MAX_WANDER_SD: f64 = 3.0;
/// Windows, s: a swing of a hand and a bump are apart.
const WINDOW_S: f64 = 0.32;
/// Rows of a window: a spectrum needs some, and costs by their square.
const MIN_ROWS: usize = 12;
const MAX_ROWS: usize = 128;
/// What is slower is motion: a hand reaches 3 to 4 Hz.
const MIN_ROUGH_HZ: f64 = 5.0;
/// Factor by which the density has to exceed that of the rests: a window of 16 frequencies and three
/// axes exceeds it by chance once in 10⁶.
const MIN_EXCESS: f64 = 2.0;
/// The top third of the spectrum times this factor limits the density, and so does the typical sample:
/// what is sampled well has little of both, while white noise and aliased vibration have as much of them
/// as of all.
const MAX_SLOPE: f64 = 3.0;

/// Power densities of white noise: (m/s²)² s and (rad/s)² s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Density {
    pub force: Vector3<f64>,
    pub rate: Vector3<f64>,
}

/// White noise at rest: N of the Allan deviation, the standard deviation of a mean over 1 s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseAtRest {
    /// Accelerometer, each axis, m/s²/√Hz: 1/√2 of a one-sided density.
    pub accel_n: [f64; 3],
    /// Gyroscope, each axis, rad/s/√Hz; null without one.
    pub gyro_n: Option<[f64; 3]>,
}

/// Noise of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    /// In the rests, sensor axes.
    pub rest: Density,
    /// Variance of the mean rate of a rest that no averaging takes away, (rad/s)².
    pub rounding: Vector3<f64>,
    /// Middle sample of each window with its densities, (m/s²)² s and (rad/s)² s, mean of the axes.
    windows: Vec<(usize, [f64; 2])>,
}

impl Noise {
    /// That of `rests`; windows in them are no rougher.
    pub fn new(samples: &Samples, rests: &[Range<usize>]) -> Noise {
        let (rest, rounding) = at_rest(samples, rests);
        Noise {
            rest,
            rounding,
            windows: windows(samples, rests),
        }
    }

    /// What a move has beyond the noise of the rests, the same along all axes: the density of its median window,
    /// since a knock is no noise; 0 where it is not rougher.
    pub fn added_noise(&self, from: usize, to: usize) -> Density {
        let at = |i: usize| self.windows.partition_point(|w| w.0 < i);
        let windows = &self.windows[at(from)..at(to)];
        let level = [self.rest.force.mean(), self.rest.rate.mean()];
        let [force, rate] = [0, 1].map(|sensor| {
            let density = quantile(windows.iter().map(|w| w.1[sensor]).collect(), 0.5);
            if density > MIN_EXCESS * level[sensor] {
                density - level[sensor]
            } else {
                0.0
            }
        });
        Density {
            force: Vector3::repeat(force),
            rate: Vector3::repeat(rate) + self.rounding * HIDDEN_RATE_S,
        }
    }
}

/// Densities by the blocks of `rests`: the variance within blocks, and where there are enough of them that between
/// neighbours, which counts noise that is slower than a block; with the variance of the mean rate by rounding.
/// Rests that are all shorter than a block are blocks themselves.
fn at_rest(samples: &Samples, rests: &[Range<usize>]) -> (Density, Vector3<f64>) {
    let runs = quiet_blocks(samples, rests);
    let blocks = || runs.iter().flatten();
    let neighbours = || runs.iter().flat_map(|run| run.windows(2));
    let count = f64::max(blocks().count() as f64, 1.0);
    let pairs = neighbours().count() as f64;
    let density = |c: usize| {
        let white = blocks().map(|b| b.variance[c]).sum::<f64>() / count;
        let square = |pair: &[Block]| {
            let size = pair[0].span.len() as f64;
            (pair[1].mean[c] - pair[0].mean[c]).powi(2) / 2.0 * size
        };
        let slow = neighbours().map(square).sum::<f64>() / f64::max(pairs, 1.0);
        let variance = if pairs > 3.0 {
            white.max(0.5 * (white + slow))
        } else {
            white
        };
        variance.max(MIN_VARIANCE[c / 3]) * samples.period_s
    };
    let mut rest = Density {
        force: Vector3::from_fn(|axis, _| density(axis)),
        ..Density::default()
    };
    if samples.has_gyro() {
        rest.rate = Vector3::from_fn(|axis, _| density(3 + axis));
    }
    // Noise that stays within a step dithers nothing.
    let rounding = Vector3::from_fn(|axis, _| {
        let resolution = samples.resolution[3 + axis];
        let range = blocks().map(|b| b.range[3 + axis]).sum::<f64>() / count;
        if range < 1.5 * resolution {
            resolution.powi(2) / 12.0
        } else {
            0.0
        }
    });
    (rest, rounding)
}

/// Blocks of each rest; of the quietest parts of the recording if no rest is long enough for a variance.
fn quiet_blocks(samples: &Samples, rests: &[Range<usize>]) -> Vec<Vec<Block>> {
    let size = block_len(samples.period_s, BLOCK_S);
    let longest = rests.iter().map(Range::len).max().unwrap_or(0);
    if longest >= MIN_BLOCK_LEN {
        let size = size.min(longest);
        return rests.iter().map(|r| blocks(samples, r, size)).collect();
    }
    let mut all = blocks(samples, &(0..samples.len()), size);
    all.sort_by(|a, b| a.total_variance(0).total_cmp(&b.total_variance(0)));
    all.truncate((all.len() as f64 * QUIETEST).ceil() as usize);
    all.into_iter().map(|block| vec![block]).collect()
}

/// Density of the force in one rest, the axes together, (m/s²)² s; none where it has too few samples to tell.
pub(crate) fn tremor(samples: &Samples, rest: &Range<usize>) -> Option<f64> {
    let can_tell = rest.len() >= MIN_BLOCK_LEN;
    can_tell.then(|| at_rest(samples, std::slice::from_ref(rest)).0.force.sum())
}

/// Variances of one axis by which a span wanders, as a foot that stands or a hand does, beyond white noise: of the
/// force at its ends, by its blocks of 0.2 s, and of the mean rate.
pub(crate) fn wander(samples: &Samples, span: &Range<usize>) -> [f64; 2] {
    let size = block_len(samples.period_s, BLOCK_S);
    let blocks = blocks(samples, span, size);
    let freedom = blocks.len() as f64 - 1.0;
    if freedom < 1.0 {
        return [0.0; 2];
    }
    let mean = samples.mean(span);
    let [force, rate] = [0, 1].map(|sensor| {
        let (mut square, mut white) = (0.0, 0.0);
        for block in &blocks {
            for c in 3 * sensor..3 * sensor + 3 {
                square += (block.mean[c] - mean[c]).powi(2) / (3.0 * freedom);
            }
            white += block.total_variance(sensor) / (3 * size * blocks.len()) as f64;
        }
        // What chance makes of white noise.
        let chance = 1.0 + MAX_WANDER_SD * (2.0 / (3.0 * freedom)).sqrt();
        if square > chance * white {
            square - white
        } else {
            0.0
        }
    });
    [force, rate / blocks.len() as f64]
}

/// Densities of all windows, a quarter of one apart; none of those in `quiet` spans.
fn windows(samples: &Samples, quiet: &[Range<usize>]) -> Vec<(usize, [f64; 2])> {
    let rows = samples.count_in(WINDOW_S).clamp(MIN_ROWS, MAX_ROWS) / 4 * 4;
    let spectrum = Spectrum::new(rows, samples.period_s);
    let of_piece = |piece: &Range<usize>| {
        (piece.start + rows / 2..(piece.end + 1).saturating_sub(rows / 2)).step_by(rows / 4)
    };
    let middles = samples.pieces.iter().flat_map(of_piece);
    let window = |middle: usize| {
        let after = quiet.partition_point(|q| q.end <= middle);
        let is_quiet = quiet.get(after).is_some_and(|q| q.contains(&middle));
        let density = [&samples.force_mps2, &samples.rate_rad_s].map(|column| {
            let rows = column.get(middle - rows / 2..middle + rows / 2);
            rows.filter(|_| !is_quiet)
                .map_or(0.0, |rows| spectrum.density(rows))
        });
        (middle, density)
    };
    middles.map(window).collect()
}

/// Periodogram of a Hann window by its definition: too short for an FFT to pay.
struct Spectrum {
    /// Window times cosine and sine, two rows for each frequency from the lowest that is rough on.
    basis: DMatrix<f64>,
    /// The first of the top third of all frequencies, counted from there.
    top: usize,
    period_s: f64,
}

impl Spectrum {
    fn new(n: usize, period_s: f64) -> Spectrum {
        let first = ((MIN_ROUGH_HZ * period_s * n as f64).ceil() as usize).clamp(2, n / 4);
        let window = |i: usize| (PI * (i as f64 + 0.5) / n as f64).sin().powi(2);
        let squares: f64 = (0..n).map(|i| window(i).powi(2)).sum();
        // From squares of three axes to a density.
        let scale = (period_s / squares / 3.0).sqrt();
        let wave = |row: usize, i: usize| {
            let angle = 2.0 * PI * ((first + row / 2) * i % n) as f64 / n as f64;
            let wave = if row.is_multiple_of(2) {
                angle.cos()
            } else {
                angle.sin()
            };
            scale * window(i) * wave
        };
        Spectrum {
            basis: DMatrix::from_fn(2 * (n / 2 - first), n, wave),
            top: (n / 3).saturating_sub(first),
            period_s,
        }
    }

    /// Mean density of three axes above the lowest rough frequency.
    fn density(&self, rows: &[[f64; 3]]) -> f64 {
        let mut tapered = DMatrix::from_fn(rows.len(), 3, |i, axis| rows[i][axis]);
        for mut column in tapered.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        let amplitudes = &self.basis * tapered;
        let mean = |from: usize| {
            let all = amplitudes.rows_range(2 * from..);
            all.norm_squared() / (all.nrows() / 2) as f64
        };
        let limit = mean(self.top).min(typical_variance(rows) * self.period_s);
        mean(0).min(MAX_SLOPE * limit)
    }
}

/// Variance of white noise by the median square of third differences, mean of the axes: a step or a knock
/// changes few of them.
fn typical_variance(rows: &[[f64; 3]]) -> f64 {
    let third = |w: &[[f64; 3]], c: usize| w[3][c] - 3.0 * w[2][c] + 3.0 * w[1][c] - w[0][c];
    let variance = |c: usize| {
        let squares = rows.windows(4).map(|w| third(w, c).powi(2)).collect();
        // 1 + 9 + 9 + 1 times the variance; the median of χ² with one degree of freedom is 0.4549.
        quantile(squares, 0.5) / (20.0 * 0.4549)
    };
    (0..3).map(variance).sum::<f64>() / 3.0
}
