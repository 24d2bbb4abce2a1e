//! What is said while it records: JSON for scripts, lines and a status line for people.

use std::io::{self, IsTerminal as _};
use std::process::ExitCode;

use gravical::output::{shown, shown_json};

use super::outlet::Outlet;
use crate::device::board::Settings;
use crate::device::event::Event;
use crate::device::item::Reason;
use crate::device::live::Status;
use crate::failure::RenderedError;

/// Version of the events.
const VERSION: u32 = 1;

/// Says what happens.
pub struct Teller {
    json: bool,
    quiet: bool,
    /// The terminal is raw: a line ends with carriage return and line feed.
    pub raw: bool,
    terminal: bool,
    /// A status line stands on the screen.
    standing: bool,
    out: Outlet,
    err: Outlet,
    /// How the board is set, for units.
    pub settings: Option<Settings>,
}

impl Teller {
    /// With `json` on standard output, else on standard error.
    pub fn new(json: bool, quiet: bool) -> Self {
        Teller {
            json,
            quiet,
            raw: false,
            terminal: io::stderr().is_terminal(),
            standing: false,
            out: Outlet::new(io::stdout()),
            err: Outlet::new(io::stderr()),
            settings: None,
        }
    }

    /// Tells one event. Whoever does not listen any more, or does not read, does not stop
    /// the recording: what finds no room is left out, the status first.
    pub fn tell(&mut self, event: &Event) {
        if self.json {
            self.json(event);
        }
        if let Event::Status { .. } = event {
            self.status(event);
        } else if !self.json
            && let Some(text) = text(event, self.raw)
            && (!self.quiet || is_trouble(event))
        {
            self.line(&text);
        }
    }

    /// Tells that the disk fails, or does no more; once each. `before` is what it said.
    pub fn failing(&mut self, before: &mut Option<String>, error: Option<String>) {
        match (&*before, &error) {
            (None, Some(text)) => self.tell(&Event::DiskFailed { text: text.clone() }),
            (Some(_), None) => self.tell(&Event::DiskRecovered),
            _ => {}
        }
        *before = error;
    }

