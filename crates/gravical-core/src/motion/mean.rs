//! Mean over a rest, of a long one over its end: biases drift.

use crate::Real;

/// Half of what counts of a long rest, s: between one and two of these do.
const HALF_S: f64 = 5.0;

/// Sums over a rest as it goes on, less its first sample: gravity would cost `f32`
/// its digits.
#[derive(Debug, Clone, Copy)]
pub(super) struct RestMean<T> {
    origin: [T; 6],
    parts: [Part<T>; 2],
}

#[derive(Debug, Clone, Copy)]
struct Part<T> {
    sum: [T; 6],
    count: T,
    seconds: T,
}

impl<T: Real> Part<T> {
    fn none() -> Self {
        Part {
            sum: [T::zero(); 6],
            count: T::zero(),
            seconds: T::zero(),
        }
    }
}

impl<T: Real> RestMean<T> {
    pub fn new() -> Self {
        RestMean {
            origin: [T::zero(); 6],
            parts: [Part::none(); 2],
        }
    }

    pub fn add(&mut self, force: &[T; 3], rate: &[T; 3], h_s: T) {
        if self.parts[1].seconds >= T::from_f64(HALF_S) {
            self.parts = [self.parts[1], Part::none()];
        }
        let value = six(force, rate);
        if self.parts.iter().all(|p| p.count == T::zero()) {
            self.origin = value;
        }
        self.change(&value, T::one(), h_s);
    }

    /// Takes a sample back that turned out not to be at rest.
    pub fn take_back(&mut self, force: &[T; 3], rate: &[T; 3], h_s: T) {
        self.change(&six(force, rate), -T::one(), -h_s);
    }

    fn change(&mut self, value: &[T; 6], by: T, h_s: T) {
        let part = &mut self.parts[1];
        for c in 0..6 {
            part.sum[c] = part.sum[c] + by * (value[c] - self.origin[c]);
        }
        part.count = part.count + by;
        part.seconds = part.seconds + h_s;
    }

    /// How long the rest was, as far as it counts, s.
    pub fn seconds(&self) -> T {
        self.parts[0].seconds + self.parts[1].seconds
    }

    /// Mean specific force and angular rate; none without a sample.
    pub fn means(&self) -> Option<([T; 3], [T; 3])> {
        let [a, b] = &self.parts;
        let count = a.count + b.count;
        if count <= T::zero() {
            return None;
        }
        let mean = |c: usize| self.origin[c] + (a.sum[c] + b.sum[c]) / count;
        Some(([mean(0), mean(1), mean(2)], [mean(3), mean(4), mean(5)]))
    }
}

fn six<T: Real>(force: &[T; 3], rate: &[T; 3]) -> [T; 6] {
    [force[0], force[1], force[2], rate[0], rate[1], rate[2]]
}
