//! A guided session: bytes of a board or time in, messages and the bytes of its files out.

use std::path::Path;

use gravical::Category;
use gravical::calibrate::CalibrateOptions;
use gravical::gravity::Gravity;
use gravical::live::event::{EndReason, Event, Loss, Message, SourceKind};
use gravical::live::folder::{JOURNAL, Journal, RECORDING, calibrate_session};
use gravical::live::recorder::{Recorder, RecorderOptions};
use gravical::live::{Command, Guide, LiveOptions, SimulatedBoard, sentence};
use gravical::recording::ReadOptions;
use gravical::recording::source::Named;
use gravical::{Error, Result, TOOL};
use gravical_report::{figure, report};
use serde::Deserialize;
use serde_json::json;

use crate::message::{self, answer};

/// A session, the source of its rows, and what becomes of them.
pub struct Live {
    guide: Guide,
    source: Source,
    /// The recording and the journal so far, and how much of them the page has.
    files: [Vec<u8>; 2],
    sent_bytes: [usize; 2],
    /// The first row is here.
    has_begun: bool,
    /// It was said why no row arrives.
    has_reported: bool,
    is_over: bool,
    /// Calibration and report.
    results: Vec<(String, Vec<u8>)>,
    /// What waits to be shown.
    events: Vec<Message>,
}

enum Source {
    /// With the time when it gives rows again, s, and its speed, times real time.
    Simulated(Box<SimulatedBoard>, f64, f64),
    Port(Box<Recorder>),
}

/// What the page says when it opens one.
#[derive(Deserialize)]
struct OpenOptions {
    source: SourceKind,
    name: String,
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    speed: f64,
}

/// What the user wants.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Input {
    command: Option<Command>,
}

impl Live {
    /// A session; with the files of one, it goes on. Its answer is the first.
    pub fn open(asked: &message::Message<'_>) -> Result<(Self, Vec<u8>)> {
        let given: OpenOptions = asked.options()?;
        let before = |name: &str| {
            asked
                .files("")
                .find(|f| f.name == name)
                .map_or(&b""[..], |f| f.bytes)
        };
        let [rows, journal] = [RECORDING, JOURNAL].map(before);
        let (past, _) = Journal::read_with_input(Named::Bytes(Path::new(JOURNAL), journal))?;
        let is_simulated = given.source == SourceKind::Simulate;
        let source = if is_simulated {
            let text = String::from_utf8_lossy(rows);
            let board = SimulatedBoard::new(given.seed, &text)?;
            Source::Simulated(Box::new(board), f64::NEG_INFINITY, given.speed)
        } else {
            let options = RecorderOptions {
                name: RECORDING.to_owned(),
                ..RecorderOptions::default()
            };
            let day_s = asked.number("day_s").unwrap_or_default();
            Source::Port(Box::new(Recorder::new(options, day_s, rows)?))
        };
        let usual = if is_simulated {
            SimulatedBoard::gravity()?
        } else {
            Gravity::default()
        };
        let known = past.source.is_some().then_some(past.gravity);
        let options = LiveOptions {
            read: ReadOptions {
                hash: true,
                ..ReadOptions::default()
            },
            gravity: known.unwrap_or(usual),
            ..LiveOptions::default()
        };
        let mut live = Live {
            guide: Guide::new(given.source, &given.name, RECORDING, options),
            source,
            files: [rows.to_vec(), journal.to_vec()],
            sent_bytes: [rows.len(), journal.len()],
            has_begun: false,
            has_reported: false,
            is_over: false,
            results: Vec::new(),
            events: Vec::new(),
        };
        if !rows.is_empty() {
            live.begin();
            live.append_to_journal();
            // What was said before is said again, and not written again.
            live.events.extend(live.guide.restore(rows, &past)?);
        }
        live.opened(asked.number("now_s").unwrap_or_default());
        let events = live.answer();
        Ok((live, events))
    }

    /// What happens in it: `tick`, `bytes`, `overflow`, `command`, `opened`, `lost`.
    pub fn call(&mut self, asked: &message::Message<'_>) -> Result<Vec<u8>> {
        let now_s = asked.number("now_s").unwrap_or_default();
        let Input { command } = asked.options()?;
        let mut done = Ok(());
        match (asked.verb(), command) {
            // It is over: what comes late changes nothing.
            _ if self.is_over => {}
            ("tick", _) => done = self.pass(now_s, b""),
            ("bytes", _) => done = self.pass(now_s, asked.file("")?.bytes),
            ("overflow", _) => done = self.overflow(),
            ("opened", _) => self.opened(now_s),
            ("lost", _) => self.lost(),
            (_, Some(command)) => done = self.command(now_s, &command),
            _ => {}
        }
        if let Err(error) = done {
            self.end(EndReason::Failed, &error.to_string());
        }
        Ok(self.answer())
    }

    /// What was said goes into the journal.
    fn append_to_journal(&mut self) {
        let events = self.guide.take();
        for message in events.iter().filter(|m| m.is_recorded() && self.has_begun) {
            self.files[1].extend_from_slice((message.to_json() + "\n").as_bytes());
        }
        self.events.extend(events);
    }

    fn answer(&mut self) -> Vec<u8> {
        self.append_to_journal();
        let events = std::mem::take(&mut self.events);
        let mut files = std::mem::take(&mut self.results);
        for (i, name) in [RECORDING, JOURNAL].into_iter().enumerate() {
            let new = &self.files[i][self.sent_bytes[i]..];
            if !new.is_empty() {
                files.push((name.to_owned(), new.to_vec()));
            }
            self.sent_bytes[i] = self.files[i].len();
        }
        answer(json!({ "events": events, "over": self.is_over }), &files)
    }

