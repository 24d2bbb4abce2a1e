//! One cell: a number, a date, nothing, or text.

use gravical_judge::units::is_listed;

use crate::date::parse_date;

/// Value of a cell: NaN where it is empty or not finite, `None` where it is text.
///
/// A date counts as seconds since 1970, a time of day as seconds since midnight.
pub(crate) fn parse_cell(field: &str, decimal_comma: bool) -> Option<f64> {
    parse_number(field, decimal_comma).or_else(|| parse_date(field, false))
}

/// The same without dates.
pub(crate) fn parse_number(field: &str, decimal_comma: bool) -> Option<f64> {
    let parse = |text: &str| fast_float2::parse::<f64, _>(text).ok().map(finite);
    let missing = || is_missing(field).then_some(f64::NAN);
    let pointed = || with_point(field, decimal_comma).and_then(|text| parse(&text));
    let number = parse(field).or_else(missing).or_else(pointed);
    number.or_else(|| Some(-parse(field.strip_prefix('\u{2212}')?)?))
}

const POWERS: [f64; 16] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// The number of at most 15 digits, without an exponent, with which a text begins, and its length.
///
/// Most cells are such numbers, and most of the work on a long file is to read them. Digits and power
/// of ten are exact, so that the division alone rounds (Clinger, How to read floating point numbers
/// accurately, 1990).
#[inline]
pub(crate) fn parse_plain(text: &[u8], point: u8) -> Option<(f64, usize)> {
    let sign = usize::from(text.first() == Some(&b'-'));
    let (mut number, mut end, mut point_at) = (0_u64, sign, None);
    while let Some(byte) = text.get(end) {
        let digit = byte.wrapping_sub(b'0');
        if digit <= 9 {
            number = number.wrapping_mul(10).wrapping_add(digit.into());
        } else if *byte == point && point_at.is_none() {
            point_at = Some(end);
        } else {
            break;
        }
        end += 1;
    }
    let decimals = point_at.map_or(0, |at| end - at - 1);
    let digits = end - sign - usize::from(point_at.is_some());
    if !(1..POWERS.len()).contains(&digits) {
        return None;
    }
    let value = number as i64 as f64 / POWERS[decimals];
    // Without a branch: the sign of noise cannot be predicted.
    Some((value.copysign(0.5 - sign as f64), end))
}

/// A number with a point before its decimals and nothing between its thousands: `1043.7` for `1.043,7`.
fn with_point(field: &str, decimal_comma: bool) -> Option<String> {
    let (group, point) = if decimal_comma {
        ('.', ',')
    } else {
        (',', '.')
    };
    let (whole, decimals) = field.split_once(point)?;
    if !decimal_comma && !whole.contains(group) {
        return None;
    }
    let mut groups = whole.split(group).skip(1);
    let are_thousands = groups.all(|digits| digits.len() == 3);
    are_thousands.then(|| format!("{}.{decimals}", whole.replace(group, "")))
}

/// NaN for what is no measurement: infinity, or a torn exponent.
fn finite(value: f64) -> f64 {
    if value.abs() < 1e100 { value } else { f64::NAN }
}

fn is_missing(field: &str) -> bool {
    const MISSING: &str = "na n/a null none - -- --- ovf";
    field.is_empty() || field.len() <= 4 && is_listed(MISSING, &field.to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn plain_numbers_equal_std(text in "-?[0-9]{0,10}(\\.[0-9]{0,10})?") {
            let digits = text.bytes().filter(u8::is_ascii_digit).count();
            let want = text.parse::<f64>().ok().filter(|_| digits < POWERS.len());
            let got = parse_plain(text.as_bytes(), b'.');
            let want = want.map(|value| (value.to_bits(), text.len()));
            prop_assert_eq!(got.map(|(value, length)| (value.to_bits(), length)), want);
        }
    }

    #[test]
    fn cells_are_numbers_dates_nothing_or_text() {
        for (text, value) in [
            ("-0.50", -0.5),
            ("+1", 1.0),
            (".5", 0.5),
            ("1.4e+3", 1400.0),
            ("\u{2212}2", -2.0),
            ("1970-01-02T00:00:01.25+01:30", 81_001.25),
            ("01-Mar-2024 10:00:00.040", 1_709_287_200.04),
            ("1.3.2024 10:00:00,040", 1_709_287_200.04),
            ("3/1/2024 10:00:00 PM", 1_709_330_400.0),
            ("11:41:59:3050", 42_119.305),
            ("15-OCT-2024 10:00:00 UTC", 1_728_986_400.0),
            ("1/3/24, 10:00 a.m.", 1_704_276_000.0),
            ("2024-03-01 12:00:00 +0200 CEST", 1_709_287_200.0),
            ("01.03.2024", 1_709_251_200.0),
            ("00:01,04", 1.04),
        ] {
            assert_eq!(parse_cell(text, false), Some(value), "{text}");
        }
        assert_eq!(parse_cell("-3,25", true), Some(-3.25));
        assert_eq!(parse_cell("-1.043.250,5", true), Some(-1_043_250.5));
        assert_eq!(parse_cell("1,043.5", false), Some(1043.5));
        assert!(parse_cell("1,0e999", true).is_some_and(f64::is_nan));
        for text in ["", "NaN", "null", "inf", "1e300"] {
            assert!(parse_cell(text, false).is_some_and(f64::is_nan), "{text}");
        }
        for text in [
            "ax",
            "1.5.2",
            "1,43.5",
            "-3,25",
            "12:xx",
            "99999-1-1 1:1:1",
            "1-1-1-1 1:1",
        ] {
            assert_eq!(parse_cell(text, false), None, "{text}");
        }
    }
}
