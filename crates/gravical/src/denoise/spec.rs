//! Specification of a filter.

use gravical_core::filter::butterworth::MAX_ORDER;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// The longest window, samples.
pub const MAX_WINDOW: usize = 10_001;
/// The highest order of a polynomial, tested to 1e-12.
pub const MAX_POLYNOMIAL: usize = 12;

/// Hint of every syntax error.
pub(super) const EXAMPLES: &str = "savgol:5,2 (window, order), savgol:11,3,1 (derivative), butter:4,5Hz (low-pass), butter:4,5-20Hz (band), highpass:4,0.5Hz, butter1: and highpass1: (causal), hampel:7,3 (window, sigmas), mean:5";

/// Specification of a filter; [`Filter::design`](super::Filter::design) designs it for a sampling
/// rate.
///
/// ```
/// use gravical::denoise::FilterSpec;
///
/// let spec: FilterSpec = "butter:4,5Hz".parse()?;
/// assert_eq!(spec.to_string(), "butter:4,5Hz");
/// assert!("butter:4".parse::<FilterSpec>().is_err());
/// # Ok::<(), gravical::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilterSpec {
    /// `savgol:WINDOW,ORDER[,DERIVATIVE]`: a polynomial fitted to the samples around each one;
    /// `mean:WINDOW`, the moving average, is the one of order 0.
    SavitzkyGolay {
        /// Samples, odd, 1 to 10,001.
        window: usize,
        /// Degree of the polynomial, 0 to 12 and below the window.
        order: usize,
        /// Order of the derivative with respect to time, at most the order; 0 smooths.
        derivative: usize,
    },
    /// `butter:ORDER,CUTOFFHz`, `butter:ORDER,LOW-HIGHHz`, `highpass:ORDER,CUTOFFHz`,
    /// and `butter1:`, `highpass1:`.
    Butterworth {
        /// 1 to 8.
        order: usize,
        /// The band that passes.
        band: Band,
        /// One pass or two.
        passes: Passes,
    },
    /// `hampel:WINDOW,SIGMAS`: a value too far from the median of its neighbours is replaced by
    /// that median.
    Hampel {
        /// Samples, odd, 3 to 10,001.
        window: usize,
        /// Largest accepted deviation in robust standard deviations, 0 to 1e6; 0 gives a running
        /// median.
        sigmas: f64,
    },
}

/// Band of a Butterworth filter, Hz. The gain of the whole filter is −3 dB at these frequencies,
/// for one pass and for two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Band {
    /// All frequencies below.
    Low {
        /// Above 0, below half the rate.
        cutoff_hz: f64,
    },
    /// All frequencies above.
    High {
        /// Above 0, below half the rate.
        cutoff_hz: f64,
    },
    /// All frequencies between.
    Between {
        /// Above 0.
        low_hz: f64,
        /// Above `low_hz`, below half the rate.
        high_hz: f64,
    },
}

/// Number of passes over the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Passes {
    /// Forwards only, as on a microcontroller: the output is delayed.
    Causal,
    /// Forwards and backwards: no delay.
    Two,
}

impl FilterSpec {
    /// Checks the ranges that do not depend on the rate.
    ///
    /// # Errors
    ///
    /// `filter-range` (usage), with the range.
    pub fn validate(&self) -> Result<()> {
        let wrong = |what: String| {
            Err(Error::usage("filter-range", format!("{self}: {what}")).with_hint(EXAMPLES))
        };
        let window_of = match *self {
            FilterSpec::SavitzkyGolay { window, .. } | FilterSpec::Hampel { window, .. } => {
                Some(window)
            }
            FilterSpec::Butterworth { .. } => None,
        };
        if let Some(window) = window_of
            && !(1..=MAX_WINDOW).contains(&window)
        {
            return wrong(format!("the window has to be 1 to {MAX_WINDOW} samples"));
        }
        if window_of.is_some_and(|window| window % 2 == 0) {
            return wrong("the window has to be odd: an even one has no middle".to_owned());
        }
        match *self {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => {
                if order >= window || order > MAX_POLYNOMIAL {
                    return wrong(format!(
                        "the order has to be below the window and at most {MAX_POLYNOMIAL}"
                    ));
                }
                if derivative > order {
                    return wrong(format!(
                        "a polynomial of order {order} has no derivative {derivative}"
                    ));
                }
            }
            FilterSpec::Hampel { window, sigmas } => {
                if window < 3 {
                    return wrong("the window has to be at least 3".to_owned());
                }
                if !(0.0..=1e6).contains(&sigmas) {
                    return wrong("sigmas have to be between 0 and 1e6".to_owned());
                }
            }
            FilterSpec::Butterworth { order, band, .. } => {
                if !(1..=MAX_ORDER).contains(&order) {
                    return wrong(format!("the order has to be 1 to {MAX_ORDER}"));
                }
                let rising = match band {
                    Band::Low { cutoff_hz } | Band::High { cutoff_hz } => cutoff_hz > 0.0,
                    Band::Between { low_hz, high_hz } => low_hz > 0.0 && high_hz > low_hz,
                };
                let finite = band.edges_hz().iter().all(|f| f.is_finite());
                if !(rising && finite) {
                    return wrong(
                        "cutoffs have to be above 0 Hz and in ascending order".to_owned(),
                    );
                }
            }
        }
        Ok(())
    }

    /// True if a constant is unchanged.
    #[must_use]
    pub fn keeps_constants(&self) -> bool {
        match self {
            FilterSpec::SavitzkyGolay { derivative, .. } => *derivative == 0,
            FilterSpec::Butterworth { band, .. } => matches!(band, Band::Low { .. }),
            FilterSpec::Hampel { .. } => true,
        }
    }

    /// Order of the derivative with respect to time.
    #[must_use]
    pub fn derivative(&self) -> usize {
        match self {
            FilterSpec::SavitzkyGolay { derivative, .. } => *derivative,
            _ => 0,
        }
    }

    /// True if the filter needs a sampling rate.
    #[must_use]
    pub fn needs_rate(&self) -> bool {
        matches!(self, FilterSpec::Butterworth { .. }) || self.derivative() > 0
    }
}

impl Band {
    /// The cutoffs.
    #[must_use]
    pub fn edges_hz(&self) -> Vec<f64> {
        match *self {
            Band::Low { cutoff_hz } | Band::High { cutoff_hz } => vec![cutoff_hz],
            Band::Between { low_hz, high_hz } => vec![low_hz, high_hz],
        }
    }
}
