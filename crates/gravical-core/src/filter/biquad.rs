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
/// stays in the state: [`reset`](Self::reset) or [`settle`](Self::settle) after one.
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

impl<T: Real> Biquad<T> {
    /// A section with the coefficients b₀, b₁, b₂ and a₁, a₂ (a₀ is 1), at rest.
    #[must_use]
    pub fn new(forward: [T; 3], back: [T; 2]) -> Self {
        Self {
            forward,
            back,
            state: [T::zero(); 2],
        }
    }

    /// b₀, b₁, b₂.
    #[must_use]
    pub fn forward(&self) -> [T; 3] {
        self.forward
    }

    /// a₁, a₂.
    #[must_use]
    pub fn back(&self) -> [T; 2] {
        self.back
    }

    /// What a constant is multiplied by once it has lasted, Σb/(1 + Σa); infinite
    /// or NaN for a section that sums up what it is given (a pole at z = 1).
    #[must_use]
    pub fn steady_gain(&self) -> T {
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

    /// As if nothing had ever been put in.
    pub fn reset(&mut self) {
        self.state = [T::zero(); 2];
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

/// `N` sections, each fed by the one before.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, Cascade};
///
/// let half = Biquad::new([0.5, 0.0, 0.0], [0.0, 0.0]);
/// let mut quarter = Cascade::new([half; 2]);
/// assert_eq!(quarter.update(8.0), 2.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade<T, const N: usize> {
    sections: [Biquad<T>; N],
}

impl<T: Real, const N: usize> Cascade<T, N> {
    /// These sections in this order.
    #[must_use]
    pub fn new(sections: [Biquad<T>; N]) -> Self {
        Self { sections }
    }

    /// The sections.
    #[must_use]
    pub fn sections(&self) -> &[Biquad<T>; N] {
        &self.sections
    }

    /// The next sample in, the next one out.
    #[inline]
    pub fn update(&mut self, input: T) -> T {
        let mut value = input;
        for section in &mut self.sections {
            value = section.update(value);
        }
        value
    }

    /// As if nothing had ever been put in.
    pub fn reset(&mut self) {
        self.sections.iter_mut().for_each(Biquad::reset);
    }

    /// As if `input` had been put in for ever; gives what then comes out. Call it
    /// with the first reading: from rest, a low-pass would climb from zero to
    /// gravity first.
    pub fn settle(&mut self, input: T) -> T {
        let mut value = input;
        for section in &mut self.sections {
            value = section.settle(value);
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resonant() -> Biquad<f64> {
        Biquad::new([0.2, 0.3, 0.1], [-1.2, 0.52])
    }

    #[test]
    fn the_difference_equation_is_met() {
        let input = [1.0, -2.0, 0.5, 4.0, 0.0, 0.0, 1.0];
        let mut section = resonant();
        let out = input.map(|x| section.update(x));
        let at =
            |list: &[f64; 7], i: usize, back: usize| i.checked_sub(back).map_or(0.0, |k| list[k]);
        for i in 0..input.len() {
            let want = 0.2 * input[i]
                + 0.3 * at(&input, i, 1)
                + 0.1 * at(&input, i, 2)
                + 1.2 * at(&out, i, 1)
                - 0.52 * at(&out, i, 2);
            assert!((out[i] - want).abs() < 1e-15, "{i}");
        }
    }

    #[test]
    fn settled_is_where_a_constant_leads() {
        let mut settled = Cascade::new([resonant(), resonant()]);
        let out = settled.settle(3.0);
        let mut driven = Cascade::new([resonant(), resonant()]);
        let mut last = 0.0;
        for _ in 0..400 {
            last = driven.update(3.0);
        }
        assert!((out - last).abs() < 1e-13);
        assert!((settled.update(3.0) - driven.update(3.0)).abs() < 1e-13);
        assert!((settled.update(7.0) - driven.update(7.0)).abs() < 1e-13);
        settled.reset();
        assert_eq!(settled.update(0.0), 0.0);
    }
}
