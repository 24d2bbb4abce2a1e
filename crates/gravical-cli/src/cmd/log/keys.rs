//! The keyboard while it records: space pauses, q or Ctrl-C ends.

use std::io::{self, IsTerminal as _, Read as _};
use std::sync::mpsc::{Receiver, channel};

use crossterm::terminal::{disable_raw_mode, enable_raw_mode};

/// The terminal in raw mode; it is restored when this is dropped, after a panic too.
///
/// Keys are read in a thread of their own, which is never waited for: a read from a closed terminal may
/// never return, or fail each time. Not through crossterm, which asks a closed terminal again and again.
pub struct Keys(Receiver<u8>);

impl Keys {
    /// None without a terminal.
    pub fn new() -> Option<Self> {
        if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
            return None;
        }
        enable_raw_mode().ok()?;
        let (sender, pressed) = channel();
        std::thread::spawn(move || {
            // Interrupted reads are repeated; any other error ends it.
            for byte in io::stdin().lock().bytes().map_while(Result::ok) {
                if sender.send(byte).is_err() {
                    return;
                }
            }
        });
        Some(Keys(pressed))
    }

    /// The next key; none once the terminal is closed.
    pub fn pressed(&self) -> Option<u8> {
        self.0.try_recv().ok()
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        let _ = disable_raw_mode();
    }
}
