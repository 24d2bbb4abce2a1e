//! The state machine of a recording: bytes, clicks and mishaps in; bytes for the file,
//! commands for the board and events out. Without clock and without I/O: time comes in
//! as seconds on any clock that only goes forward.
//!
//! Opening a port resets most boards. [`Recorder`] waits for what the board then says,
//! sets it as wanted, and begins with the header. From there on every row is in the file
//! or in a gap that the file names.

mod follow;
mod hand_over;
mod keep;
mod listen;
mod options;
mod start;
#[cfg(test)]
mod tests;

use gravical::Error;

use super::account::Account;
use super::board::Settings;
use super::event::{End, Event};
use super::frames::Sequence;
use super::gap::{Cause, Gap};
use super::line::{Reason, Row};
use super::live::Live;
use super::stamps::Stamps;
use super::wire::{Item, Wire};
pub use keep::Batch;
use keep::Keep;
use listen::Ear;
pub use options::{Action, Options, TEXT_BAUD};
use start::Start;

/// Rejected lines that are told one by one; all are counted and kept.
const TOLD_REJECTS: u64 = 10;
/// Rows fewer than this are no gap of their own: the reader counts them as lost.
const FEWEST_MISSING: u64 = 4;
/// Nothing for so long is said, s.
const SILENCE_S: f64 = 3.0;
/// Between two looks at the stream, s.
const STATUS_S: f64 = 1.0;
/// Without a row for so long, and so many of its steps, at the end: a gap, s.
const SILENT_END_S: f64 = 1.0;
const SILENT_END_STEPS: f64 = 4.5;
/// What three blank rows look like.
const RESUME: &[u8] = b"\n\n\n";

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Nothing is recorded yet.
    Starting,
    Recording,
    /// The board came back with other settings; they are being set.
    Restoring,
}

/// One recording.
#[derive(Debug)]
pub struct Recorder {
    options: Options,
    state: State,
    wire: Wire,
    ear: Ear,
    stamps: Stamps,
    sequence: Sequence,
    live: Live,
    account: Account,
    start: Start,
    keep: Keep,
    gap: Option<(f64, Gap)>,
    /// It was paused when the gap began.
    gap_in_pause: bool,
    /// Lines of the board that wait for the gap before them.
    comments: Vec<u8>,
    /// The board said its settings since the last row.
    spoke: bool,
    rejected_since_row: u64,
    open: bool,
    started_s: Option<f64>,
    paused_from_s: Option<f64>,
    paused_s: f64,
    resumed: bool,
    last_bytes_s: f64,
    last_row_s: f64,
    /// Seconds of the recording at the last row, and from the row before to it.
    last_row_elapsed_s: f64,
    row_step_s: f64,
    last_status_s: f64,
    silent: bool,
    ended_in_gap: bool,
    ended: Option<End>,
    fatal: Option<Error>,
    /// It cannot go on: nothing more is stored.
    failed: bool,
    actions: Vec<Action>,
}

impl Recorder {
    /// Nothing is open yet.
    pub fn new(options: Options) -> Self {
        Recorder {
            start: Start::default(),
            options,
            state: State::Starting,
            wire: Wire::default(),
            ear: Ear::default(),
            stamps: Stamps::default(),
            sequence: Sequence::default(),
            live: Live::default(),
            account: Account::default(),
            keep: Keep::default(),
            gap: None,
            gap_in_pause: false,
            comments: Vec::new(),
            spoke: false,
            rejected_since_row: 0,
            open: false,
            started_s: None,
            paused_from_s: None,
            paused_s: 0.0,
            resumed: false,
            last_bytes_s: 0.0,
            last_row_s: 0.0,
            last_row_elapsed_s: 0.0,
            row_step_s: 0.0,
            last_status_s: 0.0,
            silent: false,
            ended_in_gap: false,
            ended: None,
            fatal: None,
            failed: false,
            actions: Vec::new(),
        }
    }

    /// What has to be done since the last call, in order.
    pub fn take(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Why it cannot go on; asked for once.
    pub fn take_fatal(&mut self) -> Option<Error> {
        self.fatal.take()
    }

    fn fail(&mut self, error: Error) {
        self.failed = true;
        self.fatal.get_or_insert(error);
    }

    /// Why it ended, once it has.
    pub fn ended(&self) -> Option<End> {
        self.ended
    }

    /// Whether it records, or has.
    pub fn is_started(&self) -> bool {
        self.started_s.is_some()
    }

    /// Whether rows are missing right before the end.
    pub fn ended_in_gap(&self) -> bool {
        self.ended_in_gap
    }

    /// Whether it is paused.
    pub fn is_paused(&self) -> bool {
        self.paused_from_s.is_some()
    }

    /// Where every line went so far.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// How the board was set when it began.
    pub fn settings(&self) -> Option<&Settings> {
        self.start.settings.as_ref()
    }

    /// Seconds since it began, pauses left out.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        let paused = self.paused_s + self.paused_from_s.map_or(0.0, |from| now_s - from);
        self.started_s
            .map_or(0.0, |from| (now_s - from - paused).max(0.0))
    }

    fn tell(&mut self, event: Event) {
        self.actions.push(Action::Tell(event));
    }

