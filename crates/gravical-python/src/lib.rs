//! The native part of the Python package `gravical`: keywords in, arrays and JSON out. What a
//! Python user reads, signatures, docstrings and results, is Python, in `python/gravical`.

mod error;
mod keywords;
mod outcome;
mod program;
mod recording;
mod task;
mod verbs;

use pyo3::prelude::*;

/// The module `gravical._gravical`.
#[pymodule]
mod _gravical {
    #[pymodule_export]
    use crate::outcome::{Outcome, export_targets, read_calibration, write_text};
    #[pymodule_export]
    use crate::program::program;
    #[pymodule_export]
    use crate::recording::{Recording, read};
    #[pymodule_export]
    use crate::verbs::{run, simulate};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let reading = crate::keywords::fields::<gravical::recording::ReadOptions>();
        module.add("READING", reading.to_vec())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
