//! From readings to velocity and position, sample by sample, without look-ahead.
//!
//! # Overview
//!
//! Each sample is calibrated, filtered if asked for (`smooth`), freed of gravity,
//! integrated by the trapezoidal rule with its own step, and stopped where the
//! sensor rests ([`crate::still::Detector`], held against the velocity and its
//! uncertainty by `gate`). A rest levels the attitude and shows the bias of the
//! gyroscope anew (`mean`).
//!
//! What a later rest tells of the move before it cannot be had here but for one
//! thing: the velocity that is left at a rest is an error that has grown on the way
//! to it, and where it grew evenly, v τ/2 of the way is its work. That is taken off
//! the position, which steps there. The tilt that is missing at a rest is put right
//! from there on, not for the way that was. `gravical motion` corrects from both
//! ends and is the better one wherever a recording is there as a whole.
//!
//! # Example
//!
//! ```
//! use gravical_core::motion::{Motion, MotionConfig};
//!
//! // The mean of the first ten samples is gravity.
//! let mut motion = Motion::<f64, (), 0>::new(MotionConfig::still_mean(10), ())
//!     .ok_or("only rests that are looked for need memory")?;
//! for i in 0..110 {
//!     let pushed = if i >= 10 { 1.0 } else { 0.0 };
//!     motion.update([pushed, 0.0, 9.81], [0.0; 3], 0.01);
//! }
//! // Half of the first step, then 0.99 s at 1 m/s².
//! assert!((motion.velocity_mps()[0] - 0.995).abs() < 1e-9);
//! # Ok::<(), &str>(())
//! ```

mod config;
mod gate;
mod mean;
mod smooth;
mod steps;
#[cfg(test)]
mod tests;

use crate::Real;
use crate::integrate::Trapezoid;
use crate::still::Detector;
use crate::strapdown::Strapdown;

pub use config::{FirstRest, MotionConfig, Removal};
use mean::RestMean;
pub use smooth::{LowPass, Smooth};

/// Where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Before the first rest, or after something is missing: nothing is known.
    Waiting,
    /// In the samples at the start that were named.
    Start,
    /// At rest.
    Resting,
    /// Moving.
    Moving,
}

/// The pipeline and its state. `N` samples are kept: [`Detector`] says how many it
/// takes; 0 without one. `F` is the filter, `()` for none.
///
/// Of what `gravical motion` does to a whole recording these are left out: the tilt
/// and the velocity corrected along a move from its far end, rests found backwards,
/// rests against the odds, moves before the first rest, uncertainties.
#[derive(Debug, Clone)]
pub struct Motion<T, F, const N: usize> {
    config: MotionConfig<T>,
    smooth: F,
    detector: Option<Detector<T, N>>,
    /// The last samples, by number.
    kept: [Kept<T>; N],
    /// Samples since the start, and since the detector counts.
    samples: usize,
    count: usize,
    pending_s: T,
    phase: Phase,
    place_known: bool,
    rest: RestMean<T>,
    last: Kept<T>,
    /// Under [`Removal::StillMean`] what is subtracted, and the sum at the start.
    mean: [T; 3],
    start: [T; 3],
    gravity: T,
    attitude: [T; 4],
    arrived: [T; 4],
    departed: [T; 4],
    bias: [T; 3],
    bias_known: bool,
    strapdown: Strapdown<T>,
    way: Trapezoid<T>,
    acceleration: [T; 3],
    /// Since the rest, s; and how long that was.
    since_s: T,
    rested_s: T,
    steps: T,
    /// ∫ of the angle from the rest, rad s.
    turned: T,
}

/// A sample as it is integrated.
#[derive(Debug, Clone, Copy)]
struct Kept<T> {
    /// Specific force, filtered, m/s².
    force: [T; 3],
    /// Angular rate, rad/s.
    rate: [T; 3],
    h_s: T,
}

impl<T: Real> Kept<T> {
    fn none() -> Self {
        let zero = [T::zero(); 3];
        Kept {
            force: zero,
            rate: zero,
            h_s: T::zero(),
        }
    }
}

