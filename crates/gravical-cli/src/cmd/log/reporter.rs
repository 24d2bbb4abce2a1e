//! Reports the events of a recording: JSON for scripts, messages and a status line for
//! people.

use std::collections::BTreeMap;
use std::io;
use std::process::ExitCode;

use gravical::escape::{shell_word, shown, shown_json};
use gravical::inspect::Inspection;
use gravical::numfmt;
use gravical_report::document::Remark;
use serde::Serialize;

use super::POSE_S;
use super::event::{Ended, Event};
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
    pub fn summary(&mut self, ended: &Ended) {
        if !self.json && !self.quiet {
            self.screen.line(&shown(&summary(ended)));
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

/// Counts of rows and lines, the poses, and what the file holds, for people.
fn summary(ended: &Ended) -> String {
    let (file, counts) = (&ended.file, &ended.counts);
    let mut text = format!("{file}: {} rows in {:.1} s\n", counts.rows, ended.elapsed_s);
    if counts.rejected > 0 {
        let rejected = counts.rejected;
        text += &format!("  rejected  {rejected} lines, marked in the file\n");
    }
    if counts.gaps > 0 {
        let missing = match counts.missing {
            0 => String::new(),
            n => format!(", {n} rows known to be missing"),
        };
        let gaps = counts.gaps;
        text += &format!("  gaps      {gaps}{missing}; the file names each\n");
    }
    if let Some(inspection) = &ended.inspection {
        text += &content(inspection);
    }
    text + &format!("Next: gravical inspect {}", shell_word(file))
}

/// Poses, unit, rate and findings.
fn content(inspection: &Inspection) -> String {
    let mut poses: BTreeMap<&str, f64> = BTreeMap::new();
    for rest in &inspection.static_intervals {
        let duration_s = rest
            .end_s
            .zip(rest.start_s)
            .map_or(0.0, |(end, start)| end - start);
        if duration_s >= POSE_S {
            *poses
                .entry(rest.face.as_deref().unwrap_or("free"))
                .or_default() += duration_s;
        }
    }
    let poses = poses
        .iter()
        .map(|(face, duration_s)| format!("{face} {duration_s:.1} s"));
    let poses: Vec<String> = poses.collect();
    let mut text = String::new();
    if !poses.is_empty() {
        text += &format!("  poses     {}\n", poses.join(", "));
    }
    let unit = numfmt::unit(inspection.accelerometer.unit.name());
    let range = inspection.accelerometer.lsb_per_g.map(|lsb| 32768.0 / lsb);
    let range = range.map_or_else(String::new, |g| format!(" of ±{g:.0} g"));
    let rate = inspection.timing.rate_hz();
    let rate = rate.map_or_else(String::new, |hz| format!(", {hz:.2} Hz"));
    text += &format!("  accelerometer in {unit}{range}{rate}\n");
    let remarks = Remark::all(&inspection.findings, false);
    text.extend(remarks.iter().map(Remark::to_text));
    text
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
