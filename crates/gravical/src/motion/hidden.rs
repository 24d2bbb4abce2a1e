//! What may have moved without being seen: a sensor at rest is one whose motion its noise
//! hides.

use std::ops::Range;

use serde::Serialize;

use super::anchors::RandomWalk;
use super::samples::Samples;
use super::still::may_hide_m;

/// Durations that are reported, s.
const REPORTED_S: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// What is slower is not reckoned with, s: nothing is looked for beyond it.
const SLOWEST_S: f64 = 20.0;
/// χ² by which the mean force of a second has to differ from that of the five before it,
/// as for the windows that rests are found with.
const LIMIT_CHI2: f64 = 37.7;
/// Rest on either side that a move needs to be looked for by the whole of it, s.
const SIDES_S: f64 = 4.0;

/// How far a move has to go to be distinguished from rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VisibleMove {
    /// Its duration, s.
    pub seconds: f64,
    /// A shorter way of it may be taken for rest, m.
    pub distance_m: f64,
}

/// The noise that moves hide in, and for how long.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hidden {
    /// N² and, with a gyroscope, N_g².
    accel: f64,
    gyro: Option<f64>,
    /// The longest rest, s.
    rest_s: f64,
}

impl Hidden {
    pub fn new(walk: &RandomWalk, samples: &Samples, rests: &[Range<usize>]) -> Self {
        let length = |r: &Range<usize>| samples.t_s[r.end - 1] - samples.t_s[r.start];
        Hidden {
            accel: walk.accel_mean(),
            gyro: samples.rate_rad_s.as_ref().map(|_| walk.gyro),
            rest_s: rests.iter().map(length).fold(0.0, f64::max),
        }
    }

    /// The longest rest, s.
    pub fn rest_s(&self) -> f64 {
        self.rest_s
    }

    /// An acceleration that a second of it may hide, m/s².
    pub fn acceleration_mps2(&self) -> f64 {
        (LIMIT_CHI2 * 1.2 * self.accel).sqrt()
    }

    /// How far a move of `seconds` may go that is taken for rest, m.
    fn distance_m(&self, seconds: f64) -> f64 {
        let whole = seconds + SIDES_S <= self.rest_s;
        may_hide_m(seconds, self.accel, self.gyro, 9.8, whole)
    }

    /// The durations that fit into the longest rest, each with its way.
    pub fn table(&self) -> Vec<VisibleMove> {
        let fits = REPORTED_S.iter().filter(|s| **s <= self.rest_s);
        fits.map(|&seconds| VisibleMove {
            seconds,
            distance_m: self.distance_m(seconds),
        })
        .collect()
    }

    /// Standard uncertainty of a position in which no move is seen, `seconds` after it was
    /// zero, m: any way that may hide is as likely.
    pub fn sigma_m(&self, seconds: f64) -> f64 {
        self.distance_m(seconds.min(SLOWEST_S)) / 3.0_f64.sqrt()
    }
}
