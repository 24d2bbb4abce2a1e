//! A serial port, read in a thread of its own, so that a slow disk or terminal does not delay it; and why
//! it cannot be opened.

use std::io::{self, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use gravical::escape::shell_word;
use gravical::{Error, Result};
use serialport::{ErrorKind, SerialPort};

use super::ports::{is_present, list};

/// Longest wait of one read. After a silence of this time the thread sends no bytes, by which the writer
/// knows the time, and it notices that nobody wants more, and ends.
const READ: Duration = Duration::from_millis(10);
/// At the end so many reads in a row without bytes are the silence of a board: on a busy machine the system
/// passes on late what has arrived. Of one that sends without a pause these are the last reads: what had arrived is less.
const SILENT_READS: u32 = 20;
const LAST_READS: u32 = 60;

/// An open port, whose bytes are passed on as they arrive.
pub struct Serial {
    port: Box<dyn SerialPort>,
    is_closing: Arc<AtomicBool>,
}

impl Serial {
    /// Opens `path`; most boards reset on that. `pass_on` gets what was read, nothing after a silence, and at
    /// last the error that ends it; it returns false once nobody wants more.
    ///
    /// # Errors
    ///
    /// `no-such-port`, `port-permission`, `port-busy`, `port-failed` (device).
    pub fn open(
        path: &str,
        baud: u32,
        pass_on: impl FnMut(io::Result<Vec<u8>>) -> bool + Send + 'static,
    ) -> Result<Self> {
        let failed = |e| trouble(path, &e);
        let builder = serialport::new(path, baud).timeout(READ).dtr_on_open(true);
        let port = builder.clone().open().or_else(|_| {
            // Its reader before may have it for one more read.
            std::thread::sleep(2 * READ);
            builder.open()
        });
        let port = port.map_err(failed)?;
        let reading = port.try_clone().map_err(failed)?;
        let is_closing = Arc::new(AtomicBool::new(false));
        let closing = Arc::clone(&is_closing);
        std::thread::spawn(move || read(reading, pass_on, &closing));
        Ok(Serial { port, is_closing })
    }

    /// Sends bytes to the board.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    /// Ends the reading, after what has arrived: the last that is passed on is that it is closed.
    pub fn close(&self) {
        self.is_closing.store(true, Ordering::Release);
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.close();
    }
}

fn read(
    mut port: impl io::Read,
    mut pass_on: impl FnMut(io::Result<Vec<u8>>) -> bool,
    is_closing: &AtomicBool,
) {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    let mut bytes = [0; 4096];
    let (mut last_reads, mut silent_reads) = (0, 0);
    loop {
        let is_last = is_closing.load(Ordering::Acquire);
        last_reads += u32::from(is_last);
        let read = match port.read(&mut bytes) {
            // The other end of a pseudo-terminal is closed.
            Ok(0) => Err(closed()),
            Ok(n) => Ok(bytes[..n].to_vec()),
            Err(e) if matches!(e.kind(), TimedOut | Interrupted | WouldBlock) => Ok(Vec::new()),
            Err(e) => Err(e),
        };
        let is_silent = is_last && read.as_ref().is_ok_and(Vec::is_empty);
        silent_reads = if is_silent { silent_reads + 1 } else { 0 };
        let is_lost = read.is_err();
        if !pass_on(read) || is_lost {
            return;
        }
        if silent_reads >= SILENT_READS || last_reads >= LAST_READS {
            pass_on(Err(closed()));
            return;
        }
    }
}

fn closed() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the port is closed")
}

/// The error for a `path` that could not be opened.
fn trouble(path: &str, error: &serialport::Error) -> Error {
    // Windows reports NoDevice both for a missing port and for one in use.
    let is_there = is_present(path, &list().unwrap_or_default());
    let (code, what, hint) = match error.kind() {
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
            let what = "no permission to open this port";
            ("port-permission", what, &*permission_hint(path))
        }
        ErrorKind::Io(io::ErrorKind::NotFound) | ErrorKind::NoDevice if !is_there => {
            let hint = "gravical ports lists the ports; --wait waits for it";
            ("no-such-port", "there is no such port", hint)
        }
        ErrorKind::NoDevice => ("port-busy", "another program has this port open", BUSY_HINT),
        _ => {
            let hint = "is it a serial port? gravical ports lists them";
            ("port-failed", &*error.to_string(), hint)
        }
    };
    Error::device(code, format!("{path}: {what}")).with_hint(hint)
}

const BUSY_HINT: &str = if cfg!(target_os = "linux") {
    "close the serial monitor of the Arduino IDE, or another logger (fuser -v names it); just after plugging in it is ModemManager, which closes the port after some seconds (sudo systemctl stop ModemManager stops it)"
} else {
    "close the serial monitor of the Arduino IDE, or another logger"
};

/// The group of serial ports is dialout on most systems; the shell knows that of this one.
fn permission_hint(path: &str) -> String {
    if cfg!(unix) {
        let path = shell_word(path);
        format!("sudo usermod -aG $(stat -c %G {path}) $USER   (then log out and in again)")
    } else {
        "run it as a user with access to the port".to_owned()
    }
}
