//! Reports the events of a recording: JSON for scripts, messages and a status line for
//! people.

use std::io::{self, IsTerminal as _};
use std::process::ExitCode;

use gravical::core::unit::STANDARD_GRAVITY_MPS2;
use gravical::escape::{shown, shown_json};
use gravical::numfmt;
use gravical::poses::face::{AXES, Face};
use gravical::recording::{AccelScale, AccelUnit};

use crate::device::board::Settings;
use crate::device::event::Event;
use crate::failure::RenderedError;
use crate::outlet::Outlet;

/// Version of the events.
const VERSION: u32 = 1;

/// Reports events.
pub struct Reporter {
    json: bool,
    quiet: bool,
    /// The terminal is raw: a line ends with carriage return and line feed.
    pub raw: bool,
    terminal: bool,
    /// The cursor is in a status line.
    in_status: bool,
    out: Outlet,
    err: Outlet,
    /// Settings of the board, for temperatures in counts.
    pub settings: Option<Settings>,
    /// Unit of the accelerometer, once it is known.
    pub accel: Option<AccelScale>,
    /// Events are kept for the caller and not shown.
    kept: Option<Vec<Event>>,
}

impl Reporter {
    /// With `json` on standard output, otherwise on standard error.
    pub fn new(json: bool, quiet: bool) -> Self {
        Reporter {
            json,
            quiet,
            raw: false,
            terminal: io::stderr().is_terminal(),
            in_status: false,
            out: Outlet::new(io::stdout()),
            err: Outlet::new(io::stderr()),
            settings: None,
            accel: None,
            kept: None,
        }
    }

    /// One that keeps the events for [`take_kept`](Self::take_kept), and shows only what is
    /// waited for.
    pub fn keeping() -> Self {
        Reporter {
            kept: Some(Vec::new()),
            ..Reporter::new(false, true)
        }
    }

