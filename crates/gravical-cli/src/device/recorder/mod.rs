//! The life of a recording. Inputs are bytes, keys and failures; outputs are lines for the
//! file, commands for the board and events. It has no clock and no I/O: time is an
//! argument, in seconds on any clock that only advances.
//!
//! Opening a port resets most boards. [`Recorder`] waits for the first messages of the
//! board, sets it as wanted, and begins with the header. From then on every row is in the
//! file or in a gap that the file names. [`State`] lists the states.

mod begin;
mod messages;
mod queue;
mod run;
mod settings;
mod start;
#[cfg(test)]
mod tests;

use gravical::Error;
use gravical::recording::ColumnsSpec;

use super::board::{Settings, Wanted};
use super::event::{End, Event};
use super::gap::{Cause, Gap};
use super::live::{Live, Poses};
use super::row_counts::RowCounts;
use super::wire::Wire;
use queue::Queue;
use run::Run;
use start::{Setup, Start};

/// Baud rate of the firmware's text.
pub const TEXT_BAUD: u32 = 115_200;
/// Nothing for this time is reported, s.
const SILENCE_S: f64 = 3.0;
/// Time between two events of the status, s.
const STATUS_S: f64 = 1.0;

/// What is wanted of a recording.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Settings that the board must have.
    pub wanted: Wanted,
    /// Which column is which, for a board that does not say.
    pub columns: Option<ColumnsSpec>,
    /// The recording ends after this many rows; none: at the user's request.
    pub rows: Option<u64>,
    /// It ends this long after the first row, s, without pauses; none: at the user's
    /// request.
    pub duration_s: Option<f64>,
    /// A silent board is waited for without end.
    pub wait: bool,
    /// Lines behind `#` at the head of the file.
    pub preamble: Vec<String>,
    /// The header of the file that is continued.
    pub continues: Option<Vec<u8>>,
}

/// What has to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Bytes for the board.
    Send(Vec<u8>),
    /// What is written has to be safe on the disk.
    Sync,
    /// An event for the user.
    Report(Event),
}

/// The state of a recording. In each of them the port may be lost and found, and the user
/// may pause; the gap that is open, if any, is in the [`Run`].
#[derive(Debug)]
enum State {
    /// Nothing is stored: the board is waited for, asked, and set as wanted.
    Starting(Start),
    /// Rows are stored.
    Storing(Run),
    /// The board restarted, or has other settings than before. Its rows are counted in the
    /// gap that is open, until it is set as before.
    Restoring(Run, Setup),
    /// All that was asked for is there, or the recording failed: rows are counted.
    Over(Run),
}

impl State {
    fn run(&self) -> Option<&Run> {
        match self {
            State::Starting(_) => None,
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => Some(run),
        }
    }

    fn run_mut(&mut self) -> Option<&mut Run> {
        match self {
            State::Starting(_) => None,
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => Some(run),
        }
    }

    fn setup_mut(&mut self) -> Option<&mut Setup> {
        match self {
            State::Starting(start) => Some(&mut start.setup),
            State::Restoring(_, setup) => Some(setup),
            State::Storing(_) | State::Over(_) => None,
        }
    }

    /// A run that is not over continues in another state.
    fn change(&mut self, next: impl FnOnce(Run) -> State) {
        *self = match std::mem::replace(self, State::Starting(Start::default())) {
            State::Storing(run) | State::Restoring(run, _) => next(run),
            other => other,
        };
    }
}

/// One recording.
#[derive(Debug)]
pub struct Recorder {
    options: Options,
    state: State,
    wire: Wire,
    live: Live,
    queue: Queue,
    counts: RowCounts,
    actions: Vec<Action>,
    ended: Option<End>,
    fatal: Option<Error>,
}

impl Recorder {
    /// A recording without a port.
    pub fn new(options: Options) -> Self {
        Recorder {
            options,
            state: State::Starting(Start::default()),
            wire: Wire::default(),
            live: Live::default(),
            queue: Queue::default(),
            counts: RowCounts::default(),
            actions: Vec::new(),
            ended: None,
            fatal: None,
        }
    }

    // Queries.

    /// What has to be done since the last call, in order.
    pub fn take(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// The reason why the recording failed; returned once.
    pub fn take_fatal(&mut self) -> Option<Error> {
        self.fatal.take()
    }

    /// The reason of the end, once it has ended.
    pub fn ended(&self) -> Option<End> {
        self.ended
    }

    /// Whether the recording has begun.
    pub fn is_started(&self) -> bool {
        self.state.run().is_some()
    }

    /// Whether rows are missing right before the end.
    pub fn ended_in_gap(&self) -> bool {
        self.state.run().is_some_and(|run| run.ended_in_gap)
    }

    /// Counts of rows and lines so far.
    pub fn counts(&self) -> &RowCounts {
        &self.counts
    }

    /// The poses that were stored; none where the accelerometer is not known.
    pub fn poses(&self) -> Option<Poses> {
        self.live.poses()
    }

    /// The settings of the board at the beginning.
    pub fn settings(&self) -> Option<&Settings> {
        match &self.state {
            State::Starting(start) => start.settings(),
            begun => begun.run()?.settings.as_ref(),
        }
    }

    /// Seconds since the first row, without pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        self.state.run().map_or(0.0, |run| run.elapsed_s(now_s))
    }

    // Inputs.

