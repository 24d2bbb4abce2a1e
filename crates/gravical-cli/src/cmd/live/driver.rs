//! The loop between the source of rows, the session, the disk and those who show the events.

use std::collections::VecDeque;
use std::io::{BufRead as _, Read as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::{CalibrationFile, Grade};
use gravical::escape::path_word;
use gravical::live::event::{
    Command, EndReason, Event, Message, Rejection, SourceKind, WarningKind,
};
use gravical::live::folder::calibrate_session;
use gravical::live::{Session, sentences};
use gravical::numfmt::count;
use gravical::poses::Segmentation;
use gravical::recording::{ReadOptions, Recording, read};
use gravical::{Error, Result};
use gravical_report::{figure, report};

use super::journal::{JournalFile, is_vital};
use super::source::{Incoming, Source};
use super::truth::truth_event;
use crate::cmd::calibrate::save;
use crate::failure;
use crate::options::command_line;
use crate::report::write_report;

/// A hand that moves is left alone for this long, s, unless the pose is accepted.
const HAND_S: f64 = 8.0;

/// After this time the format of a slow sensor is detected from the rows that are there.
const HOLD: Duration = Duration::from_secs(6);

/// Bytes of the recording that are read at once when a session is resumed.
const AT_ONCE: usize = 1 << 16;

/// Shows events.
pub trait Renderer {
    /// Shows one. A reader who does not read does not stop the session.
    ///
    /// # Errors
    ///
    /// Where every event has to be written, and cannot be.
    fn show(&mut self, message: &Message) -> Result<()>;
    /// Shows an answer to what was typed.
    fn answer(&mut self, _text: &str) {}
    /// Takes the calibration report, which comes before the event that it was saved.
    fn report(&mut self, _html: &str) {}
}

/// What the user wants.
pub enum Entry {
    /// A line that was typed, or why it is no command. Several at once are done one after the
    /// other: what moves a simulated sensor waits until the pose before is taken.
    Typed(std::result::Result<Command, String>),
    /// From the page, where one sees what happens: done at once.
    #[cfg(feature = "live")]
    Clicked(Command),
}

/// Sends what is typed, a line each.
pub fn typed(sender: SyncSender<Entry>) {
    std::thread::spawn(move || {
        for line in std::io::stdin()
            .lock()
            .lines()
            .map_while(std::io::Result::ok)
        {
            if line.trim().is_empty() {
                continue;
            }
            let command = Command::parse(&line).map_err(|e| match e.hint() {
                Some(hint) => format!("{e}; {hint}"),
                None => e.to_string(),
            });
            if sender.send(Entry::Typed(command)).is_err() {
                return;
            }
        }
    });
}

/// A session and everything around it.
pub struct Driver<'a> {
    pub session: Session,
    pub source: &'a mut dyn Source,
    /// Its first rows, where the session began with them.
    pub first: Vec<u8>,
    /// Bytes of the recording before it was opened.
    pub recorded: u64,
    pub renderers: &'a mut Vec<Box<dyn Renderer>>,
    pub journal: Option<JournalFile>,
    pub folder: Option<PathBuf>,
    pub read: ReadOptions,
    /// The calibration file.
    pub output: Option<PathBuf>,
    /// Times real time; 0 is as fast as possible.
    pub speed: f64,
    pub entries: &'a Receiver<Entry>,
    pub interrupted: &'a AtomicBool,
}

/// The recordings of a session, and where its poses are.
type Recorded = (Vec<Recording>, Segmentation);

/// Commands that wait for the hand.
#[derive(Default)]
struct Hand {
    waiting: VecDeque<Command>,
    /// Time of the session until which it is busy, s.
    busy_until_s: f64,
    /// The direction that is asked for.
    asked: Option<[f64; 3]>,
    now_s: f64,
    /// Nobody types any more.
    closed: bool,
}

impl Hand {
    /// A simulated sensor that nobody will move again.
    fn is_at_rest(&self) -> bool {
        self.closed && self.waiting.is_empty() && self.now_s >= self.busy_until_s
    }
}

