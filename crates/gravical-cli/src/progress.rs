//! A progress bar on a terminal when reading, or a run over many sessions, takes longer than a second.

use std::io::{self, IsTerminal as _};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use std::thread;
use std::time::Duration;

use gravical::escape::one_line;
use gravical::recording::Meter;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// No bar before this.
const PATIENCE: Duration = Duration::from_secs(1);
const REFRESH: Duration = Duration::from_millis(100);

/// State of the bar.
static SHOWN: Mutex<Shown> = Mutex::new(Shown::NotYet);

enum Shown {
    NotYet,
    Bar(ProgressBar),
    /// Something was printed: no bar any more.
    Over,
}

/// The items of a run over many sessions.
struct Count {
    total: u64,
    done: AtomicU64,
    /// Those that failed among them.
    failed: AtomicU64,
}

static COUNT: OnceLock<Count> = OnceLock::new();

/// From now on items are counted, `total` of them, in place of bytes.
pub fn count(total: u64) {
    let (done, failed) = (AtomicU64::new(0), AtomicU64::new(0));
    COUNT.get_or_init(|| Count {
        total,
        done,
        failed,
    });
}

/// One more item is done.
pub fn counted(failed: bool) {
    if let Some(count) = COUNT.get() {
        count.done.fetch_add(1, Ordering::Relaxed);
        count.failed.fetch_add(u64::from(failed), Ordering::Relaxed);
    }
}

/// Prints something while the bar stays.
pub fn aside<T>(print: impl FnOnce() -> T) -> T {
    let Ok(shown) = SHOWN.lock() else {
        return print();
    };
    match &*shown {
        Shown::Bar(bar) => bar.suspend(print),
        Shown::NotYet | Shown::Over => print(),
    }
}

/// Counts the bytes read from all recordings.
pub fn meter() -> Meter {
    static METER: OnceLock<Meter> = OnceLock::new();
    METER.get_or_init(Meter::default).clone()
}

/// Shows the progress of reading after one second, until something is printed. Does nothing if
/// standard error is not a terminal.
pub fn watch() {
    if io::stderr().is_terminal() {
        thread::spawn(|| {
            thread::sleep(PATIENCE);
            while refresh() {
                thread::sleep(REFRESH);
            }
        });
    }
}

/// Removes the bar for good before something is printed.
pub fn end() {
    let Ok(mut shown) = SHOWN.lock() else { return };
    if let Shown::Bar(bar) = &*shown {
        bar.finish_and_clear();
    }
    *shown = Shown::Over;
}

/// Draws the bar; false once it has ended.
fn refresh() -> bool {
    let Ok(mut shown) = SHOWN.lock() else {
        return false;
    };
    let now = meter().progress();
    // Nothing is being read.
    if now.name.is_empty() && COUNT.get().is_none() {
        return !matches!(*shown, Shown::Over);
    }
    if let Shown::NotYet = *shown {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        *shown = Shown::Bar(bar);
    }
    let Shown::Bar(bar) = &*shown else {
        return false;
    };
    if let Some(count) = COUNT.get() {
        let failed = match count.failed.load(Ordering::Relaxed) {
            0 => String::new(),
            n => format!(", {n} failed"),
        };
        bar.set_length(count.total);
        draw(
            bar,
            "{bar:24}  {pos} of {len}{msg}, {eta} left",
            failed,
            count.done.load(Ordering::Relaxed),
        );
        return true;
    }
    let (template, message) = match now.total {
        Some(total) if now.read < total => {
            bar.set_length(total);
            (
                "reading {msg}  {bar:24}  {percent}%, {eta} left",
                one_line(&now.name).into_owned(),
            )
        }
        Some(_) => ("{spinner} computing{msg}", String::new()),
        None => (
            "{spinner} reading {msg}, {bytes}",
            one_line(&now.name).into_owned(),
        ),
    };
    draw(bar, template, message, now.read);
    true
}

fn draw(bar: &ProgressBar, template: &str, message: String, position: u64) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("█▌░"));
    }
    bar.set_message(message);
    bar.set_position(position);
    bar.tick();
}