    /// The events that were kept since the last call.
    pub fn take_kept(&mut self) -> Vec<Event> {
        self.kept.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Reports one event. A reader who stops reading does not stop the recording: events
    /// without room are dropped, the status first.
    pub fn report(&mut self, event: &Event) {
        if let Some(kept) = &mut self.kept {
            kept.push(event.clone());
            // There is no session yet that could say so.
            if let Event::Waiting { text } = event {
                self.line(&format!("waiting for {text}"));
            }
            return;
        }
        if self.json {
            self.json(event);
        }
        if let Event::Status { .. } = event {
            self.status(event);
        } else if !self.json
            && let Some(text) = text(event, self.raw)
            && (!self.quiet || is_warning(event))
        {
            self.line(&text);
        }
    }

    /// Reports that the disk fails, or has recovered; once each. `before` is the error
    /// before this one.
    pub fn disk_error(&mut self, before: &mut Option<String>, error: Option<String>) {
        match (&*before, &error) {
            (None, Some(text)) => self.report(&Event::DiskFailed { text: text.clone() }),
            (Some(_), None) => self.report(&Event::DiskRecovered),
            _ => {}
        }
        *before = error;
    }

    fn json(&mut self, event: &Event) {
        if matches!(event, Event::Ended { .. }) {
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
            Event::Status { .. } => self.out.status(bytes),
            _ => self.out.send(bytes),
        }
    }

    fn object(&self, event: &Event) -> Vec<u8> {
        let Ok(serde_json::Value::Object(object)) = serde_json::to_value(event) else {
            return Vec::new();
        };
        let mut line = serde_json::Map::new();
        line.insert("v".to_owned(), VERSION.into());
        line.extend(object);
        let end = if self.raw { "\r\n" } else { "\n" };
        let text = serde_json::Value::Object(line).to_string();
        format!("{}{end}", shown_json(&text)).into_bytes()
    }

    /// One line on standard error.
    pub fn line(&mut self, text: &str) {
        let end = if self.raw { "\r\n" } else { "\n" };
        let clear = if self.in_status { "\r\x1b[K" } else { "" };
        self.in_status = false;
        let text = shown(text.trim_end()).replace('\n', end);
        self.err.send(format!("{clear}{text}{end}").into_bytes());
    }

    /// One line on standard error of what takes time, unless it is not wanted.
    pub fn progress(&mut self, text: &str) {
        if !self.json && !self.quiet {
            self.line(text);
        }
    }

    fn status(&mut self, event: &Event) {
        if self.terminal && !self.quiet {
            let line = status_line(event, self.accel.as_ref(), self.settings.as_ref());
            self.err.status(format!("\r{line}\x1b[K").into_bytes());
            self.in_status = true;
        }
    }

    /// Reports an error; returns the exit code.
    pub fn fail(&mut self, error: &anyhow::Error) -> ExitCode {
        let Some(error) = RenderedError::of(error) else {
            return ExitCode::SUCCESS;
        };
        self.close();
        let (outlet, text) = if self.json {
            (
                &mut self.out,
                format!("{}\n", shown_json(&error.object.to_string())),
            )
        } else {
            (&mut self.err, error.text)
        };
        outlet.drain();
        outlet.send(text.into_bytes());
        ExitCode::from(error.exit)
    }

    /// Ends the status line.
    pub fn close(&mut self) {
        if std::mem::take(&mut self.in_status) {
            let end = if self.raw { "\r\n" } else { "\n" };
            self.err.send(end.into());
        }
        self.raw = false;
    }

    /// Waits until everything is written, as long as somebody reads.
    pub fn drain(&mut self) {
        self.out.drain();
        self.err.drain();
    }
}

fn is_warning(event: &Event) -> bool {
    matches!(
        event,
        Event::Gap(_)
            | Event::Finding(_)
            | Event::Lost { .. }
            | Event::Shared { .. }
            | Event::Silent { .. }
            | Event::DiskFailed { .. }
            | Event::DiskRecovered
            | Event::Rejected { .. }
            | Event::Warning { .. }
    )
}

/// The message of an event; none where it needs none.
fn text(event: &Event, keyboard: bool) -> Option<String> {
    Some(match event {
        Event::Opened { port, device } => match device {
            Some(device) => format!("{port}: {device}"),
            None => format!("{port}: open"),
        },
        Event::Shared { programs } => format!(
            "! {programs} has the port open too: rows that it reads are lost here; close it"
        ),
        Event::Waiting { text } => format!("waiting for {text}"),
        Event::Commands { text } => format!("to the board: {text}"),
        Event::Board { text } => text.clone(),
        Event::Started { .. } if keyboard => "recording; space pauses, q or Ctrl-C ends".to_owned(),
        Event::Started { .. } => "recording".to_owned(),
        Event::Paused => "paused; space resumes".to_owned(),
        Event::Resumed => "recording".to_owned(),
        Event::Warning { text } => format!("! {text}"),
        Event::Rejected { reason, text } => {
            let shown: String = text.chars().filter(|c| !c.is_control()).take(50).collect();
            format!("! rejected: {}: \"{shown}\"", reason.text())
        }
        Event::Gap(gap) => format!("! {}", gap.line().trim_start_matches("# ").trim_end()),
        Event::Finding(finding) => format!("! {}: {}", finding.kind, finding.message),
        Event::Lost { text } => {
            format!(
                "! the port is lost ({text}); plug the board in again, the recording resumes by itself"
            )
        }
        Event::Silent { duration_s } => {
            format!("! the board has sent nothing for {duration_s:.0} s")
        }
        Event::DiskFailed { text } => {
            format!("! the disk takes no rows ({text}); make room, the recording resumes by itself")
        }
        Event::DiskRecovered => "the disk takes rows again".to_owned(),
        Event::Status { .. } | Event::Ended { .. } => return None,
    })
}

/// A part of the status line; those with the lowest priority are left out where there is
/// no room.
struct Part {
    text: String,
    priority: u8,
}

/// Columns of the status line.
const MOST_COLUMNS: usize = 79;

/// One line of at most 79 columns.
fn status_line(event: &Event, accel: Option<&AccelScale>, settings: Option<&Settings>) -> String {
    let Event::Status {
        rows,
        elapsed_s,
        paused,
        rejected,
        live,
    } = event
    else {
        return String::new();
    };
    let mut parts = Vec::new();
    let mut add = |priority, text: Option<String>| {
        parts.extend(text.map(|text| Part { text, priority }));
    };
    add(9, Some(format!("{elapsed_s:.1} s")));
    add(9, Some(format!("{rows} rows")));
    add(3, live.rate_hz.map(|rate| format!("{rate:.1} Hz")));
    add(6, live.norm.map(|norm| norm_text(norm, accel)));
    let temperature = live.temperature.map(|t| temperature_text(t, settings));
    add(2, temperature);
    let state = match (paused, live.still) {
        (true, _) => Some("PAUSED"),
        (_, Some(true)) => Some("at rest"),
        (_, Some(false)) => Some("moving"),
        (_, None) => None,
    };
    add(9, state.map(str::to_owned));
    add(8, live.up.as_ref().map(|up| format!("up: {up}")));
    if let Some(done) = &live.done {
        let all = Face::all().map(Face::name);
        let (done, missing): (Vec<String>, Vec<String>) =
            all.into_iter().partition(|face| done.contains(face));
        add(
            1,
            (!done.is_empty()).then(|| format!("done {}", done.join(" "))),
        );
        let missing = match missing.is_empty() {
            true => "all 6 done".to_owned(),
            false => format!("missing {}", shortened(&missing)),
        };
        add(7, Some(missing));
    }
    add(5, (*rejected > 0).then(|| format!("{rejected} rejected")));
    loop {
        let texts: Vec<&str> = parts.iter().map(|part| part.text.as_str()).collect();
        let line = texts.join("  ");
        let least = parts.iter().map(|part| part.priority).min();
        if line.chars().count() <= MOST_COLUMNS || least.is_none_or(|least| least >= 9) {
            return line.chars().take(MOST_COLUMNS).collect();
        }
        parts.retain(|part| Some(part.priority) != least);
    }
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

/// In the unit of the recording, once that is known; counts in g.
fn norm_text(norm: f64, accel: Option<&AccelScale>) -> String {
    let Some(accel) = accel.filter(|accel| accel.unit != AccelUnit::Unknown) else {
        return format!("‖a‖ {norm:.2}");
    };
    match (accel.unit, accel.nominal()) {
        (AccelUnit::Counts, Some(lsb)) => {
            format!("‖a‖ {:.3} g", norm / lsb / STANDARD_GRAVITY_MPS2)
        }
        (AccelUnit::StandardGravity, _) => format!("‖a‖ {norm:.3} g"),
        (unit, _) => format!("‖a‖ {norm:.2} {}", numfmt::unit(unit.name())),
    }
}

fn temperature_text(temperature: f64, settings: Option<&Settings>) -> String {
    match settings {
        Some(s) if s.is_counts() => format!("{:.1} °C", s.celsius(temperature)),
        Some(_) => format!("{temperature:.1} °C"),
        None => format!("T {temperature:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::recording::Origin;

    use crate::device::gap::{Cause, Gap};
    use crate::device::live::Status;

    fn status(paused: bool, live: Status) -> Event {
        Event::Status {
            rows: 123_456,
            elapsed_s: 1234.56,
            paused,
            rejected: 0,
            live,
        }
    }

    #[test]
    fn a_status_line_has_units() {
        let live = Status {
            rate_hz: Some(100.04),
            norm: Some(9.8134),
            temperature: Some(25.53),
            still: Some(true),
            ..Status::default()
        };
        let line = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0";
        let si = Settings::parse(line).unwrap();
        let unit = |unit, lsb_per_g| AccelScale {
            unit,
            lsb_per_g,
            origin: Origin::Header,
        };
        let metric = unit(AccelUnit::MetrePerSecondSquared, None);
        assert_eq!(
            status_line(&status(false, live.clone()), Some(&metric), Some(&si)),
            "1234.6 s  123456 rows  100.0 Hz  ‖a‖ 9.81 m/s²  25.5 °C  at rest"
        );
        let counts = Settings { format: 1, ..si };
        let raw = Status {
            norm: Some(8201.0),
            temperature: Some(-3740.0),
            still: None,
            ..live.clone()
        };
        assert_eq!(
            status_line(
                &status(true, raw),
                Some(&unit(AccelUnit::Counts, Some(8192.0))),
                Some(&counts)
            ),
            "1234.6 s  123456 rows  100.0 Hz  ‖a‖ 1.001 g  25.5 °C  PAUSED"
        );
        assert_eq!(
            status_line(&status(false, live), None, None),
            "1234.6 s  123456 rows  100.0 Hz  ‖a‖ 9.81  T 25.5  at rest"
        );
        let empty = status_line(&status(false, Status::default()), None, None);
        assert_eq!(empty, "1234.6 s  123456 rows");
    }

    #[test]
    fn a_status_line_has_poses_as_far_as_there_is_room() {
        let poses = |done: &[&str]| {
            let live = Status {
                rate_hz: Some(100.04),
                norm: Some(9.8134),
                temperature: Some(25.53),
                still: Some(true),
                up: Some("-x".to_owned()),
                done: Some(done.iter().map(|face| (*face).to_owned()).collect()),
            };
            let line = status_line(&status(false, live), None, None);
            assert!(line.chars().count() <= MOST_COLUMNS);
            line
        };
        assert_eq!(
            poses(&["+x", "+y"]),
            "1234.6 s  123456 rows  100.0 Hz  ‖a‖ 9.81  at rest  up: -x  missing -x -y ±z"
        );
        assert_eq!(
            poses(&["+x", "-x", "+y", "-y", "+z"]),
            "1234.6 s  123456 rows  100.0 Hz  ‖a‖ 9.81  T 25.5  at rest  up: -x  missing -z"
        );
        assert!(poses(&["+x", "-x", "+y", "-y", "+z", "-z"]).ends_with("up: -x  all 6 done"));
    }

    #[test]
    fn gaps_are_worded_as_in_the_file() {
        let gap = Event::Gap(Gap {
            rows: 12,
            duration_s: 0.5,
            ..Gap::new(Cause::Unplugged)
        });
        assert_eq!(
            text(&gap, true).unwrap(),
            "! gap: unplugged: 12 rows are missing, 0.5 s"
        );
    }
}
