//! Dates and times of day.

use gravical_judge::units::is_listed;

/// Seconds since 1970, or since midnight for a time of day (`mm:ss.f` counts from the hour); a date
/// alone is its midnight.
pub(crate) fn parse_date(text: &str, is_day_first: bool) -> Option<f64> {
    if !text.as_bytes().first()?.is_ascii_digit() {
        return None;
    }
    let Some((day, time)) = split_day(text) else {
        let has_year = text.split(SEPARATORS).any(|part| part.len() == 4);
        return parse_day(text, is_day_first).filter(|_| has_year);
    };
    let zone_at = time.find(|c: char| !(c.is_ascii_digit() || ":.,".contains(c)));
    let (clock, zone) = time.split_at(zone_at.unwrap_or(time.len()));
    let zone = zone.trim();
    let words = zone.split(|c: char| !c.is_alphabetic());
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    if !is_zone(zone, &words) {
        return None;
    }
    let (h, m, s) = parse_clock(clock)?;
    let h = match words.first() {
        Some(&("a" | "A" | "am" | "AM")) => h % 12.0,
        Some(&("p" | "P" | "pm" | "PM")) => h % 12.0 + 12.0,
        _ => h % 24.0,
    };
    let midnight_s = match day {
        Some(day) => parse_day(day, is_day_first)? - ahead_s(zone),
        None => 0.0,
    };
    Some(midnight_s + h * 3600.0 + m * 60.0 + s)
}

/// What stands between day, month and year.
const SEPARATORS: [char; 4] = ['-', '/', '.', ' '];

/// The day, if there is one, and the time of day; `None` without a time of day.
fn split_day(text: &str) -> Option<(Option<&str>, &str)> {
    let hour = &text[..text.find(':')?];
    Some(match hour.rfind(['T', 't', ' ', '_']) {
        Some(at) => (
            Some(hour[..at].trim_end_matches([',', ' '])),
            &text[at + 1..],
        ),
        None => (None, text),
    })
}

/// `Z`, `+02:00`, `PM`, `a.m.`, `UTC`, `+0200 CEST`: only UTC and offsets shift a time.
fn is_zone(zone: &str, words: &[&str]) -> bool {
    let is_word = |word: &&str| {
        is_listed("z a p m am pm utc gmt", &word.to_ascii_lowercase())
            || (3..=5).contains(&word.len()) && word.bytes().all(|b| b.is_ascii_uppercase())
    };
    zone.chars()
        .all(|c| c.is_ascii_alphanumeric() || "+-:. ".contains(c))
        && !zone.starts_with(|c: char| c.is_ascii_digit())
        && words.iter().all(is_word)
}

/// Whether the day stands before the month in the dates of a column: one of them is above 12, or the
/// dates are closer to each other. `None` if they do not show it.
pub(crate) fn is_day_first<'a>(dates: impl Iterator<Item = &'a str>) -> Option<bool> {
    let day = |text: &'a str| split_day(text).map_or(Some(text), |(day, _)| day);
    let mut days: Vec<&str> = dates.filter_map(day).collect();
    days.dedup();
    let numbers = |day: &&str| -> Option<[u32; 2]> {
        let mut parts = day.split(['-', '/']).map(|part| part.parse().ok());
        Some([parts.next()??, parts.next()??]).filter(|[first, _]| *first < 32)
    };
    let numbers: Vec<[u32; 2]> = days.iter().filter_map(numbers).collect();
    let [has_day_first, has_day_second] = [0, 1].map(|at| numbers.iter().any(|n| n[at] > 12));
    if has_day_first || has_day_second {
        return Some(has_day_first);
    }
    let [first, second] = [true, false].map(|is_first| {
        let days = days.iter().filter_map(|day| parse_day(day, is_first));
        let days: Vec<f64> = days.collect();
        let steps = days.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.sum::<f64>()
    });
    (first != second).then_some(first < second)
}

/// Seconds by which a zone is ahead of UTC: `+02:00`, `-0530`, `Z`.
fn ahead_s(zone: &str) -> f64 {
    let digits: String = zone.chars().filter(char::is_ascii_digit).collect();
    let scale = if digits.len() > 2 { 1.0 } else { 100.0 };
    let number = scale * digits.parse::<f64>().unwrap_or(0.0);
    let sign = if zone.contains('-') { -1.0 } else { 1.0 };
    sign * (3600.0 * (number / 100.0).floor() + 60.0 * (number % 100.0))
}

/// `h:m:s.f`, `h:m:s:ffff` (fraction behind a colon), `m:s.f` or `h:m`.
fn parse_clock(text: &str) -> Option<(f64, f64, f64)> {
    let (whole, fraction) = match text.rsplit_once(['.', ',']) {
        Some(parts) => parts,
        None if text.matches(':').count() == 3 => text.rsplit_once(':')?,
        None => (text, ""),
    };
    let parts = whole.split(':').map(|part| part.parse().ok());
    let parts: Vec<u32> = parts.collect::<Option<_>>()?;
    let fraction_s = match fraction {
        "" => 0.0,
        f if f.bytes().all(|b| b.is_ascii_digit()) => {
            f.parse::<f64>().ok()? / 10_f64.powi(i32::try_from(f.len()).ok()?)
        }
        _ => return None,
    };
    let (h, m, s) = match parts[..] {
        [h, m, s] => (h, m, s),
        [m, s] if !fraction.is_empty() => (0, m, s),
        [h, m] => (h, m, 0),
        _ => return None,
    };
    Some((h.into(), m.into(), f64::from(s) + fraction_s))
}

/// Seconds from 1970 to a day: `2024-3-1`, `1.3.2024`, `3/1/2024` (month first unless it cannot
/// be), `01-Mar-2024`, `1/3/24`.
fn parse_day(day: &str, is_day_first: bool) -> Option<f64> {
    let number = |part: &str| part.parse().ok().or_else(|| month(part));
    let parts = day.split(SEPARATORS).map(number);
    let parts: Vec<i64> = parts.collect::<Option<_>>()?;
    let [a, b, c] = parts[..] else {
        return None;
    };
    let has_name = day.contains(char::is_alphabetic);
    let (year, month, day) = match () {
        _ if a > 31 => (a, b, c),
        _ if a > 12 || has_name || day.contains('.') || is_day_first => (c, b, a),
        _ => (c, a, b),
    };
    let century = match year {
        0..70 => 2000,
        70..100 => 1900,
        _ => 0,
    };
    civil_day_s(century + year, month, day)
}

/// Seconds from 1970 to a day that is written as one number: 20240301.
pub(crate) fn compact_day_s(number: f64) -> Option<f64> {
    let number = number as i64;
    civil_day_s(number / 10_000, number / 100 % 100, number % 100)
}

/// Seconds from 1970 to a day; `None` if there is no such day.
pub(crate) fn civil_day_s(year: i64, month: i64, day: i64) -> Option<f64> {
    let (month, day) = (month.try_into().ok()?, day.try_into().ok()?);
    let date = jiff::civil::Date::new(year.try_into().ok()?, month, day).ok()?;
    let midnight = jiff::tz::Offset::UTC.to_timestamp(date.at(0, 0, 0, 0));
    Some(midnight.ok()?.as_second() as f64)
}

fn month(name: &str) -> Option<i64> {
    let parsed = jiff::fmt::strtime::parse("%b", name.get(..3)?);
    parsed.ok()?.month().map(i64::from)
}
