//! Time zones, and clock times in them.

use std::fmt;
use std::io::Write as _;
use std::str::FromStr;

use jiff::Timestamp;
use jiff::civil::Date;

use crate::{Error, Result};

/// A time zone by its name in the database of IANA. The database of the system is used; where there
/// is none, that of the program.
///
/// ```
/// use gravical::wearable::Zone;
///
/// let zone: Zone = "Europe/Berlin".parse()?;
/// assert_eq!(zone.to_string(), "Europe/Berlin");
/// assert!("Europe/Atlantis".parse::<Zone>().is_err());
/// # Ok::<(), gravical::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    name: String,
    /// None for UTC, which is written with `Z`.
    zone: Option<jiff::tz::TimeZone>,
}

impl Default for Zone {
    /// UTC.
    fn default() -> Self {
        Zone {
            name: "UTC".to_owned(),
            zone: None,
        }
    }
}

impl FromStr for Zone {
    type Err = Error;

    /// # Errors
    ///
    /// `time-zone` (usage) for a name that the database does not have.
    fn from_str(text: &str) -> Result<Self> {
        let name = text.trim();
        if name.eq_ignore_ascii_case("utc") {
            return Ok(Zone::default());
        }
        let zone = jiff::tz::TimeZone::get(name).map_err(|_| {
            Error::usage("time-zone", format!("there is no time zone \"{name}\""))
                .with_hint("name one of the IANA database: Europe/Berlin, America/New_York, UTC")
        })?;
        Ok(Zone {
            name: zone.iana_name().unwrap_or(name).to_owned(),
            zone: Some(zone),
        })
    }
}

impl fmt::Display for Zone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl Zone {
    /// Appends a time as RFC 3339, with the offset of this zone; nothing for a second beyond all
    /// dates.
    pub(super) fn write(&self, out: &mut Vec<u8>, since_1970_s: i64) {
        let Ok(time) = Timestamp::from_second(since_1970_s) else {
            return;
        };
        let Some(zone) = &self.zone else {
            // Writing into memory does not fail.
            let _ = write!(out, "{time}");
            return;
        };
        let offset = zone.to_offset(time);
        let (local, minutes) = (offset.to_datetime(time), offset.seconds() / 60);
        let sign = if minutes < 0 { '-' } else { '+' };
        let (hours, minutes) = (minutes.abs() / 60, minutes.abs() % 60);
        let _ = write!(out, "{local}{sign}{hours:02}:{minutes:02}");
    }

    /// The same as text.
    pub(super) fn text(&self, since_1970_s: i64) -> String {
        let mut out = Vec::new();
        self.write(&mut out, since_1970_s);
        String::from_utf8_lossy(&out).into_owned()
    }

    /// The local date.
    pub(super) fn date(&self, since_1970_s: i64) -> Option<Date> {
        let time = Timestamp::from_second(since_1970_s).ok()?;
        let zone = self.zone.clone().unwrap_or(jiff::tz::TimeZone::UTC);
        Some(zone.to_datetime(time).date())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_times_have_the_offset_of_the_day() {
        let berlin: Zone = "Europe/Berlin".parse().unwrap();
        // 2026-03-29T00:59:55Z, five seconds before the change.
        let change = 1_774_745_995;
        assert_eq!(berlin.text(change), "2026-03-29T01:59:55+01:00");
        assert_eq!(berlin.text(change + 5), "2026-03-29T03:00:00+02:00");
        assert_eq!(Zone::default().text(change), "2026-03-29T00:59:55Z");
        let kathmandu: Zone = "Asia/Kathmandu".parse().unwrap();
        assert_eq!(kathmandu.text(change), "2026-03-29T06:44:55+05:45");
        let newfoundland: Zone = "America/St_Johns".parse().unwrap();
        assert_eq!(newfoundland.text(change), "2026-03-28T22:29:55-02:30");
        assert_eq!(newfoundland.date(change).unwrap().to_string(), "2026-03-28");
        assert_eq!(berlin.text(i64::MAX), "");
        assert_eq!("nowhere".parse::<Zone>().unwrap_err().code(), "time-zone");
        assert_eq!("utc".parse::<Zone>().unwrap(), Zone::default());
    }
}
