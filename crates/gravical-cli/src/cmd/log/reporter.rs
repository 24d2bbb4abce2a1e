//! Where the events of a recording go: JSON for scripts, messages and a status line for people.

use std::io;
use std::process::ExitCode;

use gravical::escape::{shell_word, shown, shown_json};
use gravical::numfmt::count;
use gravical_report::document::Detail;
use gravical_report::report;
use serde::Serialize;

use super::event::{Ended, Event};
use crate::failure::RenderedError;
use crate::outlet::Sink;
use crate::screen::Screen;

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
    out: Sink,
    pub screen: Screen,
}

impl Reporter {
    /// With `json` on standard output, otherwise on standard error.
    pub fn new(json: bool, quiet: bool) -> Self {
        Reporter {
            json,
            quiet,
            out: Sink::queued(io::stdout()),
            screen: Screen::new(Sink::queued(io::stderr())),
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
            self.out.drain();
        }
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time");
            self.json(&Event::Warning { text });
        }
        let v = VERSION;
        let text = serde_json::to_string(&Versioned { v, event }).unwrap_or_default();
        let line = format!("{}{}", shown_json(&text), self.screen.end());
        // A reader who has gone is no error.
        let _ = match event {
            Event::Status(_) => self.out.status(line),
            _ => self.out.send(line),
        };
    }

    /// The end: for people the counts, and what `gravical inspect` says of the file.
    pub fn ended(&mut self, ended: Ended) {
        if !self.json && !self.quiet && ended.counts.rows > 0 {
            self.screen.line(&shown(&summary(&ended)));
        }
        self.report(&[Event::Ended(Box::new(ended))]);
    }

    /// Reports an error as a line of its own; its exit code. None for a closed pipe.
    pub fn fail(&mut self, error: &anyhow::Error) -> Option<ExitCode> {
        let error = RenderedError::of(error)?;
        self.out.drain();
        let line = format!("{}\n", shown_json(&error.object.to_string()));
        let _ = self.out.send(line);
        Some(ExitCode::from(error.exit))
    }

    /// Waits until everything is written, as long as somebody reads.
    pub fn drain(&mut self) {
        self.out.drain();
        self.screen.drain();
    }
}

fn summary(ended: &Ended) -> String {
    let (file, counts) = (&ended.file, &ended.counts);
    let mut text = format!("{file}: {} rows in {:.1} s", counts.rows, ended.elapsed_s);
    for (n, what) in [
        (counts.rejected, "rejected line"),
        (counts.gaps, "gap"),
        (counts.missing, "missing row"),
    ] {
        if n > 0 {
            text += &format!(", {}", count(n, what));
        }
    }
    match &ended.inspection {
        Some(inspection) => {
            let document = report::inspection(inspection);
            format!("{text}\n\n{}", document.to_text(Detail::Full))
        }
        None => format!("{text}\nNext: gravical inspect {}", shell_word(file)),
    }
}
