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

use gravical_core::filter::biquad::{Biquad, Cascade};
use gravical_core::filter::butterworth::{DesignError, band_pass, high_pass, low_pass};

use super::spec::{Band, Passes};
use crate::numfmt::digits;
use crate::{Error, Result};

/// The filter for a sampling rate.
pub(crate) struct Butterworth {
    sections: Vec<Biquad<f64>>,
    passes: Passes,
}

/// Lowest cutoff as a share of the rate; below it too many digits are lost: the gain at zero
/// frequency is off by 1e-7 there.
const LOWEST: f64 = 1e-5;

impl Butterworth {
    /// # Errors
    ///
    /// `filter-range` (usage) for cutoffs that the rate does not allow.
    pub fn new(order: usize, band: Band, passes: Passes, rate_hz: f64) -> Result<Self> {
        let allowed = LOWEST * rate_hz..0.5 * rate_hz;
        if let Some(wrong) = band
            .edges_hz()
            .into_iter()
            .find(|f| !(*f > allowed.start && *f < allowed.end))
        {
            return Err(Error::usage(
                "filter-range",
                format!(
                    "a cutoff of {wrong} Hz is not possible at {} samples per second; {} to {} Hz is",
                    digits(rate_hz, 4),
                    digits(allowed.start, 1),
                    digits(allowed.end, 4)
                ),
            )
            .with_hint("choose another cutoff; `gravical inspect` shows the rate"));
        }
        let sections =
            design(order, designed_at(order, band, passes, rate_hz), rate_hz).map_err(|e| {
                Error::usage("filter-range", e.to_string()).with_hint(super::spec::EXAMPLES)
            })?;
        Ok(Butterworth { sections, passes })
    }

    /// The sections, ordered by the sharpness of their peak.
    pub fn sections(&self) -> &[Biquad<f64>] {
        &self.sections
    }

    /// Number of samples added at each end for two passes: three per coefficient, as in scipy.
    pub fn padding(&self) -> usize {
        let all = self.sections.len();
        let [last_b, last_a] = [
            self.sections
                .iter()
                .filter(|s| s.forward()[2] == 0.0)
                .count(),
            self.sections.iter().filter(|s| s.back()[1] == 0.0).count(),
        ];
        3 * (2 * all + 1 - last_b.min(last_a))
    }

    /// Smallest number of samples that can be filtered.
    pub fn shortest(&self) -> usize {
        match self.passes {
            Passes::Causal => 1,
            Passes::Two => self.padding() + 1,
        }
    }

    /// Filters equally spaced samples in place; shorter input is left unchanged.
    pub fn apply(&self, x: &mut [f64]) {
        if x.len() < self.shortest() {
            return;
        }
        // With a constant number of sections all of them stay in registers.
        match self.sections.len() {
            1 => self.run::<1>(x),
            2 => self.run::<2>(x),
            3 => self.run::<3>(x),
            4 => self.run::<4>(x),
            5 => self.run::<5>(x),
            6 => self.run::<6>(x),
            7 => self.run::<7>(x),
            8 => self.run::<8>(x),
            // The highest order is 8.
            _ => {}
        }
    }

    fn run<const N: usize>(&self, x: &mut [f64]) {
        let sections = <[Biquad<f64>; N]>::try_from(self.sections.as_slice());
        let (Ok(sections), Some(&first), Some(&last)) = (sections, x.first(), x.last()) else {
            return;
        };
        let mut cascade = Cascade::new(sections);
        if self.passes == Passes::Causal {
            cascade.settle(first);
            pass(cascade, x.iter_mut());
            return;
        }
        // Odd reflection about the end points: value and slope are continuous.
        let (padding, n) = (self.padding(), x.len());
        let mut before: Vec<f64> = (1..=padding).rev().map(|i| 2.0 * first - x[i]).collect();
        let mut after: Vec<f64> = (1..=padding).map(|i| 2.0 * last - x[n - 1 - i]).collect();
        cascade.settle(before.first().copied().unwrap_or(first));
        cascade = pass(cascade, before.iter_mut());
        cascade = pass(cascade, x.iter_mut());
        cascade = pass(cascade, after.iter_mut());
        cascade.settle(after.last().copied().unwrap_or(last));
        cascade = pass(cascade, after.iter_mut().rev());
        pass(cascade, x.iter_mut().rev());
    }
}

