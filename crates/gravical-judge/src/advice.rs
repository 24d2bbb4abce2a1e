//! Options that a message advises, as data: each surface words them, as flags or as keywords.

use std::fmt;

use serde::{Deserialize, Serialize};

/// An option that helps, or that is better left out, as the message says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Advice {
    /// The option, by its name in Python: `accel_unit`; `--accel-unit` of the program.
    pub name: String,
    /// The value, as text: `mg`, `true` of a switch; empty if the user knows it.
    pub value: String,
}

impl Advice {
    /// An option with its value.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Advice {
            name: name.into(),
            value: value.into(),
        }
    }
}

/// `accel_unit = mg`, or the name alone.
impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.value.as_str() {
            "" => f.write_str(&self.name),
            value => write!(f, "{} = {value}", self.name),
        }
    }
}

/// The text, with the options behind it in parentheses, each in the words of a surface.
pub fn with_options(text: &str, options: &[Advice], word: impl Fn(&Advice) -> String) -> String {
    if options.is_empty() {
        return text.to_owned();
    }
    let words: Vec<String> = options.iter().map(word).collect();
    format!("{text} ({})", words.join(", "))
}