impl<T: Real, F: Smooth<T>, const N: usize> Motion<T, F, N> {
    /// A pipeline at its start; none where `N` is too small for the rests that are
    /// looked for.
    #[must_use]
    pub fn new(config: MotionConfig<T>, smooth: F) -> Option<Self> {
        let detector = match config.rests {
            Some((plan, noise)) => Some(Detector::new(plan, noise)?),
            None => None,
        };
        let zero = [T::zero(); 3];
        let unit = [T::one(), T::zero(), T::zero(), T::zero()];
        Some(Motion {
            config,
            smooth,
            detector,
            kept: [Kept::none(); N],
            samples: 0,
            count: 0,
            pending_s: T::zero(),
            phase: match config.first_rest {
                FirstRest::Samples(_) => Phase::Start,
                FirstRest::Found => Phase::Waiting,
            },
            place_known: true,
            rest: RestMean::new(),
            last: Kept::none(),
            mean: zero,
            start: zero,
            gravity: T::zero(),
            attitude: unit,
            arrived: unit,
            departed: unit,
            bias: zero,
            bias_known: false,
            strapdown: Strapdown::new(unit),
            way: Trapezoid::new(config.velocity_mps, config.position_m),
            acceleration: zero,
            since_s: T::zero(),
            rested_s: T::zero(),
            steps: T::zero(),
            turned: T::zero(),
        })
    }

    /// Takes raw readings `h_s` seconds after those before. A sample that is not
    /// finite is left out, and the next step goes over it: then it gives false.
    #[inline]
    pub fn update(&mut self, accel: [T; 3], gyro: [T; 3], h_s: T) -> bool {
        self.update_told(accel, gyro, h_s, None)
    }

    /// As [`update`](Self::update), told whether it rests there.
    #[inline]
    pub fn update_told(
        &mut self,
        accel: [T; 3],
        gyro: [T; 3],
        h_s: T,
        rests: Option<bool>,
    ) -> bool {
        let force = self.config.accelerometer.apply(accel);
        let rate = self.config.gyroscope.apply(gyro, force);
        self.update_calibrated(force, rate, h_s, rests)
    }

    /// As [`update_told`](Self::update_told), from specific force, m/s², and angular
    /// rate, rad/s.
    #[inline]
    pub fn update_calibrated(
        &mut self,
        force: [T; 3],
        rate: [T; 3],
        h_s: T,
        rests: Option<bool>,
    ) -> bool {
        let h_s = h_s + self.pending_s;
        let sum = force[0] + force[1] + force[2] + rate[0] + rate[1] + rate[2];
        if !(sum + h_s).is_finite() {
            if h_s.is_finite() {
                self.pending_s = h_s;
            }
            return false;
        }
        self.pending_s = T::zero();
        let now = Kept {
            force: self.smooth.update(force),
            rate,
            h_s,
        };
        if self.phase == Phase::Start && self.config.removal == Removal::StillMean {
            self.note(&now, &force);
            self.start_mean(&now, rests);
        } else if self.detector.is_none() && rests.is_none() && self.phase == Phase::Moving {
            self.advance(&now);
        } else {
            self.follow(&now, &force, rests);
        }
        self.last = now;
        self.samples += 1;
        true
    }

    /// Something is missing here: no position will be known any more, and nothing
    /// else before the next rest.
    pub fn interrupt(&mut self) {
        if let Some(detector) = &mut self.detector {
            detector.reset();
        }
        self.smooth.reset();
        self.pending_s = T::zero();
        (self.samples, self.count) = (0, 0);
        self.place_known = false;
        // A mean that was not complete begins again.
        if !(self.phase == Phase::Start && self.config.removal == Removal::StillMean) {
            self.phase = Phase::Waiting;
        }
        self.way
            .reset(self.config.velocity_mps, self.config.position_m);
    }

    /// Where it stands.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Specific force of the last sample, calibrated and filtered, m/s².
    #[must_use]
    pub fn force_mps2(&self) -> [T; 3] {
        self.last.force
    }

    /// Attitude, sensor → frame; NaN while nothing is known.
    #[must_use]
    pub fn attitude(&self) -> [T; 4] {
        self.known(self.attitude)
    }

    /// Acceleration in the frame without gravity, m/s²; NaN while nothing is known.
    #[must_use]
    pub fn acceleration_mps2(&self) -> [T; 3] {
        self.known(self.acceleration)
    }

    /// Velocity, m/s; NaN while nothing is known.
    #[must_use]
    pub fn velocity_mps(&self) -> [T; 3] {
        match self.phase {
            Phase::Resting => [T::zero(); 3],
            Phase::Start if self.config.removal != Removal::StillMean => [T::zero(); 3],
            _ => self.known(self.way.velocity()),
        }
    }

    /// Position, m; NaN while nothing is known, and after
    /// [`interrupt`](Self::interrupt).
    #[must_use]
    pub fn position_m(&self) -> [T; 3] {
        if self.place_known {
            self.known(self.way.position())
        } else {
            [T::nan(); 3]
        }
    }

    fn known<const M: usize>(&self, value: [T; M]) -> [T; M] {
        let start = self.phase == Phase::Start && self.config.removal == Removal::StillMean;
        if start || self.phase == Phase::Waiting {
            [T::nan(); M]
        } else {
            value
        }
    }
}
