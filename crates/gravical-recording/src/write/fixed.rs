//! Conversion of `f64` to decimal text with a fixed number of decimals.

use std::io::Write;

/// Powers of ten for the fast path.
const POWERS: [f64; 13] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12,
];

/// From here on an `f64` has no fraction.
const TWO_POW_52: f64 = 4_503_599_627_370_496.0;
/// From here on there are more digits than are written at once.
const MAX_UNITS: f64 = 1e15;

/// Appends `value` with exactly `decimals` decimals.
///
/// The text is that of `format!("{value:.decimals$}")`, with two differences: values that round
/// to zero have no sign (`0.000`, never `-0.000`), and NaN and infinities append nothing, which
/// leaves an empty field. Fast for up to twelve decimals and `|value| · 10^decimals < 10¹⁵`, but for
/// values near a tie; these, and larger ones, are written by the standard library.
///
/// ```
/// let mut row = Vec::new();
/// gravical_recording::write::write_fixed(&mut row, -9.80665, 3);
/// assert_eq!(row, b"-9.807");
/// ```
#[inline]
pub fn write_fixed(out: &mut Vec<u8>, value: f64, decimals: u32) {
    match (decimals, POWERS.get(decimals as usize)) {
        // With the usual number the compiler unrolls the loop and divides by constants.
        (6, _) => write_pairs(out, value, POWERS[6], 6),
        (_, Some(power)) => write_pairs(out, value, *power, decimals),
        (_, None) => by_std(out, value, decimals),
    }
}

#[inline(always)]
fn write_pairs(out: &mut Vec<u8>, value: f64, power: f64, decimals: u32) {
    let scaled = value.abs() * power;
    // The sum has no bits for a fraction: it is rounded to a whole number.
    let rounded = scaled + TWO_POW_52;
    let distance = (scaled - (rounded - TWO_POW_52)).abs();
    // The error of the product is at most scaled · 2⁻⁵³; this margin is twice that.
    let is_sure = scaled < MAX_UNITS && distance < 0.5 - scaled * f64::EPSILON;
    if !is_sure {
        return by_std(out, value, decimals);
    }
    let units = rounded.to_bits() - TWO_POW_52.to_bits();
    let divisor = 10_u64.pow(decimals);
    let (mut whole, mut fraction) = (units / divisor, units % divisor);
    // Written from the last character to the first; fifteen digits, point and sign fit.
    let (mut text, mut at) = ([0; END + COPIED], END);
    for _ in 0..decimals / 2 {
        at -= 2;
        text[at..at + 2].copy_from_slice(&PAIRS[(fraction % 100) as usize]);
        fraction /= 100;
    }
    if decimals % 2 == 1 {
        at -= 1;
        text[at] = b'0' + fraction as u8;
    }
    if decimals > 0 {
        at -= 1;
        text[at] = b'.';
    }
    loop {
        at -= 2;
        text[at..at + 2].copy_from_slice(&PAIRS[(whole % 100) as usize]);
        if whole < 100 {
            break;
        }
        whole /= 100;
    }
    at += usize::from(whole < 10);
    // Without a branch: the sign of noise cannot be predicted.
    text[at - 1] = b'-';
    at -= usize::from(value < 0.0 && units != 0);
    // A copy of fixed length takes two instructions, one of variable length a call.
    let length = out.len() + END - at;
    out.extend_from_slice(&text[at..at + COPIED]);
    out.truncate(length);
}

/// End of the text in its buffer, and number of bytes copied.
const END: usize = 20;
const COPIED: usize = 24;

/// `00` to `99`.
const PAIRS: [[u8; 2]; 100] = {
    let mut pairs = [[0; 2]; 100];
    let mut number = 0;
    while number < 100 {
        pairs[number] = [b'0' + (number / 10) as u8, b'0' + (number % 10) as u8];
        number += 1;
    }
    pairs
};

/// Appends `value` as [`write_fixed`] does, without zeros at the end of the decimals.
///
/// ```
/// let mut row = Vec::new();
/// gravical_recording::write::write_trimmed(&mut row, -0.0625, 12);
/// assert_eq!(row, b"-0.0625");
/// ```
#[inline]
pub fn write_trimmed(out: &mut Vec<u8>, value: f64, decimals: u32) {
    let from = out.len();
    write_fixed(out, value, decimals);
    if decimals == 0 || out.len() == from {
        return;
    }
    while out.last() == Some(&b'0') {
        out.pop();
    }
    if out.last() == Some(&b'.') {
        out.pop();
    }
}

#[cold]
#[inline(never)]
fn by_std(out: &mut Vec<u8>, value: f64, decimals: u32) {
    if !value.is_finite() {
        return;
    }
    let start = out.len();
    // Writing to a Vec does not fail.
    let _ = write!(out, "{value:.*}", decimals as usize);
    if let Some([b'-', digits @ ..]) = out.get(start..)
        && digits.iter().all(|byte| matches!(byte, b'0' | b'.'))
    {
        out.remove(start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fixed(value: f64, decimals: u32) -> String {
        let mut out = b"kept,".to_vec();
        write_fixed(&mut out, value, decimals);
        let text = String::from_utf8(out).unwrap();
        text.strip_prefix("kept,").unwrap().to_string()
    }

    /// Output of `format!`, without the sign of a zero.
    fn expected(value: f64, decimals: u32) -> String {
        let text = format!("{value:.*}", decimals as usize);
        match text.strip_prefix('-') {
            Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => digits.into(),
            _ => text,
        }
    }

    #[test]
    fn same_as_std_near_every_limit() {
        for decimals in 0..=12 {
            for power in -10..=17 {
                for edge in [1.0, 0.5, 9.5, 9.999_999_999] {
                    let edge = edge * 10_f64.powi(power);
                    for value in [edge, edge.next_up(), edge.next_down()] {
                        assert_eq!(fixed(value, decimals), expected(value, decimals));
                    }
                }
            }
            for edge in [TWO_POW_52, TWO_POW_52 / 2.0, MAX_UNITS, MAX_UNITS - 0.5] {
                let edge = edge / 10_f64.powi(decimals as i32);
                for value in [edge, edge.next_up(), edge.next_down()] {
                    assert_eq!(fixed(-value, decimals), expected(-value, decimals));
                }
            }
        }
    }
    proptest! {
        /// Any value, its neighbours and what is near a tie with few decimals.
        #[test]
        fn same_as_std(bits: u64, counts in -40_000_i32..40_000, halvings in 0..15, decimals in 0_u32..=12) {
            let any = Some(f64::from_bits(bits)).filter(|v| v.is_finite());
            let tie = f64::from(counts) / f64::from(1 << halvings);
            let half = (f64::from(counts) + 0.5) / 10_f64.powi(decimals as i32);
            for value in [tie, half, half.next_up(), half.next_down()].into_iter().chain(any) {
                prop_assert_eq!(fixed(value, decimals), expected(value, decimals));
            }
        }
    }
}