    // Rows.

    fn begin(&mut self) {
        if !std::mem::replace(&mut self.has_begun, true) {
            self.guide.begin();
        }
    }

    /// The port is open, for the first time or again.
    fn opened(&mut self, now_s: f64) {
        let Source::Port(recorder) = &mut self.source else {
            return;
        };
        let name = self.guide.name.clone();
        let created = gravical::calibration_file::creation_time();
        let preamble = format!("# {TOOL} in the browser, {created}, {name}\n");
        recorder.opened(now_s, &name, None, preamble);
        self.has_reported = false;
        if !self.has_begun {
            let text = format!("{name} is open: waiting for its first rows.");
            self.guide.note(Event::Connecting { name }, &text);
        }
    }

    /// Bytes of the board, or time that passes.
    fn pass(&mut self, now_s: f64, bytes: &[u8]) -> Result<()> {
        let (read, rows, events) = match &mut self.source {
            Source::Simulated(board, due_s, speed) => {
                if now_s < *due_s {
                    return Ok(());
                }
                // It keeps its pace, and does not make up for a time when the page slept.
                *due_s = (*due_s + SimulatedBoard::PERIOD_S / *speed).max(now_s);
                (Ok(()), board.next_rows().into_bytes(), Vec::new())
            }
            Source::Port(recorder) => {
                let read = recorder.bytes(now_s, bytes);
                let out = recorder.take();
                // Without a row the user can do something; later it is the end.
                let read = match read {
                    Err(e) if e.category() == Category::Device && recorder.counts.rows == 0 => {
                        self.report_no_rows(&e);
                        Ok(())
                    }
                    read => read,
                };
                (read, out.lines, out.events)
            }
        };
        if !rows.is_empty() {
            self.begin();
            self.files[0].extend_from_slice(&rows);
        }
        // What was passed on before an error belongs to the recording.
        self.guide.receive(&rows, events).and(read)
    }

    /// The port has lost some of what the board sent.
    fn overflow(&mut self) -> Result<()> {
        match &mut self.source {
            Source::Port(recorder) => recorder.overflow(1),
            Source::Simulated(..) => Ok(()),
        }
    }

    /// No row arrives: what helps is said once.
    fn report_no_rows(&mut self, error: &Error) {
        if std::mem::replace(&mut self.has_reported, true) {
            return;
        }
        let remedy = match error.code() {
            "board-silent" => "Flash the sketch, or press the reset button of the board.",
            "board-not-text" => "Choose the baud rate of its sketch.",
            _ => "A row has at least three numbers.",
        };
        let event = Event::Ports {
            ports: Vec::new(),
            tried: Some(self.guide.name.clone()),
            flash: Vec::new(),
            simulate: true,
        };
        self.guide
            .note(event, &format!("{} {remedy}", sentence(error.message())));
    }

    /// The cable is pulled.
    fn lost(&mut self) {
        if let Source::Port(recorder) = &mut self.source {
            recorder.lost("unplugged");
        }
        self.guide.lost(Loss::Unplugged);
    }

    // Commands and the end.

    fn command(&mut self, now_s: f64, command: &Command) -> Result<()> {
        if let Source::Simulated(board, ..) = &mut self.source {
            match board.command(command, self.guide.session.next_up()) {
                Ok(false) => {}
                Ok(true) => return Ok(()),
                Err(error) => {
                    self.guide.warn(&error.to_string());
                    return Ok(());
                }
            }
        }
        self.guide.command(command);
        if !self.guide.session.is_done() {
            return Ok(());
        }
        if let Source::Port(recorder) = &mut self.source {
            // What is held is written.
            let _ = recorder.finish(now_s);
            self.files[0].extend(recorder.take().lines);
        }
        if *command == Command::Cancel {
            self.end(
                EndReason::Cancelled,
                "Cancelled without a calibration; what was recorded is kept.",
            );
            return Ok(());
        }
        self.save()
    }

    /// The calibration is that of the files, as `gravical calibrate` computes it of them.
    fn save(&mut self) -> Result<()> {
        self.append_to_journal();
        let named = |i: usize, name: &'static str| Named::Bytes(Path::new(name), &self.files[i]);
        let files = [named(0, RECORDING), named(1, JOURNAL)];
        let read = ReadOptions {
            hash: true,
            ..ReadOptions::default()
        };
        let gravity = Some(self.guide.session.gravity());
        let (recordings, done) =
            calibrate_session(files, &read, &CalibrateOptions::default(), gravity)?;
        let [name, page] = ["calibration.json", "calibration.html"];
        let file = &done.calibration;
        let figures = figure::calibration::figures(file, Some((&recordings, &done.segmentation)));
        let html = report::calibration(file, Some(Path::new(name)), &figures).to_html();
        let event = Event::Saved {
            file: name.to_owned(),
            folder: None,
            report: Some(page.to_owned()),
            next: Vec::new(),
        };
        let truth = match &self.source {
            Source::Simulated(board, ..) => Some(board.truth(file)),
            Source::Port(_) => None,
        };
        self.results = vec![
            (name.to_owned(), file.to_json()?.into_bytes()),
            (page.to_owned(), html.into_bytes()),
        ];
        self.guide.done(
            file,
            Some((event, "The calibration is computed.".to_owned())),
            truth,
        );
        self.is_over = true;
        Ok(())
    }

    fn end(&mut self, reason: EndReason, text: &str) {
        self.guide.end(reason, text, None);
        self.is_over = true;
    }
}
