//! Reports the events of a recording: JSON for scripts, messages and a status line for
//! people.

use std::io;
use std::process::ExitCode;

use gravical::escape::{shown, shown_json};
use gravical::poses::face::{AXES, Face};
use gravical::recording::AccelScale;
use serde::Serialize;

use super::event::Event;
use super::event::Status;
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
        Event::Warning { text } | Event::NoRows { text, .. } => format!("! {text}"),
        Event::Rejected { count: 1, first } => format!("! a line is no row: {first:?}"),
        Event::Rejected { count, first } => {
            format!("! {count} lines so far are no rows; one of them: {first:?}")
        }
        Event::Gap(gap) => format!("! {}", gap.line().trim_start_matches("# ")),
        Event::Finding(finding) => format!("! {}: {}", finding.kind, finding.message),
        Event::Lost { text } => {
            format!(
                "! the port is lost ({text}); plug the board in again, the recording resumes by itself"
            )
        }
        Event::Silent { duration_s } => {
            format!("! the board has sent nothing for {duration_s:.0} s")
        }
        Event::Status(_) | Event::Ended(_) => return None,
    })
}

/// Columns of the status line.
const MAX_COLUMNS: usize = 79;

/// One line of at most 79 columns: what is needed most comes first, and the rest where there is room.
fn status_line(status: &Status) -> String {
    let mut parts = vec![
        format!("{:.1} s", status.elapsed_s),
        format!("{} rows", status.rows),
    ];
    parts.extend(match (status.paused, status.still) {
        (true, _) => Some("PAUSED".to_owned()),
        (_, Some(true)) => Some("at rest".to_owned()),
        (_, Some(false)) => Some("moving".to_owned()),
        (_, None) => None,
    });
    parts.extend(status.up.as_ref().map(|up| format!("up: {up}")));
    parts.extend(status.done.as_ref().map(|done| {
        let mut missing = Face::all().map(Face::name).to_vec();
        missing.retain(|face| !done.contains(face));
        if missing.is_empty() {
            "all 6 done".to_owned()
        } else {
            format!("missing {}", shortened(&missing))
        }
    }));
    parts.extend(status.norm.map(|norm| norm_text(norm, status.accel)));
    parts.extend((status.rejected > 0).then(|| format!("{} rejected", status.rejected)));
    parts.extend(status.rate_hz.map(|rate| format!("{rate:.1} Hz")));
    parts.extend(status.temperature_c.map(|t| format!("{t:.1} °C")));
    while parts.join("  ").chars().count() > MAX_COLUMNS && parts.pop().is_some() {}
    parts.join("  ")
}

/// `+x -x -y` as `±x -y`.
fn shortened(faces: &[String]) -> String {
    let of_axis = |axis: char| {
        let mut own = faces.iter().filter(move |face| face.ends_with(axis));
        match (own.next(), own.next()) {
            (Some(_), Some(_)) => Some(format!("±{axis}")),
            (one, _) => one.cloned(),
        }
    };
    let axes: Vec<String> = AXES.into_iter().filter_map(of_axis).collect();
    axes.join(" ")
}

/// In m/s², or as it stands in a file of unknown unit.
fn norm_text(norm: f64, accel: Option<AccelScale>) -> String {
    match accel.and_then(|accel| accel.nominal()) {
        Some(per_mps2) => format!("‖a‖ {:.2} m/s²", norm / per_mps2),
        None => format!("‖a‖ {norm:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::recording::{AccelUnit, Origin};

    use crate::cmd::log::gaps::{Cause, Gap};

    fn status() -> Status {
        Status {
            rows: 123_456,
            elapsed_s: 1234.56,
            rate_hz: Some(100.04),
            norm: Some(9.8134),
            temperature_c: Some(25.53),
            still: Some(true),
            ..Status::default()
        }
    }

    #[test]
    fn a_status_line_has_units() {
        let unit = |unit, lsb_per_g| {
            Some(AccelScale {
                unit,
                lsb_per_g,
                origin: Origin::Header,
            })
        };
        let metric = Status {
            accel: unit(AccelUnit::MetrePerSecondSquared, None),
            ..status()
        };
        assert_eq!(
            status_line(&metric),
            "1234.6 s  123456 rows  at rest  ‖a‖ 9.81 m/s²  100.0 Hz  25.5 °C"
        );
        let counts = Status {
            norm: Some(8201.0),
            accel: unit(AccelUnit::Counts, Some(8192.0)),
            paused: true,
            ..status()
        };
        assert_eq!(
            status_line(&counts),
            "1234.6 s  123456 rows  PAUSED  ‖a‖ 9.82 m/s²  100.0 Hz  25.5 °C"
        );
        let empty = Status {
            rows: 5,
            ..Status::default()
        };
        assert_eq!(status_line(&empty), "0.0 s  5 rows");
    }

    #[test]
    fn a_status_line_has_poses_as_far_as_there_is_room() {
        let poses = |done: &[&str]| {
            let line = status_line(&Status {
                up: Some("-x".to_owned()),
                done: Some(done.iter().map(|face| (*face).to_owned()).collect()),
                ..status()
            });
            assert!(line.chars().count() <= MAX_COLUMNS);
            line
        };
        assert_eq!(
            poses(&["+x", "+y"]),
            "1234.6 s  123456 rows  at rest  up: -x  missing -x -y ±z  ‖a‖ 9.81  100.0 Hz"
        );
        assert!(poses(&["+x", "-x", "+y", "-y", "+z", "-z"]).contains("up: -x  all 6 done  "));
    }

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
