//! Decimal text to `f64` and back, against the standard library.

use gravical::scan::{parse_field, parse_field_decimal_comma, scan_number, write_fixed};

/// Longer texts are cut: trying every prefix takes their square.
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
    let scanned = scan_number(text).map(|(value, used)| (value.to_bits(), used));
    assert_eq!(scanned, by_trial(text), "{:?}", text.escape_ascii());
    if let Some((value, used)) = scan_number(text) {
        for decimals in [0, 3, 6, 9] {
            write(value, decimals);
        }
        let alone = &text[..used];
        let quoted = [b" \"", alone, b"\"\r"].concat();
        for field in [alone, &quoted] {
            assert_eq!(
                parse_field(field).map(f64::to_bits),
                Some(value.to_bits()),
                "{:?}",
                field.escape_ascii()
            );
        }
        let comma: Vec<u8> = alone
            .iter()
            .map(|b| if *b == b'.' { b',' } else { *b })
            .collect();
        assert_eq!(
            parse_field_decimal_comma(&comma).map(f64::to_bits),
            Some(value.to_bits()),
            "{:?}",
            comma.escape_ascii()
        );
    }
    let whole = by_trial(text).filter(|(_, used)| *used == text.len());
    let trims = text
        .first()
        .is_some_and(|b| b.is_ascii_whitespace() || *b == b'"')
        || text.last().is_some_and(u8::is_ascii_whitespace);
    if !trims {
        let expected = whole.map(|(bits, _)| bits);
        assert_eq!(
            parse_field(text).map(f64::to_bits),
            expected,
            "{:?}",
            text.escape_ascii()
        );
    }
    // A point is no part of a number with a decimal comma.
    if text.contains(&b'.') {
        assert_eq!(
            parse_field_decimal_comma(text),
            None,
            "{:?}",
            text.escape_ascii()
        );
    }
}

/// The longest prefix that the standard parser takes, words (inf, nan) left
/// out.
fn by_trial(text: &[u8]) -> Option<(u64, usize)> {
    let possible = text
        .iter()
        .take_while(|b| b.is_ascii_digit() || b"+-.eE".contains(b))
        .count();
    (1..=possible).rev().find_map(|end| {
        let prefix = std::str::from_utf8(&text[..end]).ok()?;
        Some((prefix.parse::<f64>().ok()?.to_bits(), end))
    })
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
