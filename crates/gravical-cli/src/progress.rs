//! A progress bar on a terminal when reading takes longer than a second.

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

/// State of the bar.
static SHOWN: Mutex<Shown> = Mutex::new(Shown::NotYet);

enum Shown {
    NotYet,
    Bar(ProgressBar),
    /// Something was printed: no bar any more.
    Over,
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
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        *shown = Shown::Bar(bar);
    }
    let Shown::Bar(bar) = &*shown else {
        return false;
    };
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
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("█▌░"));
    }
    bar.set_message(message);
    bar.set_position(now.read);
    bar.tick();
    true
}
