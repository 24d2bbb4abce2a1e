//! Filters as text: `savgol:5,2`, `butter:4,5Hz` ….

use std::fmt;
use std::str::FromStr;

use gravical_core::filter::butterworth::MAX_ORDER;

use crate::{Error, Result};

/// The longest window, samples.
const MAX_WINDOW: usize = 10_001;
/// The highest order of a polynomial, tested to 1e-12.
const MAX_POLYNOMIAL: usize = 12;

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

/// Band of a Butterworth filter. The gain of the whole filter is −3 dB at these frequencies, for one
/// pass and for two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower cutoff, Hz, above 0; `None` for a low-pass.
    pub low_hz: Option<f64>,
    /// Upper cutoff, Hz, above the lower one and below half the rate; `None` for a high-pass.
    pub high_hz: Option<f64>,
}

/// Number of passes over the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
        self.check().map_err(|fault| {
            Error::usage("filter-range", format!("{self}: {fault}")).with_hint(EXAMPLES)
        })
    }

    fn check(&self) -> Result<(), String> {
        let require = |holds: bool, what: String| if holds { Ok(()) } else { Err(what) };
        let require_window = |window: usize, min: usize| -> Result<(), String> {
            let range = format!("the window has to be {min} to {MAX_WINDOW} samples");
            require((min..=MAX_WINDOW).contains(&window), range)?;
            let odd = "the window has to be odd: an even one has no middle".to_owned();
            require(!window.is_multiple_of(2), odd)
        };
        match *self {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => {
                require_window(window, 1)?;
                let below =
                    format!("the order has to be below the window and at most {MAX_POLYNOMIAL}");
                require(order < window && order <= MAX_POLYNOMIAL, below)?;
                let none = format!("a polynomial of order {order} has no derivative {derivative}");
                require(derivative <= order, none)
            }
            FilterSpec::Hampel { window, sigmas } => {
                require_window(window, 3)?;
                let range = "sigmas have to be between 0 and 1e6".to_owned();
                require((0.0..=1e6).contains(&sigmas), range)
            }
            FilterSpec::Butterworth { order, band, .. } => {
                let range = format!("the order has to be 1 to {MAX_ORDER}");
                require((1..=MAX_ORDER).contains(&order), range)?;
                let edges = band.edges_hz();
                let is_positive = edges.iter().all(|f| *f > 0.0 && f.is_finite());
                let is_positive = is_positive && !edges.is_empty();
                let ascending = "cutoffs have to be above 0 Hz and in ascending order".to_owned();
                require(is_positive && edges.is_sorted_by(|a, b| a < b), ascending)
            }
        }
    }

    /// True if a constant is unchanged.
    #[must_use]
    pub fn keeps_constants(&self) -> bool {
        match self {
            FilterSpec::SavitzkyGolay { derivative, .. } => *derivative == 0,
            FilterSpec::Butterworth { band, .. } => band.low_hz.is_none(),
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
        [self.low_hz, self.high_hz].into_iter().flatten().collect()
    }
}

impl fmt::Display for FilterSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => match (order, derivative) {
                (0, _) => write!(f, "mean:{window}"),
                (_, 0) => write!(f, "savgol:{window},{order}"),
                _ => write!(f, "savgol:{window},{order},{derivative}"),
            },
            FilterSpec::Butterworth {
                order,
                band,
                passes,
            } => {
                let name = band.high_hz.map_or("highpass", |_| "butter");
                let one = if passes == Passes::Causal { "1" } else { "" };
                let edges: Vec<String> = band.edges_hz().iter().map(f64::to_string).collect();
                write!(f, "{name}{one}:{order},{}Hz", edges.join("-"))
            }
            FilterSpec::Hampel { window, sigmas } => write!(f, "hampel:{window},{sigmas}"),
        }
    }
}

impl FromStr for FilterSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let spec = parse(text.trim()).ok_or_else(|| {
            Error::usage("filter-syntax", format!("\"{text}\" is not a filter")).with_hint(EXAMPLES)
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
        ("mean", 1) if passes == Passes::Two => Some(FilterSpec::SavitzkyGolay {
            window: whole(0)?,
            order: 0,
            derivative: 0,
        }),
        (kind @ ("butter" | "highpass"), 2) => {
            let (low_hz, high_hz) = match (kind, hertz(arguments[1])?) {
                ("butter", (cutoff_hz, None)) => (None, Some(cutoff_hz)),
                ("butter", (low_hz, high_hz)) => (Some(low_hz), high_hz),
                (_, (cutoff_hz, None)) => (Some(cutoff_hz), None),
                _ => return None,
            };
            Some(FilterSpec::Butterworth {
                order: whole(0)?,
                band: Band { low_hz, high_hz },
                passes,
            })
        }
        _ => None,
    }
}

/// `5`, `5Hz`, `5-20 Hz`: a minus is also a sign, and part of an exponent.
fn hertz(text: &str) -> Option<(f64, Option<f64>)> {
    let text = text.to_ascii_lowercase();
    let number = |text: &str| {
        let text = text.trim().trim_end_matches("hz").trim_end();
        text.parse::<f64>().ok()
    };
    let band =
        |(at, _): (usize, &str)| Some((number(&text[..at])?, Some(number(&text[at + 1..])?)));
    let cutoff = number(&text).map(|cutoff| (cutoff, None));
    cutoff.or_else(|| text.match_indices('-').find_map(band))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_round_trips() {
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
    fn invalid_filters_are_refused() {
        let syntax = "savgol savgol: savgol:5 savgol:5,2,1,1 savgol1:5,2 savgol:-5,2 savgol:5.5,2 \
                      butter:4 butter:4, butter:4,x butter:four,5Hz kalman:1,2 highpass:4,1-2Hz \
                      hampel:5 mean:5,1 butter:4,5-Hz 5,2 mean:99999999999999999999";
        let range = "savgol:5,5 savgol:0,0 savgol:6,2 savgol:5,2,3 savgol:99,13 savgol:99999,2 butter:0,5Hz \
                     butter:9,5Hz butter:4,0Hz butter:4,-5Hz butter:4,nan butter:4,20-5Hz \
                     butter:4,infHz hampel:4,3 hampel:1,3 hampel:5,-1 hampel:5,nan mean:4 mean:0";
        for (texts, code) in [
            ("", "filter-syntax"),
            (syntax, "filter-syntax"),
            (range, "filter-range"),
        ] {
            for text in texts.split(' ') {
                let error = text.parse::<FilterSpec>().unwrap_err();
                assert_eq!(error.code(), code, "{text}");
            }
        }
    }
}
