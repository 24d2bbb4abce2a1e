//! The keyboard while it records: space pauses, q or Ctrl-C ends.

use std::io::{self, IsTerminal as _, Read as _};
use std::sync::mpsc::{Receiver, channel};

use crossterm::terminal::{disable_raw_mode, enable_raw_mode};

/// A key with a meaning.
pub enum Key {
    /// Pause, or resume.
    Pause,
    /// End the recording.
    End,
}

/// The terminal in raw mode; it is restored when this is dropped, after a panic too.
///
/// Keys are read in a thread of their own, which is never waited for: a read from a closed terminal may
/// never return, or fail each time. Not through crossterm, which asks a closed terminal again and again.
pub struct Keys(Receiver<Key>);

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
                let key = match byte {
                    b' ' => Key::Pause,
                    // Ctrl-C and Ctrl-D.
                    b'q' | 3 | 4 => Key::End,
                    _ => continue,
                };
                if sender.send(key).is_err() {
                    return;
                }
            }
        });
        Some(Keys(pressed))
    }

    /// The next key; none once the terminal is closed.
    pub fn pressed(&self) -> Option<Key> {
        self.0.try_recv().ok()
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        let _ = disable_raw_mode();
    }
}
