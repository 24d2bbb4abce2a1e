//! Butterworth filters as second-order sections: low- and high-pass.
//!
//! |H|² = 1/(1 + x²ⁿ), the flattest there is, with x = Ω/Ω_c (low-pass) or Ω_c/Ω
//! (high-pass) and Ω = tan(πf/f_s): the bilinear transform with the cutoff
//! prewarped, so that it lies at the cutoff exactly.
//! S. Butterworth, "On the theory of filter amplifiers", Wireless Engineer 7,
//! 1930; Oppenheim and Schafer, "Discrete-Time Signal Processing", section 7.1.
//!
//! Each section is written down from its own pair of poles; no polynomial of high
//! degree is ever formed. Sections come with the poles nearest to the unit circle
//! last. Each low- and high-pass section has gain 1 where the filter passes, which
//! keeps single precision from running out.
//!
//! Low cutoffs cost digits, about ε·(f_s/πf_c)² of the gain at zero frequency: up to
//! 1e-4 of gravity in single precision at f_c = f_s/100 and several 1e-3 at
//! f_s/1000, up to 1e-11 in double precision there. On a microcontroller without
//! double precision, thin out the samples before so low a cutoff.

use core::fmt;

use super::biquad::Biquad;
use crate::Real;

/// The highest order that is designed.
pub const MAX_ORDER: usize = 8;

/// Why there is no such filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DesignError {
    /// The order is not between 1 and [`MAX_ORDER`].
    Order,
    /// Room was made for another number of sections than [`sections_of`] the order.
    Sections,
    /// The cutoff is not between 0 and half the rate, or a number is not finite.
    Cutoff,
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order => write!(f, "the order has to be between 1 and {MAX_ORDER}"),
            Self::Sections => f.write_str("an order takes half as many sections, rounded up"),
            Self::Cutoff => f.write_str("the cutoff has to be between 0 and half the rate"),
        }
    }
}

impl core::error::Error for DesignError {}

/// How many sections a filter of this order takes.
pub const fn sections_of(order: usize) -> usize {
    order.div_ceil(2)
}

/// The frequencies that a filter passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Those below the cutoff.
    Low,
    /// Those above it.
    High,
}

/// Designs a filter of `order` 1 to 8 that passes 1/√2 (−3 dB) at `cutoff_hz` into `sections`,
/// [`sections_of`] the order; samples come at `rate_hz`.
///
/// # Errors
///
/// [`DesignError`], for an order or cutoff that cannot be had.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, settle};
/// use gravical_core::filter::butterworth::{Pass, design};
///
/// let mut filter = [Biquad::<f64>::default()];
/// design(Pass::Low, 2, 44.0, 1000.0, &mut filter)?;
/// assert!((settle(&mut filter, 9.81) - 9.81).abs() < 1e-12);
///
/// // Gravity is a constant: a high-pass takes it away.
/// let mut filter = [Biquad::<f64>::default(); 2];
/// design(Pass::High, 3, 0.5, 100.0, &mut filter)?;
/// assert!(settle(&mut filter, 9.81).abs() < 1e-9);
/// # Ok::<(), gravical_core::filter::butterworth::DesignError>(())
/// ```
pub fn design<T: Real>(
    pass: Pass,
    order: usize,
    cutoff_hz: T,
    rate_hz: T,
    sections: &mut [Biquad<T>],
) -> Result<(), DesignError> {
    if !(1..=MAX_ORDER).contains(&order) {
        return Err(DesignError::Order);
    }
    if sections.len() != sections_of(order) {
        return Err(DesignError::Sections);
    }
    let share = cutoff_hz / rate_hz;
    // The prewarped cutoff.
    let k = (T::from_f64(core::f64::consts::PI) * share).tan();
    let inside = share > T::zero() && share < T::from_f64(0.5);
    if !(inside && k > T::zero() && k.is_finite()) {
        return Err(DesignError::Cutoff);
    }
    let (one, two) = (T::one(), T::from_f64(2.0));
    // All zeros lie at z = −sign.
    let (sign, passed) = match pass {
        Pass::Low => (one, k),
        Pass::High => (-one, one),
    };
    for (i, section) in sections.iter_mut().enumerate() {
        *section = if let Some(inverse_q) = inverse_q::<T>(order, i) {
            // s²/Ω² + s/(QΩ) + 1 with s = (1 − z⁻¹)/(1 + z⁻¹).
            let norm = one / (one + k * inverse_q + k * k);
            let gain = passed * passed * norm;
            let a1 = two * (k * k - one) * norm;
            let a2 = (one - k * inverse_q + k * k) * norm;
            Biquad::new([gain, sign * two * gain, gain], [a1, a2])
        } else {
            let gain = passed / (one + k);
            let a1 = (k - one) / (k + one);
            Biquad::new([gain, sign * gain, T::zero()], [a1, T::zero()])
        };
    }
    Ok(())
}

/// 1/Q of section `i`, the least sharp first; none for the real pole of an odd
/// order, which is the first section.
fn inverse_q<T: Real>(order: usize, i: usize) -> Option<T> {
    let is_odd = order % 2 == 1;
    if is_odd && i == 0 {
        return None;
    }
    // Angles of the poles from the negative real axis: iπ/n, or (i + ½)π/n.
    let turns = if is_odd { i as f64 } else { i as f64 + 0.5 };
    let angle = core::f64::consts::PI * turns / order as f64;
    Some(T::from_f64(2.0) * T::from_f64(angle).cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn what_cannot_be_had() {
        use DesignError::*;
        let filter = |count| vec![Biquad::<f64>::default(); count];
        for (order, cutoff_hz, rate_hz, count, error) in [
            (0, 5.0, 100.0, 1, Order),
            (9, 5.0, 100.0, 5, Order),
            (3, 5.0, 100.0, 1, Sections),
            (2, 0.0, 100.0, 1, Cutoff),
            (2, -1.0, 100.0, 1, Cutoff),
            (2, 50.0, 100.0, 1, Cutoff),
            (2, f64::NAN, 100.0, 1, Cutoff),
            (2, f64::INFINITY, 100.0, 1, Cutoff),
            (2, 5.0, 0.0, 1, Cutoff),
            (2, 5.0, f64::NAN, 1, Cutoff),
        ] {
            let refused = design(Pass::Low, order, cutoff_hz, rate_hz, &mut filter(count));
            assert_eq!(refused, Err(error), "{cutoff_hz} Hz at {rate_hz} Hz");
        }
    }
}
