//! A progress bar on a terminal when reading takes longer than a second, or for a run over many
//! sessions.

use std::io::{self, IsTerminal as _};
use std::sync::LazyLock;
use std::thread;
use std::time::Duration;

use gravical::escape::one_line;
use gravical::recording::Meter;
use indicatif::{ProgressBar, ProgressStyle};

/// No bar before this.
const PATIENCE: Duration = Duration::from_secs(1);
const REFRESH: Duration = Duration::from_millis(100);

/// The bar of reading, finished for good once something is printed.
static READING: LazyLock<ProgressBar> = LazyLock::new(ProgressBar::no_length);

/// A bar of `total` sessions; none where standard error is not a terminal.
pub fn of_sessions(total: usize) -> ProgressBar {
    let bar = ProgressBar::new(total as u64);
    set_template(&bar, "{bar:24}  {pos} of {len}, {eta} left");
    bar
}

/// Counts the bytes read from all recordings.
pub fn meter() -> Meter {
    static METER: LazyLock<Meter> = LazyLock::new(Meter::default);
    METER.clone()
}

/// Shows the progress of reading after one second, until something is printed. Does nothing if
/// standard error is not a terminal.
pub fn watch() {
    if io::stderr().is_terminal() {
        thread::spawn(|| {
            thread::sleep(PATIENCE);
            while !READING.is_finished() {
                refresh();
                thread::sleep(REFRESH);
            }
        });
    }
}

/// Removes the bar for good before something is printed; one that is finished draws nothing.
pub fn end() {
    if !READING.is_finished() {
        READING.finish_and_clear();
    }
}

fn refresh() {
    let now = meter().progress();
    // Nothing is being read.
    if now.name.is_empty() {
        return;
    }
    let template = match now.total {
        Some(total) if now.read < total => {
            READING.set_length(total);
            "reading {msg}  {bar:24}  {percent}%, {eta} left"
        }
        Some(_) => "{spinner} computing",
        None => "{spinner} reading {msg}, {bytes}",
    };
    set_template(&READING, template);
    READING.set_message(one_line(&now.name).into_owned());
    READING.set_position(now.read);
    READING.tick();
}

fn set_template(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("█▌░"));
    }
}
