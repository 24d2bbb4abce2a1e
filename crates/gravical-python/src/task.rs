//! Work beside the interpreter: other Python threads go on, and Ctrl-C ends the work.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use gravical::recording::Meter;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::{OrRaise, panicked};

/// How often signals are looked at.
const EVERY: Duration = Duration::from_millis(50);

/// How long it is waited for work that was stopped: what is read and a motion end within a fraction
/// of that, and nobody wants to wait for the rest.
const PATIENCE: Duration = Duration::from_secs(2);

/// Runs `work` in a thread of its own. After Ctrl-C the meter stops what is read, and a motion that
/// has it, and the thread ends. Work without the meter that takes longer than [`PATIENCE`] goes on
/// to its end, and its result is dropped.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    meter: &Meter,
    work: impl FnOnce() -> gravical::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    let thread = std::thread::Builder::new()
        .name("gravical".to_owned())
        // That of a main thread.
        .stack_size(8 << 20)
        .spawn(move || {
            // The receiver is gone after Ctrl-C.
            let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
        })?;
    let receiver = std::sync::Mutex::new(receiver);
    loop {
        // A receiver may not be shared between threads, and none is.
        let wait = |time| receiver.lock().ok().map(|r| r.recv_timeout(time));
        match py.detach(|| wait(EVERY)) {
            Some(Ok(done)) => {
                // The allocator gives the memory of a thread that has ended to the next one.
                let _ = py.detach(|| thread.join());
                return match done {
                    Ok(result) => result.or_raise(py),
                    Err(panic) => Err(panicked(panic.as_ref())),
                };
            }
            Some(Err(RecvTimeoutError::Timeout)) => {
                if let Err(signal) = py.check_signals() {
                    meter.stop();
                    py.detach(|| {
                        if let Some(Ok(_)) = wait(PATIENCE) {
                            let _ = thread.join();
                        }
                    });
                    return Err(signal);
                }
            }
            Some(Err(RecvTimeoutError::Disconnected)) | None => {
                return Err(PyRuntimeError::new_err("gravical failed internally"));
            }
        }
    }
}
