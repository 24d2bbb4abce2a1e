//! Errors for options out of their range.

use crate::{Error, Result};

pub(super) fn bad(message: impl Into<String>) -> Error {
    Error::usage("simulate-option", message)
        .with_hint("`gravical simulate --help` explains the options")
}

/// Refuses values outside `low..=high`, including NaN.
pub(super) fn within(name: &str, value: f64, low: f64, high: f64, unit: &str) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let value = format!("{value} {unit}");
    Err(bad(format!(
        "{name} is {}; it has to be between {low} and {high}",
        value.trim_end()
    )))
}
