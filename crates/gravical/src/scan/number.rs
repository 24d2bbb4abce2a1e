//! Conversion of decimal text to `f64`: exact and fast where exactness is easy to prove, with the
//! standard parser otherwise.
//!
//! A decimal number with at most 19 digits is an integer `m` in a `u64` times a power of ten. If
//! `m ≤ 2⁵³` and the power is within `10^±22`, both are exact as `f64`, so that one
//! multiplication or division rounds once and gives the nearest `f64` (Clinger, "How to read
//! floating point numbers accurately", 1990). More digits with a negative power are converted by
//! one integer division whose quotient has enough bits. Long runs of digits are processed eight
//! at a time in one 64-bit word.

/// Powers of ten that are exact as `f64`.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Powers of five that fit in a `u64`.
const FIVES: [u64; 28] = {
    let mut fives = [1; 28];
    let mut k = 1;
    while k < 28 {
        fives[k] = 5 * fives[k - 1];
        k += 1;
    }
    fives
};

/// Largest number of digits that cannot overflow a `u64`.
const MAX_DIGITS: usize = 19;

/// Up to here every integer is exact as `f64`.
const MAX_EXACT_INTEGER: u64 = 1 << 53;

/// Parses the longest decimal number at the start of `text`; returns its value and its number of
/// bytes.
///
/// A number is an optional sign, digits with an optional `.` (at least one digit before or after
/// it) and an optional exponent. An `e` without a valid exponent is not part of the number.
/// `None` if no number starts here; white space, `inf`, `nan` and hexadecimal numbers are not
/// accepted.
///
/// The value is bit for bit that of [`str::parse`] for the same bytes.
///
/// ```
/// use gravical::scan::scan_number;
///
/// assert_eq!(scan_number(b"-9.8123,0.04"), Some((-9.8123, 7)));
/// assert_eq!(scan_number(b"5e3 m"), Some((5000.0, 3)));
/// assert_eq!(scan_number(b"5em"), Some((5.0, 1)));
/// assert_eq!(scan_number(b"nan"), None);
/// ```
#[inline]
#[must_use]
pub fn scan_number(text: &[u8]) -> Option<(f64, usize)> {
    scan::<b'.'>(text)
}

/// Parses a field that consists of one decimal number.
///
/// ASCII white space around the number and one pair of double quotes around the field are
/// allowed. `None` for an empty field and for any other text after the number.
///
/// ```
/// use gravical::scan::parse_field;
///
/// assert_eq!(parse_field(b" \"9.81\" "), Some(9.81));
/// assert_eq!(parse_field(b"9.81 m/s^2"), None);
/// ```
#[inline]
#[must_use]
pub fn parse_field(field: &[u8]) -> Option<f64> {
    whole::<b'.'>(field)
}

/// As [`parse_field`], with a decimal comma: `1,25`.
///
/// A point is not accepted: `1.25` and `1.250,5` are `None`, not misread.
///
/// ```
/// use gravical::scan::parse_field_decimal_comma;
///
/// assert_eq!(parse_field_decimal_comma(b"-1,25"), Some(-1.25));
/// assert_eq!(parse_field_decimal_comma(b"1.25"), None);
/// ```
#[inline]
#[must_use]
pub fn parse_field_decimal_comma(field: &[u8]) -> Option<f64> {
    whole::<b','>(field)
}

#[inline]
fn whole<const POINT: u8>(field: &[u8]) -> Option<f64> {
    match scan::<POINT>(field) {
        Some((value, used)) if used == field.len() => Some(value),
        _ => whole_trimmed::<POINT>(field),
    }
}

#[inline(never)]
fn whole_trimmed<const POINT: u8>(field: &[u8]) -> Option<f64> {
    let mut inner = field.trim_ascii();
    if let [b'"', quoted @ .., b'"'] = inner {
        inner = quoted.trim_ascii();
    }
    match scan::<POINT>(inner) {
        Some((value, used)) if used == inner.len() => Some(value),
        _ => None,
    }
}

#[inline(always)]
fn scan<const POINT: u8>(text: &[u8]) -> Option<(f64, usize)> {
    let first = *text.first()?;
    let negative = first == b'-';
    let start = usize::from(negative || first == b'+');

    let mut mantissa = 0_u64;
    let mut end = take_whole_part(text, start, &mut mantissa);
    let mut digits = end - start;
    let mut decimals = 0;
    if text.get(end) == Some(&POINT) {
        let fraction = end + 1;
        end = take_digits(text, fraction, &mut mantissa);
        decimals = end - fraction;
        digits += decimals;
    }
    if digits == 0 {
        return None;
    }
    // If the cast overflows, there are too many digits anyway.
    let mut power = -(decimals as i32);
    if let Some(b'e' | b'E') = text.get(end) {
        let (exponent, used) = take_exponent(text.get(end..).unwrap_or_default());
        power = power.saturating_add(exponent);
        end += used;
    }

    let magnitude = if digits > MAX_DIGITS {
        return by_std::<POINT>(text, end);
    } else if mantissa <= MAX_EXACT_INTEGER {
        // Converting via i64 is one instruction, directly from u64 several.
        let whole = mantissa as i64 as f64;
        match EXACT_POWERS.get(power.unsigned_abs() as usize) {
            Some(scale) if power < 0 => whole / scale,
            Some(scale) => whole * scale,
            None => return by_std::<POINT>(text, end),
        }
    } else if power == 0 {
        // Counters and time stamps in ns: the conversion itself rounds once.
        mantissa as f64
    } else {
        match FIVES.get(power.unsigned_abs() as usize) {
            Some(&five) if power < 0 => divide(mantissa, five, power),
            _ => return by_std::<POINT>(text, end),
        }
    };
    // Without a branch, since the sign of noise cannot be predicted.
    let sign = u64::from(negative) << 63;
    Some((f64::from_bits(magnitude.to_bits() | sign), end))
}

