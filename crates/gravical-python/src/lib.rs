//! The native part of the Python package `gravical`: keywords in, arrays and JSON out. What a
//! Python user reads, signatures, docstrings and results, is Python, in `python/gravical`.

mod error;
mod keywords;
mod motion;
mod outcome;
mod recording;
mod task;
mod verbs;

use pyo3::prelude::*;

/// The module `gravical._gravical`.
#[pymodule]
mod _gravical {
    #[pymodule_export]
    use crate::motion::{Stepper, motion};
    #[pymodule_export]
    use crate::outcome::{Outcome, export_targets, read_calibration};
    #[pymodule_export]
    use crate::recording::{Recording, read, write_text};
    #[pymodule_export]
    use crate::verbs::{apply, calibrate, check, compare, denoise, inspect, noise, simulate};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
