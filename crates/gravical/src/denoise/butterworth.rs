//! Butterworth filters: in one pass, or forwards and backwards without delay.
//!
//! Two passes square the response, so the filter is designed for another cutoff, at which |H|⁴ =
//! 1/2: x²ⁿ = √2 − 1. With Ω = tan(πf/f_s) a low-pass is designed for Ω_c/(√2 − 1)^(1/2n), a
//! high-pass for Ω_c·(√2 − 1)^(1/2n), a band-pass with its width Ω₂ − Ω₁ divided by that and its
//! middle √(Ω₁Ω₂) unchanged.
//!
//! The ends are treated as in scipy's `sosfiltfilt`: three samples per coefficient are added at
//! each end by odd reflection about the end point, and each pass starts in the steady state of
//! its first sample (the method of F. Gustafsson, IEEE Transactions on Signal Processing 44,
//! 1996, is better but needs a fit).

use std::f64::consts::{PI, SQRT_2};

use gravical_core::filter::biquad::Biquad;
use gravical_core::filter::butterworth::{band_pass, high_pass, low_pass, sections_of};

use super::spec::{Band, EXAMPLES, Passes};
use crate::numfmt::digits;
use crate::{Error, Result};

/// Least distance of the cutoffs from 0, from half the rate and from each other, as a share of the rate; below it
/// too many digits are lost: the gain at zero frequency is off by 1e-7 there.
const MIN_SHARE: f64 = 1e-5;

/// The filter for a sampling rate.
pub(super) struct Butterworth {
    sections: Vec<Biquad<f64>>,
    passes: Passes,
}

impl Butterworth {
    /// # Errors
    ///
    /// `filter-range` (usage) for cutoffs that the rate does not allow.
    pub fn new(order: usize, band: Band, passes: Passes, rate_hz: f64) -> Result<Self> {
        let mut ends = vec![0.0];
        ends.extend(band.edges_hz());
        ends.push(0.5 * rate_hz);
        let least_hz = MIN_SHARE * rate_hz;
        if !ends.is_sorted_by(|a, b| b - a > least_hz) {
            let what = format!(
                "cutoffs have to be between 0 and {} Hz, half the rate, in ascending order, and {} Hz from these and from each other",
                digits(0.5 * rate_hz, 4),
                digits(least_hz, 1)
            );
            return Err(Error::usage("filter-range", what)
                .with_hint("choose another cutoff; `gravical inspect` shows the rate"));
        }
        let (low_hz, high_hz) = designed_at(order, band, passes, rate_hz);
        let is_band = low_hz.is_some() && high_hz.is_some();
        let count = if is_band { order } else { sections_of(order) };
        let mut sections = vec![Biquad::default(); count];
        let designed = match (low_hz, high_hz) {
            (Some(low), Some(high)) => band_pass(order, low, high, rate_hz, &mut sections),
            (Some(cutoff), None) => high_pass(order, cutoff, rate_hz, &mut sections),
            (None, cutoff) => {
                let cutoff = cutoff.unwrap_or(f64::NAN);
                low_pass(order, cutoff, rate_hz, &mut sections)
            }
        };
        designed.map_err(|e| Error::usage("filter-range", e.to_string()).with_hint(EXAMPLES))?;
        Ok(Butterworth { sections, passes })
    }

    /// Samples added at each end: for two passes three per coefficient, as in scipy.
    fn padding(&self) -> usize {
        let first_order = |s: &&Biquad<f64>| s.forward()[2] == 0.0 && s.back()[1] == 0.0;
        match self.passes {
            Passes::Causal => 0,
            Passes::Two => {
                3 * (2 * self.sections.len() + 1 - self.sections.iter().filter(first_order).count())
            }
        }
    }

    /// Smallest number of samples that can be filtered.
    pub fn shortest(&self) -> usize {
        self.padding() + 1
    }

    /// Samples after which the response to an impulse has decayed to e⁻²⁵.
    pub fn memory(&self) -> usize {
        let radius = |s: &Biquad<f64>| {
            let [a1, a2] = s.back();
            let discriminant = 0.25 * a1 * a1 - a2;
            if discriminant > 0.0 {
                0.5 * a1.abs() + discriminant.sqrt()
            } else {
                a2.sqrt()
            }
        };
        let slowest = self.sections.iter().map(radius).fold(0.0, f64::max);
        (-25.0 / slowest.ln()).ceil() as usize + self.shortest()
    }

    /// Filters equally spaced samples, [`shortest`](Self::shortest) or more.
    pub fn filter(&self, x: &[f64]) -> Vec<f64> {
        // Odd reflection about the end points: value and slope are continuous.
        let (n, padding) = (x.len(), self.padding());
        let before = (1..=padding).rev().map(|i| 2.0 * x[0] - x[i]);
        let after = (1..=padding).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]);
        let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        self.pass(&mut y);
        if self.passes == Passes::Two {
            y.reverse();
            self.pass(&mut y);
            y.reverse();
        }
        y[padding..padding + n].to_vec()
    }

    /// One pass from the steady state of the first sample. One section after the other: its state
    /// stays in registers, and the numbers are those of the sections run together.
    fn pass(&self, y: &mut [f64]) {
        let mut steady = y[0];
        for section in &self.sections {
            let mut section = *section;
            steady = section.settle(steady);
            y.iter_mut().for_each(|v| *v = section.update(*v));
        }
    }
}

/// The cutoffs of one pass for the `band` of all passes together.
fn designed_at(
    order: usize,
    band: Band,
    passes: Passes,
    rate_hz: f64,
) -> (Option<f64>, Option<f64>) {
    if passes == Passes::Causal {
        return (band.low_hz, band.high_hz);
    }
    // The −3 dB frequency of two passes relative to that of one.
    let factor = (SQRT_2 - 1.0).powf(0.5 / order as f64);
    let warp = |f: f64| (PI * f / rate_hz).tan();
    let unwarp = |omega: f64| rate_hz / PI * omega.atan();
    let (low, high) = match (band.low_hz.map(warp), band.high_hz.map(warp)) {
        (Some(low), Some(high)) => {
            let half = 0.5 * (high - low) / factor;
            // (root − half)(root + half) = Ω₁Ω₂; this form avoids cancellation.
            let upper = half + (half * half + low * high).sqrt();
            (Some(low * high / upper), Some(upper))
        }
        (low, high) => (
            low.map(|omega| omega * factor),
            high.map(|omega| omega / factor),
        ),
    };
    (low.map(unwarp), high.map(unwarp))
}