    /// A port was opened; `device` is the device behind it.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<&str>) {
        self.wire.opened(now_s);
        self.report(Event::Opened {
            port: port.to_owned(),
            device: device.map(str::to_owned),
        });
        match &mut self.state {
            State::Starting(start) => {
                start.opened(now_s);
                self.report(Event::Waiting {
                    text: "the board (opening its port resets it: about two seconds of silence)"
                        .to_owned(),
                });
            }
            State::Restoring(_, setup) => *setup = Setup::from(now_s + start::ASK_AFTER_S),
            State::Storing(_) | State::Over(_) => {}
        }
    }

    /// The port is lost; `why` is the system's message.
    pub fn lost(&mut self, now_s: f64, why: &str) {
        if let Some(half) = self.wire.lost() {
            self.item(now_s, half);
        }
        match &mut self.state {
            State::Starting(start) => self.counts.before_start += start.drop_held(),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                run.open_gap(now_s, Cause::Unplugged);
            }
        }
        self.report(Event::Lost {
            text: why.to_owned(),
        });
    }

    /// Bytes from the board.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        if let Some(run) = self.state.run_mut() {
            run.silent = false;
        }
        // Line by line: a header says how the next line is to be read.
        for piece in bytes.split_inclusive(|b| matches!(b, b'\n' | b'\r' | 0)) {
            for item in self.wire.push(now_s, piece) {
                self.item(now_s, item);
            }
        }
    }

    /// The space bar.
    pub fn toggle_pause(&mut self, now_s: f64) {
        let (State::Storing(run) | State::Restoring(run, _)) = &mut self.state else {
            return;
        };
        run.toggle_pause(now_s);
        if run.is_paused() {
            self.report(Event::Paused);
            self.actions.push(Action::Sync);
        } else {
            self.report(Event::Resumed);
        }
    }

    /// Time passes.
    pub fn tick(&mut self, now_s: f64) {
        let open = self.wire.open;
        if open && self.fatal.is_none() {
            self.set_up(now_s);
        }
        let Some(run) = self.state.run_mut() else {
            return;
        };
        let silence_s = now_s - self.wire.last_bytes_s;
        let silent = open && silence_s >= SILENCE_S && !std::mem::replace(&mut run.silent, open);
        let status = now_s - run.last_status_s >= STATUS_S;
        if status {
            run.last_status_s = now_s;
        }
        let elapsed_s = run.elapsed_s(now_s);
        if silent {
            self.report(Event::Silent {
                duration_s: silence_s,
            });
        }
        if (self.options.duration_s).is_some_and(|wanted_s| elapsed_s >= wanted_s) {
            self.complete(End::Duration);
        }
        if status {
            let status = self.status(now_s);
            self.report(status);
        }
    }

    /// The recording ends: what has begun is closed.
    pub fn finish(&mut self, now_s: f64, why: End) {
        // The user's end cuts a line, which is no fault.
        self.wire.lost();
        match &mut self.state {
            State::Starting(start) => self.counts.before_start += start.drop_held(),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                let open_end = self.ended != Some(End::Rows);
                let gap = open_end.then(|| run.last_gap(now_s, self.live.step_s()));
                let comments = std::mem::take(&mut run.comments);
                self.close_gap(gap.flatten());
                self.queue.push_comment(comments);
            }
        }
        self.ended.get_or_insert(why);
        self.actions.push(Action::Sync);
    }

    // Events.

    fn report(&mut self, event: Event) {
        self.actions.push(Action::Report(event));
    }

    fn status(&self, now_s: f64) -> Event {
        Event::Status {
            rows: self.counts.stored,
            elapsed_s: self.elapsed_s(now_s),
            paused: self.state.run().is_some_and(Run::is_paused),
            rejected: self.counts.rejected,
            live: self.live.status(now_s),
        }
    }

    fn close_gap(&mut self, gap: Option<Gap>) {
        if let Some(gap) = gap {
            self.queue.push_mark(gap.line().into_bytes());
            self.count_gap(gap);
        }
    }

    fn count_gap(&mut self, gap: Gap) {
        self.counts.gaps += 1;
        self.counts.incomplete += u64::from(gap.is_incomplete());
        self.report(Event::Gap(gap));
    }

    // The disk.

    /// Complete lines that are to be written next, if any. Answer with
    /// [`stored`](Self::stored) or [`failed`](Self::failed).
    pub fn batch(&mut self) -> Option<Vec<u8>> {
        if let Some(run) = self.state.run_mut()
            && !run.is_in_gap()
        {
            self.queue.push_comment(std::mem::take(&mut run.comments));
        }
        self.queue.batch()
    }

    /// So much waits that it should be written before more arrives.
    pub fn is_crowded(&self) -> bool {
        self.queue.is_crowded()
    }

    /// Rejected lines to be written next. Answer with
    /// [`rejects_stored`](Self::rejects_stored) when they are.
    pub fn rejects(&mut self) -> Option<Vec<u8>> {
        self.queue.rejects()
    }

    /// The batch was passed to the system.
    pub fn stored(&mut self) {
        let (rows, gap) = self.queue.written();
        self.counts.stored += rows;
        if let Some(gap) = gap {
            if gap.rows > 0 {
                self.count_gap(gap);
            }
            self.report(Event::DiskRecovered);
        }
    }

    /// The batch could not be written; it will be tried again.
    pub fn failed(&mut self, now_s: f64, why: &str) {
        let first = self.queue.failed(now_s);
        self.counts.unstored = self.queue.dropped();
        if first {
            self.report(Event::DiskFailed {
                text: why.to_owned(),
            });
        }
    }

    /// Rejected lines were passed to the system.
    pub fn rejects_stored(&mut self) {
        self.queue.rejects_written();
    }

    /// The disk takes nothing, and there is no more time: what waits is lost.
    pub fn give_up(&mut self) {
        self.counts.rejected_unstored += self.queue.give_up();
        self.counts.unstored = self.queue.dropped();
    }
}
