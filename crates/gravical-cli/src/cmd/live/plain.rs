//! Events for a terminal, and for scripts.

use std::fs::File;
use std::io::{self, IsTerminal as _};
use std::path::Path;

use gravical::escape::{one_line, shown_json};
use gravical::live::event::{Event, Fit, Message, PortInfo, Status, Wanted};
use gravical::{Error, Result};

use super::driver::Renderer;
use crate::outlet::{Outlet, Sink};

/// Cells of the bar of progress.
const BAR: usize = 10;

/// One line an event on standard error, and a status line that is overwritten.
pub struct Plain {
    out: Sink,
    terminal: bool,
    in_status: bool,
    last_hint: Option<String>,
}

impl Plain {
    /// For standard error; `real_time`: a session that waits for nobody.
    pub fn new(real_time: bool) -> Self {
        Plain {
            out: match real_time {
                true => Sink::Queued(Outlet::new(io::stderr())),
                false => Sink::Waiting(Box::new(io::stderr())),
            },
            terminal: io::stderr().is_terminal(),
            in_status: false,
            last_hint: None,
        }
    }

    fn line(&mut self, text: &str) {
        let clear = if self.in_status { "\r\x1b[K" } else { "" };
        self.in_status = false;
        self.out.send(format!("{clear}{}\n", one_line(text)));
    }

    fn status(&mut self, t_s: f64, status: &Status) {
        if self.terminal {
            let line = status_line(status);
            self.out.status(format!("\r{}\x1b[K", one_line(&line)));
            self.in_status = true;
        } else if status.hint.is_some() && status.hint != self.last_hint {
            // Without a terminal there is no status line; what hinders is said once.
            let hint = status.hint.clone().unwrap_or_default();
            self.line(&format!("{t_s:7.1} s  waiting: {hint}"));
        }
        self.last_hint.clone_from(&status.hint);
    }
}

impl Renderer for Plain {
    fn show(&mut self, message: &Message) {
        match &message.event {
            Event::Status(status) => self.status(message.t_s, status),
            event => {
                for line in lines(event) {
                    self.line(&format!("{:7.1} s  {line}", message.t_s));
                }
            }
        }
    }

    fn answer(&mut self, text: &str) {
        self.line(text);
    }
}

fn status_line(status: &Status) -> String {
    let filled = (status.ring * BAR as f64).round() as usize;
    let bar = format!(
        "{}{}",
        "#".repeat(filled),
        ".".repeat(BAR - filled.min(BAR))
    );
    let limit = status
        .limit_mg
        .map_or(String::new(), |l| format!("/{l:.0}"));
    let say = status.hint.as_ref().unwrap_or(&status.sentence);
    format!(
        "[{bar}] {} {:.0}° {:.3} g {:.0}{limit} mg  {say}",
        status.face, status.tilt_deg, status.norm_g, status.noise_mg
    )
}

fn mg(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |v| format!("{v:.1} mg"))
}

