//! Filters as text: `savgol:5,2`, `butter:4,5Hz` …

use std::fmt;
use std::str::FromStr;

use super::spec::{Band, EXAMPLES, FilterSpec, Passes};
use crate::{Error, Result};

impl fmt::Display for FilterSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FilterSpec::SavitzkyGolay {
                window, order: 0, ..
            } => write!(f, "mean:{window}"),
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
    // A minus that is neither a sign nor part of an exponent.
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