impl Driver<'_> {
    /// Runs the session to its end; `resumes`: there are rows already.
    ///
    /// # Errors
    ///
    /// Those of the source and of the disk.
    pub fn run(mut self, kind: SourceKind, name: &str, resumes: bool) -> anyhow::Result<ExitCode> {
        // A simulated sensor is left alone until its noise is known.
        let is_moved = kind == SourceKind::Simulate;
        let mut hand = Hand {
            busy_until_s: if is_moved { HAND_S } else { 0.0 },
            ..Hand::default()
        };
        let folder = self.folder.as_ref().map(|f| f.display().to_string());
        let begun = self.session.begin(kind, name, folder);
        self.show(begun, &mut hand, resumes)?;
        if resumes {
            self.restore(&mut hand)?;
            if is_moved {
                hand.busy_until_s = hand.now_s + HAND_S;
            }
        }
        let started = Instant::now();
        let mut first_bytes: Option<Instant> = None;
        let mut first = Some(std::mem::take(&mut self.first)).filter(|rows| !rows.is_empty());
        let reason = loop {
            if self.interrupted.load(Ordering::SeqCst) {
                break if self.session.is_cancelled() {
                    EndReason::Cancelled
                } else {
                    EndReason::Interrupted
                };
            }
            let incoming = match first.take() {
                Some(rows) => Ok(Incoming::Bytes(rows)),
                None => self.source.next(),
            };
            let messages = match incoming {
                Ok(Incoming::Bytes(bytes)) => {
                    first_bytes.get_or_insert_with(Instant::now);
                    let mut messages = self.session.resumed();
                    match self.session.bytes(&bytes) {
                        Ok(more) => messages.extend(more),
                        Err(error) => {
                            self.source.close();
                            self.end(EndReason::Failed, &error.to_string(), &mut hand)?;
                            return Err(error.into());
                        }
                    }
                    messages
                }
                Ok(Incoming::Nothing)
                    if first_bytes.is_some_and(|first| first.elapsed() > HOLD) =>
                {
                    // A slow sensor; what is no recording yet may become one.
                    first_bytes = Some(Instant::now());
                    self.session.settle_format().unwrap_or_default()
                }
                Ok(Incoming::Nothing | Incoming::Opened(_) | Incoming::NoRows(_)) => Vec::new(),
                Ok(Incoming::Lost(why)) => self.session.lost(why),
                Ok(Incoming::Warning(message)) => self.warn(WarningKind::Rows, &message),
                Ok(Incoming::End) => {
                    let messages = self.session.settle_format().unwrap_or_default();
                    self.show(messages, &mut hand, false)?;
                    break self.finish(&mut hand)?;
                }
                Err(error) => {
                    self.end(EndReason::Failed, &error.to_string(), &mut hand)?;
                    return Err(error.into());
                }
            };
            self.show(messages, &mut hand, false)?;
            let messages = self.session.settle();
            self.show(messages, &mut hand, false)?;
            self.commands(&mut hand)?;
            if self.session.is_done() && !self.interrupted.load(Ordering::SeqCst) {
                break EndReason::Finished;
            }
            if kind == SourceKind::Simulate && hand.is_at_rest() {
                break self.finish(&mut hand)?;
            }
            let due_s = if self.speed > 0.0 {
                hand.now_s / self.speed
            } else {
                0.0
            };
            let ahead_s = due_s - started.elapsed().as_secs_f64();
            if kind == SourceKind::Replay && ahead_s > 0.0 {
                std::thread::sleep(Duration::from_secs_f64(ahead_s.min(1.0)));
            }
        };
        let rest = self.source.close();
        if matches!(reason, EndReason::Interrupted | EndReason::Cancelled) {
            self.session.bytes(&rest)?;
            self.source.make_safe()?;
            let folder = self.folder.as_ref();
            let safe = folder.map_or(String::new(), |f| {
                format!("; what was recorded is in {}", f.display())
            });
            let what = match reason {
                EndReason::Cancelled => "cancelled without a calibration",
                _ => "interrupted",
            };
            self.end(reason, &format!("{what}{safe}"), &mut hand)?;
            return Ok(ExitCode::from(failure::INTERRUPTED));
        }
        if reason == EndReason::SourceEnded {
            if kind == SourceKind::Replay && self.session.poses().count() == 0 {
                // What is no recording is refused as by every command.
                read(Path::new(name), &self.read)?;
            }
            let poses = count(self.session.poses().count(), "pose");
            self.end(reason, &format!("the rows ended after {poses}"), &mut hand)?;
            let hint = match &self.folder {
                Some(folder) => format!("gravical live --resume {} goes on", path_word(folder)),
                None => {
                    "--any-pose accepts every steady hold, and --capture 1 shorter ones".to_owned()
                }
            };
            let what = format!("the session ended after {poses}, too few for a calibration");
            return Err(Error::input("too-few-poses", what).with_hint(hint).into());
        }
        self.save(kind, &mut hand)
    }

    /// There will be no more rows, or none that matter.
    fn finish(&mut self, hand: &mut Hand) -> Result<EndReason> {
        let messages = self.session.command(&Command::Finish);
        self.show(messages, hand, false)?;
        Ok(if self.session.is_done() {
            EndReason::Finished
        } else {
            EndReason::SourceEnded
        })
    }

    /// Reads the rows that a session has already.
    fn restore(&mut self, hand: &mut Hand) -> Result<()> {
        if let Some(folder) = &self.folder {
            let path = folder.join(gravical::live::folder::RECORDING);
            let io = |e| Error::io(&path, e);
            let file = std::fs::File::open(&path).map_err(io)?;
            let mut file = file.take(self.recorded);
            let mut bytes = vec![0; AT_ONCE];
            loop {
                let n = file.read(&mut bytes).map_err(io)?;
                if n == 0 {
                    break;
                }
                let messages = self.session.bytes(&bytes[..n])?;
                self.show(messages, hand, true)?;
            }
        }
        let messages = self.session.resumed();
        self.show(messages, hand, false)
    }

    /// Shows events; what has to be safe is safe before. `known`: they are in the journal.
    fn show(&mut self, messages: Vec<Message>, hand: &mut Hand, known: bool) -> Result<()> {
        for message in messages {
            hand.now_s = message.t_s;
            match &message.event {
                Event::NextPose { up, .. } => hand.asked = *up,
                Event::PoseAccepted(_) => hand.busy_until_s = message.t_s,
                Event::PoseRejected { reason, .. }
                    if !matches!(reason, Rejection::Moved | Rejection::Gaps) =>
                {
                    hand.busy_until_s = message.t_s;
                }
                _ => {}
            }
            if !known && !message.event.is_status() {
                if is_vital(&message) {
                    self.source.make_safe()?;
                }
                if let Some(journal) = &mut self.journal {
                    journal.write(&message)?;
                }
            }
            self.renderers
                .iter_mut()
                .try_for_each(|r| r.show(&message))?;
        }
        Ok(())
    }

    /// Does what the user wants.
    fn commands(&mut self, hand: &mut Hand) -> Result<()> {
        loop {
            match self.entries.try_recv() {
                Ok(Entry::Typed(Ok(command))) => hand.waiting.push_back(command),
                Ok(Entry::Typed(Err(text))) => {
                    self.renderers.iter_mut().for_each(|r| r.answer(&text));
                }
                #[cfg(feature = "live")]
                Ok(Entry::Clicked(command)) => self.command(&command, hand)?,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    hand.closed = true;
                    break;
                }
            }
        }
        while hand.now_s >= hand.busy_until_s
            && !self.session.is_done()
            && let Some(command) = hand.waiting.pop_front()
        {
            self.command(&command, hand)?;
        }
        Ok(())
    }

    fn command(&mut self, command: &Command, hand: &mut Hand) -> Result<()> {
        if *command == Command::Cancel {
            // The program ends as after Ctrl-C.
            self.interrupted.store(true, Ordering::SeqCst);
        }
        let messages = match self.source.hand(command, hand.asked) {
            Ok(true) => {
                hand.busy_until_s = hand.now_s + HAND_S;
                return Ok(());
            }
            Ok(false) => self.session.command(command),
            Err(error) => self.warn(WarningKind::Refused, &error.to_string()),
        };
        self.show(messages, hand, false)
    }

    /// Saves the calibration, and reads it back.
    fn save(mut self, kind: SourceKind, hand: &mut Hand) -> anyhow::Result<ExitCode> {
        self.source.make_safe()?;
        let (file, session) = self.calibration()?;
        let done = match &self.output {
            Some(_) => "Done and saved",
            None => "Done, and not saved (-o cal.json does)",
        };
        if let Some(output) = self.output.take() {
            save(&output, false, &file)?;
            let report = self.report(&file, session.as_ref(), &output, hand)?;
            let word = path_word(&output);
            let saved = Event::Saved {
                file: output.display().to_string(),
                folder: self.folder.as_ref().map(|f| f.display().to_string()),
                report: report.map(|path| path.display().to_string()),
                next: self.next_steps(file.verdict.grade, &word, kind),
            };
            let text = format!("Saved to {}, read back and compared.", output.display());
            let messages = self.session.note(saved, text);
            self.show(messages, hand, false)?;
        }
        if let Some(truth) = self.source.truth() {
            let (event, text) = truth_event(&truth, &file);
            let messages = self.session.note(event, text);
            self.show(messages, hand, false)?;
        }
        let grade = file.verdict.grade;
        let poses = count(self.session.poses().count(), "pose");
        let message = format!("{done}: {poses}, verdict {}", grade.name());
        self.end(EndReason::Finished, &message, hand)?;
        Ok(match grade {
            Grade::Poor => ExitCode::from(failure::QUALITY),
            _ => ExitCode::SUCCESS,
        })
    }

    /// Commands to go on with: to a better calibration where it is not good, else to its use.
    fn next_steps(&self, grade: Grade, calibration: &str, kind: SourceKind) -> Vec<String> {
        let resume = self.folder.as_deref().filter(|_| grade != Grade::Good);
        let resume = resume.map(|folder| format!("gravical live --resume {}", path_word(folder)));
        let motion = match kind {
            SourceKind::Port if grade == Grade::Good => vec![
                "gravical log -o move.csv".to_owned(),
                format!("gravical motion move.csv -c {calibration} --report move.html"),
            ],
            _ => Vec::new(),
        };
        let apply = format!("gravical apply {calibration} RECORDING.csv -o calibrated.csv");
        let export = format!("gravical export {calibration} --to arduino");
        let all = resume.into_iter().chain(motion);
        all.chain([apply, export]).collect()
    }

    /// The calibration: of what is on the disk, where the session has a folder; then with its
    /// recording.
    fn calibration(&self) -> Result<(CalibrationFile, Option<Recorded>)> {
        if let Some(folder) = &self.folder {
            let options = CalibrateOptions {
                command: Some(command_line()),
                ..CalibrateOptions::default()
            };
            let given = Some(self.session.gravity());
            let (recordings, done) = calibrate_session(folder, &self.read, &options, given)?;
            return Ok((done.file, Some((recordings, done.segmentation))));
        }
        let file = self.session.calibration().cloned();
        let file = file.ok_or_else(|| Error::input("too-few-poses", "there is no calibration"))?;
        Ok((file, None))
    }

    /// The calibration report, for the page and into the folder. Where it cannot be written, the
    /// calibration is saved all the same.
    fn report(
        &mut self,
        file: &CalibrationFile,
        recorded: Option<&Recorded>,
        output: &Path,
        hand: &mut Hand,
    ) -> Result<Option<PathBuf>> {
        let session = recorded.map(|(recordings, segmentation)| figure::calibration::Session {
            recordings,
            segmentation,
        });
        let figures = figure::calibration::figures(file, session);
        let document = report::calibration(file, Some(output), &figures);
        let html = document.to_html();
        self.renderers.iter_mut().for_each(|r| r.report(&html));
        let Some(folder) = &self.folder else {
            return Ok(None);
        };
        let name = Path::new(output.file_name().unwrap_or_default()).with_extension("html");
        let path = folder.join(name);
        match write_report(&path, false, &document) {
            Ok(()) => Ok(Some(path)),
            Err(error) => {
                let why = format!("the report was not written: {error}");
                let messages = self.warn(WarningKind::Other, &why);
                self.show(messages, hand, false)?;
                Ok(None)
            }
        }
    }

    fn end(&mut self, reason: EndReason, message: &str, hand: &mut Hand) -> Result<()> {
        let folder = self
            .folder
            .as_deref()
            .filter(|_| reason != EndReason::Finished);
        let resume = folder.map(|f: &Path| format!("gravical live --resume {}", path_word(f)));
        let poses = self.session.poses().count() as u32;
        let event = Event::End {
            reason,
            poses,
            resume,
        };
        let messages = self.session.note(event, sentences([message]));
        self.show(messages, hand, false)
    }

    fn warn(&mut self, kind: WarningKind, message: &str) -> Vec<Message> {
        self.session
            .note(Event::Warning { kind }, sentences([message]))
    }
}
