//! Who shows the events, and what the user wants.

use std::fs::File;
use std::io::{self, BufRead as _, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};

use gravical::calibration_file::GravitySource;
use gravical::escape::{one_line, shown_json};
use gravical::live::event::{Command, Event, Message, Status};
use gravical::{Error, Result};
use gravical_report::document::paragraph;

use super::web::Page;
use crate::device::ports;
use crate::outlet::{Outlet, Screen};
use crate::text;

/// Who shows the events, and what the user wants.
pub struct Console {
    pub plain: Plain,
    pub lines: Option<EventLines>,
    pub page: Option<Page>,
    /// What is typed, or why it is no command. Each command waits until the one before is done.
    pub typed: Receiver<Result<Command, String>>,
    /// What is clicked on the page, where one sees what happens: it is done at once.
    pub clicked: Receiver<Command>,
    /// Set by Ctrl-C.
    pub interrupted: Arc<AtomicBool>,
}

impl Console {
    /// Shows an event. A reader who does not read does not stop the session.
    ///
    /// # Errors
    ///
    /// Where every event has to be written, and cannot be.
    pub fn show(&mut self, message: &Message) -> Result<()> {
        self.plain.show(message);
        if let Some(page) = &mut self.page {
            page.show(message);
        }
        self.lines
            .as_mut()
            .map_or(Ok(()), |lines| lines.show(message))
    }

    /// Shows what happens before the session.
    ///
    /// # Errors
    ///
    /// As of [`show`](Self::show).
    pub fn note(&mut self, event: Event, text: &str) -> Result<()> {
        self.show(&Message::new(0.0, event, text))
    }

    /// The user ends the session.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Ordering::SeqCst);
    }

    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }

    /// A user sees what happens, and can choose a port. In a script an error ends the program.
    pub fn is_seen(&self) -> bool {
        self.page.is_some() || io::stdin().is_terminal()
    }

    /// What the user wants before the session.
    pub fn command(&self) -> Option<Result<Command, String>> {
        let clicked = self.clicked.try_recv().map(Ok);
        clicked.or_else(|_| self.typed.try_recv()).ok()
    }

    /// Whether the page, which stays after the session, wants it to go on.
    pub fn goes_on(&self) -> bool {
        let page = self.page.as_ref();
        page.is_some_and(|page| page.stay(&self.clicked, &self.interrupted))
    }
}

/// Sends what is typed, a line each.
pub fn send_typed(sender: SyncSender<Result<Command, String>>) {
    std::thread::spawn(move || {
        let lines = io::stdin().lock().lines().map_while(io::Result::ok);
        for line in lines.filter(|line| !line.trim().is_empty()) {
            let command = Command::parse(&line).map_err(|e| match e.hint() {
                Some(hint) => format!("{e}; {hint}"),
                None => e.to_string(),
            });
            if sender.send(command).is_err() {
                return;
            }
        }
    });
}

/// One line an event on standard error, and a status line that is overwritten.
pub struct Plain {
    screen: Screen,
    last_hint: Option<String>,
}

impl Plain {
    /// `real_time`: the session waits for nobody.
    pub fn new(real_time: bool) -> Self {
        Plain {
            screen: Screen::new(real_time),
            last_hint: None,
        }
    }

    fn status(&mut self, message: &Message, status: &Status) {
        let bar = "#".repeat((10.0 * status.ring).round() as usize);
        let limit = status
            .limit_mg
            .map_or(String::new(), |l| format!("/{l:.0}"));
        let line = format!(
            "[{bar:.<10}] {} {:.0}° {:.3} g {:.0}{limit} mg  {}",
            status.face,
            status.tilt_deg,
            status.norm_g,
            status.noise_mg,
            status.hint.as_ref().unwrap_or(&message.text)
        );
        let line = text::fit_terminal(&one_line(&line));
        if !self.screen.status(&line)
            && let Some(hint) = &status.hint
            && status.hint != self.last_hint
        {
            // Without a terminal there is no status line; what hinders is said once.
            self.line(message.t_s, hint);
        }
        self.last_hint.clone_from(&status.hint);
    }

    fn show(&mut self, message: &Message) {
        let mark = match &message.event {
            Event::Status(status) => return self.status(message, status),
            Event::PoseAccepted(_) => "✓ ",
            Event::PoseRejected { .. } => "✗ ",
            Event::NextPose { .. } => "→ ",
            Event::Ports { .. } | Event::Warning | Event::Lost { .. } => "! ",
            Event::Gravity(gravity) if gravity.source == GravitySource::Standard => "! ",
            _ => "",
        };
        let first = format!("{mark}{}", message.text);
        let more = details(&message.event).into_iter();
        for line in std::iter::once(first).chain(more.map(|line| format!("  {line}"))) {
            self.line(message.t_s, &line);
        }
    }

    /// A paragraph behind its time.
    fn line(&mut self, t_s: f64, text: &str) {
        let first = format!("{t_s:7.1} s  ");
        self.screen.line(&paragraph(&first, text));
    }
}

/// What else an event has, a line each.
fn details(event: &Event) -> Vec<String> {
    let named = |name: &str, lines: &[String]| -> Vec<String> {
        lines.iter().map(|line| format!("{name}: {line}")).collect()
    };
    match event {
        Event::Ports {
            ports,
            flash,
            simulate,
            ..
        } => {
            let simulate = if *simulate { "`simulate` " } else { "" };
            let last = format!("Type `port NAME`, {simulate}or `cancel`.");
            let ports = ports.iter().map(ports::line).collect();
            [ports, named("To flash ours", flash), vec![last]].concat()
        }
        Event::Verdict {
            reasons,
            r#final: true,
            ..
        } => reasons.clone(),
        Event::Saved { report, next, .. } => {
            [named("Report", report.as_slice()), named("Next", next)].concat()
        }
        Event::End { resume, .. } => named("Go on with", resume.as_slice()),
        _ => Vec::new(),
    }
}

/// Events as JSON, one object a line.
pub struct EventLines {
    out: Outlet,
    path: PathBuf,
}

impl EventLines {
    /// Into a new file; `-` is standard output. `real_time`: the session waits for no reader.
    ///
    /// # Errors
    ///
    /// Those of the file system.
    pub fn open(path: &Path, real_time: bool) -> Result<Self> {
        let out = if path == Path::new("-") {
            Outlet::new(io::stdout(), real_time)
        } else {
            // A pipe and a device are there already.
            let is_new = !path.exists() || path.is_file();
            let file = File::options().write(true).create_new(is_new).open(path);
            Outlet::new(file.map_err(|e| Error::io(path, e))?, false)
        };
        let path = path.to_owned();
        Ok(EventLines { out, path })
    }

    fn show(&mut self, message: &Message) -> Result<()> {
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time.");
            self.show(&Message::new(message.t_s, Event::Warning, &text))?;
        }
        // Not even a reader who has gone is an end in silence.
        let line = format!("{}\n", shown_json(&message.to_json()));
        let sent = match message.event {
            Event::Status(_) => self.out.status(line),
            Event::End { .. } => self.out.send(line).and_then(|()| self.out.drain()),
            _ => self.out.send(line),
        };
        sent.map_err(|e| Error::io(&self.path, io::Error::other(e)))
    }
}
