//! What several commands share.

pub use gravical::gravity::GravityOptions as GravityArgs;
use gravical::recording::ReadOptions;

use crate::progress;

/// The options of reading, with progress; `hash`: the files are named in a result.
pub fn reading(options: &ReadOptions, hash: bool) -> ReadOptions {
    ReadOptions {
        hash,
        meter: Some(progress::meter()),
        ..options.clone()
    }
}

/// For commands whose first argument is the calibration.
pub const SWAPPED: &str = "the arguments are swapped: the calibration comes first";

/// The command line as typed, with the plain name of the program.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| {
        let word = word.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%^°".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            // Quoted for a shell.
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    });
    std::iter::once("gravical".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
