//! Where the events of a recording go: JSON for scripts, messages and a status line for people.

use std::io;

use gravical::escape::{shown, shown_json};
use gravical::live::recorder::Event;
use gravical::recording::Finding;
use serde::Serialize;

use super::Summary;
use crate::outlet::{Outlet, Screen};

/// Version of the events.
const VERSION: u32 = 1;

/// Reports events. A reader who stops reading does not stop the recording: events without room are
/// dropped, the status first.
pub struct Reporter {
    json: bool,
    quiet: bool,
    out: Outlet,
    pub screen: Screen,
}

impl Reporter {
    /// With `json` on standard output, otherwise on standard error.
    pub fn new(json: bool, quiet: bool) -> Self {
        Reporter {
            json,
            quiet,
            out: Outlet::new(io::stdout(), true),
            screen: Screen::new(true),
        }
    }

    pub fn event(&mut self, event: &Event) {
        if let Event::Status(status) = event
            && !self.quiet
        {
            self.screen.status(&status.line());
        }
        self.report(None, event, event.words(self.screen.is_raw));
    }

    pub fn warn(&mut self, text: String) {
        self.event(&Event::Warning { text });
    }

    /// Something is odd in the samples: an axis is frozen, a limit of the range is reached.
    pub fn finding(&mut self, finding: &Finding) {
        let words = format!("! {}: {}", finding.kind, finding.message);
        self.report(Some("finding"), finding, Some(words));
    }

    pub fn ended(&mut self, summary: &Summary) {
        // A reader who still reads needs this one.
        let _ = self.out.drain();
        self.report(Some("ended"), summary, summary.words());
    }

    /// `kind`: the type of what does not name it itself.
    fn report(&mut self, kind: Option<&str>, event: &impl Serialize, words: Option<String>) {
        if !self.json {
            let words = words.filter(|words| !self.quiet || words.starts_with('!'));
            words
                .iter()
                .for_each(|words| self.screen.line(&shown(words)));
            return;
        }
        if let Some(n) = self.out.take_dropped() {
            self.warn(format!(
                "{n} events were dropped here: they were not read in time"
            ));
        }
        let mut event = serde_json::to_value(event).unwrap_or_default();
        event["v"] = VERSION.into();
        if let Some(kind) = kind {
            event["type"] = kind.into();
        }
        let is_status = event["type"] == "status";
        let text = event.to_string();
        let line = shown_json(&text).into_owned() + self.screen.end();
        let send = if is_status {
            Outlet::status
        } else {
            Outlet::send
        };
        // A reader who has gone does not end the recording.
        let _ = send(&mut self.out, line);
    }
}
