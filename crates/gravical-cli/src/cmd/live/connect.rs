//! The way to the first row: which port is the board, and what to do where that is not clear.

use std::path::Path;
use std::time::Duration;

use gravical::escape::path_word;
use gravical::live::event::{Command, Event, SourceKind};
use gravical::live::recorder::{self, NO_ROWS};
use gravical::live::sentence;
use gravical::{Category, Error, Result};
use gravical_report::document::flag;

use super::Args;
use super::console::Console;
use super::source::{Incoming, Source};
use crate::device::ports::list;

/// Time between two looks at the ports, and at what the user wants.
const LOOK: Duration = Duration::from_millis(200);
/// The commands that flash our sketch, from the folder of gravical, where another sketch may be one.
const FLASH: [&str; 3] = [
    "arduino-cli core install arduino:avr",
    "arduino-cli compile --fqbn arduino:avr:uno firmware/mpu6050_logger",
    "arduino-cli upload --fqbn arduino:avr:uno -p {port} firmware/mpu6050_logger",
];

/// A source that is open.
pub struct OpenSource {
    pub kind: SourceKind,
    pub name: String,
    pub source: Box<dyn Source>,
    /// Length of its file when it was opened: what a session that goes on begins with.
    pub restored_bytes: u64,
    /// What it had while its first rows were waited for.
    pub first: Incoming,
}

/// Opens a source, and shows what hinders.
pub struct Connection<'a> {
    /// What the user chooses changes them.
    pub args: Args,
    pub console: &'a mut Console,
}

impl Connection<'_> {
    /// Opens the source, and waits for the first rows of a board. Which port that is the user may choose;
    /// none: the user has ended it.
    ///
    /// # Errors
    ///
    /// Those of the source; in a script those of a board, too.
    pub fn open(mut self) -> Result<Option<OpenSource>> {
        let is_seen = self.console.is_seen();
        while !self.console.is_interrupted() {
            let done = self.first_rows();
            if let (Some(folder), Ok(None) | Err(_)) = (&self.args.folder, &done) {
                // Without a board no empty folder remains; one with a file in it does.
                let _ = std::fs::remove_dir(folder);
            }
            match done {
                Ok(None) => {}
                Err(e) if is_seen && e.category() == Category::Device => self.ask(&e)?,
                done => return done,
            }
        }
        Ok(None)
    }

    /// None: the user wants another source, or none.
    fn first_rows(&mut self) -> Result<Option<OpenSource>> {
        let mut opened = self.args.open()?;
        // A port may be that of another device.
        while opened.kind == SourceKind::Port && opened.first.bytes.is_empty() {
            let waited = self.wait(&mut opened).and_then(|()| self.chooses());
            if !matches!(waited, Ok(false)) || self.console.is_interrupted() {
                let _ = opened.source.close(true);
                return waited.map(|_| None);
            }
        }
        Ok(Some(opened))
    }

    fn wait(&mut self, opened: &mut OpenSource) -> Result<()> {
        let Incoming { bytes, events } = opened.source.next()?.unwrap_or_default();
        opened.first.bytes.extend(bytes);
        for event in events {
            match event {
                recorder::Event::Opened { port: name, .. } => {
                    opened.name.clone_from(&name);
                    self.args.board.port = Some(name.clone());
                    let text = format!("{name} is open: waiting for its first rows.");
                    self.console.note(Event::Connecting { name }, &text)?;
                }
                recorder::Event::Lost { .. } => {
                    let text = format!("{}: unplugged before the first row", opened.name);
                    return Err(Error::device("no-such-port", text));
                }
                recorder::Event::Warning { text } | recorder::Event::Waiting { text } => {
                    self.console.note(Event::Warning, &text)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Shows the ports until one is chosen; where one is missing, until there are others.
    fn ask(&mut self, trouble: &Error) -> Result<()> {
        let code = trouble.code();
        let is_mute = code == "settings-refused" || NO_ROWS.contains(&code);
        let waits = ["no-port", "no-such-port", "several-ports"].contains(&code);
        let hint = trouble.worded_hint(flag);
        let remedy = match code {
            "several-ports" => "choose the one of your board",
            _ if waits => "plug it in: it is opened when it is there; or choose another port",
            _ => hint.as_deref().unwrap_or("choose another port"),
        };
        let text = format!("{} {}", sentence(trouble.message()), sentence(remedy));
        let tried = self.args.board.port.clone();
        let port = tried.clone().unwrap_or_else(|| "PORT".to_owned());
        let mut shown = None;
        while !self.console.is_interrupted() && !self.chooses()? {
            let ports = list().unwrap_or_default();
            let now = Some((ports.clone(), Path::new(&port).exists()));
            if shown.is_some() && shown != now && waits {
                return Ok(());
            }
            if shown != now {
                let flash = FLASH.iter().filter(|_| is_mute);
                let flash = flash.map(|line| line.replace("{port}", &path_word(Path::new(&port))));
                let event = Event::Ports {
                    ports,
                    tried: tried.clone(),
                    flash: flash.collect(),
                    simulate: self.args.resume.is_none(),
                };
                self.console.note(event, &text)?;
                shown = now;
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Whether the user has chosen another source. Only a port of this computer can be, or the one that was
    /// tried.
    fn chooses(&mut self) -> Result<bool> {
        while let Some(command) = self.console.command() {
            let why = match command {
                Ok(Command::Cancel) => {
                    self.console.interrupt();
                    return Ok(false);
                }
                Ok(Command::Simulate) if self.args.resume.is_none() => {
                    self.args.simulate = true;
                    return Ok(true);
                }
                Ok(Command::Port { name }) => {
                    let ports = list().unwrap_or_default();
                    let is_known = ports.iter().any(|port| port.name == name);
                    if is_known || self.args.board.port.as_ref() == Some(&name) {
                        self.args.board.port = Some(name);
                        return Ok(true);
                    }
                    format!("{name} is no port of this computer.")
                }
                Ok(Command::Simulate) => "This session is of another sensor.".to_owned(),
                Ok(_) => "No row has arrived yet: the session has not begun.".to_owned(),
                Err(text) => text,
            };
            self.console.note(Event::Warning, &why)?;
        }
        Ok(false)
    }
}
