use super::*;
use proptest::prelude::*;

/// The longest prefix that is a number according to the standard parser.
fn by_trial(text: &str) -> Option<(u64, usize)> {
    (1..=text.len()).rev().find_map(|end| {
        let prefix = text.get(..end)?;
        // std also reads words (inf, nan), which are not numbers here.
        if prefix.contains(|letter: char| letter.is_ascii_alphabetic() && !"eE".contains(letter)) {
            return None;
        }
        Some((prefix.parse::<f64>().ok()?.to_bits(), end))
    })
}

fn scanned(text: &str) -> Option<(u64, usize)> {
    scan_number(text.as_bytes()).map(|(value, used)| (value.to_bits(), used))
}

/// Checks the number alone and followed by other text.
fn check(text: &str) {
    for behind in [
        "",
        ",",
        ",-1.25",
        "\t12345678.87654321",
        " m/s",
        "-",
        "e",
        ".",
        "\u{b0}",
    ] {
        let text = format!("{text}{behind}");
        assert_eq!(scanned(&text), by_trial(&text), "{text:?}");
    }
}

#[test]
fn parsing_stops_after_the_number() {
    let cases: [(&str, Option<(f64, usize)>); 30] = [
        ("", None),
        (".", None),
        ("-", None),
        ("+", None),
        ("-.", None),
        ("e5", None),
        (".e5", None),
        ("--1", None),
        (" 1", None),
        ("inf", None),
        ("-nan", None),
        (",5", None),
        ("1e", Some((1.0, 1))),
        ("1e+", Some((1.0, 1))),
        ("1e-x", Some((1.0, 1))),
        ("1e+-2", Some((1.0, 1))),
        ("1.e2", Some((100.0, 4))),
        ("1E+02", Some((100.0, 5))),
        ("1e2.5", Some((100.0, 3))),
        ("1.", Some((1.0, 2))),
        (".5", Some((0.5, 2))),
        ("+.5", Some((0.5, 3))),
        ("-5.", Some((-5.0, 3))),
        ("1.2.3", Some((1.2, 3))),
        ("12abc", Some((12.0, 2))),
        ("0x10", Some((0.0, 1))),
        ("1_000", Some((1.0, 1))),
        ("-0", Some((-0.0, 2))),
        ("1-2", Some((1.0, 1))),
        ("9.8123,0.0042", Some((9.8123, 6))),
    ];
    for (text, expected) in cases {
        let expected = expected.map(|(value, used)| (value.to_bits(), used));
        assert_eq!(scanned(text), expected, "{text:?}");
        check(text);
    }
}

#[test]
fn limits_of_every_conversion_path() {
    for text in [
        "9007199254740991",
        "9007199254740992",
        "9007199254740993",
        "9007199254740993.0",
        "9007199254740995e-1",
        "9999999999999999999",
        "99999999999999999999",
        "18446744073709551615",
        "18446744073709551616",
        "1730147727805583790",
        "-1730147727.805583790",
        "1e22",
        "1e23",
        "123456789e-22",
        "123456789e-23",
        "9007199254740993e-27",
        "9007199254740993e-28",
        "9999999999999999999e-27",
        "0.000000000000000000000000000000000000123",
        "0000000000000000000000000001.5",
        "1.00000000000000011102230246251565404236316680908203125",
        "1.00000000000000011102230246251565404236316680908203124",
        "1.00000000000000011102230246251565404236316680908203126",
        "2.2250738585072011e-308",
        "2.2250738585072014e-308",
        "4.9406564584124654e-324",
        "2.4703282292062327e-324",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "0e999999999999999999999",
        "0.0e-999999999999999999999",
        "1e999999999999999999999",
        "1e-999999999999999999999",
        "1e2147483647",
        "0.001e-2147483648",
        "0.001e2147483650",
    ] {
        check(text);
        check(&format!("-{text}"));
    }
    // Too many digits, and a power that is compensated by the number of digits.
    check(&"7".repeat(400));
    check(&format!("0.{}1", "0".repeat(340)));
    check(&format!("0.{}1e400", "0".repeat(400)));
}