    fn json(&mut self, event: &Event) {
        if matches!(event, Event::Ended { .. }) {
            // This one is wanted by whoever still reads.
            self.out.drain();
        }
        if let Some(n) = self.out.take_left_out() {
            let text = format!("{n} events are left out here: nobody read them in time");
            let bytes = self.object(&Event::Warning { text });
            self.out.say(bytes);
        }
        let bytes = self.object(event);
        match event {
            Event::Status { .. } => self.out.status(bytes),
            _ => self.out.say(bytes),
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
        let clear = if self.standing { "\r\x1b[K" } else { "" };
        self.standing = false;
        let text = shown(text.trim_end()).replace('\n', end);
        self.err.say(format!("{clear}{text}{end}").into_bytes());
    }

    fn status(&mut self, event: &Event) {
        if self.terminal && !self.quiet {
            let line = status_line(event, self.settings.as_ref());
            self.err.status(format!("\r{line}\x1b[K").into_bytes());
            self.standing = true;
        }
    }

    /// Tells why it failed; the exit code.
    pub fn fail(&mut self, error: &anyhow::Error) -> ExitCode {
        let Some(rendered) = RenderedError::of(error) else {
            return ExitCode::SUCCESS;
        };
        self.close();
        let (outlet, text) = if self.json {
            (
                &mut self.out,
                format!("{}\n", shown_json(&rendered.object.to_string())),
            )
        } else {
            (&mut self.err, rendered.text)
        };
        outlet.drain();
        outlet.say(text.into_bytes());
        ExitCode::from(rendered.exit)
    }

    /// The status line becomes an ordinary one.
    pub fn close(&mut self) {
        if std::mem::take(&mut self.standing) {
            let end = if self.raw { "\r\n" } else { "\n" };
            self.err.say(end.into());
        }
        self.raw = false;
    }

    /// Waits until all is said, as long as somebody reads.
    pub fn drain(&mut self) {
        self.out.drain();
        self.err.drain();
    }
}

fn is_trouble(event: &Event) -> bool {
    matches!(
        event,
        Event::Gap(_)
            | Event::Lost { .. }
            | Event::Shared { .. }
            | Event::Silent { .. }
            | Event::DiskFailed { .. }
            | Event::DiskRecovered
            | Event::Rejected { .. }
            | Event::Warning { .. }
    )
}

/// A sentence, where an event is worth one.
fn text(event: &Event, keyboard: bool) -> Option<String> {
    Some(match event {
        Event::Opened { port, device } => match device {
            Some(device) => format!("{port}: {device}"),
            None => format!("{port}: open"),
        },
        Event::Shared { programs } => format!(
            "! {programs} has the port open, too: rows that it reads do not come here; close it"
        ),
        Event::Waiting { text } => format!("waiting for {text}"),
        Event::Commands { text } => format!("to the board: {text}"),
        Event::Board { text } => text.clone(),
        Event::Started { .. } if keyboard => "recording; space pauses, q or Ctrl-C ends".to_owned(),
        Event::Started { .. } => "recording".to_owned(),
        Event::Paused => "paused; space goes on".to_owned(),
        Event::Resumed => "recording".to_owned(),
        Event::Warning { text } => format!("! {text}"),
        Event::Rejected {
            reason: Reason::BadFrame,
            text,
        } => {
            let why = text.split_once("# ").map_or(text.as_str(), |(_, why)| why);
            format!("! rejected: no frame: {why}")
        }
        Event::Rejected { reason, text } => {
            // Bytes of a frame have their reason behind them.
            let text = text.split("  # ").next().unwrap_or_default();
            let shown: String = text.chars().filter(|c| !c.is_control()).take(50).collect();
            format!("! rejected: {}: \"{shown}\"", reason.text())
        }
        Event::Gap(gap) => format!("! {}", gap.line().trim_start_matches("# ").trim_end()),
        Event::Lost { text } => {
            format!("! the port is gone ({text}); plug it in again, it goes on by itself")
        }
        Event::Silent { duration_s } => {
            format!("! nothing has come from the board for {duration_s:.0} s")
        }
        Event::DiskFailed { text } => {
            format!("! the disk takes nothing ({text}); make room, it goes on by itself")
        }
        Event::DiskRecovered => "the disk takes rows again".to_owned(),
        Event::Speed { .. } | Event::Status { .. } | Event::Ended { .. } => return None,
    })
}

/// One line of at most 80 columns.
fn status_line(event: &Event, settings: Option<&Settings>) -> String {
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
    let mut line = format!("{elapsed_s:7.1} s {rows:8} rows");
    if let Some(rate) = live.rate_hz {
        line.push_str(&format!("  {rate:5.1} Hz"));
    }
    line.push_str(&norm_and_temperature(live, settings));
    line.push_str(match (paused, live.still) {
        (true, _) => "  PAUSED",
        (_, Some(true)) => "  still",
        (_, Some(false)) => "  moving",
        (_, None) => "",
    });
    if *rejected > 0 {
        line.push_str(&format!("  {rejected} rejected"));
    }
    line.chars().take(79).collect()
}

fn norm_and_temperature(live: &Status, settings: Option<&Settings>) -> String {
    let (Some(norm), Some(temperature)) = (live.norm, live.temperature) else {
        return String::new();
    };
    match settings {
        Some(s) if s.format >= 1 => {
            let norm_g = norm * f64::from(s.accel_range_g) / 32768.0;
            let celsius = temperature / 340.0 + 36.53;
            format!("  ‖a‖ {norm_g:.3} g  {celsius:.1} °C")
        }
        Some(_) => format!("  ‖a‖ {norm:.2} m/s²  {temperature:.1} °C"),
        // Whatever the unit is.
        None => format!("  ‖a‖ {norm:.2}  T {temperature:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::gap::{Cause, Gap};

    #[test]
    fn a_status_line_fits_and_has_units() {
        let live = Status {
            rate_hz: Some(100.04),
            norm: Some(9.8134),
            temperature: Some(25.53),
            still: Some(true),
        };
        let status = |paused, live| Event::Status {
            rows: 123_456,
            elapsed_s: 1234.56,
            paused,
            rejected: 0,
            live,
        };
        let line = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0";
        let si = Settings::parse(line).unwrap();
        assert_eq!(
            status_line(&status(false, live), Some(&si)),
            " 1234.6 s   123456 rows  100.0 Hz  ‖a‖ 9.81 m/s²  25.5 °C  still"
        );
        let counts = Settings { format: 1, ..si };
        let raw = Status {
            norm: Some(8201.0),
            temperature: Some(-3740.0),
            still: None,
            ..live
        };
        assert_eq!(
            status_line(&status(true, raw), Some(&counts)),
            " 1234.6 s   123456 rows  100.0 Hz  ‖a‖ 1.001 g  25.5 °C  PAUSED"
        );
        let nothing = status_line(&status(false, Status::default()), None);
        assert_eq!(nothing, " 1234.6 s   123456 rows");
    }

    #[test]
    fn gaps_read_like_the_file() {
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
