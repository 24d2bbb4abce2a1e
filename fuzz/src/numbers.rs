//! Decimal text to `f64` and back, against the standard library.

use gravical_recording::parse_cell;
use gravical_recording::write::write_fixed;

/// Longer texts are cut.
const MOST: usize = 120;

/// Numbers: the bytes as text, and their first nine as a value with its number
/// of decimals.
pub fn number(data: &[u8]) {
    read(&data[..data.len().min(MOST)]);
    if let [decimals, a, b, c, d, e, f, g, h, ..] = *data {
        let value = f64::from_bits(u64::from_be_bytes([a, b, c, d, e, f, g, h]));
        let decimals = u32::from(decimals % 20);
        write(value, decimals);
        // The neighbours of a short decimal are where rounding goes wrong.
        let short = (value % 1e6 * 1e4).round() / 1e4;
        for value in [short, short.next_up(), short.next_down(), short + 0.5] {
            write(value, decimals);
        }
    }
}

fn read(text: &[u8]) {
    let Ok(text) = std::str::from_utf8(text) else {
        return;
    };
    let read = [false, true].map(|comma| parse_cell(text, comma));
    // What the standard parser takes, words (inf, nan) left out; no sensor gives more than 1e100.
    let is_number = text
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    let Some(value) = text.parse::<f64>().ok().filter(|_| is_number) else {
        return;
    };
    let is = |read: Option<f64>| match read {
        Some(read) if value.abs() < 1e100 => read.to_bits() == value.to_bits(),
        Some(read) => read.is_nan(),
        None => false,
    };
    assert!(read.into_iter().all(is), "{text:?}");
    if text.len() <= 40 {
        assert!(is(parse_cell(&text.replace('.', ","), true)), "{text:?}");
    }
    for decimals in [0, 3, 6, 9] {
        write(value, decimals);
    }
}

fn write(value: f64, decimals: u32) {
    let mut out = b"before,".to_vec();
    write_fixed(&mut out, value, decimals);
    let expected = if value.is_finite() {
        let text = format!("{value:.*}", decimals as usize);
        match text.strip_prefix('-') {
            Some(zero) if zero.bytes().all(|b| matches!(b, b'0' | b'.')) => zero.to_owned(),
            _ => text,
        }
    } else {
        String::new()
    };
    assert_eq!(
        out.strip_prefix(b"before,"),
        Some(expected.as_bytes()),
        "{value:?} with {decimals} decimals"
    );
}
