//! Numbers as text, with significant digits. A minus is a hyphen here; pages use the
//! typographic sign.

/// Decimals that show `uncertainty` with two digits, 0 to 6.
pub fn decimals_for(uncertainty: f64) -> usize {
    if !(uncertainty.is_finite() && uncertainty > 0.0) {
        return 6;
    }
    (1.0 - uncertainty.log10().floor()).clamp(0.0, 6.0) as usize
}

/// Decimals that show `value` with `digits` significant digits, 0 to 6.
pub fn decimals_of(value: f64, digits: i32) -> usize {
    let magnitude = value.abs().max(1e-9).log10().floor() as i32;
    (digits - 1 - magnitude).clamp(0, 6) as usize
}

/// `value` with `decimals`; no sign if it rounds to zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if is_zero(size) => size.to_owned(),
        _ => text,
    }
}

/// The same, with a plus sign for positive values.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if value > 0.0 && value.is_finite() && !is_zero(&text) {
        return format!("+{text}");
    }
    text
}

fn is_zero(text: &str) -> bool {
    !text.bytes().any(|b| matches!(b, b'1'..=b'9'))
}

/// `value` with this number of significant digits.
pub fn digits(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    fixed(value, decimals_of(value, digits))
}

/// As [`digits`], with a power of ten for values of which six decimals would not show the digits.
pub fn small(value: f64, count: i32) -> String {
    let limit = 10_f64.powi(count - 8).max(1e-4);
    if value != 0.0 && value.is_finite() && value.abs() < limit {
        let precision = usize::try_from(count - 1).unwrap_or(0);
        return format!("{value:.precision$e}");
    }
    digits(value, count)
}

/// m/s² in mg: 1 mg is a thousandth of 9.80665 m/s².
pub fn milli_g(mps2: f64) -> f64 {
    1000.0 * mps2 / gravical_core::unit::STANDARD_GRAVITY_MPS2
}

/// m/s² as mg with two digits.
pub fn mg(mps2: f64) -> String {
    let mg = milli_g(mps2);
    if mg != 0.0 && mg.abs() < 0.001 {
        return "< 0.001".to_owned();
    }
    digits(mg, 2)
}

/// A duration with two or three digits: `45 s`, `12 min`, `2.5 h`, `3.1 d`.
pub fn duration_text(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 120.0 => (s, "s"),
        s if s < 5400.0 => (s / 60.0, "min"),
        s if s < 48.0 * 3600.0 => (s / 3600.0, "h"),
        s => (s / 86400.0, "d"),
    };
    match value {
        v if v < 9.95 => format!("{v:.1} {unit}"),
        v => format!("{v:.0} {unit}"),
    }
}

/// A unit as printed; files and options have `m/s^2`.
pub fn unit(name: &str) -> String {
    match name {
        "deg" => "°".to_owned(),
        "deg/s" => "°/s".to_owned(),
        "unknown" => "unit of the file".to_owned(),
        _ => name.replace("m/s^2", "m/s²"),
    }
}

/// Coverage factor of every ± that people read: 95 % (JCGM 100:2008, 6.2).
pub const COVERAGE: f64 = 2.0;

/// The name of a value of an enum, as in JSON.
pub fn name(value: &impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

/// The same in words, with spaces.
pub fn words(value: &impl serde::Serialize) -> String {
    name(value).replace('-', " ")
}

/// A number of things: `1 pose`, `2 poses`.
pub fn count(n: impl std::fmt::Display, word: &str) -> String {
    let n = n.to_string();
    let ending = if n == "1" { "" } else { "s" };
    format!("{n} {word}{ending}")
}
