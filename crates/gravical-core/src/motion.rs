//! From readings to velocity and position, sample by sample, without look-ahead.
//!
//! # Overview
//!
//! Each sample is calibrated, freed of gravity, integrated by the trapezoidal rule with its own step, and stopped where the
//! sensor rests ([`crate::still::Detector`], held against the velocity and its
//! uncertainty by `gate`). A rest levels the attitude and shows the bias of the
//! gyroscope anew (`mean`).
//!
//! What a later rest tells of the move before it cannot be had here but for one
//! thing: the velocity that is left at a rest is an error that has grown on the way
//! to it, and where it grew evenly, v τ/2 of the displacement is its work. That is taken off
//! the position, which steps there. The tilt that is missing at a rest is put right
//! from there on, not for the move before. `gravical motion` corrects from both
//! ends and is the better one wherever a recording is there as a whole.
//!
//! # Example
//!
//! ```
//! use gravical_core::motion::{Motion, MotionConfig};
//!
//! // The mean of the first ten samples is gravity.
//! let mut motion = Motion::<f64, 0>::new(MotionConfig::initial_mean(10))?;
//! for i in 0..110 {
//!     let pushed = if i >= 10 { 1.0 } else { 0.0 };
//!     motion.update([pushed, 0.0, 9.81], [0.0; 3], 0.01);
//! }
//! // Half of the first step, then 0.99 s at 1 m/s².
//! assert!((motion.velocity_mps()[0] - 0.995).abs() < 1e-9);
//! # Ok::<(), gravical_core::still::TooFewSamples>(())
//! ```

mod config;
mod course;
mod gate;
mod mean;
mod propagator;
#[cfg(test)]
mod tests;

use crate::Real;
use crate::matrix3::{add, norm, scaled, sub};
use crate::still::{Detector, Event, Plan, TooFewSamples};
use crate::strapdown::{from_rotation_vector, level, levelling_error, quat_mul};

pub use config::{FirstRest, MotionConfig, Removal};
use course::Course;
pub use gate::{FAR, FLOOR_MPS, OpenNoise};
use mean::RestMean;
pub use propagator::Propagator;

/// A shorter rest corrects velocity and tilt, not the gyroscope's bias, s.
pub const LEAST_FOR_BIAS_S: f64 = 1.0;

/// A rest that has lasted so long is one, s: seconds of nearly constant acceleration,
/// as in braking, look like rest for a shorter time.
const FIRM_S: f64 = 2.0;
/// What is quiet at speed for so long after such a rest is taken for a rest, s: until
/// then it may ride at constant speed, as in a lift.
const RIDE_S: f64 = 6.0;
/// … and after one that has not lasted, s.
const DOUBTFUL_S: f64 = 1.0;

/// How it comes to rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arrival {
    /// Where the velocity is zero, as far as it is known.
    AtZero,
    /// Although it is not.
    AtSpeed,
}

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
/// takes; 0 without one.
///
/// Of what `gravical motion` does to a whole recording these are left out: the tilt
/// and the velocity corrected along a move from its far end, rests found backwards,
/// rests against the odds, moves before the first rest, uncertainties.
#[derive(Debug, Clone)]
pub struct Motion<T, const N: usize> {
    config: MotionConfig<T>,
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
    course: Course<T>,
    /// The course if the last rest was none: it goes on until that has lasted.
    doubt: Option<Course<T>>,
    taken_back: u32,
    overruled: u32,
    /// Under [`Removal::InitialMean`] the sum at the start, less the first sample.
    start: [T; 3],
    arrived: [T; 4],
    bias_known: bool,
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

impl<T: Real, const N: usize> Motion<T, N> {
    /// A pipeline at its start.
    ///
    /// # Errors
    ///
    /// Where `N` samples are too few for the rests that are looked for: one second and one more
    /// at the sampling rate of their plan.
    pub fn new(config: MotionConfig<T>) -> Result<Self, TooFewSamples> {
        let detector = match config.rests {
            Some((plan, noise)) => Some(Detector::new(plan, noise)?),
            None => None,
        };
        let zero = [T::zero(); 3];
        let unit = [T::one(), T::zero(), T::zero(), T::zero()];
        let mut forward = Propagator::new(unit, config.removal == Removal::Strapdown, zero);
        forward.set_velocity_position(config.velocity_mps, config.position_m);
        Ok(Motion {
            config,
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
            course: Course::new(forward),
            doubt: None,
            taken_back: 0,
            overruled: 0,
            start: zero,
            arrived: unit,
            bias_known: false,
        })
    }

