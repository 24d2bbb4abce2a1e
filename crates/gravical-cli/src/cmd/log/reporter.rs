//! Where the events of a recording go: JSON for scripts, messages and a status line for people.

use std::io;

use gravical::escape::{shown, shown_json};
use gravical::recording::Finding;
use serde::Serialize;

use super::Summary;
use super::recorder::event::Event;
use crate::outlet::{Outlet, Screen};

/// Version of the events.
const VERSION: u32 = 1;

/// One event. As JSON an object a line with its `type`.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Report<'a> {
    Event(&'a Event),
    /// Something is odd in the samples: an axis is frozen, a limit of the range is reached.
    Finding(Typed<&'a Finding>),
    /// The end.
    Ended(Typed<&'a Summary>),
}

#[derive(Serialize)]
pub struct Typed<T> {
    r#type: &'static str,
    #[serde(flatten)]
    event: T,
}

#[derive(Serialize)]
struct Versioned<'a> {
    v: u32,
    #[serde(flatten)]
    report: &'a Report<'a>,
}

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
        self.report(&Report::Event(event), event.words(self.screen.is_raw));
    }

    pub fn warn(&mut self, text: String) {
        self.event(&Event::Warning { text });
    }

    pub fn finding(&mut self, event: &Finding) {
        let r#type = "finding";
        let words = format!("! {}: {}", event.kind, event.message);
        self.report(&Report::Finding(Typed { r#type, event }), Some(words));
    }

    pub fn ended(&mut self, event: &Summary) {
        // A reader who still reads needs this one.
        let _ = self.out.drain();
        let r#type = "ended";
        self.report(&Report::Ended(Typed { r#type, event }), event.words());
    }

    fn report(&mut self, report: &Report<'_>, words: Option<String>) {
        if self.json {
            self.print(report);
        } else if let Some(words) = words.filter(|words| !self.quiet || words.starts_with('!')) {
            self.screen.line(&shown(&words));
        }
    }

    fn print(&mut self, report: &Report<'_>) {
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time");
            self.print(&Report::Event(&Event::Warning { text }));
        }
        let v = VERSION;
        let text = serde_json::to_string(&Versioned { v, report }).unwrap_or_default();
        let line = format!("{}{}", shown_json(&text), self.screen.end());
        // A reader who has gone does not end the recording.
        let _ = match report {
            Report::Event(Event::Status(_)) => self.out.status(line),
            _ => self.out.send(line),
        };
    }
}
