//! A session and the words around it: what a host of it has to keep and to show.

use gravical_calibrate::calibration_file::Calibration;
use gravical_judge::Result;
use gravical_judge::numfmt::count;

use crate::event::{Command, EndReason, Event, Loss, Message, SourceKind};
use crate::folder::Journal;
use crate::options::LiveOptions;
use crate::recorder;
use crate::session::Session;

/// A guided session without clock and I/O: rows, commands and what happens to the source in, messages out.
///
/// A host gives it what arrives, and afterwards [takes](Self::take) the messages: it makes the rows safe, writes those
/// messages that [belong to the journal](Message::is_recorded), and then shows them all.
pub struct Guide {
    /// The session itself.
    pub session: Session,
    /// Where its rows come from.
    pub source: SourceKind,
    /// The name of the source.
    pub name: String,
    /// Where it is kept; none where it is not.
    pub folder: Option<String>,
    now_s: f64,
    messages: Vec<Message>,
}

impl Guide {
    /// A session of this source that reads `recording`.
    pub fn new(source: SourceKind, name: &str, recording: &str, options: LiveOptions) -> Self {
        Guide {
            session: Session::new(recording, options),
            source,
            name: name.to_owned(),
            folder: None,
            now_s: 0.0,
            messages: Vec::new(),
        }
    }

    /// What has to be shown, and recorded, since the last call.
    pub fn take(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    /// The session begins.
    pub fn begin(&mut self) {
        let text = match &self.folder {
            Some(folder) => format!("{}; the session is in {folder}", self.name),
            None => self.name.clone(),
        };
        let event = Event::Session {
            source: self.source,
            name: self.name.clone(),
            folder: self.folder.clone(),
            gravity: self.session.gravity(),
        };
        self.note(event, &text);
    }

    /// It goes on after these rows, with the poses of its journal. Returns what was said before, to be shown again.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub fn restore(&mut self, rows: &[u8], journal: &Journal) -> Result<Vec<Message>> {
        let restored = self.session.restore(rows, journal)?;
        self.now_s = restored.last().map_or(0.0, |m| m.t_s);
        Ok(restored)
    }

    /// Rows of the recording, and then what happened to their source.
    ///
    /// # Errors
    ///
    /// Those of reading.
    pub fn receive(&mut self, rows: &[u8], events: Vec<recorder::Event>) -> Result<()> {
        if !rows.is_empty() {
            let resumed = self.session.resumed();
            self.show(resumed);
            let messages = self.session.bytes(rows)?;
            self.show(messages);
            if self.source == SourceKind::Port {
                // The recorder has waited for rows enough, also of a slow sensor.
                let settled = self.session.settle_format().unwrap_or_default();
                self.show(settled);
            }
        }
        for event in events {
            match event {
                recorder::Event::Lost { .. } => self.lost(Loss::Unplugged),
                recorder::Event::Silent { .. } => self.lost(Loss::Silent),
                recorder::Event::Warning { text } | recorder::Event::Waiting { text } => {
                    self.warn(&text);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// No rows arrive.
    pub fn lost(&mut self, why: Loss) {
        let messages = self.session.lost(why);
        self.show(messages);
    }

    /// No rows will arrive any more.
    ///
    /// # Errors
    ///
    /// Those of reading: it was no recording.
    pub fn finish(&mut self) -> Result<()> {
        let messages = self.session.settle_format()?;
        self.show(messages);
        self.command(&Command::Finish);
        Ok(())
    }

    /// What the user wants.
    pub fn command(&mut self, command: &Command) {
        let messages = self.session.command(command);
        self.show(messages);
    }

    /// The calibration is computed: `saved` says where it is, `truth` how far it is from that of a simulated sensor.
    pub fn done(
        &mut self,
        calibration: &Calibration,
        saved: Option<(Event, String)>,
        truth: Option<(Event, String)>,
    ) {
        let done = match saved {
            Some((event, text)) => {
                self.note(event, &text);
                "Done"
            }
            None => "Done, and not saved",
        };
        if let Some((event, text)) = truth {
            self.note(event, &text);
        }
        let poses = count(self.session.poses().count(), "pose");
        let text = format!("{done}: {poses}, verdict {}", calibration.grade());
        self.end(EndReason::Finished, &text, None);
    }

    /// The last event; `resume` says how to go on.
    pub fn end(&mut self, reason: EndReason, text: &str, resume: Option<String>) {
        let poses = self.session.poses().count() as u32;
        self.note(
            Event::End {
                reason,
                poses,
                resume,
            },
            text,
        );
    }

    /// Something to do, or to know.
    pub fn warn(&mut self, text: &str) {
        self.note(Event::Warning, text);
    }

    /// Says what only the host knows.
    pub fn note(&mut self, event: Event, text: &str) {
        self.show([Message::new(self.now_s, event, text)]);
    }

    fn show(&mut self, messages: impl IntoIterator<Item = Message>) {
        self.messages.extend(messages);
        self.now_s = self.messages.last().map_or(self.now_s, |m| m.t_s);
    }
}
