//! What each rest says of tilt, gravity and the gyroscope's bias.

use std::ops::Range;

use gravical_core::motion::LEAST_FOR_BIAS_S;

use super::MotionOptions;
use super::leg::Anchor;
use super::samples::{Samples, View};
use super::still::Noise;
use crate::finding::{Finding, FindingKind};

/// Of a long rest so much counts, at the end where the leg begins, s: biases
/// drift.
const LONGEST_S: f64 = 10.0;

/// Variance of a gyroscope's bias that no rest shows, (rad/s)²: 1 °/s.
const UNKNOWN_BIAS: f64 = 3.0e-4;

/// Which end of a rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// Its first seconds: where a leg arrives.
    First,
    /// Its last seconds: where a leg departs.
    Last,
}

/// Noise as it walks: N of the accelerometer along each axis of the sensor and of
/// the gyroscope.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RandomWalk {
    /// N², m²/s³.
    pub accel: [f64; 3],
    /// N_g², rad²/s; the mean of the axes.
    pub gyro: f64,
    /// Variance that rounding leaves in the mean of any rest, the mean of the axes:
    /// (m/s²)² and (rad/s)².
    pub rounding: [f64; 2],
}

impl RandomWalk {
    /// N² = σ²·VIF·Σw²/Σw over samples of the weights w that the trapezoid gives
    /// them, half of the time between their neighbours: with even stamps σ²·VIF·h.
    pub fn new(accel: Option<&Noise>, gyro: Option<&Noise>, samples: &Samples) -> Self {
        let (mut sum, mut squares) = (0.0, 0.0);
        for piece in samples.pieces() {
            for t in samples.t_s[piece].windows(3) {
                let w = 0.5 * (t[2] - t[0]);
                sum += w;
                squares += w * w;
            }
        }
        let step = if sum > 0.0 { squares / sum } else { 0.0 };
        let walk = |noise: &Noise| noise.sigma.map(|s| s * s * noise.vif * step);
        let left = |noise: &Noise| noise.rounding.iter().map(|r| r * r).sum::<f64>() / 3.0;
        RandomWalk {
            accel: accel.map_or([0.0; 3], walk),
            gyro: gyro.map_or(0.0, |n| walk(n).iter().sum::<f64>() / 3.0),
            rounding: [accel.map_or(0.0, left), gyro.map_or(0.0, left)],
        }
    }

    /// With N of an Allan deviation, as far as it is known, and a finding that says what was used.
    pub fn with_noise(mut self, options: &MotionOptions) -> (Self, Option<Finding>) {
        let Some(noise) = &options.noise else {
            return (self, None);
        };
        let say = |sensor: &str, unit: &str, own: f64, rest: f64| {
            let ratio = match rest > 0.0 {
                true => format!(", {:.2} times that of the rests", (own / rest).sqrt()),
                false => String::new(),
            };
            let n = own.sqrt();
            format!("N of the noise file for the {sensor} ({n:.2e} {unit}{ratio})")
        };
        let (accel, gyro) = (self.accel_mean(), self.gyro);
        let of_rests = |sensor: &str| {
            format!("for the {sensor} N of the rests, because the file lacks N of an axis")
        };
        let of_accel = match noise.densities('a') {
            Some(n) => {
                self.accel = options.axes.to_case(n).map(|n| n * n);
                say("accelerometer", "m/s²/√Hz", self.accel_mean(), accel)
            }
            None => of_rests("accelerometer"),
        };
        let of_gyro = match noise.densities('g') {
            Some(n) => {
                self.gyro = n.iter().map(|n| n * n).sum::<f64>() / 3.0;
                say("gyroscope", "rad/s/√Hz", self.gyro, gyro)
            }
            None => of_rests("gyroscope"),
        };
        let text = format!("the bands use {of_accel}; {of_gyro}");
        (self, Some(Finding::new(FindingKind::NoiseUsed, text)))
    }

    /// The mean of the accelerometer's axes, m²/s³.
    pub fn accel_mean(&self) -> f64 {
        self.accel.iter().sum::<f64>() / 3.0
    }

