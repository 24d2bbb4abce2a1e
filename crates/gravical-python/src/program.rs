//! The program `gravical`, for the script of the wheel.

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

/// Runs the program with these words, the first of which is its name; its exit code.
#[pyfunction]
pub fn program(py: Python<'_>, words: Vec<OsString>) -> Option<u8> {
    let code = py.detach(|| gravical_cli::run(words));
    // An exit code can be compared, not read.
    (0..=u8::MAX).find(|number| code == ExitCode::from(*number))
}
