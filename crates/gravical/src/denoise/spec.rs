//! Which filter: `savgol:5,2`, `butter:4,5Hz` …, as text and as a value.

use std::fmt;
use std::str::FromStr;

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

impl fmt::Display for FilterSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => {
                write!(f, "savgol:{window},{order}")?;
                match derivative {
                    0 => Ok(()),
                    d => write!(f, ",{d}"),
                }
            }
            FilterSpec::Butterworth {
                order,
                band,
                passes,
            } => {
                let name = match band {
                    Band::High { .. } => "highpass",
                    _ => "butter",
                };
                let one = match passes {
                    Passes::Causal => "1",
                    Passes::Two => "",
                };
                write!(f, "{name}{one}:{order},")?;
                match band {
                    Band::Low { cutoff_hz } | Band::High { cutoff_hz } => {
                        write!(f, "{cutoff_hz}Hz")
                    }
                    Band::Between { low_hz, high_hz } => write!(f, "{low_hz}-{high_hz}Hz"),
                }
            }
            FilterSpec::Hampel { window, sigmas } => write!(f, "hampel:{window},{sigmas}"),
            FilterSpec::Mean { window } => write!(f, "mean:{window}"),
        }
    }
}

impl FromStr for FilterSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let spec = parse(text.trim()).ok_or_else(|| {
            Error::usage("filter-syntax", format!("\"{text}\" is no filter")).with_hint(EXAMPLES)
        })?;
        spec.validate()?;
        Ok(spec)
    }
}

fn parse(text: &str) -> Option<FilterSpec> {
    let (name, arguments) = text.split_once(':')?;
    let arguments: Vec<&str> = arguments.split(',').map(str::trim).collect();
    let whole = |at: usize| arguments.get(at)?.parse::<usize>().ok();
    let name = name.trim().to_ascii_lowercase();
    let passes = if name.ends_with('1') {
        Passes::Causal
    } else {
        Passes::Two
    };
    match (name.trim_end_matches('1'), arguments.len()) {
        ("savgol", 2 | 3) if passes == Passes::Two => Some(FilterSpec::SavitzkyGolay {
            window: whole(0)?,
            order: whole(1)?,
            derivative: if arguments.len() == 3 { whole(2)? } else { 0 },
        }),
        ("hampel", 2) if passes == Passes::Two => Some(FilterSpec::Hampel {
            window: whole(0)?,
            sigmas: arguments[1].parse().ok()?,
        }),
        ("mean", 1) if passes == Passes::Two => Some(FilterSpec::Mean { window: whole(0)? }),
        (kind @ ("butter" | "highpass"), 2) => {
            let edges = hertz(arguments[1])?;
            let band = match (kind, edges) {
                ("butter", (cutoff_hz, None)) => Band::Low { cutoff_hz },
                ("butter", (low_hz, Some(high_hz))) => Band::Between { low_hz, high_hz },
                (_, (cutoff_hz, None)) => Band::High { cutoff_hz },
                _ => return None,
            };
            Some(FilterSpec::Butterworth {
                order: whole(0)?,
                band,
                passes,
            })
        }
        _ => None,
    }
}

/// `5`, `5Hz`, `5-20 Hz`.
fn hertz(text: &str) -> Option<(f64, Option<f64>)> {
    let text = text.to_ascii_lowercase();
    let text = text.trim_end_matches("hz").trim();
    // Not the sign, and not that of an exponent.
    let cut = text
        .bytes()
        .enumerate()
        .position(|(i, b)| b == b'-' && i > 0 && text.as_bytes()[i - 1] != b'e');
    let number = |text: &str| text.trim().trim_end_matches("hz").parse::<f64>().ok();
    match cut {
        Some(at) => Some((number(&text[..at])?, Some(number(&text[at + 1..])?))),
        None => Some((number(text)?, None)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_there_and_back() {
        for text in [
            "savgol:5,2",
            "savgol:11,3,1",
            "butter:4,5Hz",
            "butter1:2,44.5Hz",
            "butter:4,5-20Hz",
            "butter1:4,0.5-20Hz",
            "highpass:4,0.5Hz",
            "highpass1:1,0.05Hz",
            "hampel:7,3",
            "hampel:7,0",
            "mean:5",
        ] {
            let spec: FilterSpec = text.parse().unwrap();
            assert_eq!(spec.to_string(), text);
        }
        for (text, same) in [
            (" Butter: 4 , 5 hz", "butter:4,5Hz"),
            ("butter:4,5", "butter:4,5Hz"),
            ("butter:2,1e-2-5Hz", "butter:2,0.01-5Hz"),
            ("butter:2,5Hz-20Hz", "butter:2,5-20Hz"),
            ("savgol:5,2,0", "savgol:5,2"),
        ] {
            let spec: FilterSpec = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(spec.to_string(), same);
        }
    }

    #[test]
    fn what_is_no_filter() {
        for text in [
            "",
            "savgol",
            "savgol:",
            "savgol:5",
            "savgol:5,2,1,1",
            "savgol1:5,2",
            "savgol:-5,2",
            "savgol:5.5,2",
            "butter:4",
            "butter:4,",
            "butter:4,x",
            "butter:four,5Hz",
            "kalman:1,2",
            "highpass:4,1-2Hz",
            "hampel:5",
            "mean:5,1",
            "butter:4,5-Hz",
            "5,2",
            "mean:99999999999999999999",
        ] {
            let error = text.parse::<FilterSpec>().unwrap_err();
            assert_eq!(error.code(), "filter-syntax", "{text}");
            assert!(error.hint().unwrap().contains("savgol:5,2"));
        }
        for text in [
            "savgol:5,5",
            "savgol:0,0",
            "savgol:5,2,3",
            "savgol:99,13",
            "savgol:99999,2",
            "butter:0,5Hz",
            "butter:9,5Hz",
            "butter:4,0Hz",
            "butter:4,-5Hz",
            "butter:4,nan",
            "butter:4,20-5Hz",
            "butter:4,infHz",
            "hampel:4,3",
            "hampel:1,3",
            "hampel:5,-1",
            "hampel:5,nan",
            "mean:4",
            "mean:0",
        ] {
            let error = text.parse::<FilterSpec>().unwrap_err();
            assert_eq!(error.code(), "filter-range", "{text}");
        }
    }
}
