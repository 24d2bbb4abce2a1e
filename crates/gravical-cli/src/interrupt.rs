//! A signal ends the program after unfinished files were deleted, unless the command has taken over: then the third does.

use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use gravical::output::discard_unfinished;

/// Set by a signal, once a command handles it itself.
static COMMAND_FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Signals so far; a command that does not end by itself is ended by the last.
static SIGNALS: AtomicU32 = AtomicU32::new(0);
const LAST: u32 = 3;

/// Handles the signals that end a program: Ctrl-C, termination, and a terminal that closes.
///
/// # Errors
///
/// The system's.
pub fn watch() -> anyhow::Result<()> {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        // A shell starts what runs in the background with an ignored SIGINT, by which scripts end it all the same.
        let hangup = (!is_ignored(SIGHUP)).then_some(SIGHUP);
        let signals = [SIGINT, SIGTERM].into_iter().chain(hangup);
        let mut signals = signal_hook::iterator::Signals::new(signals)?;
        std::thread::spawn(move || {
            for signal in signals.forever() {
                end(|| {
                    // The shell sees which signal it was.
                    let _ = signal_hook::low_level::emulate_default_handler(signal);
                });
            }
        });
    }
    #[cfg(not(unix))]
    ctrlc::set_handler(|| end(|| std::process::exit(crate::failure::INTERRUPTED.into())))?;
    Ok(())
}

fn end(exit: impl FnOnce()) {
    let is_patient = SIGNALS.fetch_add(1, Ordering::SeqCst) + 1 < LAST;
    match COMMAND_FLAG.get() {
        Some(handled) if is_patient => handled.store(true, Ordering::SeqCst),
        _ => {
            discard_unfinished();
            exit();
        }
    }
}

/// The signal was ignored when the program began: `nohup` lets it survive its terminal. Known on Linux only.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// From now on a signal sets this and does not end the program.
pub fn flag() -> Arc<AtomicBool> {
    Arc::clone(COMMAND_FLAG.get_or_init(Arc::default))
}
