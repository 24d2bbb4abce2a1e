//! What several commands share.

use gravical::escape::shell_word;
pub use gravical::gravity::GravityOptions as GravityArgs;
use gravical::recording::ReadOptions;
use gravical::{Error, Result};

use crate::{progress, words};

/// The options of reading, with progress; `hash`: the files are named in a result.
pub fn reading(options: &ReadOptions, hash: bool) -> ReadOptions {
    ReadOptions {
        hash,
        meter: Some(progress::meter()),
        ..options.clone()
    }
}

/// Parses a number of this range.
pub fn number(min: f64, max: f64) -> impl Fn(&str) -> Result<f64> + Clone {
    move |text: &str| {
        let value = text.parse().ok();
        let value = value.filter(|value| (min..=max).contains(value));
        value.ok_or_else(|| {
            let text = format!("{text} is no number from {min} to {max}");
            Error::usage("option-range", text)
        })
    }
}

/// The command line as typed, with the plain name of the program.
pub fn command_line() -> String {
    let words = words::all().iter().skip(1);
    words.fold("gravical".to_owned(), |line, word| {
        line + " " + &shell_word(&word.to_string_lossy())
    })
}
