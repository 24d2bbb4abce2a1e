//! Dates and times of day as stamps.

/// No date is longer: fifteen digits after the seconds, zone, and spaces between the parts.
const LONGEST: usize = 64;

/// Parses a date and time of day as seconds since 1970 (in UTC; only differences are used), or a
/// time of day alone as seconds since midnight.
///
/// `2025-04-07T10:15:00.25Z`, `2017-05-19 14:31:14,220`, `5/19/2017 14:31:14.220`,
/// `2019-05-08T11.41.59.305`, `11:41:59:3050`, `2:31:14.220 PM`. Digits after the seconds are
/// their fraction, whatever the separator. If two numbers can both be the month, the first one is
/// used: only a change of date at midnight would show which is right.
#[must_use]
pub fn parse_date(text: &[u8]) -> Option<f64> {
    parse(text, false)
}

/// The same; of two numbers that can both be the month, the second one is.
#[must_use]
pub fn parse_date_day_first(text: &[u8]) -> Option<f64> {
    parse(text, true)
}

fn parse(text: &[u8], day_first: bool) -> Option<f64> {
    let text = text.trim_ascii();
    // Fast rejection of words, of which a header can have many, and of whole lines.
    if !text.first()?.is_ascii_digit() || !(4..=LONGEST).contains(&text.len()) {
        return None;
    }
    let text = std::str::from_utf8(text).ok()?;
    let (first, rest) = text
        .split_once(['T', ' '])
        .or_else(|| text.rsplit_once('/').filter(|(_, time)| time.contains(':')))
        .map_or((text, ""), |(a, b)| (a, b.trim_start()));
    match day_s(first, day_first) {
        Some(day) if rest.is_empty() => Some(day),
        Some(day) => Some(day + time_of_day_s(rest, true)?),
        None => time_of_day_s(text, false),
    }
}

/// Midnight of a date, s since 1970.
fn day_s(text: &str, day_first: bool) -> Option<f64> {
    let mut parts = text.split(['-', '/', '.']);
    let (a, b, c) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    let number = |part: &str| -> Option<i16> {
        let digits = part.bytes().all(|d| d.is_ascii_digit());
        digits.then(|| part.parse().ok()).flatten()
    };
    let (year, month, day) = match (a.len(), c.len()) {
        (4, _) => (number(a)?, number(b)?, number(c)?),
        (_, 4) if number(a)? > 12 || day_first && number(b)? <= 12 => {
            (number(c)?, number(b)?, number(a)?)
        }
        (_, 4) => (number(c)?, number(a)?, number(b)?),
        _ => return None,
    };
    let date = jiff::civil::Date::new(year, month.try_into().ok()?, day.try_into().ok()?).ok()?;
    let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp();
    Some(midnight.as_second() as f64)
}

/// Seconds since midnight in UTC, if the time has a zone.
fn time_of_day_s(text: &str, dated: bool) -> Option<f64> {
    let text = text.trim();
    let (text, half_day_s) = match text.as_bytes() {
        [.., b'A' | b'a', b'M' | b'm'] => (text[..text.len() - 2].trim_end(), Some(0.0)),
        [.., b'P' | b'p', b'M' | b'm'] => (text[..text.len() - 2].trim_end(), Some(43_200.0)),
        _ => (text, None),
    };
    let zone_at = text.find(['Z', '+', '-']).unwrap_or(text.len());
    let (clock, zone) = text.split_at(zone_at);
    let mut parts = clock.trim_end().splitn(4, [':', '.', ',']);
    let mut whole = |below: f64, most: usize| -> Option<f64> {
        let part = parts.next()?;
        let digits = (1..=most).contains(&part.len()) && part.bytes().all(|d| d.is_ascii_digit());
        let value: f64 = digits.then(|| part.parse().ok()).flatten()?;
        (value < below).then_some(value)
    };
    // Without a date, a number with points only may be a version.
    if !clock.contains(':') && !dated {
        return None;
    }
    let hour = whole(25.0, 2)?;
    let minute = whole(60.0, 2)?;
    let second = whole(61.0, 2).unwrap_or(0.0);
    let fraction = match parts.next() {
        Some(digits) if digits.len() <= 15 && digits.bytes().all(|d| d.is_ascii_digit()) => {
            let number: u64 = if digits.is_empty() {
                0
            } else {
                digits.parse().ok()?
            };
            number as f64 / 10_f64.powi(digits.len() as i32)
        }
        Some(_) => return None,
        None => 0.0,
    };
    let hour = match half_day_s {
        Some(_) => hour % 12.0,
        None => hour,
    };
    let since_midnight = hour * 3600.0 + minute * 60.0 + second + fraction;
    Some(since_midnight + half_day_s.unwrap_or(0.0) - zone_s(zone)?)
}

/// Offset of a zone from UTC: `Z`, `+02:00`, `-0530`, or empty.
fn zone_s(text: &str) -> Option<f64> {
    let sign = match text.as_bytes() {
        [] | [b'Z'] => return Some(0.0),
        [b'+', ..] => 1.0,
        [b'-', ..] => -1.0,
        _ => return None,
    };
    let digits: String = text[1..].chars().filter(|c| *c != ':').collect();
    let number: f64 = digits.parse().ok()?;
    let (hours, minutes) = match digits.len() {
        2 => (number, 0.0),
        4 => ((number / 100.0).floor(), number % 100.0),
        _ => return None,
    };
    Some(sign * (hours * 3600.0 + minutes * 60.0))
}

#[cfg(test)]
mod tests {
    use super::parse_date;

    #[test]
    fn dates_and_times_of_loggers_are_parsed() {
        let base = parse_date(b"2017-05-19").unwrap();
        for (text, seconds) in [
            ("2017-05-19 14:31:14.220", 52_274.22),
            ("2017-05-19T14:31:14,220", 52_274.22),
            ("2017-05-19T14:31:14.220Z", 52_274.22),
            ("2017-05-19T16:31:14.220+02:00", 52_274.22),
            ("2017/05/19 14:31:14.22", 52_274.22),
            ("5/19/2017 14:31:14.220", 52_274.22),
            ("19.05.2017 14:31:14.220", 52_274.22),
            ("5/19/2017 2:31:14.220 PM", 52_274.22),
            ("2017-05-19T14.31.14.220", 52_274.22),
            ("2017/05/19/14:31:14.220000", 52_274.22),
        ] {
            let parsed = parse_date(text.as_bytes()).unwrap_or(f64::NAN) - base;
            assert!((parsed - seconds).abs() < 1e-5, "{text}: {parsed}");
        }
        assert_eq!(base, 1_495_152_000.0);
        for (text, seconds) in [
            ("11:41:59:3050", 42_119.305),
            ("11:41:59,305", 42_119.305),
            ("9:05", 32_700.0),
        ] {
            assert_eq!(parse_date(text.as_bytes()), Some(seconds), "{text}");
        }
        for text in [
            "9.81",
            "1,2",
            "12",
            "2017-13-40",
            "x",
            "",
            "1-2-3",
            "25:99",
            "-0.5",
        ] {
            assert_eq!(parse_date(text.as_bytes()), None, "{text}");
        }
    }
}