#[test]
fn fields() {
    for (field, expected) in [
        ("1.25", Some(1.25)),
        (" 1.25\t", Some(1.25)),
        ("1.25\r", Some(1.25)),
        ("\"1.25\"", Some(1.25)),
        (" \" 1.25 \" ", Some(1.25)),
        ("", None),
        ("  ", None),
        ("\"\"", None),
        ("\"", None),
        ("\"1.25", None),
        ("1.25\"", None),
        ("\"\"1\"\"", None),
        ("1.25 2", None),
        ("1,25", None),
        ("1e", None),
        ("nan", None),
    ] {
        assert_eq!(parse_field(field.as_bytes()), expected, "{field:?}");
    }
    for (field, expected) in [
        ("1,25", Some(1.25)),
        (" \"-1,25e-3\" ", Some(-1.25e-3)),
        (",5", Some(0.5)),
        ("5", Some(5.0)),
        (
            "0,12345678901234567890123",
            "0.12345678901234567890123".parse().ok(),
        ),
        ("1.25", None),
        ("1.250,5", None),
        ("1,2,3", None),
        (",", None),
    ] {
        assert_eq!(
            parse_field_decimal_comma(field.as_bytes()),
            expected,
            "{field:?}"
        );
    }
}

/// Decimal numbers of all shapes, and near misses.
fn numbers() -> impl Strategy<Value = String> {
    prop_oneof![
        // Typical output of loggers.
        "[+-]?[0-9]{1,3}\\.[0-9]{1,8}",
        "[+-]?[0-9]{1,20}",
        // Long mantissas, leading zeros, exponents.
        "[+-]?[0-9]{0,25}\\.?[0-9]{0,25}",
        "[+-]?0{0,25}[0-9]{0,5}\\.?0{0,25}[0-9]{0,19}",
        "[+-]?[0-9]{0,19}\\.?[0-9]{0,19}[eE][+-]?[0-9]{0,3}",
        "[+-]?[1-9]\\.[0-9]{15,18}e[+-]?[0-2][0-9]",
        // Any sequence of the same characters.
        "[-+0-9.eE]{0,12}",
    ]
}

/// The exact middle between two neighbours: 54 bits, then all digits, complete or truncated near
/// the limits of the fast paths, or with one digit more.
fn halfway() -> impl Strategy<Value = String> {
    (1_u64 << 53..1 << 54, -30_i32..30, 0_usize..60, 0..3).prop_map(|(bits, power, keep, edit)| {
        let middle = (bits | 1) as u128;
        let mut text = if power < 0 {
            // middle · 2^power = middle · 5^−power / 10^−power
            let places = (-power) as usize;
            let digits = decimal_product(middle, 5, places);
            let digits = format!("{digits:0>width$}", width = places + 1);
            let (whole, fraction) = digits.split_at(digits.len() - places);
            format!("{whole}.{fraction}")
        } else {
            decimal_product(middle, 2, power as usize)
        };
        match edit {
            0 => text.truncate(text.len().min(keep.max(1))),
            1 if text.contains('.') => text.push('1'),
            _ => {}
        }
        text
    })
}

/// `number · factor^times` in decimal digits.
fn decimal_product(number: u128, factor: u8, times: usize) -> String {
    let mut digits: Vec<u8> = number.to_string().bytes().rev().map(|b| b - b'0').collect();
    for _ in 0..times {
        let mut carry = 0;
        for digit in &mut digits {
            let product = *digit * factor + carry;
            *digit = product % 10;
            carry = product / 10;
        }
        if carry > 0 {
            digits.push(carry);
        }
    }
    digits.iter().rev().map(|d| char::from(d + b'0')).collect()
}

proptest! {
    #[test]
    fn same_as_std(text in numbers()) {
        check(&text);
    }

    #[test]
    fn same_as_std_halfway(text in halfway()) {
        check(&text);
    }

    #[test]
    fn every_value_round_trips(bits: u64, precision in 0_usize..20) {
        let value = f64::from_bits(bits);
        prop_assume!(value.is_finite());
        check(&format!("{value:e}"));
        check(&format!("{value}"));
        check(&format!("{value:.precision$e}"));
    }

    #[test]
    fn readings_round_trip(value in -40_000.0..40_000.0, precision in 0_usize..20) {
        check(&format!("{value}"));
        check(&format!("{value:.precision$}"));
    }

    #[test]
    fn decimal_comma_is_the_same_number(text in numbers()) {
        let comma = text.replace('.', ",");
        prop_assert_eq!(
            parse_field_decimal_comma(comma.as_bytes()).map(f64::to_bits),
            parse_field(text.as_bytes()).map(f64::to_bits)
        );
    }

    #[test]
    fn any_bytes_are_accepted_without_panic(bytes: Vec<u8>) {
        if let Some((_, used)) = scan_number(&bytes) {
            prop_assert!(used > 0 && used <= bytes.len());
        }
        let _ = parse_field(&bytes);
        let _ = parse_field_decimal_comma(&bytes);
    }
}