    /// Takes raw readings `h_s` seconds after those before. A sample that is not
    /// finite is left out, and the next step goes over it: then it gives false.
    #[inline]
    pub fn update(&mut self, accel: [T; 3], gyro: [T; 3], h_s: T) -> bool {
        let force = self.config.accelerometer.apply(accel);
        let rate = self.config.gyroscope.apply(gyro, force);
        self.update_calibrated(force, force, rate, h_s, None)
    }

    /// As [`update`](Self::update), from specific force, m/s², and angular rate, rad/s, with
    /// rest or motion given, where it is known. `smoothed` is the force that is integrated:
    /// rests are found in the other one. A filter has to keep a constant; what it delays,
    /// velocity is late by.
    #[inline]
    pub fn update_calibrated(
        &mut self,
        force: [T; 3],
        smoothed: [T; 3],
        rate: [T; 3],
        h_s: T,
        rests: Option<bool>,
    ) -> bool {
        let h_s = h_s + self.pending_s;
        let sum = force[0]
            + force[1]
            + force[2]
            + smoothed[0]
            + smoothed[1]
            + smoothed[2]
            + rate[0]
            + rate[1]
            + rate[2];
        if !(sum + h_s).is_finite() {
            if h_s.is_finite() {
                self.pending_s = h_s;
            }
            return false;
        }
        self.pending_s = T::zero();
        let now = Kept {
            force: smoothed,
            rate,
            h_s,
        };
        if self.phase == Phase::Start && self.config.removal == Removal::InitialMean {
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
        self.pending_s = T::zero();
        (self.samples, self.count) = (0, 0);
        self.place_known = false;
        self.doubt = None;
        // A mean that was not complete begins again.
        if !(self.phase == Phase::Start && self.config.removal == Removal::InitialMean) {
            self.phase = Phase::Waiting;
        }
        self.course
            .forward
            .set_velocity_position(self.config.velocity_mps, self.config.position_m);
    }

    /// Where it stands.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// How many rests were taken back: from the one before them the velocity comes to
    /// zero at the next, from them it does not. Moves that they parted are one.
    #[must_use]
    pub fn taken_back(&self) -> u32 {
        self.taken_back
    }

    /// How many rests were taken for such although the velocity there is not zero within
    /// its uncertainty: how far the move before them went is not known.
    #[must_use]
    pub fn overruled(&self) -> u32 {
        self.overruled
    }

    /// Specific force of the last sample, calibrated and filtered, m/s².
    #[must_use]
    pub fn force_mps2(&self) -> [T; 3] {
        self.last.force
    }

    /// Attitude, sensor → frame; NaN while nothing is known.
    #[must_use]
    pub fn attitude(&self) -> [T; 4] {
        self.known(self.course.forward.attitude())
    }

    /// Acceleration in the frame without gravity, m/s²; NaN while nothing is known.
    #[must_use]
    pub fn acceleration_mps2(&self) -> [T; 3] {
        self.known(self.course.forward.acceleration())
    }

    /// Velocity, m/s; NaN while nothing is known.
    #[must_use]
    pub fn velocity_mps(&self) -> [T; 3] {
        match self.phase {
            Phase::Resting => [T::zero(); 3],
            Phase::Start if self.config.removal != Removal::InitialMean => [T::zero(); 3],
            _ => self.known(self.course.forward.velocity()),
        }
    }

    /// Position, m; NaN while nothing is known, and after
    /// [`interrupt`](Self::interrupt).
    #[must_use]
    pub fn position_m(&self) -> [T; 3] {
        if self.place_known {
            self.known(self.course.forward.position())
        } else {
            [T::nan(); 3]
        }
    }

    fn known<const M: usize>(&self, value: [T; M]) -> [T; M] {
        let start = self.phase == Phase::Start && self.config.removal == Removal::InitialMean;
        if start || self.phase == Phase::Waiting {
            [T::nan(); M]
        } else {
            value
        }
    }

    /// Samples whose mean is not known yet: integrated less the first one, and put
    /// right for the mean at once when it is known. A constant is integrated exactly.
    fn start_mean(&mut self, now: &Kept<T>, given: Option<bool>) {
        if self.samples == 0 {
            self.start = [T::zero(); 3];
            self.course
                .forward
                .level(self.course.forward.attitude(), now.force);
            self.course.since_s = T::zero();
        } else {
            self.course.since_s = self.course.since_s + now.h_s;
        }
        self.course.forward.update(now.force, now.rate, now.h_s);
        self.start = add(&self.start, &self.course.forward.acceleration());
        let FirstRest::Samples(count) = self.config.first_rest else {
            return;
        };
        if self.samples + 1 < count {
            return;
        }
        let share = T::one() / T::from_f64((self.samples + 1) as f64);
        let off = scaled(&self.start, share);
        let t = self.course.since_s;
        let half = T::from_f64(0.5) * t * t;
        let (v, p) = (
            self.course.forward.velocity(),
            self.course.forward.position(),
        );
        let mean = add(&self.course.forward.gravity(), &off);
        self.course
            .forward
            .level(self.course.forward.attitude(), mean);
        self.course
            .forward
            .set_velocity_position(sub(&v, &scaled(&off, t)), sub(&p, &scaled(&off, half)));
        self.course.forward.update(now.force, now.rate, T::zero());
        self.course.gravity = norm(&mean);
        self.course.rested_s = t;
        self.phase = Phase::Moving;
        if self.config.zero_velocity && given.unwrap_or(self.is_still()) {
            self.course
                .forward
                .set_velocity_position([T::zero(); 3], self.config.position_m);
            self.settle(now, given.is_some());
        }
    }

    /// Keeps a sample and shows it to the detector.
    fn note(&mut self, now: &Kept<T>, force: &[T; 3]) -> Option<Event> {
        let detector = self.detector.as_mut()?;
        if let Some(place) = self.kept.get_mut(self.count % N.max(1)) {
            *place = *now;
        }
        self.count += 1;
        detector.update(*force, Some(now.rate))
    }

    fn is_still(&self) -> bool {
        self.detector.as_ref().is_some_and(Detector::is_still)
    }

    /// A sample where there are rests.
    fn follow(&mut self, now: &Kept<T>, force: &[T; 3], given: Option<bool>) {
        let event = self.note(now, force);
        let still = self.is_still();
        if let Some(doubt) = &mut self.doubt {
            doubt.advance(now, self.config.removal == Removal::Strapdown);
        }
        match self.phase {
            Phase::Start => {
                let FirstRest::Samples(count) = self.config.first_rest else {
                    return;
                };
                if self.samples < count {
                    self.remain(now);
                } else {
                    self.leave();
                    self.phase = Phase::Moving;
                    self.advance(now);
                }
            }
            Phase::Resting => match (given, event) {
                (Some(false), _) => {
                    self.leave();
                    self.phase = Phase::Moving;
                    self.advance(now);
                    self.rely_on_first();
                }
                (None, Some(Event::Ended { onset })) => self.depart(onset),
                _ => self.remain(now),
            },
            Phase::Moving => {
                self.advance(now);
                let arrival = match given {
                    Some(given) => given.then_some(Arrival::AtZero),
                    None => self.comes_to_rest(still),
                };
                if let Some(arrival) = arrival.filter(|_| self.config.zero_velocity) {
                    self.arrive(now, given.is_some(), arrival);
                }
            }
            // A first rest that was the only one does not come again.
            Phase::Waiting if self.config.zero_velocity || !self.bias_known => {
                if given.unwrap_or(still) {
                    self.arrive_first(now, given.is_some());
                }
            }
            Phase::Waiting => {}
        }
    }

    /// One more sample of a rest.
    fn remain(&mut self, now: &Kept<T>) {
        self.rest.add(&now.force, &now.rate, now.h_s);
        if self.rest.seconds() >= T::from_f64(FIRM_S) {
            self.doubt = None;
        }
        if self.phase == Phase::Start && self.samples == 0 {
            self.level();
        }
    }

    /// Integrates a sample of a move.
    #[inline]
    fn advance(&mut self, now: &Kept<T>) {
        let turns = self.detector.is_some() && self.config.removal == Removal::Strapdown;
        self.course.advance(now, turns);
    }

    /// The rest levels and shows the bias.
    fn level(&mut self) {
        let Some((force, rate)) = self.rest.means() else {
            return;
        };
        self.course.gravity = norm(&force);
        if self.config.removal != Removal::InitialMean {
            let attitude = if self.bias_known {
                quat_mul(
                    &from_rotation_vector(&levelling_error(&self.arrived, &force)),
                    &self.arrived,
                )
            } else {
                level(force, T::zero())
            };
            let down = [T::zero(), T::zero(), self.course.gravity];
            self.course.forward.level(attitude, down);
        }
        // A short one corrects the tilt only.
        if !self.bias_known || self.rest.seconds() >= T::from_f64(LEAST_FOR_BIAS_S) {
            self.course.bias = rate;
        }
    }

    /// The rest ends with the sample before: from there it is integrated.
    fn leave(&mut self) {
        self.level();
        self.bias_known = true;
        self.course.depart(self.rest.seconds());
        if self.samples > 0 {
            // The last sample at rest: no time has passed at it.
            let last = Kept {
                h_s: T::zero(),
                ..self.last
            };
            self.advance(&last);
        }
    }

    /// The detector noticed that the rest had ended at sample `onset`: what has come
    /// since is integrated now.
    fn depart(&mut self, onset: usize) {
        let now = self.count - 1;
        let oldest = self.count.saturating_sub(N);
        let first = onset.max(oldest + 1).min(now);
        // This sample has not been added to the rest.
        for i in first..now {
            let kept = self.kept[i % N];
            self.rest.take_back(&kept.force, &kept.rate, kept.h_s);
        }
        self.last = self.kept[(first - 1) % N];
        self.leave();
        self.phase = Phase::Moving;
        for i in first..=now {
            let kept = self.kept[i % N];
            self.advance(&kept);
        }
        self.rely_on_first();
    }

    /// Without zero velocity the first rest was the only one.
    fn rely_on_first(&mut self) {
        if !self.config.zero_velocity {
            self.detector = None;
        }
    }

    /// Whether a quiet stretch is a rest. The velocity says so, from the rest before or,
    /// where that has not lasted, from the one before that: then it was none, and is
    /// taken back. And a stretch that stays quiet is one whatever the velocity is.
    fn comes_to_rest(&mut self, still: bool) -> Option<Arrival> {
        let Some((_, noise)) = &self.config.rests else {
            return None;
        };
        let quiet_s = self.course.note(still);
        if let Some(doubt) = &mut self.doubt {
            doubt.note(still);
        }
        if !still {
            return None;
        }
        if self.course.may_rest(&self.config, noise) {
            return Some(Arrival::AtZero);
        }
        if let Some(doubt) = self.doubt.filter(|d| d.may_rest(&self.config, noise)) {
            self.course = doubt;
            self.doubt = None;
            self.taken_back += 1;
            return Some(Arrival::AtZero);
        }
        let limit_s = if self.course.rested_s >= T::from_f64(FIRM_S) {
            RIDE_S
        } else {
            DOUBTFUL_S
        };
        (quiet_s >= T::from_f64(limit_s)).then(|| {
            self.overruled += 1;
            Arrival::AtSpeed
        })
    }

    /// It rests: the velocity is zero.
    fn arrive(&mut self, now: &Kept<T>, given: bool, arrival: Arrival) {
        self.doubt = (!given).then_some(self.course);
        self.course.arrive(arrival == Arrival::AtSpeed);
        self.settle(now, given);
    }

    /// The first rest, or the first after something was missing.
    fn arrive_first(&mut self, now: &Kept<T>, given: bool) {
        let velocity = if self.place_known && !self.config.zero_velocity {
            self.config.velocity_mps
        } else {
            [T::zero(); 3]
        };
        self.course
            .forward
            .set_velocity_position(velocity, self.config.position_m);
        self.settle(now, given);
    }

    fn settle(&mut self, now: &Kept<T>, given: bool) {
        self.phase = Phase::Resting;
        self.rest = RestMean::new();
        self.arrived = self.course.forward.attitude();
        match self.config.rests {
            Some((plan, _)) if !given => {
                // What the detector was certain by.
                let long = (plan.block * Plan::SEED_BLOCKS).min(N);
                for i in self.count.saturating_sub(long)..self.count {
                    let kept = self.kept[i % N];
                    self.rest.add(&kept.force, &kept.rate, kept.h_s);
                }
            }
            _ => self.rest.add(&now.force, &now.rate, now.h_s),
        }
        self.level();
    }
}
