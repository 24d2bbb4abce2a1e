//! Butterworth filters as second-order sections: low-, high- and band-pass.
//!
//! |H|² = 1/(1 + x²ⁿ), the flattest there is, with x = Ω/Ω_c (low-pass), Ω_c/Ω
//! (high-pass) or (Ω² − Ω₀²)/(ΩB) (band-pass) and Ω = tan(πf/f_s): the bilinear
//! transform with the cutoff prewarped, so that it lies at the cutoff exactly.
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
    Order {
        /// What was asked for.
        order: usize,
    },
    /// The order needs another number of sections than was made room for.
    Sections {
        /// ⌈order/2⌉; for a band-pass the order.
        needed: usize,
    },
    /// A cutoff is not between 0 and half the rate, the two of a band-pass do not
    /// rise, or a number is not finite.
    Cutoff,
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order { order } => {
                write!(
                    f,
                    "the order has to be between 1 and {MAX_ORDER}, not {order}"
                )
            }
            Self::Sections { needed } => write!(f, "this order takes {needed} sections"),
            Self::Cutoff => write!(
                f,
                "cutoffs have to rise and lie between 0 and half the rate"
            ),
        }
    }
}

impl core::error::Error for DesignError {}

/// How many sections a low- or high-pass of this order takes; a band-pass takes
/// as many as its order.
#[must_use]
pub const fn sections_of(order: usize) -> usize {
    order.div_ceil(2)
}

/// Designs a low-pass of `order` 1 to 8 that passes 1/√2 (−3 dB) at `cutoff_hz` into `sections`,
/// [`sections_of`] the order; samples come at `rate_hz`.
///
/// # Errors
///
/// [`DesignError`], for an order or cutoff that cannot be had.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, settle};
/// use gravical_core::filter::butterworth::low_pass;
///
/// let mut filter = [Biquad::<f64>::default()];
/// low_pass(2, 44.0, 1000.0, &mut filter)?;
/// assert!((settle(&mut filter, 9.81) - 9.81).abs() < 1e-12);
/// # Ok::<(), gravical_core::filter::butterworth::DesignError>(())
/// ```
pub fn low_pass<T: Real>(
    order: usize,
    cutoff_hz: T,
    rate_hz: T,
    sections: &mut [Biquad<T>],
) -> Result<(), DesignError> {
    check(order, sections_of(order), sections)?;
    let k = prewarped(cutoff_hz, rate_hz)?;
    one_edge(order, k, T::one(), k, sections);
    Ok(())
}

/// Designs a high-pass, as [`low_pass`] does a low-pass.
///
/// # Errors
///
/// [`DesignError`], for an order or cutoff that cannot be had.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, settle};
/// use gravical_core::filter::butterworth::high_pass;
///
/// // Gravity is a constant: it is taken away.
/// let mut filter = [Biquad::<f64>::default(); 2];
/// high_pass(3, 0.5, 100.0, &mut filter)?;
/// assert!(settle(&mut filter, 9.81).abs() < 1e-9);
/// # Ok::<(), gravical_core::filter::butterworth::DesignError>(())
/// ```
pub fn high_pass<T: Real>(
    order: usize,
    cutoff_hz: T,
    rate_hz: T,
    sections: &mut [Biquad<T>],
) -> Result<(), DesignError> {
    check(order, sections_of(order), sections)?;
    let k = prewarped(cutoff_hz, rate_hz)?;
    one_edge(order, k, -T::one(), T::one(), sections);
    Ok(())
}

/// Sections with all zeros at z = −`sign`; `passed`: the prewarped cutoff `k` for a low-pass, 1 for a
/// high-pass.
fn one_edge<T: Real>(order: usize, k: T, sign: T, passed: T, sections: &mut [Biquad<T>]) {
    let two = T::from_f64(2.0);
    for (i, section) in sections.iter_mut().enumerate() {
        *section = if let Some(inverse_q) = inverse_q::<T>(order, i) {
            // s²/Ω² + s/(QΩ) + 1 with s = (1 − z⁻¹)/(1 + z⁻¹).
            let norm = T::one() / (T::one() + k * inverse_q + k * k);
            let gain = passed * passed * norm;
            Biquad::new([gain, sign * two * gain, gain], back(k, inverse_q, norm))
        } else {
            let gain = passed / (T::one() + k);
            Biquad::new([gain, sign * gain, T::zero()], [real_pole(k), T::zero()])
        };
    }
}

