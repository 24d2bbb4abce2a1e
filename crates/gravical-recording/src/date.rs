//! Dates and times of day.

/// Seconds since 1970, or since midnight for a time of day (`mm:ss.f` counts from the hour).
pub(crate) fn parse_date(text: &str, is_day_first: bool) -> Option<f64> {
    if !text.as_bytes().first()?.is_ascii_digit() || !text.contains(':') {
        return None;
    }
    let (day, time) = match text.split_once(['T', ' ']) {
        Some((day, time)) if day.len() > 5 && !day.contains(':') => (Some(day), time),
        _ => (None, text),
    };
    let zone_at = time
        .find(['Z', '+', '-', 'A', 'P', 'a', 'p'])
        .unwrap_or(time.len());
    let (clock, zone) = time.split_at(zone_at);
    if !zone.chars().all(|c| "Z+-:AaPpMm. 0123456789".contains(c)) {
        return None;
    }
    let (h, m, s) = parse_clock(clock.trim())?;
    let h = match zone.as_bytes() {
        [b'a' | b'A', ..] => h % 12.0,
        [b'p' | b'P', ..] => h % 12.0 + 12.0,
        _ => h % 24.0,
    };
    let midnight_s = match day {
        Some(day) => parse_day(day, is_day_first)? - ahead_s(zone),
        None => 0.0,
    };
    Some(midnight_s + h * 3600.0 + m * 60.0 + s)
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
/// be), `01-Mar-2024`.
fn parse_day(day: &str, is_day_first: bool) -> Option<f64> {
    let number = |part: &str| part.parse().ok().or_else(|| month(part));
    let parts = day.split(['-', '/', '.']).map(number);
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
    let (month, day) = (month.try_into().ok()?, day.try_into().ok()?);
    let date = jiff::civil::Date::new(year.try_into().ok()?, month, day).ok()?;
    let midnight = jiff::tz::Offset::UTC.to_timestamp(date.at(0, 0, 0, 0));
    Some(midnight.ok()?.as_second() as f64)
}

fn month(name: &str) -> Option<i64> {
    const MONTHS: [&str; 12] = [
        "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec",
    ];
    let word: String = name.to_lowercase().chars().take(3).collect();
    MONTHS.iter().position(|m| *m == word).map(|m| m as i64 + 1)
}
