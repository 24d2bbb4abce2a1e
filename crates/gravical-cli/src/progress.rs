//! A progress bar on a terminal when reading takes longer than a second, or for a run over many
//! sessions.

use std::io::{self, IsTerminal as _};
use std::sync::{Mutex, OnceLock};
use std::thread;
use std::time::Duration;

use gravical::escape::one_line;
use gravical::recording::Meter;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// No bar before this.
const PATIENCE: Duration = Duration::from_secs(1);
const REFRESH: Duration = Duration::from_millis(100);

/// State of the bar of reading.
static SHOWN: Mutex<Shown> = Mutex::new(Shown::NotYet);

enum Shown {
    NotYet,
    Bar(ProgressBar),
    /// Something was printed: no bar any more.
    Over,
}

/// A bar of `total` sessions; none where standard error is not a terminal.
pub fn of_sessions(total: usize) -> ProgressBar {
    let bar = new_bar(Some(total as u64));
    set_template(&bar, "{bar:24}  {pos} of {len}, {eta} left");
    bar
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
    if now.name.is_empty() {
        return !matches!(*shown, Shown::Over);
    }
    if let Shown::NotYet = *shown {
        *shown = Shown::Bar(new_bar(None));
    }
    let Shown::Bar(bar) = &*shown else {
        return false;
    };
    let template = match now.total {
        Some(total) if now.read < total => {
            bar.set_length(total);
            "reading {msg}  {bar:24}  {percent}%, {eta} left"
        }
        Some(_) => "{spinner} computing",
        None => "{spinner} reading {msg}, {bytes}",
    };
    set_template(bar, template);
    bar.set_message(one_line(&now.name).into_owned());
    bar.set_position(now.read);
    bar.tick();
    true
}

fn new_bar(length: Option<u64>) -> ProgressBar {
    ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr())
}

fn set_template(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("█▌░"));
    }
}