/// Designs a band-pass of `order` 1 to 8 that passes 1/√2 (−3 dB) at `low_hz` and at `high_hz` into
/// `sections`, as many as the order: a band-pass has that many pairs of poles.
///
/// # Errors
///
/// [`DesignError`], for an order or edges that cannot be had.
///
/// ```
/// use gravical_core::filter::biquad::{Biquad, settle};
/// use gravical_core::filter::butterworth::band_pass;
///
/// let mut filter = [Biquad::<f64>::default(); 2];
/// band_pass(2, 5.0, 20.0, 100.0, &mut filter)?;
/// assert!(settle(&mut filter, 9.81).abs() < 1e-12);
/// # Ok::<(), gravical_core::filter::butterworth::DesignError>(())
/// ```
pub fn band_pass<T: Real>(
    order: usize,
    low_hz: T,
    high_hz: T,
    rate_hz: T,
    sections: &mut [Biquad<T>],
) -> Result<(), DesignError> {
    check(order, order, sections)?;
    let low = prewarped(low_hz, rate_hz)?;
    let high = prewarped(high_hz, rate_hz)?;
    // Also false where rounding makes the two one.
    if !(low_hz < high_hz && low < high) {
        return Err(DesignError::Cutoff);
    }
    let (centre_squared, width) = (low * high, high - low);
    let two = T::from_f64(2.0);
    for (i, section) in sections.iter_mut().enumerate() {
        // A pair of poles of the low-pass gives two pairs, the real one gives one;
        // a pair s² + αs + β of the band-pass.
        let (alpha, beta) = match inverse_q::<T>(order, order.div_ceil(2) - 1 - i / 2) {
            Some(inverse_q) => band_pair(inverse_q, centre_squared, width, i % 2 == 0),
            None => (width, centre_squared),
        };
        let norm = T::one() / (T::one() + alpha + beta);
        let gain = width * norm;
        *section = Biquad::new(
            [gain, T::zero(), -gain],
            [
                two * (beta - T::one()) * norm,
                (T::one() - alpha + beta) * norm,
            ],
        );
    }
    // a₂ of a pair is the square of its radius.
    sections.sort_unstable_by(|a, b| {
        let radius = |s: &Biquad<T>| s.back()[1];
        radius(a)
            .partial_cmp(&radius(b))
            .unwrap_or(core::cmp::Ordering::Equal)
    });
    Ok(())
}

fn check<T>(order: usize, needed: usize, sections: &[Biquad<T>]) -> Result<(), DesignError> {
    if !(1..=MAX_ORDER).contains(&order) {
        return Err(DesignError::Order { order });
    }
    if needed != sections.len() {
        return Err(DesignError::Sections { needed });
    }
    Ok(())
}

/// tan(πf/f_s).
fn prewarped<T: Real>(frequency_hz: T, rate_hz: T) -> Result<T, DesignError> {
    let share = frequency_hz / rate_hz;
    let omega = (T::from_f64(core::f64::consts::PI) * share).tan();
    let inside = share > T::zero() && share < T::from_f64(0.5);
    if inside && omega > T::zero() && omega.is_finite() {
        Ok(omega)
    } else {
        Err(DesignError::Cutoff)
    }
}

/// 1/Q of section `i`, the least sharp first; none for the real pole of an odd
/// order, which is the first section.
fn inverse_q<T: Real>(order: usize, i: usize) -> Option<T> {
    let odd = order % 2;
    let pair = (i + 1).checked_sub(odd)?;
    if odd == 1 && pair == 0 {
        return None;
    }
    // Angles of the poles from the negative real axis: kπ/n, or (k + ½)π/n.
    let turns = if odd == 1 {
        pair as f64
    } else {
        i as f64 + 0.5
    };
    let angle = core::f64::consts::PI * turns / order as f64;
    Some(T::from_f64(2.0) * T::from_f64(angle).cos())
}

/// a₁ and a₂ of a pair of poles at Q and the prewarped cutoff `k`.
fn back<T: Real>(k: T, inverse_q: T, norm: T) -> [T; 2] {
    [
        T::from_f64(2.0) * (k * k - T::one()) * norm,
        (T::one() - k * inverse_q + k * k) * norm,
    ]
}

/// a₁ of the real pole.
fn real_pole<T: Real>(k: T) -> T {
    (k - T::one()) / (k + T::one())
}

/// One of the two pairs s² + αs + β that the pair p, p* of the low-pass becomes:
/// the roots of s² − pBs + Ω₀² and their conjugates. The larger root comes from the
/// formula without cancellation, the other one from the product of the two.
fn band_pair<T: Real>(inverse_q: T, centre_squared: T, width: T, larger: bool) -> (T, T) {
    let half = T::from_f64(0.5);
    // p = −cos θ + i sin θ, times B/2.
    let cos = half * inverse_q;
    let sin = (T::one() - cos * cos).max(T::zero()).sqrt();
    let (re, im) = (-half * width * cos, half * width * sin);
    // √((pB/2)² − Ω₀²), the branch that points as p does.
    let (u, v) = (
        re * re - im * im - centre_squared,
        T::from_f64(2.0) * re * im,
    );
    let r = u.hypot(v);
    // u ± r without cancellation: (r + u)(r − u) = v².
    let (root_re, root_im) = if u >= T::zero() {
        let a = (half * (r + u)).sqrt();
        (
            a,
            if a > T::zero() {
                half * v / a
            } else {
                T::zero()
            },
        )
    } else {
        let b = (half * (r - u)).sqrt();
        (half * v / b, b)
    };
    let same = re * root_re + im * root_im >= T::zero();
    let sign = if same { T::one() } else { -T::one() };
    let (s_re, s_im) = (re + sign * root_re, im + sign * root_im);
    let squared = s_re * s_re + s_im * s_im;
    if larger {
        (-T::from_f64(2.0) * s_re, squared)
    } else {
        // Ω₀²/s.
        (
            -T::from_f64(2.0) * s_re * centre_squared / squared,
            centre_squared * centre_squared / squared,
        )
    }
}

#[cfg(test)]
mod tests;
