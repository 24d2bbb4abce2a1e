//! The way to the first row: which port is the board, and whether rows arrive from it. Where that is
//! not clear the user chooses, on the page or in the terminal.

use std::path::{Path, PathBuf};
use std::time::Duration;

use gravical::escape::path_word;
use gravical::live::event::{Command, EndReason, Loss, PortInfo, SourceKind, WarningKind};
use gravical::live::{Event, Message, sentence};
use gravical::{Category, Error, Result};

use super::Args;
use super::console::Console;
use super::source::{Incoming, Source};
use crate::device::ports::{list, list_with_holders, the_board};

/// What the user wants is asked for after this time …
const ASK: Duration = Duration::from_millis(50);
/// … and so many times between two looks at the ports.
const ASKED: u32 = 6;

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

/// A source that is open.
pub struct OpenSource {
    pub kind: SourceKind,
    pub name: String,
    pub source: Box<dyn Source>,
    /// The recording before it was opened.
    pub before: Vec<u8>,
    /// What it had first, where the session began with that.
    pub first: Vec<Incoming>,
}

/// What becomes of a source that is open, or of a question.
enum Answer {
    /// Rows arrive.
    Rows(OpenSource),
    /// The user chose.
    Chosen(Origin),
    /// The user ended it.
    Ended,
}

/// Waits for rows, and lets the user choose where they come from.
pub struct Connector<'a> {
    pub args: &'a Args,
    pub folder: &'a Path,
    pub console: &'a mut Console,
    /// The port that was opened, or could not be.
    pub tried: Option<String>,
}

impl Connector<'_> {
    /// Opens the source, and asks the user where that fails or no row arrives; none when the user ended
    /// it.
    ///
    /// # Errors
    ///
    /// Those of the source that are no question.
    pub fn connect(&mut self, mut origin: Origin) -> Result<Option<OpenSource>> {
        loop {
            if let Origin::Port(name) = &origin {
                self.tried.clone_from(name);
            }
            let opened = self.args.open(&origin, self.folder);
            let answer = match opened.and_then(|opened| self.first_rows(opened)) {
                Err(trouble) if self.args.is_seen() && trouble.category() == Category::Device => {
                    self.choose(&trouble)?
                }
                answer => answer?,
            };
            match answer {
                Answer::Rows(opened) => return Ok(Some(opened)),
                Answer::Chosen(chosen) => origin = chosen,
                Answer::Ended => return Ok(None),
            }
        }
    }

    /// Waits for the first rows of a port. The user may choose another one meanwhile.
    fn first_rows(&mut self, mut opened: OpenSource) -> Result<Answer> {
        if opened.kind != SourceKind::Port {
            return Ok(Answer::Rows(opened));
        }
        let answer = 'wait: loop {
            let mut next = match opened.source.next() {
                Ok(next) => next.into_iter(),
                Err(error) => break Err(error),
            };
            while let Some(incoming) = next.next() {
                match incoming {
                    Incoming::Bytes(_) => {
                        opened.first = [incoming].into_iter().chain(next).collect();
                        return Ok(Answer::Rows(opened));
                    }
                    Incoming::Connected(name) => {
                        let text = format!("{name} is open: waiting for its first rows.");
                        self.tried = Some(name.clone());
                        opened.name.clone_from(&name);
                        self.show(Event::Connecting { name }, &text)?;
                    }
                    Incoming::Lost(Loss::Unplugged) => {
                        let text = format!("{}: unplugged before the first row", opened.name);
                        break 'wait Err(Error::device("no-such-port", text));
                    }
                    Incoming::Warning(text) => self.warn(WarningKind::Rows, &text)?,
                    _ => {}
                }
            }
            if let Some(answer) = self.answer()? {
                break Ok(answer);
            }
        };
        opened.source.discard();
        answer
    }

    /// What the user chooses after `trouble`. A port that was missing is taken as soon as it is there.
    fn choose(&mut self, trouble: &Error) -> Result<Answer> {
        let mut shown = None;
        loop {
            let found = list_with_holders().unwrap_or_default();
            if let Some(name) = arrived(trouble, self.tried.as_deref(), &found) {
                return Ok(Answer::Chosen(Origin::Port(Some(name))));
            }
            if shown.as_ref() != Some(&found) {
                let (remedy, needs_sketch) = remedy(trouble);
                let event = Event::Ports {
                    ports: found.clone(),
                    tried: self.tried.clone(),
                    flash: if needs_sketch {
                        self.flash()
                    } else {
                        Vec::new()
                    },
                    simulate: self.can_simulate(),
                };
                let text = format!("{} {}", sentence(trouble.message()), sentence(remedy));
                self.show(event, &text)?;
            }
            shown = Some(found);
            for _ in 0..ASKED {
                if let Some(answer) = self.answer()? {
                    return Ok(answer);
                }
                std::thread::sleep(ASK);
            }
        }
    }

    /// What the user wants since the last call. Only a port of this computer can be chosen, or the one
    /// that was tried.
    fn answer(&mut self) -> Result<Option<Answer>> {
        let mut reason = EndReason::Interrupted;
        while let Ok(entry) = self.console.entries.try_recv() {
            let refusal = match entry.command {
                Ok(Command::Simulate) if self.can_simulate() => {
                    return Ok(Some(Answer::Chosen(Origin::Simulated(None))));
                }
                Ok(Command::Port { name }) => {
                    let ports = list().unwrap_or_default();
                    if self.tried.as_ref() == Some(&name) || ports.iter().any(|p| p.name == name) {
                        return Ok(Some(Answer::Chosen(Origin::Port(Some(name)))));
                    }
                    format!("{name} is no port of this computer")
                }
                Ok(Command::Cancel) => {
                    reason = EndReason::Cancelled;
                    self.console.interrupt();
                    break;
                }
                Ok(Command::Simulate) => "this session is of another sensor".to_owned(),
                Ok(_) => "no row has arrived yet: the session has not begun".to_owned(),
                Err(text) => text,
            };
            self.warn(WarningKind::Refused, &refusal)?;
        }
        if !self.console.is_interrupted() {
            return Ok(None);
        }
        let event = Event::End {
            reason,
            poses: 0,
            resume: None,
        };
        self.show(event, "Ended before the first row.")?;
        Ok(Some(Answer::Ended))
    }

    /// A simulated sensor can take the place of the board.
    fn can_simulate(&self) -> bool {
        self.args.resume.is_none()
    }

    /// The commands that flash our sketch, from the folder of gravical.
    fn flash(&self) -> Vec<String> {
        let port = path_word(Path::new(self.tried.as_deref().unwrap_or("PORT")));
        let sketch = "firmware/mpu6050_logger";
        vec![
            "arduino-cli core install arduino:avr".to_owned(),
            format!("arduino-cli compile --fqbn arduino:avr:uno {sketch}"),
            format!("arduino-cli upload --fqbn arduino:avr:uno -p {port} {sketch}"),
        ]
    }

    fn warn(&mut self, kind: WarningKind, text: &str) -> Result<()> {
        self.show(Event::Warning { kind }, text)
    }

    fn show(&mut self, event: Event, text: &str) -> Result<()> {
        self.console.show(&Message::new(0.0, event, text))
    }
}

/// The port that was waited for, if it is there now.
fn arrived(error: &Error, tried: Option<&str>, ports: &[PortInfo]) -> Option<String> {
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
fn remedy(trouble: &Error) -> (&str, bool) {
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
