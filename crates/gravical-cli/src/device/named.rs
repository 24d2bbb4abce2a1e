//! Rows in which each number is behind its name, as the Serial Plotter has them and examples of
//! Adafruit: `ax: 0.1 ay: 0.2` (`=` likewise). In a file the names are the header.

use gravical::recording::names::{Quantity, bare_axis, understand};
use gravical::recording::row::is_missing_value;
use gravical::recording::units::is_unit;
use gravical::scan::scan_number;

use super::item::FIELDS;

/// The texts around the numbers of a line in which each number follows a name with `:` or
/// `=`, and the numbers as they are written (`nan` too), separated by commas; none for any other
/// line.
pub fn unnamed(text: &[u8]) -> Option<(Vec<String>, Vec<u8>)> {
    let mut texts = Vec::new();
    let mut numbers = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.iter().position(|b| matches!(b, b':' | b'=')) {
        let (name, behind) = rest.split_at(at + 1);
        if !name.iter().any(u8::is_ascii_alphabetic) {
            return None;
        }
        let behind = behind.trim_ascii_start();
        let (digits, after) = behind.split_at(number_length(behind)?);
        texts.push(squeezed(name));
        numbers.push(digits);
        rest = after;
    }
    texts.push(squeezed(rest));
    let is_row = FIELDS.contains(&numbers.len());
    is_row.then(|| (texts, numbers.join(&b","[..])))
}

/// Length of the number that the text begins with, or of the word that boards print in its place.
fn number_length(text: &[u8]) -> Option<usize> {
    let word = text.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    match is_missing_value(text.get(..word)?) {
        true => Some(word),
        false => scan_number(text).map(|(_, length)| length),
    }
}

/// The names of the columns with their units, from the texts around the numbers.
pub fn column_names(texts: &[String]) -> Vec<String> {
    let mut units = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for (i, text) in texts.iter().enumerate() {
        let (unit, name) = unit_and_name(text, i == 0, i + 1 == texts.len());
        if i > 0 {
            units.push(unit);
        }
        if i + 1 < texts.len() {
            names.push(with_words_of(names.last(), name));
        }
    }
    // `X: 0.1 Y: 0.2 Z: 9.8 m/s^2`: the unit belongs to all three.
    for i in (1..names.len()).rev() {
        if units[i - 1].is_empty() && is_same_sensor(&names[i - 1], &names[i]) {
            units[i - 1] = units[i].clone();
        }
    }
    let with_unit = |(name, unit): (String, String)| match unit.is_empty() {
        true => name,
        false => format!("{name} ({unit})"),
    };
    names.into_iter().zip(units).map(with_unit).collect()
}

/// Text with each run of spaces as one: numbers may be padded.
fn squeezed(text: &[u8]) -> String {
    let text = gravical::recording::dialect::decode(text);
    let mut out = String::new();
    for c in text.trim().chars() {
        if !(c == ' ' && out.ends_with(' ')) {
            out.push(c);
        }
    }
    out
}

/// A text between two numbers is the unit of the first and the name of the second.
fn unit_and_name(text: &str, is_first: bool, is_last: bool) -> (String, String) {
    let text = text.trim_end_matches([':', '=']).trim();
    let separators = [',', ';', '\t', '|'];
    let plain = |part: &str| {
        part.trim_matches(|c: char| c == ' ' || separators.contains(&c))
            .to_owned()
    };
    if is_first || is_last {
        let part = plain(text);
        return match is_first {
            true => (String::new(), part.replace(separators, " ")),
            false => (part, String::new()),
        };
    }
    if let Some((unit, name)) = text.rsplit_once(separators) {
        return (plain(unit), plain(name));
    }
    match text.split_once(' ') {
        Some((unit, name)) if is_unit(unit) => (unit.to_owned(), name.to_owned()),
        _ => (String::new(), text.to_owned()),
    }
}

/// `Y` after `Acceleration X` is `Acceleration Y`.
fn with_words_of(last: Option<&String>, name: String) -> String {
    let prefix = last.and_then(|last| last.trim().rsplit_once(' '));
    match prefix {
        Some((words, axis)) if bare_axis(axis).is_some() && bare_axis(&name).is_some() => {
            format!("{words} {name}")
        }
        _ => name,
    }
}

/// Whether two names are axes of one sensor.
fn is_same_sensor(a: &str, b: &str) -> bool {
    let sensor = |name: &str| match understand(name).map(|c| c.quantity) {
        Some(Quantity::Accel(_)) => Some(0),
        Some(Quantity::Gyro(_)) => Some(1),
        _ => bare_axis(name).map(|_| 2),
    };
    sensor(a).is_some() && sensor(a) == sensor(b)
}
