//! White noise of the rests, and what a move has beyond it.
//!
//! Wheels, hands and steps make a move rougher than the rests around it, and its displacement less
//! certain. What is faster than a motion of interest counts as white noise.

use std::f64::consts::PI;
use std::ops::Range;

use gravical_signal::{BLOCK_S, Block, MIN_VARIANCE, block_len, blocks, quantile};
use nalgebra::Vector3;

use crate::options::RestNoise;
use crate::samples::Samples;

/// Samples that a variance takes.
const MIN_BLOCK_LEN: usize = 5;
/// Without a rest of so many, the noise is that of this fraction of the recording, where it is quietest.
const QUIETEST: f64 = 0.1;
/// Steps of the gyroscope's resolution hide a rate for about so long, s: a turn of a hand goes through
/// several steps within it.
const HIDDEN_RATE_S: f64 = 0.2;
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Density {
    pub force: Vector3<f64>,
    pub rate: Vector3<f64>,
}

impl Density {
    pub const ZERO: Density = Density {
        force: Vector3::new(0.0, 0.0, 0.0),
        rate: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Noise of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    /// In the rests, sensor axes.
    pub rest: Density,
    /// What the filter takes it for: the same unless it is given.
    pub white: Density,
    /// Variance of the mean rate of a rest that no averaging takes away, (rad/s)².
    pub rounding: Vector3<f64>,
    /// Of the moves.
    pub rough: Roughness,
}

impl Noise {
    /// Densities by the blocks of `rests`: the variance within blocks, and where there are enough of them
    /// that between neighbours, which counts noise that is slower than a block. Rests that are all shorter
    /// than a block are blocks themselves. The filter takes those that are `given`, at least what no data sheet
    /// undercuts.
    pub fn new(
        samples: &Samples,
        rests: &[Range<usize>],
        given: Option<&RestNoise>,
        rough: Roughness,
    ) -> Noise {
        let channels = samples.channels();
        let (mut within, mut between, mut range) = ([0.0; 6], [0.0; 6], [0.0; 6]);
        let (mut count, mut pairs) = (0.0, 0.0);
        for blocks in quiet_blocks(samples, rests) {
            for block in &blocks {
                count += 1.0;
                for c in 0..6 {
                    within[c] += block.variance[c];
                    range[c] += block.range[c];
                }
            }
            for pair in blocks.windows(2) {
                pairs += 1.0;
                let size = pair[0].span.len();
                for c in 0..6 {
                    between[c] += (pair[1].mean[c] - pair[0].mean[c]).powi(2) / 2.0 * size as f64;
                }
            }
        }
        let density = |first: usize| {
            Vector3::from_fn(|axis, _| {
                let c = first + axis;
                let white = within[c] / f64::max(count, 1.0);
                let slow = between[c] / f64::max(pairs, 1.0);
                let variance = if pairs > 3.0 {
                    white.max(0.5 * (white + slow))
                } else {
                    white
                };
                variance.max(MIN_VARIANCE[c / 3]) * samples.period_s
            })
        };
        let has_gyro = if samples.has_gyro() { 1.0 } else { 0.0 };
        let rest = Density {
            force: density(0),
            rate: density(3) * has_gyro,
        };
        let at_least = |n: [f64; 3], sensor: usize| {
            Vector3::from(n).map(|n| (n * n).max(MIN_VARIANCE[sensor] * samples.period_s))
        };
        let white = given.map(|given| Density {
            force: at_least(given.force_mps2_sqrt_s, 0),
            rate: at_least(given.rate_rad_sqrt_s, 1) * has_gyro,
        });
        let resolution = channels.resolution;
        Noise {
            rest,
            white: white.unwrap_or(rest),
            rounding: Vector3::from_fn(|c, _| {
                rounding(resolution[3 + c], range[3 + c] / f64::max(count, 1.0))
            }),
            rough,
        }
    }

    /// As a caller reads it.
    pub fn of_rests(&self) -> RestNoise {
        RestNoise {
            force_mps2_sqrt_s: self.rest.force.map(f64::sqrt).into(),
            rate_rad_sqrt_s: self.rest.rate.map(f64::sqrt).into(),
        }
    }

    /// What a move has beyond the noise of the rests, the same along all axes.
    pub fn excess(&self, from: usize, to: usize) -> Density {
        let level = [self.white.force.mean(), self.white.rate.mean()];
        let [force, rate] = self.rough.excess(from..to, level);
        Density {
            force: Vector3::repeat(force),
            rate: Vector3::repeat(rate) + self.rounding * HIDDEN_RATE_S,
        }
    }
}

/// Blocks of each rest; of the quietest parts of the recording if no rest is long enough for a variance.
fn quiet_blocks(samples: &Samples, rests: &[Range<usize>]) -> Vec<Vec<Block>> {
    let channels = samples.channels();
    let size = block_len(samples.period_s, BLOCK_S);
    let longest = rests.iter().map(Range::len).max().unwrap_or(0);
    if longest >= MIN_BLOCK_LEN {
        let size = size.min(longest);
        return rests.iter().map(|r| blocks(&channels, r, size)).collect();
    }
    let mut all = blocks(&channels, &(0..samples.len()), size);
    all.sort_by(|a, b| a.total_variance(0).total_cmp(&b.total_variance(0)));
    all.truncate((all.len() as f64 * QUIETEST).ceil() as usize);
    all.into_iter().map(|block| vec![block]).collect()
}

/// Variance of a mean that no averaging takes away: noise that stays within a step dithers nothing.
fn rounding(resolution: f64, range: f64) -> f64 {
    if range < 1.5 * resolution {
        resolution.powi(2) / 12.0
    } else {
        0.0
    }
}

/// Density of the force in one rest, the axes together, (m/s²)² s; none where it has too few samples to tell.
pub(crate) fn tremor(samples: &Samples, rest: &Range<usize>) -> Option<f64> {
    if rest.len() < MIN_BLOCK_LEN {
        return None;
    }
    let rough = Roughness::default();
    let noise = Noise::new(samples, std::slice::from_ref(rest), None, rough);
    Some(noise.rest.force.sum())
}

/// Densities of windows, (m/s²)² s and (rad/s)² s, mean of the axes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Roughness {
    /// Middle sample of each window with its densities.
    windows: Vec<(usize, [f64; 2])>,
    /// Where the next window begins.
    next: usize,
    spectrum: Option<Spectrum>,
}

