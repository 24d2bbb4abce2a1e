//! Errors of the library as exceptions of the package.

use gravical::finding::Advice;
use gravical::{Category, Error};
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::prelude::*;

/// Code of a keyword that does not exist: an exception of Python itself.
pub const UNEXPECTED: &str = "unexpected-keyword";

/// The option as a keyword argument: `accel_unit="mg"`.
fn keyword(option: &Advice) -> String {
    let value = match option.value.as_str() {
        "true" | "on" => "True".to_owned(),
        "off" => "False".to_owned(),
        value if value.is_empty() || value.parse::<f64>().is_ok() => value.to_owned(),
        text => format!("{text:?}"),
    };
    format!("{}={value}", option.name)
}

/// The exception for an error, of a class of `_errors.py`.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    if error.code() == UNEXPECTED {
        return PyTypeError::new_err(error.message().to_owned());
    }
    let class = match (error.code(), error.category()) {
        ("not-found", _) => "NotFoundError",
        ("exists", _) => "ExistsError",
        (_, Category::Usage) => "UsageError",
        (_, Category::Input) => "InputError",
        (_, Category::System) => "MachineError",
        (_, Category::Device) => "Error",
    };
    let place = error.location();
    let arguments = (
        error.worded(keyword),
        error.code(),
        error.worded_hint(keyword),
        place.map(|p| p.path.display().to_string()),
        place.and_then(|p| p.line),
        place.and_then(|p| p.column),
    );
    let module = py.import("gravical._errors");
    match module.and_then(|module| module.call_method1(class, arguments)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// A panic is a fault of this package, and no reason to end the interpreter.
pub fn panicked(panic: &(dyn std::any::Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    PyRuntimeError::new_err(format!(
        "gravical failed internally: {}; please report it with what it was called with",
        text.unwrap_or("unknown")
    ))
}
