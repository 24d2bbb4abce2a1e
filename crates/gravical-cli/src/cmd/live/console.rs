//! Who shows the events, and what the user wants.

use std::fs::File;
use std::io::{self, BufRead as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};

use gravical::escape::{one_line, shown_json};
use gravical::live::event::{Command, Event, Message, Status, WarningKind};
use gravical::{Error, Result};

use crate::device::ports;
use crate::outlet::Sink;
use crate::screen::Screen;

/// Shows events.
pub trait Renderer {
    /// Shows one. A reader who does not read does not stop the session.
    ///
    /// # Errors
    ///
    /// Where every event has to be written, and cannot be.
    fn show(&mut self, message: &Message) -> Result<()>;
}

/// What the user wants.
pub struct Entry {
    /// Or why what was typed is no command.
    pub command: std::result::Result<Command, String>,
    /// From the page, where one sees what happens: it is done at once. Of several typed ones each that
    /// moves a simulated sensor waits until the pose before is taken.
    pub is_clicked: bool,
}

/// Who shows the events, and what the user wants.
pub struct Console {
    pub renderers: Vec<Box<dyn Renderer>>,
    pub entries: Receiver<Entry>,
    /// Set by Ctrl-C.
    pub interrupted: Arc<AtomicBool>,
}

impl Console {
    /// Shows an event.
    ///
    /// # Errors
    ///
    /// As [`Renderer::show`].
    pub fn show(&mut self, message: &Message) -> Result<()> {
        self.renderers.iter_mut().try_for_each(|r| r.show(message))
    }

    /// Shows what happens before the session.
    ///
    /// # Errors
    ///
    /// As [`Renderer::show`].
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
}

/// Sends what is typed, a line each.
pub fn send_typed(sender: SyncSender<Entry>) {
    std::thread::spawn(move || {
        let lines = io::stdin().lock().lines();
        let lines = lines.map_while(io::Result::ok);
        for line in lines.filter(|line| !line.trim().is_empty()) {
            let command = Command::parse(&line).map_err(|e| match e.hint() {
                Some(hint) => format!("{e}; {hint}"),
                None => e.to_string(),
            });
            let entry = Entry {
                command,
                is_clicked: false,
            };
            if sender.send(entry).is_err() {
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
        let out = if real_time {
            Sink::queued(io::stderr())
        } else {
            Sink::Waiting(Box::new(io::stderr()))
        };
        Plain {
            screen: Screen::new(out),
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
        if !self.screen.status(&one_line(&line))
            && let Some(hint) = &status.hint
            && status.hint != self.last_hint
        {
            // Without a terminal there is no status line; what hinders is said once.
            let line = format!("{:7.1} s  {hint}", message.t_s);
            self.screen.line(&one_line(&line));
        }
        self.last_hint.clone_from(&status.hint);
    }
}

impl Renderer for Plain {
    fn show(&mut self, message: &Message) -> Result<()> {
        let mark = match &message.event {
            Event::Status(status) => {
                self.status(message, status);
                return Ok(());
            }
            Event::PoseAccepted(_) => "✓ ",
            Event::PoseRejected { .. } => "✗ ",
            Event::NextPose { .. } => "→ ",
            Event::Ports { .. } | Event::Warning { .. } | Event::Lost { .. } => "! ",
            _ => "",
        };
        let first = format!("{mark}{}", message.text);
        let more = details(&message.event).into_iter();
        for line in std::iter::once(first).chain(more.map(|line| format!("  {line}"))) {
            let line = format!("{:7.1} s  {line}", message.t_s);
            self.screen.line(&one_line(&line));
        }
        Ok(())
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
            (true, true) => Sink::queued(io::stdout()),
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
        if let Some(n) = self.out.take_dropped() {
            let text = format!("{n} events were dropped here: they were not read in time.");
            let kind = WarningKind::Other;
            self.show(&Message::new(message.t_s, Event::Warning { kind }, &text))?;
        }
        // Not even a reader who has gone is an end in silence.
        let io = |e: io::Error| Error::io(&self.path, io::Error::other(e));
        let line = format!("{}\n", shown_json(&message.to_json()));
        let sent = if message.event.is_status() {
            self.out.status(line)
        } else {
            self.out.send(line)
        };
        sent.map_err(io)
    }
}
