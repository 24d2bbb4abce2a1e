//! How the numbers of a line are written: between separators, or each behind its name.

use gravical::recording::names::{Quantity, bare_axis, understand};
use gravical::recording::row::Delimiter;
use gravical::recording::units::is_unit;

use super::item::Reason;

/// Numbers of a row: fewer are messages of a sketch, more are no IMU.
pub const FIELDS: std::ops::RangeInclusive<usize> = 3..=32;

/// Separators in the order in which they are tried.
const DELIMITERS: [Delimiter; 4] = [
    Delimiter::Byte(b','),
    Delimiter::Byte(b';'),
    Delimiter::Byte(b'\t'),
    Delimiter::Whitespace,
];

/// How the numbers of a line are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Form {
    /// Numbers between separators.
    Plain {
        /// What separates them.
        delimiter: Delimiter,
        /// How many there are.
        fields: usize,
    },
    /// `ax: 0.1 ay: 0.2` (`=` likewise): the text before each number, and behind the last.
    Named(Vec<String>),
}

/// The numbers of a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers {
    /// The line for the file: as it arrived, or the numbers alone where they had names.
    pub line: Vec<u8>,
    /// All of them, finite.
    pub values: Vec<f64>,
}

impl Form {
    /// The form of a line.
    ///
    /// # Errors
    ///
    /// Why the line is no row of any form.
    pub fn of(text: &[u8]) -> Result<Self, Reason> {
        if let Some((texts, _)) = named(text) {
            return Ok(Form::Named(texts));
        }
        let mut reason = Reason::FieldCount;
        for delimiter in DELIMITERS {
            let fields = split(text, delimiter).len();
            if !FIELDS.contains(&fields) {
                continue;
            }
            let form = Form::Plain { delimiter, fields };
            match form.numbers(text) {
                Ok(_) => return Ok(form),
                // Words are no row with a bad number.
                Err(_) if !text.iter().any(u8::is_ascii_digit) && !has_nan(text) => {}
                Err(why) => reason = why,
            }
        }
        Err(reason)
    }

    /// The numbers of a line of this form.
    ///
    /// # Errors
    ///
    /// Why the line has another form.
    pub fn numbers(&self, text: &[u8]) -> Result<Numbers, Reason> {
        match self {
            Form::Plain { delimiter, fields } => {
                let parts = split(text, *delimiter);
                if parts.len() != *fields {
                    return Err(Reason::FieldCount);
                }
                let values: Option<Vec<f64>> = parts.iter().map(|part| number(part)).collect();
                let values = values.ok_or(Reason::NotANumber)?;
                let line = without_last_delimiter(text, *delimiter).to_vec();
                Ok(Numbers { line, values })
            }
            Form::Named(texts) => {
                let (own, numbers) = named(text).ok_or(Reason::FieldCount)?;
                if own != *texts {
                    return Err(Reason::FieldCount);
                }
                let values: Option<Vec<f64>> = numbers.iter().map(|n| number(n)).collect();
                let values = values.ok_or(Reason::NotANumber)?;
                let line = numbers.join(&b","[..]);
                Ok(Numbers { line, values })
            }
        }
    }

    /// Numbers of a row.
    pub fn fields(&self) -> usize {
        match self {
            Form::Plain { fields, .. } => *fields,
            Form::Named(texts) => texts.len().saturating_sub(1),
        }
    }

    /// What separates the columns of the file.
    pub fn separator(&self) -> u8 {
        match self {
            Form::Plain {
                delimiter: Delimiter::Byte(byte),
                ..
            } => *byte,
            Form::Plain { .. } => b' ',
            Form::Named(_) => b',',
        }
    }

    /// The names of the columns with their units, where each number has its name.
    pub fn names(&self) -> Option<Vec<String>> {
        let Form::Named(texts) = self else {
            return None;
        };
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
        Some(names.into_iter().zip(units).map(with_unit).collect())
    }
}