    /// Seconds of noise alone that a mean of the accelerometer over `seconds` is worth:
    /// fewer, where rounding leaves more in it than noise does.
    fn worth_s(&self, seconds: f64) -> f64 {
        let density = self.accel_mean();
        if density > 0.0 {
            seconds / (1.0 + self.rounding[0] * seconds / density)
        } else {
            seconds
        }
    }

    /// Variance of the gyroscope's bias by a mean over `seconds`, (rad/s)².
    fn bias(&self, seconds: f64) -> f64 {
        self.gyro / seconds + self.rounding[1]
    }
}

/// The rests of a recording, asked for what they say.
pub(super) struct Anchors<'a> {
    view: View<'a>,
    walk: RandomWalk,
}

impl<'a> Anchors<'a> {
    pub fn new(view: View<'a>, walk: RandomWalk) -> Self {
        Anchors { view, walk }
    }

    /// What the rest `k` of `rests` says at that side.
    pub fn at(&self, rests: &[Range<usize>], k: usize, side: Side) -> Anchor {
        let rows = self.part(&rests[k], side);
        let (bias, bias_variance) = self.bias(rests, k, side);
        Anchor {
            force: self.view.mean_force(rows.clone()),
            seconds: self.walk.worth_s(self.seconds(&rows)),
            bias,
            bias_variance,
        }
    }

    /// What all of `rows` say, however long.
    pub fn whole(&self, rows: Range<usize>) -> Anchor {
        Anchor {
            force: self.view.mean_force(rows.clone()),
            seconds: self.walk.worth_s(self.seconds(&rows)),
            ..self.over(rows)
        }
    }

    /// What samples that are no rest say: the mean is all there is of gravity, and
    /// of the gyroscope's bias nothing is known.
    pub fn moving(&self, rows: Range<usize>) -> Anchor {
        Anchor {
            bias: [0.0; 3],
            bias_variance: UNKNOWN_BIAS,
            ..self.whole(rows)
        }
    }

    /// The same for samples that are no rest, or one that was cut by hand.
    pub fn over(&self, rows: Range<usize>) -> Anchor {
        self.at(std::slice::from_ref(&rows), 0, Side::First)
    }

    /// The rest that the bias is taken from: itself where it is long enough, else
    /// the last long one before, else the first after.
    fn source(&self, rests: &[Range<usize>], k: usize) -> Option<usize> {
        let long = |k: &usize| self.seconds(&rests[*k]) >= LEAST_FOR_BIAS_S;
        (0..=k)
            .rev()
            .find(long)
            .or_else(|| (k..rests.len()).find(long))
    }

    fn bias(&self, rests: &[Range<usize>], k: usize, side: Side) -> ([f64; 3], f64) {
        if !self.view.has_gyro() {
            return ([0.0; 3], 0.0);
        }
        match self.source(rests, k) {
            Some(source) => {
                let side = match source.cmp(&k) {
                    std::cmp::Ordering::Less => Side::Last,
                    std::cmp::Ordering::Equal => side,
                    std::cmp::Ordering::Greater => Side::First,
                };
                let rows = self.part(&rests[source], side);
                let variance = self.walk.bias(self.seconds(&rows));
                (self.view.mean_rate(rows), variance)
            }
            // A short rest is better than none.
            None => {
                let rows = self.part(&rests[k], side);
                let variance = self.walk.bias(self.seconds(&rows)) + UNKNOWN_BIAS;
                (self.view.mean_rate(rows), variance)
            }
        }
    }

    fn part(&self, rest: &Range<usize>, side: Side) -> Range<usize> {
        let t = self.view.t_s();
        match side {
            Side::First => {
                let until = t[rest.start] + LONGEST_S;
                let count = t[rest.clone()].partition_point(|t| *t <= until);
                rest.start..rest.start + count.max(1)
            }
            Side::Last => {
                let from = t[rest.end - 1] - LONGEST_S;
                let skip = t[rest.clone()].partition_point(|t| *t < from);
                rest.start + skip.min(rest.len() - 1)..rest.end
            }
        }
    }

    /// Time that the samples stand for; never zero.
    pub fn seconds(&self, rows: &Range<usize>) -> f64 {
        let t = self.view.t_s();
        let n = rows.len();
        let span = t[rows.end - 1] - t[rows.start];
        if n > 1 && span > 0.0 {
            span * n as f64 / (n - 1) as f64
        } else {
            1e-3
        }
    }
}
