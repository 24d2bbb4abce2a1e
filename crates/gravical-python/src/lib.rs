//! The native part of the Python package `gravical`: arguments in, arrays and JSON out. What a
//! Python user reads, signatures, docstrings and results, is Python, in `python/gravical`.

mod arrays;
mod calibration;
mod error;
mod motion;
mod options;
mod outcome;
mod recording;
mod task;
mod verbs;

use pyo3::prelude::*;

/// The module `gravical._gravical`.
#[pymodule]
mod _gravical {
    #[pymodule_export]
    use crate::arrays::{allan_deviation, filter_channels, noise_of_channel};
    #[pymodule_export]
    use crate::calibration::{Calibration, calibrate_paths, calibrate_recordings, export_targets};
    #[pymodule_export]
    use crate::motion::{Stepper, motion};
    #[pymodule_export]
    use crate::outcome::Outcome;
    #[pymodule_export]
    use crate::recording::{Recording, read, read_bytes, write_text};
    #[pymodule_export]
    use crate::verbs::{
        apply_file, apply_recording, check_paths, check_recordings, compare, denoise_file,
        denoise_recording, inspect_path, inspect_recording, noise_path, noise_recording, simulate,
    };

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
