//! What a sample does to the state: before, at and between rests.

use crate::Real;
use crate::matrix3::{add, norm, scaled, sub};
use crate::still::{Detector, Event, Plan};
use crate::strapdown::{level, missing_tilt, rotate, times, turn};

use super::{FirstRest, Kept, Motion, Phase, Removal, RestMean, Smooth, gate};

/// A shorter rest corrects velocity and tilt, not the gyroscope's bias, s.
const LEAST_FOR_BIAS_S: f64 = 1.0;

impl<T: Real, F: Smooth<T>, const N: usize> Motion<T, F, N> {
    /// Samples whose mean is not known yet: integrated less the first one, and put
    /// right for the mean at once when it is known. A constant is integrated exactly.
    pub(super) fn start_mean(&mut self, now: &Kept<T>, told: Option<bool>) {
        if self.samples == 0 {
            (self.mean, self.start) = (now.force, [T::zero(); 3]);
            self.since_s = T::zero();
        } else {
            self.since_s = self.since_s + now.h_s;
        }
        let off = sub(&now.force, &self.mean);
        self.start = add(&self.start, &off);
        self.way.update(off, now.h_s);
        let FirstRest::Samples(count) = self.config.first_rest else {
            return;
        };
        if self.samples + 1 < count {
            return;
        }
        let share = T::one() / T::from_f64((self.samples + 1) as f64);
        let off = scaled(&self.start, share);
        let t = self.since_s;
        let half = T::from_f64(0.5) * t * t;
        let (v, p) = (self.way.velocity(), self.way.position());
        self.mean = add(&self.mean, &off);
        self.way
            .reset(sub(&v, &scaled(&off, t)), sub(&p, &scaled(&off, half)));
        self.acceleration = sub(&now.force, &self.mean);
        self.way.update(self.acceleration, T::zero());
        self.gravity = norm(&self.mean);
        self.rested_s = t;
        self.phase = Phase::Moving;
        if self.config.zero_velocity && told.unwrap_or(self.is_still()) {
            self.way.reset([T::zero(); 3], self.config.position_m);
            self.settle(now, told.is_some());
        }
    }

    /// Keeps a sample and shows it to the detector.
    pub(super) fn note(&mut self, now: &Kept<T>, force: &[T; 3]) -> Option<Event> {
        let detector = self.detector.as_mut()?;
        if let Some(place) = self.kept.get_mut(self.count % N.max(1)) {
            *place = *now;
        }
        self.count += 1;
        detector.update(*force, Some(now.rate))
    }

    pub(super) fn is_still(&self) -> bool {
        self.detector.as_ref().is_some_and(Detector::is_still)
    }

    /// A sample where there are rests.
    pub(super) fn follow(&mut self, now: &Kept<T>, force: &[T; 3], told: Option<bool>) {
        let event = self.note(now, force);
        let still = self.is_still();
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
            Phase::Resting => match (told, event) {
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
                let rests = match told {
                    Some(told) => told,
                    None => still && self.may_rest(),
                };
                if rests && self.config.zero_velocity {
                    self.arrive(now, told.is_some());
                }
            }
            // A first rest that was the only one does not come again.
            Phase::Waiting if self.config.zero_velocity || !self.bias_known => {
                if told.unwrap_or(still) {
                    self.arrive_first(now, told.is_some());
                }
            }
            Phase::Waiting => {}
        }
    }

    /// One more sample of a rest.
    pub(super) fn remain(&mut self, now: &Kept<T>) {
        self.rest.add(&now.force, &now.rate, now.h_s);
        if self.phase == Phase::Start && self.samples == 0 {
            self.level();
        }
    }

    /// Integrates a sample of a move.
    #[inline]
    pub(super) fn advance(&mut self, now: &Kept<T>) {
        self.since_s = self.since_s + now.h_s;
        self.steps = self.steps + T::one();
        self.acceleration = match self.config.removal {
            Removal::StillMean => sub(&now.force, &self.mean),
            Removal::ConstantTilt => self.without_gravity(&now.force),
            Removal::Strapdown => {
                self.attitude = self.strapdown.update(sub(&now.rate, &self.bias), now.h_s);
                self.without_gravity(&now.force)
            }
        };
        if self.detector.is_some() && self.config.removal == Removal::Strapdown {
            self.turned = self.turned + now.h_s * gate::angle(&self.departed, &self.attitude);
        }
        self.way.update(self.acceleration, now.h_s);
    }

    pub(super) fn without_gravity(&self, force: &[T; 3]) -> [T; 3] {
        let up = rotate(&self.attitude, force);
        [up[0], up[1], up[2] - self.gravity]
    }

    /// The rest levels and shows the bias.
    pub(super) fn level(&mut self) {
        let Some((force, rate)) = self.rest.means() else {
            return;
        };
        self.gravity = norm(&force);
        if self.config.removal != Removal::StillMean {
            self.attitude = if self.bias_known {
                times(&turn(&missing_tilt(&self.arrived, &force)), &self.arrived)
            } else {
                level(force, T::zero())
            };
        }
        // A short one corrects the tilt only.
        if !self.bias_known || self.rest.seconds() >= T::from_f64(LEAST_FOR_BIAS_S) {
            self.bias = rate;
        }
    }

    /// The rest ends with the sample before: from there it is integrated.
    pub(super) fn leave(&mut self) {
        self.level();
        self.bias_known = true;
        self.rested_s = self.rest.seconds();
        self.since_s = T::zero();
        self.steps = T::zero();
        self.turned = T::zero();
        self.departed = self.attitude;
        self.strapdown.reset(self.attitude);
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
    pub(super) fn depart(&mut self, onset: usize) {
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
    pub(super) fn rely_on_first(&mut self) {
        if !self.config.zero_velocity {
            self.detector = None;
        }
    }

    /// It rests: the velocity is zero, and what was left of it comes off the way.
    pub(super) fn arrive(&mut self, now: &Kept<T>, told: bool) {
        let left = self.way.velocity();
        let half = T::from_f64(0.5) * self.since_s;
        let position = sub(&self.way.position(), &scaled(&left, half));
        self.way.reset([T::zero(); 3], position);
        self.settle(now, told);
    }

    /// The first rest, or the first after something was missing.
    pub(super) fn arrive_first(&mut self, now: &Kept<T>, told: bool) {
        let velocity = if self.place_known && !self.config.zero_velocity {
            self.config.velocity_mps
        } else {
            [T::zero(); 3]
        };
        self.way.reset(velocity, self.config.position_m);
        self.settle(now, told);
    }

    pub(super) fn settle(&mut self, now: &Kept<T>, told: bool) {
        self.phase = Phase::Resting;
        self.acceleration = [T::zero(); 3];
        self.rest = RestMean::new();
        self.arrived = self.attitude;
        match self.config.rests {
            Some((plan, _)) if !told => {
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

    /// A quiet stretch is a rest when the velocity there is as near to zero as it can
    /// be known.
    pub(super) fn may_rest(&self) -> bool {
        let Some((_, noise)) = &self.config.rests else {
            return false;
        };
        let doubt = gate::Doubt {
            since_s: self.since_s,
            step_s: self.since_s / self.steps.max(T::one()),
            rested_s: self.rested_s,
            gravity: self.gravity,
            turned: self.turned,
        };
        let limit = T::from_f64(gate::FAR) * doubt.velocity(&self.config, noise);
        self.way.velocity().iter().all(|v| v.abs() <= limit)
    }
}
