//! Work beside the interpreter: other Python threads go on, and Ctrl-C ends the work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use gravical::recording::Meter;
use pyo3::prelude::*;

use crate::error::{panicked, raised};

/// How often signals are looked at.
const SIGNAL_PERIOD: Duration = Duration::from_millis(50);

/// Time that stopped work has to end. Readers and `motion` end within a fraction of it; other work is left to
/// finish on its own.
const PATIENCE: Duration = Duration::from_secs(2);

/// Runs `work` in a thread of its own. After Ctrl-C the meter stops what is read, and a motion that
/// has it, and the thread ends. Work without the meter that takes longer than [`PATIENCE`] goes on
/// to its end, and its result is dropped.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Meter) -> gravical::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (caller, is_done) = (thread::current(), Arc::new(AtomicBool::new(false)));
    let meter = Meter::default();
    let (done, own_meter) = (is_done.clone(), meter.clone());
    let thread = thread::Builder::new()
        .name("gravical".to_owned())
        // That of a main thread.
        .stack_size(8 << 20)
        .spawn(move || {
            let result = work(&own_meter);
            done.store(true, Ordering::Release);
            caller.unpark();
            result
        })?;
    // A panic is no end of the work, but one of the thread.
    let has_ended = || is_done.load(Ordering::Acquire) || thread.is_finished();
    let mut stopped: Option<(PyErr, Instant)> = None;
    let has_waited = |(_, since): &(PyErr, Instant)| since.elapsed() > PATIENCE;
    while !(has_ended() || stopped.as_ref().is_some_and(has_waited)) {
        py.detach(|| thread::park_timeout(SIGNAL_PERIOD));
        if let Err(signal) = py.check_signals() {
            meter.stop();
            stopped.get_or_insert((signal, Instant::now()));
        }
    }
    if let Some((signal, _)) = stopped {
        if has_ended() {
            let _ = py.detach(|| thread.join());
        }
        return Err(signal);
    }
    // The allocator gives the memory of a thread that has ended to the next one.
    match py.detach(|| thread.join()) {
        Ok(result) => result.map_err(|e| raised(py, &e)),
        Err(panic) => Err(panicked(panic.as_ref())),
    }
}