    /// A port was opened; `device` is what is behind it.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<&str>) {
        self.listen_from(now_s);
        self.open = true;
        self.start.opened(now_s);
        self.last_bytes_s = now_s;
        self.silent = false;
        self.tell(Event::Opened {
            port: port.to_owned(),
            device: device.map(str::to_owned),
        });
    }

    /// The port is gone; `why` is what the system says.
    pub fn lost(&mut self, now_s: f64, why: &str) {
        self.open = false;
        if let Some(Item::Bad { bytes, reason }) = self.wire.cut() {
            self.bad(bytes, reason);
        }
        if self.is_started() {
            self.open_gap(now_s, Cause::Unplugged);
        } else {
            self.account.before_start += self.start.forget_held();
        }
        self.tell(Event::Lost {
            text: why.to_owned(),
        });
    }

    /// Bytes from the board.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        self.heard(now_s, bytes);
        self.last_bytes_s = now_s;
        self.silent = false;
        for item in self.wire.push(bytes) {
            if !matches!(item, Item::Bad { .. }) {
                self.makes_sense(now_s);
            }
            match item {
                Item::Row { bytes, row } => self.row(now_s, bytes, row),
                Item::Comment(bytes) => self.comment(now_s, &bytes),
                Item::Header { bytes, whole } => self.header(now_s, bytes, whole),
                Item::Bad { bytes, reason } => self.bad(bytes, reason),
            }
        }
    }

    fn reject(&mut self, bytes: Vec<u8>, reason: Reason) {
        self.account.rejected += 1;
        self.rejected_since_row += 1;
        if self.account.rejected <= TOLD_REJECTS {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            self.tell(Event::Rejected { reason, text });
        }
        self.keep.reject(bytes);
    }

    fn row(&mut self, now_s: f64, bytes: Vec<u8>, row: Row) {
        self.account.received += 1;
        self.live.see(now_s, row);
        if self.state == State::Starting {
            self.account.before_start += self.start.hold(now_s, bytes, row);
            return;
        }
        if self.wire.coding() == self.start.coding {
            self.follow(now_s, &row);
        }
        self.row_step_s = now_s - self.last_row_s;
        self.last_row_s = now_s;
        self.last_row_elapsed_s = self.elapsed_s(now_s);
        if self.ended.is_some() || self.failed {
            self.account.after_end += 1;
        } else if self.is_paused() {
            self.account.paused += 1;
        } else if self.state == State::Restoring {
            self.account.other_settings += 1;
            if let Some((_, gap)) = &mut self.gap {
                gap.rows += 1;
            }
        } else {
            self.store(now_s, bytes);
        }
    }

    fn store(&mut self, now_s: f64, bytes: Vec<u8>) {
        self.close_gap(now_s);
        self.keep.comment(std::mem::take(&mut self.comments));
        if std::mem::take(&mut self.resumed) {
            self.keep.resume();
        }
        self.keep.row(bytes);
        let taken = self.account.stored + self.keep.rows();
        if self.options.rows.is_some_and(|wanted| taken >= wanted) {
            self.ended = Some(End::Rows);
        }
    }

    fn comment(&mut self, now_s: f64, bytes: &[u8]) {
        self.account.comments += 1;
        let text = String::from_utf8_lossy(bytes.trim_ascii()).into_owned();
        self.tell(Event::Board { text: text.clone() });
        if self.state == State::Starting {
            self.start.said(&text);
        } else {
            self.comments.extend_from_slice(text.as_bytes());
            self.comments.push(b'\n');
        }
        if let Some(settings) = Settings::parse(&text) {
            self.spoke = true;
            self.settings_are(now_s, settings);
        }
    }

    /// The space bar.
    pub fn toggle_pause(&mut self, now_s: f64) {
        if !self.is_started() || self.ended.is_some() {
            return;
        }
        match self.paused_from_s.take() {
            Some(from) => {
                self.paused_s += now_s - from;
                self.resumed = self.account.stored + self.keep.rows() > 0;
                self.tell(Event::Resumed);
            }
            None => {
                self.paused_from_s = Some(now_s);
                self.tell(Event::Paused);
                self.actions.push(Action::Sync);
            }
        }
    }

    /// Time goes by.
    pub fn tick(&mut self, now_s: f64) {
        if self.open && self.state != State::Recording {
            self.wait_for_the_board(now_s);
        }
        if self.open {
            self.listen_elsewhere(now_s);
        }
        if self.failed {
            self.noise_is_rejected();
        }
        let waits = self.open && self.is_started() && !self.silent;
        if waits && now_s - self.last_bytes_s >= SILENCE_S {
            self.silent = true;
            self.tell(Event::Silent {
                duration_s: now_s - self.last_bytes_s,
            });
        }
        if self.ended.is_none()
            && self.is_started()
            && (self.options.duration_s).is_some_and(|wanted| self.elapsed_s(now_s) >= wanted)
        {
            self.ended = Some(End::Duration);
        }
        if self.is_started() && now_s - self.last_status_s >= STATUS_S {
            self.last_status_s = now_s;
            let status = self.status(now_s);
            self.tell(status);
        }
    }

    /// How it goes.
    pub fn status(&self, now_s: f64) -> Event {
        Event::Status {
            rows: self.account.stored,
            elapsed_s: self.elapsed_s(now_s),
            paused: self.is_paused(),
            rejected: self.account.rejected,
            live: self.live.status(now_s),
        }
    }

    /// Nothing more will come: what is begun is closed.
    pub fn finish(&mut self, now_s: f64, why: End) {
        // A line that is cut by the end is no mishap, but what comes after it.
        self.wire.cut();
        self.noise_is_rejected();
        self.account.before_start += self.start.forget_held();
        if self.is_started() {
            self.gap_until_the_end(now_s);
            self.close_gap(now_s);
            self.keep.comment(std::mem::take(&mut self.comments));
        }
        self.ended.get_or_insert(why);
        self.actions.push(Action::Sync);
    }
}
