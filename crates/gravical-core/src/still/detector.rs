//! Rest and motion, live.

use super::{CHANNELS, Plan, RestNoise, Statistic, onset};
use crate::Real;

/// What has just become certain. Samples count from 0 since [`Detector::new`] or
/// [`Detector::reset`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// It has rested since that sample, five blocks (1 s) ago.
    Began {
        /// First sample of the five blocks that agree.
        since: usize,
    },
    /// It no longer rests.
    Ended {
        /// Where the motion began, moved into the rest by the margin of the plan:
        /// the last sample to be taken as rest is the one before.
        onset: usize,
    },
}

#[derive(Debug, Clone)]
// The larger one is the usual one, and there is no heap to put it on.
#[allow(clippy::large_enum_variant)]
enum State<T> {
    Moving {
        from: usize,
    },
    Still {
        since: usize,
        statistic: Statistic<T>,
    },
}

/// Says sample by sample whether the sensor rests.
///
/// `N` is the number of samples kept: more than 1 s of them
/// ([`Plan::onset_samples`]), 101 or more at 100 Hz. In `f32` it takes 24 N + 1.6 kB (4.7 kB for 128).
///
/// It runs forwards only: where a rest begins it knows to a quarter of a block at
/// best. `gravical motion` runs backwards too.
#[derive(Debug, Clone)]
pub struct Detector<T, const N: usize> {
    plan: Plan,
    noise: RestNoise<T>,
    ring: [[T; CHANNELS]; N],
    next: usize,
    state: State<T>,
}

/// A [`Detector`] that keeps too few samples for its sampling rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooFewSamples {
    /// Samples that it keeps, its parameter `N`.
    pub kept: usize,
    /// Samples that it has to keep: one second and one more.
    pub needed: usize,
}

impl core::fmt::Display for TooFewSamples {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let TooFewSamples { kept, needed } = self;
        write!(
            f,
            "N is {kept}: at this sampling rate it has to be {needed} or more, one second of samples and one more"
        )
    }
}

impl core::error::Error for TooFewSamples {}

impl<T: Real, const N: usize> Detector<T, N> {
    /// A sensor of which nothing is known but its noise.
    ///
    /// # Errors
    ///
    /// Where `N` samples are less than 1 s and one more.
    pub fn new(plan: Plan, noise: RestNoise<T>) -> Result<Self, TooFewSamples> {
        let needed = plan.onset_samples() + 1;
        if N < needed {
            return Err(TooFewSamples { kept: N, needed });
        }
        Ok(Detector {
            plan,
            noise,
            ring: [[T::zero(); CHANNELS]; N],
            next: 0,
            state: State::Moving { from: 0 },
        })
    }

    /// True while it rests.
    #[must_use]
    pub fn is_still(&self) -> bool {
        matches!(self.state, State::Still { .. })
    }

    /// Forgets everything but the noise.
    pub fn reset(&mut self) {
        self.next = 0;
        self.state = State::Moving { from: 0 };
    }

    /// Takes a sample: specific force, m/s², and angular rate, rad/s. One with a
    /// value that is not finite is left out and not counted.
    pub fn update(&mut self, force_mps2: [T; 3], rate_rad_s: Option<[T; 3]>) -> Option<Event> {
        let [a, b, c] = force_mps2;
        let [d, e, f] = rate_rad_s.unwrap_or([T::zero(); 3]);
        let sample = [a, b, c, d, e, f];
        if !sample.iter().all(|v| v.is_finite()) {
            return None;
        }
        let now = self.next;
        self.ring[now % N] = sample;
        self.next += 1;
        match &self.state {
            State::Moving { from } => {
                let since = self.seed(*from)?;
                let statistic = self.started(since);
                self.state = State::Still { since, statistic };
                Some(Event::Began { since })
            }
            State::Still { .. } => self.go_on(now),
        }
    }

    fn at(&self, sample: usize) -> [T; CHANNELS] {
        self.ring[sample % N]
    }

    /// Whether the last five blocks agree; looked at every quarter of a block.
    fn seed(&self, from: usize) -> Option<usize> {
        let length = self.plan.block;
        let whole = length * Plan::SEED_BLOCKS;
        let since = self.next.checked_sub(whole)?;
        let step = (length / 4).max(1);
        if !since.checked_sub(from)?.is_multiple_of(step) {
            return None;
        }
        let mut means = [[T::zero(); CHANNELS]; Plan::SEED_BLOCKS];
        let mut squares = [T::zero(); CHANNELS];
        let count = T::from_f64(length as f64);
        for (k, mean) in means.iter_mut().enumerate() {
            let start = since + k * length;
            let first = self.at(start);
            let mut sum = [T::zero(); CHANNELS];
            let mut square = [T::zero(); CHANNELS];
            for i in start..start + length {
                let value = self.at(i);
                for c in 0..CHANNELS {
                    let off = value[c] - first[c];
                    sum[c] = sum[c] + off;
                    square[c] = square[c] + off * off;
                }
            }
            for c in 0..CHANNELS {
                let m = sum[c] / count;
                mean[c] = first[c] + m;
                squares[c] = squares[c] + (square[c] - m * sum[c]);
            }
        }
        let freedom = T::from_f64(((length - 1) * Plan::SEED_BLOCKS) as f64);
        let variance = squares.map(|s| s / freedom);
        (self.noise.quiet(&variance) && self.noise.agree(&means, length)).then_some(since)
    }

