//! Times in UTC, to the second: when a session was recorded, when a result was computed.
//!
//! ```
//! use gravical_judge::utc::UtcTime;
//!
//! let time: UtcTime = "2026-03-09T12:15:00+02:00".parse()?;
//! assert_eq!(time.to_string(), "2026-03-09T10:15:00Z");
//! // Without a zone it is UTC; a date alone is its midnight.
//! assert_eq!("2026-03-09".parse::<UtcTime>()?.minute(), "2026-03-09 00:00");
//! # Ok::<(), gravical_judge::Error>(())
//! ```

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicI64, Ordering};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::problem::Problem;

/// Time stamps from here on are dates; below they count from the start of a board.
const EARLIEST_S: i64 = 946_684_800; // 2000-01-01
const LATEST_S: i64 = 4_102_444_800; // 2100-01-01

/// The time that was told, in seconds since 1970; 0: none was.
static TOLD: AtomicI64 = AtomicI64::new(0);

/// A time, to the second. Text and JSON: RFC 3339 in UTC, `2026-03-09T10:15:00Z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(with = "String"))]
#[serde(try_from = "String", into = "String")]
pub struct UtcTime(jiff::Timestamp);

impl UtcTime {
    /// The current time, or SOURCE_DATE_EPOCH, or the time that was [told](UtcTime::tell).
    pub fn now() -> Self {
        let epoch = std::env::var("SOURCE_DATE_EPOCH").ok();
        let epoch = epoch.and_then(|s| s.trim().parse().ok());
        let told = Some(TOLD.load(Ordering::Relaxed)).filter(|s| *s != 0);
        let known = epoch.or(told);
        let known = known.and_then(|s| jiff::Timestamp::from_second(s).ok());
        whole(known.unwrap_or_else(jiff::Timestamp::now))
    }

    /// Tells the time where there is no clock: in a browser.
    #[doc(hidden)]
    pub fn tell(since_1970_s: f64) {
        TOLD.store(since_1970_s as i64, Ordering::Relaxed);
    }

    /// Of a time stamp in seconds since 1970; none unless it is from 2000 to 2099, since most
    /// boards count from their start.
    pub fn of_stamp(since_1970_s: f64) -> Option<Self> {
        let second = since_1970_s.floor() as i64;
        if !(EARLIEST_S..LATEST_S).contains(&second) {
            return None;
        }
        jiff::Timestamp::from_second(second).ok().map(UtcTime)
    }

    /// Days from an earlier time; negative if that is later.
    pub fn days_since(self, earlier: UtcTime) -> f64 {
        (self.0.as_second() - earlier.0.as_second()) as f64 / 86_400.0
    }

    /// Date and time of day to the minute: `2026-03-09 10:15`.
    pub fn minute(self) -> String {
        self.0.strftime("%Y-%m-%d %H:%M").to_string()
    }
}

/// Whole seconds are enough.
fn whole(time: jiff::Timestamp) -> UtcTime {
    UtcTime(jiff::Timestamp::from_second(time.as_second()).unwrap_or(time))
}

impl fmt::Display for UtcTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for UtcTime {
    type Err = Error;

    /// # Errors
    ///
    /// `date-syntax` (usage).
    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        let zoned = text.parse::<jiff::Timestamp>().ok();
        let plain = || {
            let civil: jiff::civil::DateTime = text.parse().ok()?;
            Some(civil.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp())
        };
        zoned.or_else(plain).map(whole).ok_or_else(|| {
            let text = text.to_owned();
            Problem::NoDate { text }.error()
        })
    }
}

impl TryFrom<String> for UtcTime {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<UtcTime> for String {
    fn from(time: UtcTime) -> Self {
        time.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_boards_and_other_words_are_no_dates() {
        for stamp in [16.2, f64::NAN, 1e18] {
            assert_eq!(UtcTime::of_stamp(stamp), None);
        }
        let time = UtcTime::of_stamp(1_767_225_600.9).unwrap();
        assert_eq!(time.to_string(), "2026-01-01T00:00:00Z");
        for text in ["", "yesterday", "2026-13-01", "09.03.2026", "1767225600"] {
            assert!(text.parse::<UtcTime>().is_err(), "{text}");
        }
        let time: UtcTime = "2026-03-09 10:15".parse().unwrap();
        assert_eq!(time.to_string(), "2026-03-09T10:15:00Z");
    }
}
