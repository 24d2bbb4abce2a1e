//! Messages on standard error, and a status line that is overwritten.

use std::io::{self, IsTerminal as _};

use crate::outlet::Outlet;

/// Standard error. A terminal that has gone stops nothing.
pub struct Screen {
    out: Outlet,
    is_terminal: bool,
    /// The cursor is in a status line.
    in_status: bool,
    /// The terminal is raw: a line ends with carriage return and line feed.
    pub is_raw: bool,
}

impl Screen {
    /// In `real_time` nothing waits for it.
    pub fn new(real_time: bool) -> Self {
        Screen {
            out: Outlet::new(io::stderr(), real_time),
            is_terminal: io::stderr().is_terminal(),
            in_status: false,
            is_raw: false,
        }
    }

    /// The end of a line.
    pub fn end(&self) -> &'static str {
        if self.is_raw { "\r\n" } else { "\n" }
    }

    /// One line or more, in place of the status.
    pub fn line(&mut self, text: &str) {
        let end = self.end();
        let clear = if self.in_status { "\r\x1b[K" } else { "" };
        self.in_status = false;
        let text = text.trim_end().replace('\n', end);
        let _ = self.out.send(format!("{clear}{text}{end}"));
    }

    /// The status; false without a terminal.
    pub fn status(&mut self, line: &str) -> bool {
        if self.is_terminal {
            let _ = self.out.status(format!("\r{line}\x1b[K"));
            self.in_status = true;
        }
        self.is_terminal
    }

    /// Ends the status line.
    pub fn close(&mut self) {
        if std::mem::take(&mut self.in_status) {
            let _ = self.out.send(self.end().to_owned());
        }
        self.is_raw = false;
    }
}
