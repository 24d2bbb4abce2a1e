//! The loop between the source of rows, the session, the disk and those who show the events.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::TryRecvError;
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

use super::connect::OpenSource;
use super::console::{Console, Entry};
use super::source::Incoming;
use super::truth::truth_event;
use crate::cmd::calibrate::save;
use crate::cmd::log::LogFile;
use crate::failure;
use crate::options::command_line;
use crate::report::write_report;

/// A hand that moves is left alone for this long, s, unless the pose is accepted.
const HAND_S: f64 = 8.0;

/// A session and everything around it.
pub struct Driver<'a> {
    pub session: Session,
    pub opened: OpenSource,
    /// There are rows already.
    pub resumes: bool,
    pub console: &'a mut Console,
    /// An event a line.
    pub journal: Option<LogFile>,
    pub folder: Option<PathBuf>,
    pub read: ReadOptions,
    /// The calibration file.
    pub output: Option<PathBuf>,
    /// Times real time; 0 is as fast as possible.
    pub speed: f64,
    pub hand: SimulatedHand,
}

/// The recordings of a session, and where its poses are.
type Recorded = (Vec<Recording>, Segmentation);

/// Commands that are typed, and the hand that moves a simulated sensor by them.
#[derive(Default)]
pub struct SimulatedHand {
    waiting: VecDeque<Command>,
    /// Time of the session until which it is busy, s.
    busy_until_s: f64,
    /// The direction that is asked for.
    asked: Option<[f64; 3]>,
    now_s: f64,
    /// Nobody types any more.
    is_gone: bool,
}

impl SimulatedHand {
    /// It moves the sensor, or leaves it alone.
    fn is_busy(&self) -> bool {
        self.now_s < self.busy_until_s
    }

    /// It will not move the sensor again.
    fn is_done(&self) -> bool {
        self.is_gone && self.waiting.is_empty() && !self.is_busy()
    }

    fn see(&mut self, message: &Message) {
        self.now_s = message.t_s;
        match &message.event {
            Event::NextPose { up, .. } => self.asked = *up,
            Event::PoseRejected {
                reason: Rejection::Moved | Rejection::Gaps,
                ..
            } => {}
            Event::PoseAccepted(_) | Event::PoseRejected { .. } => self.busy_until_s = message.t_s,
            _ => {}
        }
    }
}

/// How the rows end.
enum Ending {
    /// There are enough poses.
    Finished,
    /// The user does not want to go on.
    Stopped(EndReason),
    /// There are no more rows, and too few poses.
    OutOfRows,
}