/// `mantissa / five · 2^power` to the nearest `f64`, for numbers of 16 to 19 digits, as in files
/// with full precision.
///
/// `five` is 5^−power, so this is `mantissa · 10^power`. With both operands shifted to their top
/// bit the quotient has 63 or 64 bits, ten more than an `f64`; its lowest bit is also set if
/// there is a remainder, and the conversion rounds once. Every result is a normal number: at
/// least 2⁵³ · 10⁻²⁷.
#[inline]
fn divide(mantissa: u64, five: u64, power: i32) -> f64 {
    let (mantissa_shift, five_shift) = (mantissa.leading_zeros(), five.leading_zeros());
    let dividend = u128::from(mantissa << mantissa_shift) << 63;
    let divisor = u128::from(five << five_shift);
    let quotient = (dividend / divisor) as u64 | u64::from(dividend % divisor != 0);
    let binary = five_shift as i32 - mantissa_shift as i32 - 63 + power;
    quotient as f64 * f64::from_bits(((1023 + binary) as u64) << 52)
}

/// As [`take_digits`]; the first three digits, usually all before the point, are processed one by
/// one, which is fastest.
#[inline(always)]
fn take_whole_part(text: &[u8], position: usize, mantissa: &mut u64) -> usize {
    for end in position..position + 3 {
        let Some(digit) = digit(text, end) else {
            return end;
        };
        *mantissa = *mantissa * 10 + digit;
    }
    take_digits(text, position + 3, mantissa)
}

/// Appends the digits at `position` to `mantissa` (modulo 2⁶⁴) and returns the position after
/// them.
///
/// The rest after blocks of eight is processed digit by digit: the branches are predicted for
/// columns with a fixed number of decimals, and parsing of the next field need not wait for the
/// length of this one.
#[inline(always)]
fn take_digits(text: &[u8], mut position: usize, mantissa: &mut u64) -> usize {
    while let Some(bytes) = text.get(position..).and_then(<[u8]>::first_chunk) {
        // A digit becomes its value, every other byte becomes more than 9 …
        let word = u64::from_le_bytes(*bytes) ^ 0x3030_3030_3030_3030;
        // … which sets its top bit. A sum carries out of a byte only if that bit is set in it
        // anyway.
        let other = (word.wrapping_add(0x7676_7676_7676_7676) | word) & 0x8080_8080_8080_8080;
        if other != 0 {
            break;
        }
        *mantissa = mantissa
            .wrapping_mul(100_000_000)
            .wrapping_add(eight_digits(word));
        position += 8;
    }
    while let Some(digit) = digit(text, position) {
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(digit);
        position += 1;
    }
    position
}

/// The value of the digit at `position`, if there is one.
#[inline(always)]
fn digit(text: &[u8], position: usize) -> Option<u64> {
    let value = text.get(position)?.wrapping_sub(b'0');
    (value <= 9).then_some(u64::from(value))
}

/// The number whose eight digits are the bytes of `word`, the first digit in the lowest byte.
#[inline(always)]
fn eight_digits(word: u64) -> u64 {
    const PAIRS: u64 = 0x0000_00FF_0000_00FF;
    // Neighbours are combined to two-digit numbers in every second byte …
    let pairs = word.wrapping_mul(10).wrapping_add(word >> 8);
    // … and the four of them, weighted, are summed in the upper half.
    let first_and_third = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let second_and_fourth = ((pairs >> 16) & PAIRS).wrapping_mul(1 + (10_000 << 32));
    first_and_third.wrapping_add(second_and_fourth) >> 32
}

/// The exponent at the start of `text` (at the `e`) and its length, `(0, 0)` without a valid
/// exponent. Saturates far beyond the range of `f64`.
#[inline(never)]
fn take_exponent(text: &[u8]) -> (i32, usize) {
    // The usual form: a sign and two digits.
    if let [
        _,
        sign @ (b'+' | b'-'),
        tens @ b'0'..=b'9',
        ones @ b'0'..=b'9',
        rest @ ..,
    ] = text
        && !rest.first().is_some_and(u8::is_ascii_digit)
    {
        let exponent = 10 * i32::from(tens - b'0') + i32::from(ones - b'0');
        return (if *sign == b'-' { -exponent } else { exponent }, 4);
    }
    let negative = text.get(1) == Some(&b'-');
    let start = if negative || text.get(1) == Some(&b'+') {
        2
    } else {
        1
    };
    let mut end = start;
    let mut exponent = 0_i32;
    while let Some(digit @ b'0'..=b'9') = text.get(end) {
        exponent = exponent
            .saturating_mul(10)
            .saturating_add(i32::from(digit - b'0'));
        end += 1;
    }
    match (end == start, negative) {
        (true, _) => (0, 0),
        (false, true) => (-exponent, end),
        (false, false) => (exponent, end),
    }
}

/// The number in the first `end` bytes, parsed by the standard library.
#[cold]
#[inline(never)]
fn by_std<const POINT: u8>(text: &[u8], end: usize) -> Option<(f64, usize)> {
    let number = std::str::from_utf8(text.get(..end)?).ok()?;
    let value = if POINT == b'.' {
        number.parse()
    } else {
        number.replace(char::from(POINT), ".").parse()
    };
    Some((value.ok()?, end))
}

#[cfg(test)]
mod tests;