impl Roughness {
    /// Adds the windows that the samples so far hold; those in `quiet` spans are no rougher than the rests.
    pub fn extend(&mut self, samples: &Samples, quiet: &[Range<usize>]) {
        let sensors = if samples.has_gyro() { 2 } else { 1 };
        let spectrum = self.spectrum.get_or_insert_with(|| {
            let rows = samples.count_in(WINDOW_S).clamp(MIN_ROWS, MAX_ROWS) / 4 * 4;
            Spectrum::new(rows, samples.period_s)
        });
        let rows = spectrum.window.len();
        while self.next < samples.len() {
            let (from, end) = (self.next, samples.channels().piece(self.next).end);
            if from + rows > end {
                if end == samples.len() {
                    break;
                }
                self.next = end;
                continue;
            }
            let middle = from + rows / 2;
            let after = quiet.partition_point(|q| q.end <= middle);
            let mut density = [0.0; 2];
            if !quiet.get(after).is_some_and(|q| q.contains(&middle)) {
                for sensor in 0..sensors {
                    let column = [&samples.force, &samples.rate][sensor];
                    density[sensor] = spectrum.density(&column[from..from + rows]);
                }
            }
            self.windows.push((middle, density));
            self.next += rows / 4;
        }
    }

    /// Starts again at a sample.
    pub fn restart(&mut self, at: usize) {
        self.windows.clear();
        self.next = at;
    }

    /// Densities of a span beyond `level`, those of its median window, since a knock is no noise; 0 where it
    /// is not rougher.
    pub fn excess(&self, span: Range<usize>, level: [f64; 2]) -> [f64; 2] {
        let at = |i: usize| self.windows.partition_point(|w| w.0 < i);
        let windows = &self.windows[at(span.start)..at(span.end)];
        [0, 1].map(|sensor| {
            let density = quantile(windows.iter().map(|w| w.1[sensor]).collect(), 0.5);
            if density > MIN_EXCESS * level[sensor] {
                density - level[sensor]
            } else {
                0.0
            }
        })
    }
}

/// Periodogram of a Hann window by its definition: too short for an FFT to pay.
#[derive(Debug, Clone)]
struct Spectrum {
    window: Vec<f64>,
    /// Sine and cosine of 2πi/n.
    circle: Vec<(f64, f64)>,
    /// Lowest frequency that is rough, and that of the top third.
    first: usize,
    top: usize,
    /// From squares to a density.
    scale: f64,
    period_s: f64,
}

impl Spectrum {
    fn new(n: usize, period_s: f64) -> Spectrum {
        let window: Vec<f64> = (0..n)
            .map(|i| (PI * (i as f64 + 0.5) / n as f64).sin().powi(2))
            .collect();
        let first = ((MIN_ROUGH_HZ * period_s * n as f64).ceil() as usize).clamp(2, n / 4);
        Spectrum {
            circle: (0..n)
                .map(|i| (2.0 * PI * i as f64 / n as f64).sin_cos())
                .collect(),
            first,
            top: first.max(n / 3),
            scale: period_s / window.iter().map(|w| w * w).sum::<f64>() / 3.0,
            period_s,
            window,
        }
    }

    /// Mean density of three axes above the lowest rough frequency.
    fn density(&self, rows: &[[f64; 3]]) -> f64 {
        let n = self.window.len();
        let mut power = vec![0.0; n / 2];
        for axis in 0..3 {
            let mean = rows.iter().map(|x| x[axis]).sum::<f64>() / n as f64;
            let tapered: Vec<f64> = rows
                .iter()
                .zip(&self.window)
                .map(|(x, w)| (x[axis] - mean) * w)
                .collect();
            for (k, power) in power.iter_mut().enumerate().skip(self.first) {
                let (mut re, mut im, mut place) = (0.0, 0.0, 0);
                for v in &tapered {
                    let (sin, cos) = self.circle[place];
                    re += v * cos;
                    im += v * sin;
                    place += k;
                    if place >= n {
                        place -= n;
                    }
                }
                *power += (re * re + im * im) * self.scale;
            }
        }
        let mean = |k: usize| power[k..].iter().sum::<f64>() / (n / 2 - k) as f64;
        let limit = mean(self.top).min(typical_variance(rows) * self.period_s);
        mean(self.first).min(MAX_SLOPE * limit)
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
