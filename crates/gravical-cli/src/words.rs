//! The words of the command line: in Python they are not those of the process.

use std::ffi::OsString;
use std::sync::OnceLock;

static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Once, before all else.
pub fn set(words: Vec<OsString>) {
    let _ = WORDS.set(words);
}

/// The name of the program and its arguments.
pub fn all() -> &'static [OsString] {
    WORDS.get().map_or(&[], Vec::as_slice)
}
