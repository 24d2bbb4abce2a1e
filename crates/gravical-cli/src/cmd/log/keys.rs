//! The keyboard while it records: space pauses, q or Ctrl-C ends.

use std::io::{self, IsTerminal as _};
use std::sync::Once;
use std::time::Duration;

use crossterm::event::{Event, KeyCode, KeyEventKind, KeyModifiers, poll, read};
use crossterm::terminal::{disable_raw_mode, enable_raw_mode};

/// What the user wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// Pause, or go on.
    Pause,
    /// End.
    End,
}

/// The terminal in raw mode; it is put back when this goes, a panic included.
pub struct Keys(());

impl Keys {
    /// None where no terminal is in front of the user.
    pub fn new() -> Option<Self> {
        if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
            return None;
        }
        static HOOK: Once = Once::new();
        HOOK.call_once(|| {
            let before = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |panic| {
                let _ = disable_raw_mode();
                before(panic);
            }));
        });
        enable_raw_mode().ok().map(|()| Keys(()))
    }

    /// What was pressed since the last call.
    pub fn pressed(&self) -> Option<Key> {
        while poll(Duration::ZERO).unwrap_or(false) {
            let Ok(Event::Key(key)) = read() else {
                continue;
            };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            match key.code {
                KeyCode::Char(' ') => return Some(Key::Pause),
                KeyCode::Char('q') => return Some(Key::End),
                KeyCode::Char('c' | 'd') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                    return Some(Key::End);
                }
                _ => {}
            }
        }
        None
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        let _ = disable_raw_mode();
    }
}