    /// The statistic as if it had run since the seed.
    fn started(&self, since: usize) -> Statistic<T> {
        let first = self.at(since);
        let length = self.plan.block;
        let count = T::from_f64(length as f64);
        let mut origin = [T::zero(); CHANNELS];
        for i in since..since + length {
            let value = self.at(i);
            for c in 0..CHANNELS {
                origin[c] = origin[c] + (value[c] - first[c]) / count;
            }
        }
        for c in 0..CHANNELS {
            origin[c] = origin[c] + first[c];
        }
        let mut statistic = Statistic::new(self.plan, self.noise, origin);
        for i in since..self.next {
            let leaving = self.leaving(i, since, origin);
            // There is no reference yet, so there is no alarm either.
            statistic.update(self.at(i), leaving);
        }
        statistic
    }

    fn leaving(&self, now: usize, since: usize, none: [T; CHANNELS]) -> [[T; CHANNELS]; 3] {
        self.plan.windows.map(|w| {
            if now >= since + w {
                self.at(now - w)
            } else {
                none
            }
        })
    }

    fn go_on(&mut self, now: usize) -> Option<Event> {
        let sample = self.at(now);
        let since = match &self.state {
            State::Still { since, .. } => *since,
            State::Moving { .. } => return None,
        };
        let leaving = self.leaving(now, since, sample);
        let State::Still { statistic, .. } = &mut self.state else {
            return None;
        };
        statistic.update(sample, leaving)?;
        let rest = statistic.reference().unwrap_or(sample);
        let length = self.plan.onset_samples().min(now - since);
        let variance = &self.noise.mean_variance[0];
        let tau = onset(now, length, &rest, variance, |i| self.at(i));
        self.state = State::Moving { from: now };
        let onset = (tau + 1).saturating_sub(self.plan.margin).max(since + 1);
        Some(Event::Ended { onset })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise() -> RestNoise<f64> {
        RestNoise::new([0.03; 3], 1.0, None)
    }

    #[test]
    fn the_buffer_has_to_hold_a_second() {
        let plan = Plan::new(100.0);
        let few = Detector::<f64, 100>::new(plan, noise()).unwrap_err();
        let (kept, needed) = (100, 101);
        assert_eq!(few, TooFewSamples { kept, needed });
        assert!(Detector::<f64, 101>::new(plan, noise()).is_ok());
    }

    #[test]
    fn what_shakes_never_rests() {
        let mut detector: Detector<f64, 101> = Detector::new(Plan::new(100.0), noise()).unwrap();
        for i in 0..2000 {
            let shake = if i % 2 == 0 { 0.2 } else { -0.2 };
            assert_eq!(detector.update([shake, 0.0, 9.81], None), None);
        }
        assert!(!detector.is_still());
    }

    #[test]
    fn reset_forgets() {
        let mut detector: Detector<f64, 101> = Detector::new(Plan::new(100.0), noise()).unwrap();
        let events = |d: &mut Detector<f64, 101>| {
            (0..300)
                .filter_map(|i| d.update([0.0, if i < 250 { 0.0 } else { 1.0 }, 9.81], None))
                .collect::<std::vec::Vec<_>>()
        };
        let first = events(&mut detector);
        assert_eq!(first[0], Event::Began { since: 0 });
        assert!(matches!(first[1], Event::Ended { onset } if (240..=250).contains(&onset)));
        detector.reset();
        assert_eq!(events(&mut detector), first);
    }

    #[test]
    fn rest_after_motion_begins_anew() {
        let mut detector: Detector<f64, 101> = Detector::new(Plan::new(100.0), noise()).unwrap();
        let mut events = std::vec::Vec::new();
        for i in 0..900 {
            // Laid on another side in between.
            let force = match i {
                0..300 => [0.0, 0.0, 9.81],
                300..500 => [f64::from(i % 7), f64::from(i % 5), 5.0],
                _ => [9.81, 0.0, 0.0],
            };
            events.extend(detector.update(force, None));
        }
        assert_eq!(events.len(), 3, "{events:?}");
        assert!(matches!(events[2], Event::Began { since } if (500..506).contains(&since)));
    }

    #[test]
    fn numbers_that_are_none_start_no_rest() {
        let mut detector: Detector<f64, 101> = Detector::new(Plan::new(100.0), noise()).unwrap();
        for _ in 0..500 {
            assert_eq!(detector.update([f64::NAN, 0.0, 9.81], None), None);
        }
    }
}
