//! Second-order sections in direct form II transposed, alone and in a row.
//!
//! y = b₀x + s₁, s₁ ← b₁x − a₁y + s₂, s₂ ← b₂x − a₂y: the form that rounds least
//! of the four (Oppenheim and Schafer, "Discrete-Time Signal Processing", 6.3 and
//! 6.9), and the one of scipy's `sosfilt`. High orders as one polynomial lose all
//! digits at low cutoffs; sections keep them.

use crate::Real;

/// A second-order section, and where it stands.
///
/// H(z) = (b₀ + b₁z⁻¹ + b₂z⁻²)/(1 + a₁z⁻¹ + a₂z⁻²). A sample that is not finite
/// stays in the state: [`settle`](Self::settle) after one.
///
/// ```
/// use gravical_core::filter::biquad::Biquad;
///
/// // The mean of two neighbours.
/// let mut section = Biquad::new([0.5, 0.5, 0.0], [0.0, 0.0]);
/// assert_eq!([section.update(2.0), section.update(4.0)], [1.0, 3.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biquad<T> {
    forward: [T; 3],
    back: [T; 2],
    state: [T; 2],
}

impl<T: Real> Default for Biquad<T> {
    /// A section that gives zero.
    fn default() -> Self {
        Self::new([T::zero(); 3], [T::zero(); 2])
    }
}

impl<T: Real> Biquad<T> {
    /// A section with the coefficients b₀, b₁, b₂ and a₁, a₂ (a₀ is 1), at rest.
    pub fn new(forward: [T; 3], back: [T; 2]) -> Self {
        Self {
            forward,
            back,
            state: [T::zero(); 2],
        }
    }

    /// What a constant is multiplied by once it has lasted, Σb/(1 + Σa); infinite
    /// or NaN for a section that sums up what it is given (a pole at z = 1).
    fn steady_gain(&self) -> T {
        let [b0, b1, b2] = self.forward;
        let [a1, a2] = self.back;
        (b0 + b1 + b2) / (T::one() + a1 + a2)
    }

    /// The next sample in, the next one out.
    #[inline]
    pub fn update(&mut self, input: T) -> T {
        let [b0, b1, b2] = self.forward;
        let [a1, a2] = self.back;
        let output = b0 * input + self.state[0];
        self.state = [
            b1 * input - a1 * output + self.state[1],
            b2 * input - a2 * output,
        ];
        output
    }

    /// As if `input` had been put in for ever; gives what then comes out.
    ///
    /// The state that a constant leaves behind: s₁ = (G − b₀)x and
    /// s₂ = (b₂ − a₂G)x with the steady gain G.
    pub fn settle(&mut self, input: T) -> T {
        let gain = self.steady_gain();
        self.state = [
            (gain - self.forward[0]) * input,
            (self.forward[2] - self.back[1] * gain) * input,
        ];
        gain * input
    }
}

/// The next sample in, the next one out, through sections of which each is fed by the one before.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, update};
///
/// let mut halves = [Biquad::new([0.5, 0.0, 0.0], [0.0, 0.0]); 2];
/// assert_eq!(update(&mut halves, 8.0), 2.0);
/// ```
#[inline]
pub fn update<T: Real>(sections: &mut [Biquad<T>], input: T) -> T {
    sections
        .iter_mut()
        .fold(input, |value, section| section.update(value))
}

/// As if `input` had been put in for ever; gives what then comes out. Call it with the first
/// reading: from rest, a low-pass would climb from zero to gravity first.
pub fn settle<T: Real>(sections: &mut [Biquad<T>], input: T) -> T {
    sections
        .iter_mut()
        .fold(input, |value, section| section.settle(value))
}
