//! A Savitzky–Golay filter for readings as they come: a polynomial through the
//! last `W` of them, evaluated at the newest.
//!
//! A. Savitzky and M. J. E. Golay, "Smoothing and differentiation of data by
//! simplified least squares procedures", Analytical Chemistry 36, 1964; at the
//! newest sample: P. A. Gorry, Analytical Chemistry 62, 1990. The coefficients are
//! fixed numbers, computed once where there is room for it:
//! `gravical::denoise::causal_coefficients`.
//!
//! One-sided it does not lag behind a polynomial of its order, but it smooths far
//! less than the same window around a sample: of white noise 0.94 is left with
//! window 5 and order 2, against 0.70.

use crate::Real;

/// The longest window.
pub const MAX_WINDOW: usize = 64;

/// Weights over the last `W` samples, 1 to [`MAX_WINDOW`].
///
/// Before the first sample it counts as if that one had been there for ever.
///
/// ```
/// use gravical_core::filter::savgol::SavitzkyGolay;
///
/// // Order 1 over three samples: a line, at its newest point.
/// let mut filter = SavitzkyGolay::<f64, 3>::new(&[-1.0 / 6.0, 1.0 / 3.0, 5.0 / 6.0])
///     .expect("three weights for a window of three");
/// let out = [1.0, 2.0, 3.0].map(|x| filter.update(x));
/// assert!((out[2] - 3.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SavitzkyGolay<T, const W: usize> {
    coefficients: [T; W],
    samples: [T; W],
    /// Where the oldest sample is, and the next one goes.
    next: usize,
    started: bool,
}

impl<T: Real, const W: usize> SavitzkyGolay<T, W> {
    /// `coefficients` belong to the samples from the oldest to the newest; `None`
    /// unless there are `W` of them, 1 to [`MAX_WINDOW`], all finite.
    #[must_use]
    pub fn new(coefficients: &[T]) -> Option<Self> {
        let coefficients: [T; W] = coefficients.try_into().ok()?;
        let fits = (1..=MAX_WINDOW).contains(&W) && coefficients.iter().all(|c| c.is_finite());
        fits.then_some(Self {
            coefficients,
            samples: [T::zero(); W],
            next: 0,
            started: false,
        })
    }

    /// Forgets what was put in.
    pub fn reset(&mut self) {
        self.started = false;
    }

    /// The next sample in, the value of the polynomial there out.
    pub fn update(&mut self, input: T) -> T {
        if !self.started {
            self.samples = [input; W];
            self.started = true;
        }
        if let Some(place) = self.samples.get_mut(self.next) {
            *place = input;
        }
        self.next = if self.next + 1 < W { self.next + 1 } else { 0 };
        // From the oldest sample to the newest.
        let (newer, older) = self.samples.split_at(self.next.min(W));
        older
            .iter()
            .chain(newer)
            .zip(&self.coefficients)
            .fold(T::zero(), |sum, (x, c)| sum + *x * *c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Order 2 at the newest of five: (3, −5, −3, 9, 31)/35.
    const FIVE: [f64; 5] = [
        3.0 / 35.0,
        -5.0 / 35.0,
        -3.0 / 35.0,
        9.0 / 35.0,
        31.0 / 35.0,
    ];

    #[test]
    fn a_parabola_passes_without_lag() {
        let mut filter = SavitzkyGolay::<f64, 5>::new(&FIVE).unwrap();
        for i in 0..30 {
            let t = f64::from(i);
            let x = 2.0 - 0.3 * t + 0.05 * t * t;
            let y = filter.update(x);
            assert!(i < 4 || (y - x).abs() < 1e-13, "{i}: {y} {x}");
        }
    }

    #[test]
    fn the_first_sample_starts_it() {
        let mut filter = SavitzkyGolay::<f32, 5>::new(&FIVE.map(|c| c as f32)).unwrap();
        assert!((filter.update(9.81) - 9.81).abs() < 1e-5);
        filter.update(3.0);
        filter.reset();
        assert!((filter.update(-4.0) + 4.0).abs() < 1e-5);
    }

    #[test]
    fn weights_have_to_fit() {
        assert!(SavitzkyGolay::<f64, 4>::new(&FIVE).is_none());
        assert!(SavitzkyGolay::<f64, 0>::new(&[]).is_none());
        assert!(SavitzkyGolay::<f64, 65>::new(&[0.0; 65]).is_none());
        assert!(SavitzkyGolay::<f64, 1>::new(&[f64::NAN]).is_none());
    }
}
