//! Which filter, as a value.

use gravical_core::filter::butterworth::MAX_ORDER;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// The longest window, samples.
pub const MAX_WINDOW: usize = 10_001;
/// The highest order of a polynomial: what is tested to 1e-12.
pub const MAX_POLYNOMIAL: usize = 12;

/// What the hint of every syntax error says.
pub(super) const EXAMPLES: &str = "savgol:5,2 (window, order), savgol:11,3,1 (derivative), butter:4,5Hz (low-pass), butter:4,5-20Hz (band), highpass:4,0.5Hz, butter1: and highpass1: (causal), hampel:7,3 (window, sigmas), mean:5";

/// A filter as it is asked for; [`Filter::design`](super::Filter::design) makes it
/// ready for a sampling rate.
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
    /// `savgol:WINDOW,ORDER[,DERIVATIVE]`: a polynomial fitted to the samples
    /// around each one.
    SavitzkyGolay {
        /// Samples, 1 to [`MAX_WINDOW`]. An even window gives values that belong
        /// half a step later.
        window: usize,
        /// Degree of the polynomial, 0 to [`MAX_POLYNOMIAL`] and below the window.
        order: usize,
        /// Which derivative with respect to time, at most the order; 0 smooths.
        derivative: usize,
    },
    /// `butter:ORDER,CUTOFFHz`, `butter:ORDER,LOW-HIGHHz`, `highpass:ORDER,CUTOFFHz`,
    /// and `butter1:`, `highpass1:`.
    Butterworth {
        /// 1 to 8.
        order: usize,
        /// What passes.
        band: Band,
        /// Once, or there and back.
        passes: Passes,
    },
    /// `hampel:WINDOW,SIGMAS`: what is too far from the median of its neighbours is
    /// replaced by it.
    Hampel {
        /// Samples, odd, 3 to [`MAX_WINDOW`].
        window: usize,
        /// How far is too far, robust standard deviations, 0 to 1e6; 0 makes it a
        /// running median.
        sigmas: f64,
    },
    /// `mean:WINDOW`: the moving average.
    Mean {
        /// Samples, odd, 1 to [`MAX_WINDOW`].
        window: usize,
    },
}

/// What passes a Butterworth filter, Hz. All of it together is down by 3 dB there,
/// whether in one pass or in two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Band {
    /// All below.
    Low {
        /// Above 0, below half the rate.
        cutoff_hz: f64,
    },
    /// All above.
    High {
        /// Above 0, below half the rate.
        cutoff_hz: f64,
    },
    /// All between.
    Between {
        /// Above 0.
        low_hz: f64,
        /// Above `low_hz`, below half the rate.
        high_hz: f64,
    },
}

/// How often a filter goes over the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Passes {
    /// Forwards only, as on a microcontroller: it delays.
    Causal,
    /// Forwards and backwards: no delay.
    Two,
}

impl FilterSpec {
    /// Checks ranges that hold at any rate.
    ///
    /// # Errors
    ///
    /// `filter-range` (usage), with the range.
    pub fn validate(&self) -> Result<()> {
        let wrong = |what: String| {
            Err(Error::usage("filter-range", format!("{self}: {what}")).with_hint(EXAMPLES))
        };
        let window_of = match *self {
            FilterSpec::SavitzkyGolay { window, .. }
            | FilterSpec::Hampel { window, .. }
            | FilterSpec::Mean { window } => Some(window),
            FilterSpec::Butterworth { .. } => None,
        };
        if let Some(window) = window_of
            && !(1..=MAX_WINDOW).contains(&window)
        {
            return wrong(format!("the window has to be 1 to {MAX_WINDOW} samples"));
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
                if window % 2 == 0 || window < 3 {
                    return wrong("the window has to be odd and at least 3".to_owned());
                }
                if !(0.0..=1e6).contains(&sigmas) {
                    return wrong("sigmas have to be between 0 and 1e6".to_owned());
                }
            }
            FilterSpec::Mean { window } => {
                if window % 2 == 0 {
                    return wrong("the window has to be odd: an even one has no middle".to_owned());
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
                    return wrong("cutoffs have to be above 0 Hz and to rise".to_owned());
                }
            }
        }
        Ok(())
    }

    /// True when a constant comes out as it went in.
    #[must_use]
    pub fn keeps_constants(&self) -> bool {
        match self {
            FilterSpec::SavitzkyGolay { derivative, .. } => *derivative == 0,
            FilterSpec::Butterworth { band, .. } => matches!(band, Band::Low { .. }),
            FilterSpec::Hampel { .. } | FilterSpec::Mean { .. } => true,
        }
    }

    /// How often the result is differentiated by time.
    #[must_use]
    pub fn derivative(&self) -> usize {
        match self {
            FilterSpec::SavitzkyGolay { derivative, .. } => *derivative,
            _ => 0,
        }
    }

    /// True when the filter cannot be had without a sampling rate.
    #[must_use]
    pub fn needs_rate(&self) -> bool {
        matches!(self, FilterSpec::Butterworth { .. }) || self.derivative() > 0
    }
}

impl Band {
    /// The one cutoff, or both.
    #[must_use]
    pub fn edges_hz(&self) -> Vec<f64> {
        match *self {
            Band::Low { cutoff_hz } | Band::High { cutoff_hz } => vec![cutoff_hz],
            Band::Between { low_hz, high_hz } => vec![low_hz, high_hz],
        }
    }
}
