//! Where the events of a recording go: JSON for scripts, messages and a status line for people.

use std::io;

use gravical::escape::{shown, shown_json};
use serde::Serialize;

use super::event::Event;
use crate::outlet::{Outlet, Screen};

/// Version of the events.
const VERSION: u32 = 1;

#[derive(Serialize)]
struct Versioned<'a> {
    v: u32,
    #[serde(flatten)]
    event: &'a Event,
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

    /// Reports events, in order.
    pub fn report(&mut self, events: &[Event]) {
        for event in events {
            if self.json {
                self.json(event);
            }
            if let Event::Status(status) = event
                && !self.quiet
            {
                self.screen.status(&status.line());
            } else if !self.json
                && let Some(words) = event.words(self.screen.is_raw)
                && (!self.quiet || words.starts_with('!'))
            {
                self.screen.line(&shown(&words));
            }
        }
    }

    fn json(&mut self, event: &Event) {
        if matches!(event, Event::Ended(_)) {
            // A reader who still reads needs this one.
            let _ = self.out.drain();
        }
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time");
            self.json(&Event::Warning { text });
        }
        let v = VERSION;
        let text = serde_json::to_string(&Versioned { v, event }).unwrap_or_default();
        let line = format!("{}{}", shown_json(&text), self.screen.end());
        // A reader who has gone does not end the recording.
        let _ = match event {
            Event::Status(_) => self.out.status(line),
            _ => self.out.send(line),
        };
    }
}
