//! A progress bar on a terminal, where reading takes longer than a second.

use std::io::{self, IsTerminal as _};
use std::sync::{Mutex, OnceLock};
use std::thread;
use std::time::Duration;

use gravical::output::one_line;
use gravical::recording::Meter;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// What takes less time has no bar.
const PATIENCE: Duration = Duration::from_secs(1);
const REFRESH: Duration = Duration::from_millis(100);

/// The bar while there is one.
static SHOWN: Mutex<Shown> = Mutex::new(Shown::NotYet);

enum Shown {
    NotYet,
    Bar(ProgressBar),
    /// Something was printed: no bar comes after that.
    Over,
}

/// Counts what all recordings of this run give.
pub fn meter() -> Meter {
    static METER: OnceLock<Meter> = OnceLock::new();
    METER.get_or_init(Meter::default).clone()
}

/// Shows how far reading is, from the first second on, until something is printed. Does
/// nothing where standard error is no terminal.
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

/// Takes the bar away for good: the screen is wanted for something else.
pub fn end() {
    let Ok(mut shown) = SHOWN.lock() else { return };
    if let Shown::Bar(bar) = &*shown {
        bar.finish_and_clear();
    }
    *shown = Shown::Over;
}

/// Draws the bar as it is now; false once there is none any more.
fn refresh() -> bool {
    let Ok(mut shown) = SHOWN.lock() else {
        return false;
    };
    let now = meter().progress();
    // A verb that reads nothing has its own ways.
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
