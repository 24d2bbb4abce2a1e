//! The keyboard while it records: space pauses, q or Ctrl-C ends.

use std::io::{self, IsTerminal as _, Read as _};
use std::sync::mpsc::{Receiver, Sender, channel};

use crossterm::terminal::{disable_raw_mode, enable_raw_mode};

/// A key with a meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// Pause, or resume.
    Pause,
    /// End the recording.
    End,
}

/// The terminal in raw mode; it is restored when this is dropped, after a panic too.
///
/// Keys are read in a thread of their own: a read from a closed terminal may never return,
/// or fail each time, and must not stop the recording. The thread is never waited for.
pub struct Keys(Receiver<Key>);

impl Keys {
    /// None without a terminal.
    pub fn new() -> Option<Self> {
        if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
            return None;
        }
        enable_raw_mode().ok()?;
        let (sender, pressed) = channel();
        std::thread::spawn(move || listen(&sender));
        Some(Keys(pressed))
    }

    /// The next key; none once the terminal is closed.
    pub fn pressed(&self) -> Option<Key> {
        self.0.try_recv().ok()
    }
}

/// Passes keys on until the terminal is closed or nobody reads them.
fn listen(pressed: &Sender<Key>) {
    let mut bytes = [0; 64];
    loop {
        // Not through crossterm, which asks a closed terminal again and again.
        let n = match io::stdin().lock().read(&mut bytes) {
            Ok(0) => return,
            Ok(n) => n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        for byte in bytes.iter().take(n) {
            let key = match byte {
                b' ' => Key::Pause,
                // Ctrl-C and Ctrl-D.
                b'q' | 3 | 4 => Key::End,
                _ => continue,
            };
            if pressed.send(key).is_err() {
                return;
            }
        }
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        let _ = disable_raw_mode();
    }
}