/// One pass; returns the final state. By value, so that the state stays in registers.
#[inline(always)]
fn pass<'a, const N: usize>(
    mut cascade: Cascade<f64, N>,
    x: impl Iterator<Item = &'a mut f64>,
) -> Cascade<f64, N> {
    for value in x {
        *value = cascade.update(*value);
    }
    cascade
}

/// (√2 − 1)^(1/2n): the −3 dB frequency of two passes of order n, relative to that of one.
fn two_pass_factor(order: usize, passes: Passes) -> f64 {
    match passes {
        Passes::Causal => 1.0,
        Passes::Two => (SQRT_2 - 1.0).powf(0.5 / order as f64),
    }
}

/// The band of one pass for the `band` of all passes together.
fn designed_at(order: usize, band: Band, passes: Passes, rate_hz: f64) -> Band {
    let factor = two_pass_factor(order, passes);
    if passes == Passes::Causal {
        return band;
    }
    let warp = |f: f64| (PI * f / rate_hz).tan();
    let unwarp = |omega: f64| rate_hz / PI * omega.atan();
    match band {
        Band::Low { cutoff_hz } => Band::Low {
            cutoff_hz: unwarp(warp(cutoff_hz) / factor),
        },
        Band::High { cutoff_hz } => Band::High {
            cutoff_hz: unwarp(warp(cutoff_hz) * factor),
        },
        Band::Between { low_hz, high_hz } => {
            let (low, high) = (warp(low_hz), warp(high_hz));
            let half = 0.5 * (high - low) / factor;
            // (root − half)(root + half) = Ω₁Ω₂; this form avoids cancellation.
            let upper = half + (half * half + low * high).sqrt();
            Band::Between {
                low_hz: unwarp(low * high / upper),
                high_hz: unwarp(upper),
            }
        }
    }
}

fn design(
    order: usize,
    band: Band,
    rate_hz: f64,
) -> std::result::Result<Vec<Biquad<f64>>, DesignError> {
    fn list<const N: usize>(
        designed: std::result::Result<Cascade<f64, N>, DesignError>,
    ) -> std::result::Result<Vec<Biquad<f64>>, DesignError> {
        Ok(designed?.sections().to_vec())
    }
    match band {
        Band::Low { cutoff_hz: f } => match order {
            1 | 2 => list(low_pass::<_, 1>(order, f, rate_hz)),
            3 | 4 => list(low_pass::<_, 2>(order, f, rate_hz)),
            5 | 6 => list(low_pass::<_, 3>(order, f, rate_hz)),
            _ => list(low_pass::<_, 4>(order, f, rate_hz)),
        },
        Band::High { cutoff_hz: f } => match order {
            1 | 2 => list(high_pass::<_, 1>(order, f, rate_hz)),
            3 | 4 => list(high_pass::<_, 2>(order, f, rate_hz)),
            5 | 6 => list(high_pass::<_, 3>(order, f, rate_hz)),
            _ => list(high_pass::<_, 4>(order, f, rate_hz)),
        },
        Band::Between {
            low_hz: a,
            high_hz: b,
        } => match order {
            1 => list(band_pass::<_, 1>(order, a, b, rate_hz)),
            2 => list(band_pass::<_, 2>(order, a, b, rate_hz)),
            3 => list(band_pass::<_, 3>(order, a, b, rate_hz)),
            4 => list(band_pass::<_, 4>(order, a, b, rate_hz)),
            5 => list(band_pass::<_, 5>(order, a, b, rate_hz)),
            6 => list(band_pass::<_, 6>(order, a, b, rate_hz)),
            7 => list(band_pass::<_, 7>(order, a, b, rate_hz)),
            _ => list(band_pass::<_, 8>(order, a, b, rate_hz)),
        },
    }
}
