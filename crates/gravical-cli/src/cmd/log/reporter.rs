//! Reports the events of a recording: JSON for scripts, messages and a status line for
//! people.

use std::io;
use std::process::ExitCode;

use gravical::escape::{shown, shown_json};
use serde::Serialize;

use super::event::Event;
use super::status::status_line;
use crate::failure::RenderedError;
use crate::outlet::{Outlet, Sink};
use crate::screen::Screen;

/// Version of the events.
const VERSION: u32 = 1;

#[derive(Serialize)]
struct Versioned<'a> {
    v: u32,
    #[serde(flatten)]
    event: &'a Event,
}

/// Reports events.
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
            out: Outlet::new(io::stdout()),
            screen: Screen::new(Sink::Queued(Outlet::new(io::stderr()))),
        }
    }

    /// Reports one event. A reader who stops reading does not stop the recording: events
    /// without room are dropped, the status first.
    pub fn report(&mut self, event: &Event) {
        if self.json {
            self.json(event);
        }
        if let Event::Status(status) = event {
            if !self.quiet {
                self.screen.status(&status_line(status));
            }
        } else if !self.json
            && let Some(text) = text(event, self.screen.is_raw)
            && (!self.quiet || text.starts_with('!'))
        {
            self.screen.line(&shown(&text));
        }
    }

    /// Reports events, in order.
    pub fn report_all(&mut self, events: &[Event]) {
        events.iter().for_each(|event| self.report(event));
    }

    fn json(&mut self, event: &Event) {
        if matches!(event, Event::Ended(_)) {
            // A reader who still reads needs this one.
            self.out.drain();
        }
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time");
            let bytes = self.object(&Event::Warning { text });
            self.out.send(bytes);
        }
        let bytes = self.object(event);
        match event {
            Event::Status(_) => self.out.status(bytes),
            _ => self.out.send(bytes),
        }
    }

    fn object(&self, event: &Event) -> Vec<u8> {
        let event = Versioned { v: VERSION, event };
        let text = serde_json::to_string(&event).unwrap_or_default();
        format!("{}{}", shown_json(&text), self.screen.end()).into_bytes()
    }

    /// The summary for people.
    pub fn summary(&mut self, text: &str) {
        if !self.json && !self.quiet {
            self.screen.line(&shown(text));
        }
    }

    /// Reports an error; returns the exit code.
    pub fn fail(&mut self, error: &anyhow::Error) -> ExitCode {
        let Some(error) = RenderedError::of(error) else {
            return ExitCode::SUCCESS;
        };
        self.screen.close();
        if self.json {
            self.out.drain();
            let line = format!("{}\n", shown_json(&error.object.to_string()));
            self.out.send(line.into_bytes());
        } else {
            self.screen.drain();
            self.screen.line(&error.text);
        }
        ExitCode::from(error.exit)
    }

    /// Waits until everything is written, as long as somebody reads.
    pub fn drain(&mut self) {
        self.out.drain();
        self.screen.drain();
    }
}

/// The message of an event; none where it needs none.
fn text(event: &Event, keyboard: bool) -> Option<String> {
    Some(match event {
        Event::Opened { port, device } => {
            let device = device.as_deref().unwrap_or("open");
            format!("{port}: {device}; waiting for the board (opening its port may reset it)")
        }
        Event::Waiting { text } => format!("waiting for {text}"),
        Event::Board { text } => text.clone(),
        Event::Started { .. } if keyboard => "recording; space pauses, q or Ctrl-C ends".to_owned(),
        Event::Started { .. } | Event::Resumed => "recording".to_owned(),
        Event::Paused => "paused; space resumes".to_owned(),
        Event::Warning { text } => format!("! {text}"),
        Event::NoRows { text, hint } => format!("! {text}\n  try: {hint}"),
        Event::Rejected { count: 1, first } => format!("! a line is no row: {first:?}"),
        Event::Rejected { count, first } => {
            format!("! {count} lines so far are no rows; one of them: {first:?}")
        }
        Event::Gap(gap) => format!("! {}", gap.line().trim_start_matches("# ")),
        Event::Finding(finding) => format!("! {}: {}", finding.kind, finding.message),
        Event::Lost { text } => format!(
            "! the port is lost ({text}); plug the board in again, the recording resumes by itself"
        ),
        Event::Silent { duration_s } => {
            format!("! the board has sent nothing for {duration_s:.0} s")
        }
        Event::Status(_) | Event::Ended(_) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cmd::log::gaps::{Cause, Gap};

    #[test]
    fn gaps_are_worded_as_in_the_file() {
        let gap = Event::Gap(Gap {
            cause: Cause::Unplugged,
            rows: Some(12),
            duration_s: 0.5,
            clock_restarts: false,
            until_end: false,
        });
        assert_eq!(
            text(&gap, true).unwrap(),
            "! gap: unplugged: 12 rows are missing, 0.5 s"
        );
    }
}