/// An event in a line or more.
fn lines(event: &Event) -> Vec<String> {
    let one = match event {
        Event::Ports {
            ports,
            message,
            remedy,
            flash,
            simulate,
            ..
        } => {
            let remedy = remedy.as_ref().map_or(String::new(), |r| format!(": {r}"));
            let first = format!("! {message}{remedy}");
            let ports = ports.iter().map(|p| format!("  {}", port_line(p)));
            let flash = flash.iter().map(|line| format!("  To flash ours: {line}"));
            let simulate = if *simulate { "simulate; " } else { "" };
            let last = format!("  Type port and its name; {simulate}Ctrl-C ends.");
            let all = std::iter::once(first).chain(ports).chain(flash);
            return all.chain([last]).collect();
        }
        Event::Connecting { name } => format!("{name} is open: waiting for its first rows"),
        Event::Session { name, folder, .. } => match folder {
            Some(folder) => format!("{name} → {folder}"),
            None => name.clone(),
        },
        Event::Identified {
            rate_hz,
            columns,
            unit,
            notes,
            ..
        } => {
            let rate = rate_hz.map_or("rate unknown".to_owned(), |r| format!("{r:.1} Hz"));
            let first = format!("{rate}, {} columns, {}", columns.len(), unit);
            return std::iter::once(first)
                .chain(notes.iter().cloned())
                .collect();
        }
        Event::Floor {
            noise_mg, limit_mg, ..
        } => {
            let [x, y, z] = noise_mg;
            format!("noise at rest {x:.1}, {y:.1}, {z:.1} mg; above {limit_mg:.0} mg it moves")
        }
        Event::Status(_) | Event::PoseCandidate { .. } => return Vec::new(),
        Event::PoseAccepted(pose) => {
            let name = pose.face.clone().unwrap_or_else(|| "free pose".to_owned());
            let note = pose
                .note
                .as_ref()
                .map_or(String::new(), |n| format!("; {n}"));
            format!(
                "✓ {name}: ‖a‖ {:.3} m/s², noise {:.1} mg ({} of 6 faces, {} free){note}",
                pose.norm_mps2, pose.noise_mg, pose.faces_done, pose.free_done
            )
        }
        Event::PoseRejected {
            message, remedy, ..
        } => format!("✗ {message}: {remedy}"),
        Event::PoseUndone { pose, face, .. } => {
            let name = face.clone().unwrap_or_else(|| "free pose".to_owned());
            format!("pose {pose} ({name}) no longer counts")
        }
        Event::NextPose {
            kind, faces, hint, ..
        } => match (kind, hint) {
            (Wanted::Face, _) => format!("→ put up, and hold still: {}", faces.join(" ")),
            (Wanted::Free, Some(hint)) => format!("→ free pose: {hint}"),
            (Wanted::Free, None) => "→ free pose: any new direction".to_owned(),
            (Wanted::None, _) => "→ good: `stop` saves; more poses make it better".to_owned(),
        },
        Event::Fit(fit) => fit_line(fit),
        Event::Verdict {
            sentence,
            reasons,
            r#final,
            ..
        } => {
            let reasons = reasons
                .iter()
                .filter(|_| *r#final)
                .map(|r| format!("  {r}"));
            return std::iter::once(sentence.clone()).chain(reasons).collect();
        }
        Event::Gravity { gravity_mps2, .. } => format!("gravity {gravity_mps2:.5} m/s²"),
        Event::Warning { message, .. } => format!("! {message}"),
        Event::Saved {
            file, report, next, ..
        } => {
            let report = report.iter().map(|r| format!("  Report: {r}"));
            let next = next.iter().map(|n| format!("  Next: {n}"));
            return std::iter::once(format!("Saved to {file}; read back and compared."))
                .chain(report)
                .chain(next)
                .collect();
        }
        Event::Lost { message, .. } | Event::Resumed { message, .. } => message.clone(),
        Event::Truth {
            norm_error_mg,
            before_mg,
            rows,
        } => {
            let rows = rows.iter().map(|row| {
                let plus_minus = row
                    .plus_minus
                    .map_or(String::new(), |p| format!(" ± {p:.2}"));
                format!(
                    "  {:9} true {:8.2}  found {:8.2}{plus_minus} {}",
                    row.name, row.truth, row.found, row.unit
                )
            });
            let first = format!(
                "The truth: error of ‖a‖ {norm_error_mg:.2} mg rms with this calibration, {before_mg:.1} mg without"
            );
            return std::iter::once(first).chain(rows).collect();
        }
        Event::End {
            message, resume, ..
        } => {
            let resume = resume.iter().map(|r| format!("Go on with: {r}"));
            return std::iter::once(message.clone()).chain(resume).collect();
        }
    };
    vec![one]
}

/// A port and what it is: `/dev/ttyACM0  2341:0043  Arduino Uno  [95437]  open in cat (4711)`.
fn port_line(port: &PortInfo) -> String {
    let serial = port.serial.as_ref().map(|s| format!("[{s}]"));
    let holders =
        (!port.open_in.is_empty()).then(|| format!("open in {}", port.open_in.join(", ")));
    let parts = [
        Some(port.name.clone()),
        port.usb.clone(),
        port.device.clone(),
        serial,
        holders,
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join("  ")
}

fn fit_line(fit: &Fit) -> String {
    let [x, y, z] = fit.bias_mg;
    format!(
        "bias {x:.1}, {y:.1}, {z:.1} mg; error of ‖a‖ ≤ {} (2σ, worst direction); leave-one-out {}; {}",
        mg(fit.worst_mg),
        mg(fit.leave_one_out_mg),
        fit.grade.name()
    )
}

/// Events as JSON, one object a line.
pub struct EventLines {
    out: Sink,
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
                let file = File::create_new(path).map_err(|e| Error::io(path, e))?;
                Sink::Waiting(Box::new(file))
            }
        };
        Ok(EventLines { out })
    }
}

impl Renderer for EventLines {
    fn show(&mut self, message: &Message) {
        if let Ok(text) = serde_json::to_string(message) {
            let line = format!("{}\n", shown_json(&text));
            match message.event.is_status() {
                true => self.out.status(line),
                false => self.out.send(line),
            }
        }
    }
}