/// The names in a header of a board, and how it is written: at least three fields, all of
/// which begin with a letter.
pub fn header_names(text: &[u8]) -> Option<(Form, Vec<String>)> {
    let is_name = |field: &&[u8]| {
        field.first().is_some_and(u8::is_ascii_alphabetic)
            && !field.iter().any(|b| matches!(b, b':' | b'='))
            && !NO_NAMES.iter().any(|w| is(field, w))
    };
    DELIMITERS.into_iter().find_map(|delimiter| {
        let parts = split(text, delimiter);
        let fields = parts.len();
        if !FIELDS.contains(&fields) || !parts.iter().all(is_name) {
            return None;
        }
        let names = parts
            .iter()
            .map(|part| gravical::recording::dialect::decode(part))
            .collect();
        Some((Form::Plain { delimiter, fields }, names))
    })
}

/// What boards print in place of a number.
const NO_NAMES: [&[u8]; 3] = [b"nan", b"inf", b"ovf"];

fn is(field: &[u8], word: &[u8]) -> bool {
    field.eq_ignore_ascii_case(word)
}

fn has_nan(text: &[u8]) -> bool {
    let words = text.split(|b| !b.is_ascii_alphabetic());
    words.clone().any(|w| NO_NAMES.iter().any(|n| is(w, n)))
}

/// The fields of a line; a separator behind the last one makes no further field.
fn split(text: &[u8], delimiter: Delimiter) -> Vec<&[u8]> {
    match delimiter {
        Delimiter::Whitespace => text
            .split(u8::is_ascii_whitespace)
            .filter(|part| !part.is_empty())
            .collect(),
        Delimiter::Byte(byte) => without_last_delimiter(text, delimiter)
            .split(|b| *b == byte)
            .map(<[u8]>::trim_ascii)
            .collect(),
    }
}

fn without_last_delimiter(text: &[u8], delimiter: Delimiter) -> &[u8] {
    match (delimiter, text.trim_ascii_end()) {
        (Delimiter::Byte(byte), [rest @ .., last]) if *last == byte => rest,
        _ => text,
    }
}

