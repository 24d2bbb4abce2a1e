//! Why a port cannot be opened, or gives no row, and the remedy.

use std::io;

use gravical::Error;
use gravical::escape::{shell_word, shown};
use serialport::ErrorKind;

/// The error for a `path` that could not be opened.
pub fn opening(path: &str, error: &serialport::Error) -> Error {
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

/// The last bytes that arrived are judged: so many.
pub const JUDGED_BYTES: usize = 512;
/// Characters of the line that is quoted.
const QUOTED: usize = 80;
/// With more than this share of characters that no text has, it is none.
const MAX_UNREADABLE: f64 = 0.1;

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
