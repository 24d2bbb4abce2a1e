//! Where the rows come from: which port is the board, and what to do where that is not clear.

use std::path::{Path, PathBuf};
use std::time::Duration;

use gravical::escape::path_word;
use gravical::live::event::{PortInfo, SourceKind};
use gravical::{Error, Result};

use super::source::{Incoming, Source};
use crate::device::ports::the_board;

/// Time between two looks at the ports, and at what the user wants.
const LOOK: Duration = Duration::from_millis(200);

/// Where the rows come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// A recording.
    Replay(PathBuf),
    /// A simulated sensor of this seed; without one it is drawn.
    Simulated(Option<u64>),
    /// The port of this name; without one the only board that is plugged in.
    Port(Option<String>),
}

impl Origin {
    /// The port, if it has a name.
    pub fn port(&self) -> Option<&str> {
        match self {
            Origin::Port(name) => name.as_deref(),
            _ => None,
        }
    }
}

/// A source that is open.
pub struct OpenSource {
    pub kind: SourceKind,
    pub name: String,
    pub source: Box<dyn Source>,
    /// The recording before it was opened.
    pub before: Vec<u8>,
}

/// No source: the user has to choose one.
pub struct Absent;

impl Source for Absent {
    fn next(&mut self) -> Result<Vec<Incoming>> {
        std::thread::sleep(LOOK);
        Ok(Vec::new())
    }
}

/// The commands that flash our sketch, from the folder of gravical.
pub fn flash(port: Option<&str>) -> Vec<String> {
    let port = path_word(Path::new(port.unwrap_or("PORT")));
    let sketch = "firmware/mpu6050_logger";
    vec![
        "arduino-cli core install arduino:avr".to_owned(),
        format!("arduino-cli compile --fqbn arduino:avr:uno {sketch}"),
        format!("arduino-cli upload --fqbn arduino:avr:uno -p {port} {sketch}"),
    ]
}

/// The port that was waited for, if it is there now.
pub fn arrived(error: &Error, tried: Option<&str>, ports: &[PortInfo]) -> Option<String> {
    match (error.code(), tried) {
        ("no-port", _) => the_board(ports).ok().map(|port| port.name),
        ("no-such-port", Some(name)) => {
            let is_there = ports.iter().any(|p| p.name == name) || Path::new(name).exists();
            is_there.then(|| name.to_owned())
        }
        _ => None,
    }
}

/// The remedy where the port is chosen while the program runs, and whether another sketch may be one.
pub fn remedy(trouble: &Error) -> (&str, bool) {
    match trouble.code() {
        "board-silent" => (
            "flash a sketch, ours or any that prints numbers; choose another port; or try the simulated sensor",
            true,
        ),
        "no-samples-from-board" => (
            "flash a sketch, ours or any that prints numbers; begin again with its rate, as --baud 9600; or choose another port",
            true,
        ),
        "no-port" => (
            "plug it in: it is opened when it is there. Some USB cables only charge; any other port can be chosen",
            false,
        ),
        "no-such-port" => (
            "plug it in: it is opened when it is there; or choose another one",
            false,
        ),
        "several-ports" => ("choose the one of your board", false),
        code => {
            let hint = trouble.hint().unwrap_or("choose another one");
            (hint, code == "settings-refused")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board(name: &str) -> PortInfo {
        PortInfo {
            name: name.to_owned(),
            board: true,
            ..PortInfo::default()
        }
    }

    #[test]
    fn what_was_waited_for_is_taken() {
        let none = Error::device("no-port", "");
        assert_eq!(arrived(&none, None, &[]), None);
        let one = [board("/dev/none1")];
        assert_eq!(arrived(&none, None, &one).as_deref(), Some("/dev/none1"));
        // Two at once are a question.
        let two = [board("/dev/none1"), board("/dev/none2")];
        assert_eq!(arrived(&none, None, &two), None);
        let missing = Error::device("no-such-port", "");
        let is = |name, ports: &[PortInfo]| arrived(&missing, Some(name), ports);
        assert_eq!(is("/dev/none2", &one), None);
        assert_eq!(is("/dev/none2", &two).as_deref(), Some("/dev/none2"));
        // One that is busy is not tried again and again.
        let busy = Error::device("port-busy", "");
        assert_eq!(arrived(&busy, Some("/dev/none1"), &one), None);
    }
}
