//! The mean of the first samples off, and the rest integrated, sample by sample.

use gravical_core::integrate::Trapezoid;
use gravical_core::matrix3::{norm, sub};

use crate::motion::anchors::{Walk, Weights};
use crate::motion::assumed::still_mean;
use crate::motion::samples::Samples;

/// Velocity and position, and what has been seen on the way.
#[derive(Debug, Clone)]
pub(super) struct Track {
    mean: [f64; 3],
    way: Trapezoid<f64>,
    /// Since the first sample, s.
    tau_s: f64,
    speed: f64,
    pub peak_mps: f64,
    pub path_m: f64,
}

impl Track {
    fn new(mean: [f64; 3], v0: [f64; 3]) -> Self {
        Track {
            mean,
            way: Trapezoid::new(v0, [0.0; 3]),
            tau_s: 0.0,
            speed: f64::NAN,
            peak_mps: 0.0,
            path_m: 0.0,
        }
    }

    /// The specific force `tau_s` after the first sample.
    #[inline]
    fn see(&mut self, tau_s: f64, force: &[f64; 3]) {
        let h = tau_s - self.tau_s;
        self.way.update(sub(force, &self.mean), h);
        self.tau_s = tau_s;
    }

    /// The same, followed by its speed.
    #[inline]
    fn see_speed(&mut self, tau_s: f64, force: &[f64; 3]) {
        let h = tau_s - self.tau_s;
        self.see(tau_s, force);
        let speed = norm(&self.way.velocity());
        if !self.speed.is_nan() {
            self.path_m += 0.5 * (self.speed + speed) * h;
        }
        self.peak_mps = self.peak_mps.max(speed);
        self.speed = speed;
    }

    pub fn velocity(&self) -> [f64; 3] {
        self.way.velocity()
    }

    /// From its start, m.
    pub fn way(&self) -> [f64; 3] {
        self.way.position()
    }

    pub fn tau_s(&self) -> f64 {
        self.tau_s
    }
}

/// What becomes of the samples.
#[derive(Debug, Clone)]
pub(super) struct Way {
    rows: usize,
    v0: [f64; 3],
    /// The first samples, calibrated and by the nominal scale.
    pub head: Samples,
    nominal: Samples,
    with_nominal: bool,
    pub calibrated: Option<Track>,
    pub uncalibrated: Option<Track>,
    pub weights: Weights,
    pub samples: usize,
    pub first_s: f64,
    pub last_s: f64,
    /// Sample before the first break and its time, s.
    pub whole: Option<(usize, f64)>,
    /// The longest gap at a break, s.
    pub longest_gap_s: f64,
}

impl Way {
    /// The mean is that over `rows` samples.
    pub fn new(rows: usize, v0: [f64; 3], with_nominal: bool) -> Self {
        Way {
            rows,
            v0,
            head: Samples::default(),
            nominal: Samples::default(),
            with_nominal,
            calibrated: None,
            uncalibrated: None,
            weights: Weights::default(),
            samples: 0,
            first_s: f64::NAN,
            last_s: f64::NAN,
            whole: None,
            longest_gap_s: f64::NEG_INFINITY,
        }
    }

    /// A sample; `parted` when it does not follow the one before.
    #[inline]
    pub fn see(&mut self, t_s: f64, force: &[f64; 3], nominal: &[f64; 3], parted: bool) {
        if parted {
            self.part(t_s);
        }
        self.weights.see(t_s);
        self.last_s = t_s;
        self.samples += 1;
        if self.samples <= self.rows {
            return self.keep(t_s, force, nominal);
        }
        if self.whole.is_some() {
            return;
        }
        let tau = t_s - self.first_s;
        if let Some(track) = &mut self.calibrated {
            track.see_speed(tau, force);
        }
        if let Some(track) = &mut self.uncalibrated {
            track.see(tau, nominal);
        }
    }

    #[cold]
    fn part(&mut self, t_s: f64) {
        self.longest_gap_s = self.longest_gap_s.max(t_s - self.last_s);
        self.weights.part();
        if self.whole.is_none() && self.samples > 0 {
            self.whole = Some((self.samples - 1, self.last_s));
        }
    }

    #[cold]
    fn keep(&mut self, t_s: f64, force: &[f64; 3], nominal: &[f64; 3]) {
        if self.samples == 1 {
            self.first_s = t_s;
        }
        add(&mut self.head, t_s, force);
        if self.with_nominal {
            add(&mut self.nominal, t_s, nominal);
        }
        if self.samples == self.rows {
            self.begin();
        }
    }

    /// The mean is known, or there are no more samples.
    pub fn begin(&mut self) {
        if self.calibrated.is_some() || self.head.is_empty() {
            return;
        }
        let until = self.whole.map_or(self.head.len(), |(last, _)| last + 1);
        let start = |samples: &Samples| {
            let (mean, _) = still_mean(samples, samples.len(), Walk::default());
            let mut track = Track::new(mean, self.v0);
            for i in 0..until.min(samples.len()) {
                track.see_speed(samples.t_s[i] - self.first_s, &samples.force_at(i));
            }
            track
        };
        self.uncalibrated = self.with_nominal.then(|| start(&self.nominal));
        self.calibrated = Some(start(&self.head));
    }
}

fn add(samples: &mut Samples, t_s: f64, force: &[f64; 3]) {
    samples.row.push(samples.t_s.len());
    samples.t_s.push(t_s);
    for (channel, value) in samples.force_mps2.iter_mut().zip(force) {
        channel.push(*value);
    }
}