fn number(field: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// The texts around the numbers of a line in which each number follows a name with `:` or
/// `=`, and the numbers as they are written (`nan` too); none for any other line.
fn named(text: &[u8]) -> Option<(Vec<String>, Vec<&[u8]>)> {
    let mut texts = Vec::new();
    let mut numbers = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.iter().position(|b| matches!(b, b':' | b'=')) {
        let (name, behind) = rest.split_at(at + 1);
        if !name.iter().any(u8::is_ascii_alphabetic) {
            return None;
        }
        let behind = behind.trim_ascii_start();
        let end = number_length(behind)?;
        texts.push(squeezed(name));
        let (digits, after) = behind.split_at(end);
        numbers.push(digits);
        rest = after;
    }
    texts.push(squeezed(rest));
    FIELDS.contains(&numbers.len()).then_some((texts, numbers))
}

/// Length of the number that the text begins with.
fn number_length(text: &[u8]) -> Option<usize> {
    let word = text.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    if has_nan(text.get(..word)?) {
        return Some(word);
    }
    let mut end = 0;
    for (i, byte) in text.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|i| text.get(i));
        let after = text.get(i + 1);
        let belongs = match byte {
            b'0'..=b'9' | b'.' => true,
            b'+' | b'-' => matches!(before, None | Some(b'e' | b'E')),
            b'e' | b'E' => {
                before.is_some_and(u8::is_ascii_digit)
                    && after.is_some_and(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-'))
            }
            _ => false,
        };
        if !belongs {
            break;
        }
        end = i + 1;
    }
    let digits = text.get(..end)?.iter().any(u8::is_ascii_digit);
    digits.then_some(end)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<(Form, Numbers), Reason> {
        let form = Form::of(text.as_bytes())?;
        let numbers = form.numbers(text.as_bytes())?;
        Ok((form, numbers))
    }

    #[test]
    fn separators_and_counts_of_plain_rows() {
        for (text, byte, fields) in [
            ("0.1,-0.2,9.81", b',', 3),
            ("16;0.1;.2;-9.", b';', 4),
            ("1\t2\t3\t4\t5\t6", b'\t', 6),
            ("1   2.5 -3e-2", b' ', 3),
            ("1, 2, 3, 4, 5, 6, 7", b',', 7),
            ("1,\t2,\t3", b',', 3),
        ] {
            let (form, numbers) = of(text).unwrap();
            assert_eq!((form.separator(), form.fields()), (byte, fields), "{text}");
            assert_eq!(numbers.line, text.as_bytes());
            assert_eq!(form.names(), None);
        }
        // A separator behind the last number is left out.
        assert_eq!(of("1,2,3,").unwrap().1.line, b"1,2,3");
        let most = vec!["1"; 32].join(",");
        assert_eq!(of(&most).unwrap().0.fields(), 32);
        for (text, reason) in [
            ("1,2", Reason::FieldCount),
            (&*format!("{most},1"), Reason::FieldCount),
            ("garbage", Reason::FieldCount),
            ("Hello, world, again", Reason::FieldCount),
            ("1,2,3,nan", Reason::NotANumber),
            ("1,2,3,1e999", Reason::NotANumber),
            ("1,2,,4", Reason::NotANumber),
            ("1,2,4.1.2", Reason::NotANumber),
            ("nan,nan,nan", Reason::NotANumber),
        ] {
            assert_eq!(of(text).map(|_| ()), Err(reason), "{text}");
        }
    }

    #[test]
    fn names_and_units_of_numbers() {
        for (text, names, line) in [
            ("x:0.1 y:0.2 z:9.8", "x,y,z", "0.1,0.2,9.8"),
            ("ax:0.1,ay:-1,az:9.8", "ax,ay,az", "0.1,-1,9.8"),
            (
                "X: 0.1\tY: 2e-3\tZ: 9.8\tm/s^2",
                "X (m/s^2),Y (m/s^2),Z (m/s^2)",
                "0.1,2e-3,9.8",
            ),
            (
                "Acceleration X: 0.1, Y: 0.2, Z: 9.8 m/s^2",
                "Acceleration X (m/s^2),Acceleration Y (m/s^2),Acceleration Z (m/s^2)",
                "0.1,0.2,9.8",
            ),
            (
                "AccX=1 g AccY=2 g AccZ=3 g T=25.5C",
                "AccX (g),AccY (g),AccZ (g),T (C)",
                "1,2,3,25.5",
            ),
            (
                "Gyro x: 1 y: 2 z: 3 deg/s  Accel x:  4 y:  5 z:  6 g",
                "Gyro x (deg/s),Gyro y (deg/s),Gyro z (deg/s),Accel x (g),Accel y (g),Accel z (g)",
                "1,2,3,4,5,6",
            ),
            (
                "temp: 25 \u{b0}C, ax: 1, ay: 2, az: 3",
                "temp (\u{b0}C),ax,ay,az",
                "25,1,2,3",
            ),
        ] {
            let (form, numbers) = of(text).unwrap();
            assert_eq!(form.names().unwrap().join(","), names, "{text}");
            assert_eq!(String::from_utf8(numbers.line).unwrap(), line);
        }
        let (form, _) = of("x:0.1 y:0.2 z:9.8").unwrap();
        // Padding does not matter, names do.
        assert!(form.numbers(b"x:  1.1 y: 0.2 z:   -9.8").is_ok());
        for (text, reason) in [
            ("x:0.1 y:0.2 w:9.8", Reason::FieldCount),
            ("x:0.1 y:0.2", Reason::FieldCount),
            ("x:0.1 y:nan z:9.8", Reason::NotANumber),
            ("0.1,0.2,9.8", Reason::FieldCount),
        ] {
            assert_eq!(form.numbers(text.as_bytes()), Err(reason), "{text}");
        }
        assert!(of("rate: 100 Hz").is_err() && of("10:20:30").is_err());
    }

    #[test]
    fn headers_have_names_only() {
        let names = |text: &str| header_names(text.as_bytes()).map(|(_, names)| names.join("|"));
        assert_eq!(names("t,ax,ay,az").unwrap(), "t|ax|ay|az");
        assert_eq!(
            names("aX (g)\taY (g)\taZ (g)").unwrap(),
            "aX (g)|aY (g)|aZ (g)"
        );
        assert_eq!(names("ax ay az").unwrap(), "ax|ay|az");
        let latin_1 = b"aX (g),aY,aZ,gX (\xb0/s),gY,gZ";
        assert_eq!(header_names(latin_1).unwrap().1[3], "gX (\u{b0}/s)");
        for text in ["1,2,3", "nan,nan,nan", "a,b", "ax,1,2", "", "a,,c"] {
            assert_eq!(names(text), None, "{text}");
        }
    }
}