impl Driver<'_> {
    /// Runs the session to its end.
    ///
    /// # Errors
    ///
    /// Those of the source and of the disk.
    pub fn run(mut self) -> anyhow::Result<ExitCode> {
        let ending = self.guide();
        // A recording that cannot be written has been rescued.
        let is_lost = matches!(&ending, Err(error) if error.code() == "io");
        let rest = if is_lost {
            Vec::new()
        } else {
            self.opened.source.close()
        };
        match ending {
            Ok(Ending::Finished) => self.save(),
            Ok(Ending::Stopped(reason)) => self.stopped(reason, &rest),
            Ok(Ending::OutOfRows) => self.out_of_rows(),
            Err(error) => {
                // The disk of the journal may be full as well.
                let _ = self.end(EndReason::Failed, &error.to_string());
                Err(error.into())
            }
        }
    }

    /// Reads rows and does what the user wants, until there is an end.
    fn guide(&mut self) -> Result<Ending> {
        let kind = self.opened.kind;
        let folder = self.folder.as_ref().map(|f| f.display().to_string());
        let begun = self.session.begin(kind, &self.opened.name, folder);
        if self.resumes {
            self.render(&begun)?;
            self.restore()?;
        } else {
            self.show(begun)?;
        }
        if kind == SourceKind::Simulate {
            // It is left alone until its noise is known.
            self.hand.busy_until_s = self.hand.now_s + HAND_S;
        }
        let started = Instant::now();
        loop {
            if let Some(ending) = self.step()? {
                return Ok(ending);
            }
            if kind == SourceKind::Replay && self.speed > 0.0 {
                let due_s = self.hand.now_s / self.speed;
                let ahead_s = due_s - started.elapsed().as_secs_f64();
                std::thread::sleep(Duration::from_secs_f64(ahead_s.clamp(0.0, 1.0)));
            }
        }
    }

    fn step(&mut self) -> Result<Option<Ending>> {
        if self.console.is_interrupted() {
            return Ok(Some(Ending::Stopped(if self.session.is_done() {
                EndReason::Cancelled
            } else {
                EndReason::Interrupted
            })));
        }
        let messages = match self.opened.next()? {
            Incoming::Bytes(bytes) => {
                let mut messages = self.session.resumed();
                messages.extend(self.session.bytes(&bytes)?);
                if self.opened.kind == SourceKind::Port {
                    // The logger has waited for rows enough, also of a slow sensor.
                    messages.extend(self.session.settle_format().unwrap_or_default());
                }
                messages
            }
            Incoming::Lost(why) => self.session.lost(why),
            Incoming::Warning(message) => {
                self.warn(WarningKind::Rows, &message)?;
                Vec::new()
            }
            Incoming::Nothing | Incoming::Connected(_) => Vec::new(),
            Incoming::End => {
                let messages = self.session.settle_format().unwrap_or_default();
                self.show(messages)?;
                return self.finish().map(Some);
            }
        };
        self.show(messages)?;
        let messages = self.session.settle();
        self.show(messages)?;
        self.commands()?;
        if self.session.is_done() && !self.console.is_interrupted() {
            return Ok(Some(Ending::Finished));
        }
        if self.opened.kind == SourceKind::Simulate && self.hand.is_done() {
            return self.finish().map(Some);
        }
        Ok(None)
    }

    /// There will be no more rows, or none that matter.
    fn finish(&mut self) -> Result<Ending> {
        let messages = self.session.command(&Command::Finish);
        self.show(messages)?;
        Ok(if self.session.is_done() {
            Ending::Finished
        } else {
            Ending::OutOfRows
        })
    }

    /// Reads the rows that a session has already.
    fn restore(&mut self) -> Result<()> {
        if let Some(folder) = &self.folder {
            let path = folder.join(gravical::live::folder::RECORDING);
            let mut bytes = std::fs::read(&path).map_err(|e| Error::io(&path, e))?;
            bytes.truncate(self.opened.recorded as usize);
            let messages = self.session.bytes(&bytes)?;
            self.render(&messages)?;
        }
        let messages = self.session.resumed();
        self.show(messages)
    }

    /// Shows events; what has to be safe is safe before.
    fn show(&mut self, messages: Vec<Message>) -> Result<()> {
        for message in messages {
            if let Some(journal) = &mut self.journal
                && !message.event.is_status()
            {
                let line = serde_json::to_string(&message);
                let line = line.map_err(|e| Error::io(journal.path(), e.into()))?;
                // Without these a session could not be resumed as it was.
                let is_vital = matches!(
                    message.event,
                    Event::Session { .. }
                        | Event::PoseAccepted(_)
                        | Event::PoseUndone { .. }
                        | Event::Gravity { .. }
                );
                if is_vital {
                    self.opened.source.make_safe()?;
                }
                journal.write(format!("{line}\n").as_bytes())?;
                if is_vital {
                    journal.sync()?;
                }
            }
            self.render(&[message])?;
        }
        Ok(())
    }

    /// Shows events that are in the journal.
    fn render(&mut self, messages: &[Message]) -> Result<()> {
        for message in messages {
            self.hand.see(message);
            self.console.show(message)?;
        }
        Ok(())
    }

    /// Does what the user wants.
    fn commands(&mut self) -> Result<()> {
        loop {
            match self.console.entries.try_recv() {
                Ok(Entry::Typed(Ok(command))) => self.hand.waiting.push_back(command),
                Ok(Entry::Typed(Err(text))) => self.warn(WarningKind::Refused, &text)?,
                #[cfg(feature = "live")]
                Ok(Entry::Clicked(command)) => self.command(&command)?,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    self.hand.is_gone = true;
                    break;
                }
            }
        }
        while !self.hand.is_busy()
            && !self.session.is_done()
            && let Some(command) = self.hand.waiting.pop_front()
        {
            self.command(&command)?;
        }
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<()> {
        if *command == Command::Cancel {
            // The program ends as after Ctrl-C.
            self.console.interrupt();
        }
        match self.opened.source.hand(command, self.hand.asked) {
            Ok(true) => {
                self.hand.busy_until_s = self.hand.now_s + HAND_S;
                Ok(())
            }
            Ok(false) => {
                let messages = self.session.command(command);
                self.show(messages)
            }
            Err(error) => self.warn(WarningKind::Refused, &error.to_string()),
        }
    }

    // Ends.

    /// The user has ended it: what was recorded is kept.
    fn stopped(&mut self, reason: EndReason, rest: &[u8]) -> anyhow::Result<ExitCode> {
        self.session.bytes(rest)?;
        self.opened.source.make_safe()?;
        let folder = self.folder.as_ref();
        let safe = folder.map_or(String::new(), |f| {
            format!("; what was recorded is in {}", f.display())
        });
        let what = match reason {
            EndReason::Cancelled => "cancelled without a calibration",
            _ => "interrupted",
        };
        self.end(reason, &format!("{what}{safe}"))?;
        Ok(ExitCode::from(failure::INTERRUPTED))
    }

    fn out_of_rows(&mut self) -> anyhow::Result<ExitCode> {
        let poses = self.session.poses().count();
        if self.opened.kind == SourceKind::Replay && poses == 0 {
            // What is no recording is refused as by every command.
            read(Path::new(&self.opened.name), &self.read)?;
        }
        let poses = count(poses, "pose");
        self.end(
            EndReason::SourceEnded,
            &format!("the rows ended after {poses}"),
        )?;
        let hint = match self.resume_command() {
            Some(command) => format!("{command} goes on"),
            None => "--any-pose accepts every steady hold, and --capture 1 shorter ones".to_owned(),
        };
        let what = format!("the session ended after {poses}, too few for a calibration");
        Err(Error::input("too-few-poses", what).with_hint(hint).into())
    }

    /// Saves the calibration, and reads it back.
    fn save(&mut self) -> anyhow::Result<ExitCode> {
        self.opened.source.make_safe()?;
        let (file, session) = self.calibration()?;
        let done = match &self.output {
            Some(_) => "Done and saved",
            None => "Done, and not saved (-o cal.json does)",
        };
        if let Some(output) = self.output.take() {
            save(&output, false, &file)?;
            let report = self.report(&file, session.as_ref(), &output)?;
            let word = path_word(&output);
            let saved = Event::Saved {
                file: output.display().to_string(),
                folder: self.folder.as_ref().map(|f| f.display().to_string()),
                report: report.map(|path| path.display().to_string()),
                next: self.next_steps(file.verdict.grade, &word),
            };
            let text = format!("Saved to {}, read back and compared.", output.display());
            self.note(saved, text)?;
        }
        if let Some(truth) = self.opened.source.truth() {
            let (event, text) = truth_event(&truth, &file);
            self.note(event, text)?;
        }
        let grade = file.verdict.grade;
        let poses = count(self.session.poses().count(), "pose");
        let message = format!("{done}: {poses}, verdict {grade}");
        self.end(EndReason::Finished, &message)?;
        Ok(match grade {
            Grade::Poor => ExitCode::from(failure::QUALITY),
            _ => ExitCode::SUCCESS,
        })
    }

    /// Commands to go on with: to a better calibration where it is not good, else to its use.
    fn next_steps(&self, grade: Grade, calibration: &str) -> Vec<String> {
        let resume = self.resume_command().filter(|_| grade != Grade::Good);
        let motion = match self.opened.kind {
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
    ) -> Result<Option<PathBuf>> {
        let session = recorded.map(|(recordings, segmentation)| figure::calibration::Session {
            recordings,
            segmentation,
        });
        let figures = figure::calibration::figures(file, session);
        let document = report::calibration(file, Some(output), &figures);
        let html = document.to_html();
        let renderers = self.console.renderers.iter_mut();
        renderers.for_each(|r| r.report(&html));
        let Some(folder) = &self.folder else {
            return Ok(None);
        };
        let name = Path::new(output.file_name().unwrap_or_default()).with_extension("html");
        let path = folder.join(name);
        match write_report(&path, false, &document) {
            Ok(()) => Ok(Some(path)),
            Err(error) => {
                let why = format!("the report was not written: {error}");
                self.warn(WarningKind::Other, &why)?;
                Ok(None)
            }
        }
    }

    fn end(&mut self, reason: EndReason, message: &str) -> Result<()> {
        let resume = self.resume_command();
        let event = Event::End {
            reason,
            poses: self.session.poses().count() as u32,
            resume: resume.filter(|_| reason != EndReason::Finished),
        };
        self.note(event, sentences([message]))
    }

    fn warn(&mut self, kind: WarningKind, message: &str) -> Result<()> {
        self.note(Event::Warning { kind }, sentences([message]))
    }

    /// Shows what only the program knows.
    fn note(&mut self, event: Event, text: String) -> Result<()> {
        let messages = self.session.note(event, text);
        self.show(messages)
    }

    fn resume_command(&self) -> Option<String> {
        let folder = path_word(self.folder.as_ref()?);
        Some(format!("gravical live --resume {folder}"))
    }
}
