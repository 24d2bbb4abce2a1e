//! A serial port, read in a thread of its own, so that a slow disk or terminal does not delay it; and why
//! it cannot be opened, or gives no row.

use std::io::{self, Read as _, Write as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use gravical::escape::{shell_word, shown};
use gravical::{Error, Result};
use serialport::{ErrorKind, SerialPort};

/// Longest wait of one read. After a silence of this time the thread sends no bytes, by which it notices
/// that nobody wants more, and ends.
const READ: Duration = Duration::from_millis(10);
/// What waits at the end is taken in this time, in which few bytes arrive.
const REST: Duration = Duration::from_millis(20);

/// The last bytes that arrived are judged: so many.
pub const JUDGED_BYTES: usize = 512;
/// Characters of the line that is quoted.
const QUOTED: usize = 80;
/// With more than this share of characters that no text has, it is none.
const MAX_UNREADABLE: f64 = 0.1;

/// An open port.
pub struct Serial {
    port: Box<dyn SerialPort>,
    incoming: Receiver<io::Result<Vec<u8>>>,
}

impl Serial {
    /// Opens `path`; most boards reset on that.
    ///
    /// # Errors
    ///
    /// `no-such-port`, `port-permission`, `port-busy`, `port-failed` (device).
    pub fn open(path: &str, baud: u32) -> Result<Self> {
        let failed = |e| trouble(path, &e);
        let builder = serialport::new(path, baud).timeout(READ).dtr_on_open(true);
        let port = builder.clone().open().or_else(|_| {
            // Its reader before may have it for one more read.
            std::thread::sleep(2 * READ);
            builder.open()
        });
        let port = port.map_err(failed)?;
        let reading = port.try_clone().map_err(failed)?;
        let (sender, incoming) = channel();
        std::thread::spawn(move || read(reading, &sender));
        Ok(Serial { port, incoming })
    }

    /// The next bytes, in order; none within `timeout`.
    ///
    /// # Errors
    ///
    /// The system's error: the port is lost.
    pub fn next(&mut self, timeout: Duration) -> io::Result<Vec<u8>> {
        match self.incoming.recv_timeout(timeout) {
            Ok(read) => read,
            Err(RecvTimeoutError::Timeout) => Ok(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => Err(closed()),
        }
    }

    /// Sends bytes to the board. It does not wait until they are there: a port that is stuck takes forever.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    /// Closes the port; returns the bytes that have arrived. It ends even if bytes keep arriving.
    pub fn rest(self) -> Vec<u8> {
        let start = Instant::now();
        let reads = self.incoming.try_iter().map_while(|read| read.ok());
        let reads = reads.take_while(|_| start.elapsed() < REST);
        reads.flatten().collect()
    }
}

fn read(mut port: Box<dyn SerialPort>, to: &Sender<io::Result<Vec<u8>>>) {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    let mut bytes = [0; 4096];
    loop {
        let read = match port.read(&mut bytes) {
            // The other end of a pseudo-terminal is closed.
            Ok(0) => Err(closed()),
            Ok(n) => Ok(bytes.iter().take(n).copied().collect()),
            Err(e) if matches!(e.kind(), TimedOut | Interrupted | WouldBlock) => Ok(Vec::new()),
            Err(e) => Err(e),
        };
        let is_lost = read.is_err();
        if to.send(read).is_err() || is_lost {
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
    let is_there = (cfg!(not(windows)) && std::path::Path::new(path).exists())
        || serialport::available_ports()
            .is_ok_and(|ports| ports.iter().any(|p| p.port_name == path));
    match error.kind() {
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => Error::device(
            "port-permission",
            format!("{path}: no permission to open this port"),
        )
        .with_hint(permission_hint(path)),
        ErrorKind::Io(io::ErrorKind::NotFound) | ErrorKind::NoDevice if !is_there => {
            Error::device("no-such-port", format!("{path}: there is no such port"))
                .with_hint("gravical ports lists the ports; --wait waits for it")
        }
        ErrorKind::NoDevice => Error::device(
            "port-busy",
            format!("{path}: another program has this port open"),
        )
        .with_hint(BUSY_HINT),
        _ => Error::device("port-failed", format!("{path}: {error}"))
            .with_hint("is it a serial port? gravical ports lists them"),
    }
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

/// Why the last bytes of `port` are no rows, as an error.
pub fn no_rows(port: &str, bytes: &[u8]) -> Error {
    let text = String::from_utf8_lossy(bytes);
    let is_unreadable = |c: &char| {
        *c == char::REPLACEMENT_CHARACTER
            || c.is_control() && !matches!(c, '\r' | '\n' | '\t' | '\u{1b}')
    };
    let unreadable = text.chars().filter(is_unreadable).count();
    let (code, text, hint) = if bytes.is_empty() {
        (
            "board-silent",
            format!("{port} is open, but nothing arrives: does the board have a sketch?"),
            "check that it is the right port (gravical ports), and that its sketch prints rows, as firmware/mpu6050_logger does",
        )
    } else if unreadable as f64 > MAX_UNREADABLE * text.chars().count() as f64 {
        (
            "no-samples-from-board",
            format!(
                "what {port} sends is no text: the baud rate of the board is another one, or it has no sketch"
            ),
            "give the baud rate of the sketch: --baud 9600 or 57600, for example",
        )
    } else {
        // What follows the last end of a line is a part of one.
        let whole = text.rfind(['\r', '\n']).map_or(&*text, |end| &text[..end]);
        let line = whole.trim_end().rsplit(['\r', '\n']).next();
        let line = shown(line.unwrap_or_default().trim()).into_owned();
        let line: String = line.chars().take(QUOTED).collect();
        (
            "no-samples-from-board",
            format!("{port} sends text that is no row of a sensor: {line:?}"),
            "a row has at least three numbers, as firmware/mpu6050_logger prints them; --columns names what they are",
        )
    };
    Error::device(code, text).with_hint(hint)
}
