//! Templates: the text of a program or a file of parameters with names in place of its numbers.

use std::collections::BTreeMap;

/// What the names in a template stand for.
pub(super) struct Values {
    texts: BTreeMap<String, String>,
    write: fn(f64) -> String,
}

impl Values {
    /// No values yet; `write` writes numbers.
    pub fn new(write: fn(f64) -> String) -> Self {
        let texts = BTreeMap::new();
        Values { texts, write }
    }

    pub fn text(&mut self, key: &str, text: impl Into<String>) {
        self.texts.insert(key.to_owned(), text.into());
    }

    /// Elements as `key0`, `key1`, `key2`.
    pub fn vector(&mut self, key: &str, vector: &[f64; 3]) {
        for (i, value) in vector.iter().enumerate() {
            self.text(&format!("{key}{i}"), (self.write)(*value));
        }
    }

    /// Elements as `key00` to `key22`.
    pub fn matrix(&mut self, key: &str, matrix: &[[f64; 3]; 3]) {
        for (i, row) in matrix.iter().enumerate() {
            self.vector(&format!("{key}{i}"), row);
        }
    }

    /// `+key` and `-key` are a term of a sum: the sign, a space and the magnitude.
    fn look_up(&self, key: &str) -> String {
        let value = |key: &str| self.texts.get(key).map_or("", String::as_str);
        match (key.strip_prefix('+'), key.strip_prefix('-')) {
            (Some(added), _) => term(value(added), "+", "-"),
            (_, Some(subtracted)) => term(value(subtracted), "-", "+"),
            _ => value(key).to_owned(),
        }
    }
}

fn term(number: &str, positive: &str, negative: &str) -> String {
    match number.strip_prefix('-') {
        Some(magnitude) => format!("{negative} {magnitude}"),
        None => format!("{positive} {number}"),
    }
}

/// Replaces each `$key$`. Lines from `$if key$` to `$end$` are left out where `key` has no value;
/// a line with `$about$` is repeated for each of its lines.
pub(super) fn fill_template(template: &str, values: &Values) -> String {
    let mut text = String::new();
    let mut is_left_out = false;
    for line in template.lines() {
        let condition = line.strip_prefix("$if ").and_then(|l| l.strip_suffix('$'));
        if let Some(key) = condition {
            is_left_out = !values.texts.contains_key(key);
        } else if line == "$end$" {
            is_left_out = false;
        } else if let Some((before, after)) = line.split_once("$about$") {
            for about in values.look_up("about").lines() {
                text += &format!("{before}{about}{after}\n");
            }
        } else if !is_left_out {
            for (i, part) in line.split('$').enumerate() {
                let is_key = i % 2 == 1;
                text += &if is_key {
                    values.look_up(part)
                } else {
                    part.to_owned()
                };
            }
            text.push('\n');
        }
    }
    text
}

/// Nine significant digits, which reproduce an `f32`. Exponents have a sign: YAML 1.1 takes one
/// without for text.
pub(super) fn nine_digits(value: f64) -> String {
    let text = format!("{value:.8e}");
    match text.split_once('e') {
        Some((digits, exponent)) if !exponent.starts_with('-') => format!("{digits}e+{exponent}"),
        _ => text,
    }
}
