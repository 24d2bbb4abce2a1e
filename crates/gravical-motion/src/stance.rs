//! Stances of a walking foot: between two swings the sample where the angular rate is least (angular rate
//! energy detector, Skog et al. 2010, doi 10.1109/TBME.2010.2060723), and more of them while it stands there.

use std::ops::Range;

use crate::samples::Samples;

/// Window of the root mean square of the rate, s: a stance lasts 0.3 s and more.
const WINDOW_S: f64 = 0.1;
/// A swing turns faster than this, rad/s: a foot reaches 5 to 10.
const MIN_SWING_RAD_S: f64 = 2.5;
/// What the specific force of a stance differs from gravity at most, m/s².
const MAX_FORCE_MISFIT_MPS2: f64 = 2.0;
/// Swings of a walk between two rests: a hand that turns to and fro looks like one.
const MIN_SWINGS: usize = 3;
/// A foot that stands between steps is in stance every so often, s, while it turns less than this, rad/s.
const STANDING_S: f64 = 0.5;
const MAX_STANDING_RAD_S: f64 = 0.06;

/// The quietest sample since `first`.
#[derive(Debug, Clone)]
pub(crate) struct Stance {
    first: usize,
    pub sample: usize,
    rate: f64,
    /// Number of the swing before it.
    pub swing: usize,
}

/// The stances of the move from sample `from` to `end`: at least `size` samples away from the rests there,
/// which say the same, and none if they are not those of a foot: it swings often enough, or stands after
/// the last step of the walk before.
pub(crate) fn steps(
    stances: &[Stance],
    size: usize,
    (from, end): (usize, usize),
    last_step: Option<usize>,
) -> &[Stance] {
    let first = stances.partition_point(|s| s.sample < from + size);
    let after = stances.partition_point(|s| s.sample.saturating_add(size) < end);
    let stances = stances.get(first..after).unwrap_or_default();
    let swings = stances.chunk_by(|a, b| a.swing == b.swing).count();
    let is_walk = swings >= MIN_SWINGS || stances.iter().all(|s| Some(s.swing) == last_step);
    if is_walk { stances } else { &[] }
}

/// Finds where the rate is least after each swing.
#[derive(Debug, Clone)]
pub(crate) struct StanceDetector {
    /// Samples of a window.
    pub size: usize,
    standing_len: usize,
    gravity: f64,
    max_rate_rad_s: f64,
    swing: usize,
    pub quietest: Option<Stance>,
    /// Σ ω² over the window, and the sample after it.
    sum: f64,
    at: usize,
}

impl StanceDetector {
    /// From the first sample on; `rest` says what gravity is.
    pub fn new(samples: &Samples, rest: &Range<usize>, max_rate_rad_s: f64) -> StanceDetector {
        let size = samples.count_in(WINDOW_S).max(3);
        let mean = samples.channels().mean(rest);
        StanceDetector {
            size,
            standing_len: samples.count_in(STANDING_S).max(size),
            gravity: norm(&[mean[0], mean[1], mean[2]]),
            max_rate_rad_s,
            swing: 0,
            quietest: None,
            sum: 0.0,
            at: 0,
        }
    }

    /// Those in the samples so far that were not returned before, but the last, which may get quieter.
    pub fn update(&mut self, samples: &Samples) -> Vec<Stance> {
        std::iter::from_fn(|| self.next(samples)).collect()
    }

    fn next(&mut self, samples: &Samples) -> Option<Stance> {
        if !samples.has_gyro() || self.max_rate_rad_s <= 0.0 {
            return None;
        }
        let square = |i: usize| samples.rate[i].iter().map(|w| w * w).sum::<f64>();
        let mut found = None;
        while found.is_none() && self.at < samples.len() {
            let i = self.at;
            self.at += 1;
            if i >= self.size {
                found = self.take(samples, i - self.size / 2);
                self.sum -= square(i - self.size);
            }
            self.sum += square(i);
        }
        found
    }

    fn take(&mut self, samples: &Samples, sample: usize) -> Option<Stance> {
        let rate = (self.sum / self.size as f64).max(0.0).sqrt();
        let force = (norm(&samples.force[sample]) - self.gravity).abs();
        if norm(&samples.rate[sample]) > MIN_SWING_RAD_S {
            self.swing += usize::from(self.swing == 0 || self.quietest.is_some());
            return self.quietest.take();
        }
        if self.swing == 0 || rate >= self.max_rate_rad_s || force >= MAX_FORCE_MISFIT_MPS2 {
            return None;
        }
        let stands = rate < MAX_STANDING_RAD_S;
        let standing_len = self.standing_len;
        let long = |q: &mut Stance| stands && sample - q.first > standing_len;
        let found = self.quietest.take_if(long);
        if self.quietest.as_ref().is_none_or(|q| rate < q.rate) {
            self.quietest = Some(Stance {
                first: self.quietest.as_ref().map_or(sample, |q| q.first),
                sample,
                rate,
                swing: self.swing,
            });
        }
        found
    }
}

fn norm(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
