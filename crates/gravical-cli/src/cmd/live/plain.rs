//! Events for a terminal, and for scripts.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use gravical::escape::{one_line, shown_json};
use gravical::live::event::{Event, Message, Status, TruthRow, WarningKind};
use gravical::{Error, Result};

use super::console::Renderer;
use crate::device::ports;
use crate::outlet::{Outlet, Sink};
use crate::screen::Screen;

/// One line an event on standard error, and a status line that is overwritten.
pub struct Plain {
    screen: Screen,
    last_hint: Option<String>,
}

impl Plain {
    /// For standard error; `real_time`: a session that waits for nobody.
    pub fn new(real_time: bool) -> Self {
        let out = if real_time {
            Sink::Queued(Outlet::new(io::stderr()))
        } else {
            Sink::Waiting(Box::new(io::stderr()))
        };
        Plain {
            screen: Screen::new(out),
            last_hint: None,
        }
    }

    fn line(&mut self, text: &str) {
        self.screen.line(&one_line(text));
    }

    fn status(&mut self, message: &Message, status: &Status) {
        let line = status_line(status, &message.text);
        if !self.screen.status(&one_line(&line))
            && let Some(hint) = &status.hint
            && status.hint != self.last_hint
        {
            // Without a terminal there is no status line; what hinders is said once.
            self.line(&format!("{:7.1} s  {hint}", message.t_s));
        }
        self.last_hint.clone_from(&status.hint);
    }
}

impl Renderer for Plain {
    fn show(&mut self, message: &Message) -> Result<()> {
        let t_s = message.t_s;
        if let Event::Status(status) = &message.event {
            self.status(message, status);
        } else if let Some(mark) = mark(&message.event) {
            self.line(&format!("{t_s:7.1} s  {mark}{}", message.text));
            for line in details(&message.event) {
                self.line(&format!("{t_s:7.1} s    {line}"));
            }
        }
        Ok(())
    }
}

fn status_line(status: &Status, text: &str) -> String {
    let bar = "#".repeat((10.0 * status.ring).round() as usize);
    let limit_mg = status.limit_mg;
    let limit = limit_mg.map_or(String::new(), |l| format!("/{l:.0}"));
    let say = status.hint.as_deref().unwrap_or(text);
    format!(
        "[{bar:.<10}] {} {:.0}° {:.3} g {:.0}{limit} mg  {say}",
        status.face, status.tilt_deg, status.norm_g, status.noise_mg
    )
}

/// What stands before the sentences of an event; none for one that has no line.
fn mark(event: &Event) -> Option<&'static str> {
    match event {
        Event::Status(_) | Event::PoseCandidate => None,
        Event::PoseAccepted(_) => Some("✓ "),
        Event::PoseRejected { .. } => Some("✗ "),
        Event::NextPose { .. } => Some("→ "),
        Event::Ports { .. } | Event::Warning { .. } | Event::Lost { .. } => Some("! "),
        _ => Some(""),
    }
}

/// What else an event has, a line each.
fn details(event: &Event) -> Vec<String> {
    match event {
        Event::Ports {
            ports,
            flash,
            simulate,
            ..
        } => {
            let ports = ports.iter().map(ports::line);
            let flash = flash.iter().map(|line| format!("To flash ours: {line}"));
            let simulate = if *simulate { "`simulate` " } else { "" };
            let last = format!("Type `port NAME`, {simulate}or `cancel`.");
            ports.chain(flash).chain([last]).collect()
        }
        Event::Verdict {
            reasons,
            r#final: true,
            ..
        } => reasons.clone(),
        Event::Saved { report, next, .. } => {
            let report = report.iter().map(|r| format!("Report: {r}"));
            let next = next.iter().map(|n| format!("Next: {n}"));
            report.chain(next).collect()
        }
        Event::Truth { rows, .. } => {
            let line = |row: &TruthRow| {
                let plus_minus = row.plus_minus;
                let plus_minus = plus_minus.map_or(String::new(), |p| format!(" ± {p:.2}"));
                format!(
                    "{:9} true {:8.2}  found {:8.2}{plus_minus} {}",
                    row.name, row.truth, row.found, row.unit
                )
            };
            rows.iter().map(line).collect()
        }
        Event::End { resume, .. } => {
            let resume = resume.iter();
            resume.map(|r| format!("Go on with: {r}")).collect()
        }
        _ => Vec::new(),
    }
}

/// Events as JSON, one object a line.
pub struct EventLines {
    out: Sink,
    path: PathBuf,
}

impl EventLines {
    /// Into a new file; `-` is standard output. `real_time`: the session waits for no reader.
    ///
    /// # Errors
    ///
    /// Those of the file system.
    pub fn open(path: &Path, real_time: bool) -> Result<Self> {
        let out = match (path == Path::new("-"), real_time) {
            (true, true) => Sink::Queued(Outlet::new(io::stdout())),
            (true, false) => Sink::Waiting(Box::new(io::stdout())),
            (false, _) => {
                // A pipe and a device are there already.
                let is_new = !path.exists() || path.is_file();
                let file = File::options().write(true).create_new(is_new).open(path);
                Sink::Waiting(Box::new(file.map_err(|e| Error::io(path, e))?))
            }
        };
        let path = path.to_owned();
        Ok(EventLines { out, path })
    }
}

impl Renderer for EventLines {
    fn show(&mut self, message: &Message) -> Result<()> {
        if let Sink::Queued(out) = &mut self.out
            && let Some(n) = out.take_dropped()
        {
            let text = format!("{n} events were dropped here: they were not read in time.");
            let kind = WarningKind::Other;
            self.show(&Message::new(message.t_s, Event::Warning { kind }, text))?;
        }
        // Not even a reader who has gone is an end in silence.
        let io = |e: io::Error| Error::io(&self.path, io::Error::other(e));
        let text = serde_json::to_string(message).map_err(|e| io(e.into()))?;
        let line = format!("{}\n", shown_json(&text));
        let sent = if message.event.is_status() {
            self.out.status(line)
        } else {
            self.out.send(line)
        };
        sent.map_err(io)
    }
}
