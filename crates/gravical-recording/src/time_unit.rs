//! Units of time stamps.

use serde::{Deserialize, Serialize};

/// Unit of the time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum TimeUnit {
    /// Seconds.
    #[serde(rename = "s")]
    #[cfg_attr(feature = "clap", value(name = "s"))]
    Second,
    /// Milliseconds.
    #[serde(rename = "ms")]
    #[cfg_attr(feature = "clap", value(name = "ms"))]
    Millisecond,
    /// Hundreds of microseconds, the ticks of some motion trackers.
    #[serde(rename = "100us")]
    #[cfg_attr(feature = "clap", value(name = "100us"))]
    HundredMicroseconds,
    /// Microseconds.
    #[serde(rename = "us")]
    #[cfg_attr(feature = "clap", value(name = "us"))]
    Microsecond,
    /// Nanoseconds.
    #[serde(rename = "ns")]
    #[cfg_attr(feature = "clap", value(name = "ns"))]
    Nanosecond,
}

impl TimeUnit {
    /// Units that are guessed.
    pub(crate) const GUESSED: [TimeUnit; 4] = [
        TimeUnit::Second,
        TimeUnit::Millisecond,
        TimeUnit::Microsecond,
        TimeUnit::Nanosecond,
    ];

    /// Seconds per unit.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e-3,
            TimeUnit::HundredMicroseconds => 1e-4,
            TimeUnit::Microsecond => 1e-6,
            TimeUnit::Nanosecond => 1e-9,
        }
    }

    /// Name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            TimeUnit::Second => "s",
            TimeUnit::Millisecond => "ms",
            TimeUnit::HundredMicroseconds => "100us",
            TimeUnit::Microsecond => "us",
            TimeUnit::Nanosecond => "ns",
        }
    }

    /// The unit of so many seconds.
    #[must_use]
    pub fn of_seconds(seconds: f64) -> Option<Self> {
        let units = [TimeUnit::HundredMicroseconds];
        let mut units = TimeUnit::GUESSED.into_iter().chain(units);
        units.find(|u| (u.seconds() / seconds - 1.0).abs() < 1e-9)
    }

    /// Parses a unit.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Some(match text.trim().to_lowercase().as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => TimeUnit::Second,
            "ms" | "msec" | "msecs" | "millisec" | "millisecs" | "millis" | "millisecond"
            | "milliseconds" => TimeUnit::Millisecond,
            "us" | "µs" | "μs" | "usec" | "usecs" | "microsec" | "microsecs" | "micros"
            | "microsecond" | "microseconds" => TimeUnit::Microsecond,
            "ns" | "nsec" | "nsecs" | "nanosec" | "nanosecs" | "nanos" | "nanosecond"
            | "nanoseconds" => TimeUnit::Nanosecond,
            _ => return None,
        })
    }
}

/// Seconds of one unit of time, which may have a number: `ms`, `[10ms]`.
pub(crate) fn time_scale_s(text: &str) -> Option<f64> {
    let text: String = text.chars().filter(|c| !"[]() ".contains(*c)).collect();
    let word = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let many: f64 = text[..text.len() - word.len()].parse().unwrap_or(1.0);
    (many > 0.0).then_some(many * TimeUnit::parse(word)?.seconds())
}
