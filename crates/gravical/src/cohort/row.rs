//! What is said of an item: one row.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::escape::path_text;
use crate::finding::{Finding, Severity};

/// Between reasons, which have semicolons of their own.
pub const SEPARATOR: &str = " / ";

/// What a command made of an item.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome<V> {
    /// The verdict as it is printed.
    pub verdict: String,
    /// Whether it failed its quality gate.
    pub is_poor: bool,
    /// Reasons of the verdict, the main one first.
    pub reasons: Vec<String>,
    /// What was measured.
    pub values: V,
}

/// The row of an item: common to all commands, and `values` of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row<V> {
    /// Name of the item.
    pub name: String,
    /// Its path as given.
    pub path: String,
    /// In one word.
    pub status: Status,
    /// The verdict of the command; null without a result.
    pub verdict: Option<String>,
    /// Why: reasons of the verdict, or the message of the error.
    pub reason: Option<String>,
    /// Code of the error.
    pub error_code: Option<String>,
    /// What to do about it.
    pub hint: Option<String>,
    /// Name of an item before this one with the same content.
    pub same_content_as: Option<String>,
    /// File of the result.
    pub result: Option<String>,
    /// SHA-256 of the content; null if it could not be read.
    pub sha256: Option<String>,
    /// What the command measured; absent without a result. Some field of it is always there.
    #[serde(flatten)]
    pub values: Option<V>,
}

/// What became of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// A result that can be used: the command alone would end with 0.
    Done,
    /// A result that failed its quality gate: 4.
    Poor,
    /// No result.
    Error,
}

/// Values of a command, as columns of a table.
pub trait Columns: Serialize + DeserializeOwned + Send {
    /// The fields, in order; none of them is nested.
    const NAMES: &'static [&'static str];
}

/// The kinds of the warnings among `findings`, each once.
pub fn kinds(findings: &[Finding]) -> String {
    let warnings = findings.iter().filter(|f| f.severity == Severity::Warning);
    let mut kinds: Vec<String> = warnings.map(|f| f.kind.to_string()).collect();
    kinds.sort();
    kinds.dedup();
    kinds.join(" ")
}

/// The columns that all commands have, in front of their own.
pub const COMMON: [&str; 10] = [
    "name",
    "path",
    "status",
    "verdict",
    "reason",
    "error_code",
    "hint",
    "same_content_as",
    "result",
    "sha256",
];

impl<V> Row<V> {
    /// The row of an item of which nothing else is known.
    #[must_use]
    pub fn of(name: &str, status: Status) -> Self {
        Row {
            name: name.to_owned(),
            path: String::new(),
            status,
            verdict: None,
            reason: None,
            error_code: None,
            hint: None,
            same_content_as: None,
            result: None,
            sha256: None,
            values: None,
        }
    }

    /// The item has this outcome, in the file `result`.
    pub fn measured(&mut self, outcome: Outcome<V>, result: Option<&Path>) {
        self.status = match outcome.is_poor {
            true => Status::Poor,
            false => Status::Done,
        };
        self.verdict = Some(outcome.verdict);
        self.reason = Some(outcome.reasons.join(SEPARATOR)).filter(|r| !r.is_empty());
        self.result = result.map(path_text);
        self.values = Some(outcome.values);
    }

    /// The item has no result, for this reason.
    pub fn failed(&mut self, code: &str, message: &str, hint: Option<&str>) {
        self.status = Status::Error;
        self.error_code = Some(code.to_owned());
        self.reason = Some(message.to_owned());
        self.hint = hint.map(str::to_owned);
    }
}

impl<V: Serialize> Row<V> {
    /// The fields of a table with these columns; empty where nothing is known.
    ///
    /// # Errors
    ///
    /// Those of serde, which a row does not cause.
    pub fn fields(&self, columns: &[&str]) -> serde_json::Result<Vec<String>> {
        let row = serde_json::to_value(self)?;
        let field = |name: &&str| match row.get(name) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        };
        Ok(columns.iter().map(field).collect())
    }
}

/// The columns of a table: the common ones, then `own`.
#[must_use]
pub fn columns(own: &[&'static str]) -> Vec<&'static str> {
    [&COMMON[..], own].concat()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct Length {
        pub length_m: f64,
    }

    impl Columns for Length {
        const NAMES: &'static [&'static str] = &["length_m"];
    }

    pub fn row(name: &str, length_m: Option<f64>) -> Row<Length> {
        Row {
            path: format!("in/{name}.csv"),
            verdict: Some("good".to_owned()),
            sha256: Some("00".to_owned()),
            values: length_m.map(|length_m| Length { length_m }),
            ..Row::of(name, Status::Done)
        }
    }

    #[test]
    fn columns_are_the_fields() {
        let one = row("a", Some(0.5));
        let value = serde_json::to_value(&one).unwrap();
        let mut fields: Vec<&str> = value
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let columns = columns(Length::NAMES);
        let mut sorted = columns.clone();
        fields.sort_unstable();
        sorted.sort_unstable();
        assert_eq!(fields, sorted);
        assert_eq!(one.fields(&columns).unwrap()[10], "0.5");
        assert_eq!(one.fields(&columns).unwrap()[4], "");
        // As the journal reads it, with and without values.
        for row in [one, row("b", None)] {
            let text = serde_json::to_string(&row).unwrap();
            assert_eq!(serde_json::from_str::<Row<Length>>(&text).unwrap(), row);
        }
    }
}
