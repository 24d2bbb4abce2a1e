//! The life of a recording: bytes, clicks and mishaps in; bytes for the file, commands for
//! the board and events out. Without clock and without I/O: time comes in as seconds on
//! any clock that only goes forward.
//!
//! Opening a port resets most boards. [`Recorder`] waits for what the board then says,
//! sets it as wanted, and begins with the header. From there on every row is in the file
//! or in a gap that the file names. [`State`] says which states there are.

mod keep;
mod run;
mod start;
#[cfg(test)]
mod tests;

use gravical::Error;

use super::account::Account;
use super::board::{Settings, Wanted};
use super::event::{End, Event};
use super::frames;
use super::gap::{Cause, Gap};
use super::item::{Item, Kind, Reason, Row};
use super::live::Live;
use super::wire::{Coding, Wire};
use keep::Keep;
use run::Run;
use start::{Dialog, Start, UP_S};

/// Bits a second of the firmware's text.
pub const TEXT_BAUD: u32 = 115_200;
/// What the report's boards send, where none says so.
const COLUMNS: &str = "Timestamp,ax,ay,az,temp,gx,gy,gz";
/// Without a header for so long there will be none, s, when so many rows came.
const NO_HEADER_S: f64 = 6.0;
const ROWS_WITHOUT_HEADER: usize = 5;
/// Without a row for so long something is wrong, s.
const NO_ROWS_S: f64 = 8.0;
/// Rejected lines that are told one by one; all are counted and kept.
const TOLD_REJECTS: u64 = 10;
/// Nothing for so long is said, s.
const SILENCE_S: f64 = 3.0;
/// Between two looks at the stream, s.
const STATUS_S: f64 = 1.0;

/// What is wanted of a recording.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Settings that the board has to have.
    pub wanted: Wanted,
    /// It ends with so many rows; none: when it is told to.
    pub rows: Option<u64>,
    /// It ends so long after the first row, s, pauses left out; none: when it is told to.
    pub duration_s: Option<f64>,
    /// A silent board is waited for without end.
    pub wait: bool,
    /// Lines behind `#` at the head of the file.
    pub preamble: Vec<String>,
    /// The header of the file that is continued.
    pub continues: Option<Vec<u8>>,
    /// Bits a second of text; a port is opened so.
    pub baud: u32,
}

/// What has to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Bytes for the board.
    Send(Vec<u8>),
    /// When all that was sent has left, the port has to be set to so many bits a second.
    /// Answer with [`Recorder::bytes`] for what came at the rate before, then with
    /// [`Recorder::baud_is_set`].
    Baud(u32),
    /// What is written has to be safe on the disk.
    Sync,
    /// Somebody may want to know.
    Tell(Event),
}

/// Where a recording stands. The port may come and go in each of them, and the user may
/// pause; the gap that is open, if any, is the [`Run`]'s.
#[derive(Debug)]
enum State {
    /// Nothing is stored: the board is waited for, asked, and set as wanted.
    Starting(Start),
    /// Rows are stored.
    Storing(Run),
    /// The board started anew, or is set otherwise than it was. Its rows are counted in
    /// the gap that is open, until it is set as before.
    Restoring(Run, Dialog),
    /// All that was asked for is there, or it cannot go on: rows are counted.
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

    fn dialog_mut(&mut self) -> Option<&mut Dialog> {
        match self {
            State::Starting(start) => Some(&mut start.dialog),
            State::Restoring(_, dialog) => Some(dialog),
            State::Storing(_) | State::Over(_) => None,
        }
    }

    /// What has begun, and is not over, goes on in another state.
    fn goes_on(&mut self, next: impl FnOnce(Run) -> State) {
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
    keep: Keep,
    account: Account,
    actions: Vec<Action>,
    ended: Option<End>,
    fatal: Option<Error>,
}

impl Recorder {
    /// Nothing is open yet.
    pub fn new(options: Options) -> Self {
        Recorder {
            options,
            state: State::Starting(Start::default()),
            wire: Wire::default(),
            live: Live::default(),
            keep: Keep::default(),
            account: Account::default(),
            actions: Vec::new(),
            ended: None,
            fatal: None,
        }
    }

    // What it is asked.

    /// What has to be done since the last call, in order.
    pub fn take(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Why it cannot go on; asked for once.
    pub fn take_fatal(&mut self) -> Option<Error> {
        self.fatal.take()
    }

    /// Why it ended, once it has.
    pub fn ended(&self) -> Option<End> {
        self.ended
    }

    /// Whether it records, or has.
    pub fn is_started(&self) -> bool {
        self.state.run().is_some()
    }

    /// Whether rows are missing right before the end.
    pub fn ended_in_gap(&self) -> bool {
        self.state.run().is_some_and(|run| run.ended_in_gap)
    }

    /// Where every line went so far.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// How the board was set when it began.
    pub fn settings(&self) -> Option<&Settings> {
        match &self.state {
            State::Starting(start) => start.settings.as_ref(),
            begun => begun.run()?.settings.as_ref(),
        }
    }

    /// Seconds since it began, pauses left out.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        self.state.run().map_or(0.0, |run| run.elapsed_s(now_s))
    }

    // What happens.

    /// A port was opened; `device` is what is behind it.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<&str>) {
        self.wire.opened(now_s);
        self.tell(Event::Opened {
            port: port.to_owned(),
            device: device.map(str::to_owned),
        });
        match &mut self.state {
            State::Starting(start) => {
                start.opened(now_s);
                self.tell(Event::Waiting {
                    text: "the board (opening its port resets it: about two seconds of silence)"
                        .to_owned(),
                });
            }
            State::Restoring(_, dialog) => *dialog = Dialog::from(now_s + start::ASK_AFTER_S),
            State::Storing(_) | State::Over(_) => {}
        }
    }

    /// The port is gone; `why` is what the system says.
    pub fn lost(&mut self, now_s: f64, why: &str) {
        if let Some(half) = self.wire.lost() {
            self.item(now_s, half);
        }
        match &mut self.state {
            State::Starting(start) => self.account.before_start += start.forget_held(),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                run.open_gap(now_s, Cause::Unplugged);
            }
        }
        self.tell(Event::Lost {
            text: why.to_owned(),
        });
    }

    /// The port has the rate of [`Action::Baud`] now; what came at the one before was
    /// handed over.
    pub fn baud_is_set(&mut self, now_s: f64) {
        if !self.wire.turned(now_s) {
            return;
        }
        if let Some(dialog) = self.state.dialog_mut() {
            dialog.turned(now_s);
        }
        if let State::Starting(start) = &mut self.state {
            self.account.before_start += start.forget_held();
            start.columns = None;
        }
    }

    /// Bytes from the board.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        if let Some(run) = self.state.run_mut() {
            run.silent = false;
        }
        for item in self.wire.push(now_s, bytes) {
            self.item(now_s, item);
        }
    }

    /// The space bar.
    pub fn toggle_pause(&mut self, now_s: f64) {
        let (State::Storing(run) | State::Restoring(run, _)) = &mut self.state else {
            return;
        };
        run.toggle_pause(now_s);
        if run.is_paused() {
            self.tell(Event::Paused);
            self.actions.push(Action::Sync);
        } else {
            self.tell(Event::Resumed);
        }
    }

    /// Time goes by.
    pub fn tick(&mut self, now_s: f64) {
        let open = self.wire.open;
        if open && self.fatal.is_none() {
            self.settle(now_s);
            if let Some(coding) = self.wire.elsewhere(now_s) {
                self.turn_to(coding);
            }
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
            self.tell(Event::Silent {
                duration_s: silence_s,
            });
        }
        if (self.options.duration_s).is_some_and(|wanted_s| elapsed_s >= wanted_s) {
            self.is_complete(End::Duration);
        }
        if status {
            let status = self.status(now_s);
            self.tell(status);
        }
    }

    /// Nothing more will come: what is begun is closed.
    pub fn finish(&mut self, now_s: f64, why: End) {
        // A line that is cut by the end is no mishap, but what comes after it.
        self.wire.lost();
        match &mut self.state {
            State::Starting(start) => self.account.before_start += start.forget_held(),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                let open_end = self.ended != Some(End::Rows);
                let gap = open_end.then(|| run.last_gap(now_s, self.live.step_s()));
                let comments = std::mem::take(&mut run.comments);
                self.close_gap(gap.flatten());
                self.keep.comment(comments);
            }
        }
        self.ended.get_or_insert(why);
        self.actions.push(Action::Sync);
    }

    // What the board sent.

    fn item(&mut self, now_s: f64, item: Item) {
        let turned = |run: &Run| run.coding != self.wire.coding;
        if !matches!(item.kind, Kind::Rejected(_)) && self.state.run().is_some_and(turned) {
            self.board_is_anew(now_s);
        }
        match item.kind {
            Kind::Row(row) => {
                self.account.received += 1;
                self.live.see(now_s, row);
                self.row(now_s, item.bytes, row);
            }
            Kind::Comment => self.comment(now_s, &item.bytes),
            Kind::Header { whole } => self.header(now_s, item.bytes, whole),
            Kind::Rejected(reason) => self.reject(item.bytes, reason),
        }
    }

    fn row(&mut self, now_s: f64, bytes: Vec<u8>, row: Row) {
        if let State::Starting(start) = &mut self.state {
            self.account.before_start += start.hold(now_s, bytes, row);
            return;
        }
        if let State::Storing(run) | State::Restoring(run, _) = &mut self.state
            && run.coding == self.wire.coding
            && run.follow(now_s, &row, &mut self.account)
        {
            self.restore(Dialog::default());
            self.ask(now_s);
        }
        if let Some(run) = self.state.run_mut() {
            run.saw_row(now_s);
        }
        match &mut self.state {
            State::Starting(_) | State::Over(_) => self.account.after_end += 1,
            State::Storing(run) | State::Restoring(run, _) if run.is_paused() => {
                self.account.paused += 1;
            }
            State::Restoring(run, _) => {
                self.account.other_settings += 1;
                run.row_in_gap();
            }
            State::Storing(run) => {
                let gap = run.close_gap(now_s);
                let comments = std::mem::take(&mut run.comments);
                let resumed = std::mem::take(&mut run.resumed);
                run.has_rows = true;
                self.close_gap(gap);
                self.keep.comment(comments);
                if resumed {
                    // Three blank rows.
                    self.keep.mark(b"\n\n\n".to_vec());
                }
                self.keep.row(bytes);
                let taken = self.account.stored + self.keep.rows();
                if self.options.rows.is_some_and(|wanted| taken >= wanted) {
                    self.is_complete(End::Rows);
                }
            }
        }
    }

    fn comment(&mut self, now_s: f64, bytes: &[u8]) {
        self.account.comments += 1;
        let text = String::from_utf8_lossy(bytes).into_owned();
        let settings = Settings::parse(&text);
        match &mut self.state {
            State::Starting(start) => start.said(&text, settings),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                run.comments.extend_from_slice(text.as_bytes());
                run.comments.push(b'\n');
            }
        }
        self.tell(Event::Board { text });
        if let Some(settings) = settings {
            self.settings_are(now_s, settings);
        }
    }

    fn header(&mut self, now_s: f64, bytes: Vec<u8>, whole: bool) {
        let columns = match &self.state {
            State::Starting(start) => start.columns.as_ref(),
            begun => begun.run().map(|run| &run.columns),
        };
        let known = columns == Some(&bytes);
        let starting = matches!(self.state, State::Starting(_));
        let starts_up = starting && self.wire.heard_its_start();
        if !whole && !known && !starts_up && !begins_with_time(&bytes) {
            self.reject(bytes, Reason::Half);
            return;
        }
        match &mut self.state {
            State::Starting(start) => {
                start.columns = Some(bytes);
                self.start_if_ready(now_s);
            }
            State::Storing(_) if known => {}
            State::Storing(run) if run.settings.is_some() && !run.spoke => {
                run.open_gap(now_s, Cause::Settings);
                self.restore(Dialog::about(bytes));
                self.ask(now_s);
            }
            State::Storing(_) => self.fail(columns_changed(&bytes)),
            // While it is being set it may say what it likes.
            State::Restoring(..) | State::Over(_) => {}
        }
    }

    fn reject(&mut self, bytes: Vec<u8>, reason: Reason) {
        self.account.rejected += 1;
        if let Some(run) = self.state.run_mut() {
            run.rejected_since_row += 1;
        }
        if self.account.rejected <= TOLD_REJECTS {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            self.tell(Event::Rejected { reason, text });
        }
        self.account.rejected_unstored += u64::from(!self.keep.reject(&bytes));
    }

    // How the board is set.

    fn goal(&self) -> Wanted {
        self.state.run().map_or(self.options.wanted, Run::goal)
    }

    /// The board said how it is set.
    fn settings_are(&mut self, now_s: f64, settings: Settings) {
        let coding = self.wire.coding;
        let met = self.goal().is_met_by(&settings);
        if let Some(run) = self.state.run_mut() {
            run.spoke = true;
            run.is_set(&settings, coding);
        }
        match &mut self.state {
            State::Starting(start) if met => {
                start.dialog.settled();
                if coding == Coding::Frames {
                    // There is no header between frames.
                    start.columns = Some(frames::COLUMNS.into());
                    self.start_if_ready(now_s);
                }
            }
            State::Restoring(..) if met => self.state.goes_on(State::Storing),
            State::Storing(run) if !met => {
                run.open_gap(now_s, Cause::Settings);
                self.restore(Dialog::default());
            }
            _ => {}
        }
        if !met && self.state.dialog_mut().is_some_and(|d| d.tries == 0) {
            self.command(now_s);
        }
    }

    /// Its rows are not stored until the board is set as it was.
    fn restore(&mut self, dialog: Dialog) {
        self.state.goes_on(|run| State::Restoring(run, dialog));
    }

    /// The board speaks otherwise than it did: it was reset.
    fn board_is_anew(&mut self, now_s: f64) {
        self.wire.clock_anew();
        if let Some(run) = self.state.run_mut() {
            run.board_anew(now_s);
        }
        if matches!(self.state, State::Storing(_)) {
            // Most boards say by themselves how they are set.
            self.restore(Dialog::from(now_s + UP_S));
        }
    }

    /// Asks the board how it is set.
    fn ask(&mut self, now_s: f64) {
        if let Some(dialog) = self.state.dialog_mut() {
            dialog.ask(now_s);
            self.actions.push(Action::Send(b"?\n".to_vec()));
        }
    }

    /// Sends what is wanted.
    fn command(&mut self, now_s: f64) {
        let goal = self.goal();
        if let Some(dialog) = self.state.dialog_mut() {
            dialog.command(now_s);
        }
        let commands = goal.commands();
        let text = String::from_utf8_lossy(&commands).trim().replace('\n', " ");
        self.tell(Event::Commands { text });
        self.actions.push(Action::Send(commands));
        if let Some(format) = goal.format {
            self.turn_to(Coding::of_format(format));
        }
    }

    /// Has the port set to the rate that belongs to `coding`, where it is another one.
    fn turn_to(&mut self, coding: Coding) {
        if self.wire.turns_to(coding) {
            let baud = match coding {
                Coding::Text => self.options.baud,
                Coding::Frames => frames::BAUD,
            };
            self.actions.push(Action::Baud(baud));
            self.tell(Event::Speed { baud });
        }
    }

    /// What is missing of the board is asked for, in the end given up.
    fn settle(&mut self, now_s: f64) {
        let starting = matches!(self.state, State::Starting(_));
        // It is not set as it has to be; it said nothing that makes sense.
        let (mut unmet, mut silent) = (true, false);
        if let State::Starting(start) = &self.state {
            let wanted = &self.options.wanted;
            unmet =
                !(start.settings).map_or(wanted.is_empty(), |settings| wanted.is_met_by(&settings));
            silent = start.settings.is_none() && start.held.is_empty();
            if !unmet || silent {
                self.without_header(now_s);
            }
        }
        // At a rate at which nothing makes sense nothing is understood either.
        let unsure = !self.wire.understood;
        let frames = self.wire.coding == Coding::Frames;
        let Some(dialog) = self.state.dialog_mut().filter(|d| d.is_due(now_s)) else {
            return;
        };
        if unmet && dialog.is_refused(now_s, !starting) {
            let error = match dialog.other_columns.take() {
                Some(columns) => columns_changed(&columns),
                None => settings_refused(self.settings().is_some()),
            };
            self.fail(error);
        } else if unmet && !silent && !unsure && (dialog.asked || !frames) {
            self.command(now_s);
        } else {
            self.ask(now_s);
        }
    }

    // How it begins and ends.

    fn start_if_ready(&mut self, now_s: f64) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let wanted = self.options.wanted;
        let set = wanted.is_empty()
            || (start.settings).is_some_and(|settings| wanted.is_met_by(&settings));
        if set && start.columns.is_some() {
            // Rows before the header are of another clock, or of other settings.
            self.account.before_start += start.forget_held();
            self.begin(now_s);
        }
    }

    /// Nothing names the columns: it begins without, or there are no rows either.
    fn without_header(&mut self, now_s: f64) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let waited_s = now_s - start.opened_s;
        let rowless_s = now_s - start.last_row_s;
        if waited_s >= NO_HEADER_S && start.held.len() >= ROWS_WITHOUT_HEADER {
            let usual = match self.wire.coding {
                Coding::Text => "# the board named no columns: taken as the usual ones",
                Coding::Frames => "# the board did not say how it is set: the range is not known",
            };
            start.said(usual, None);
            let held = std::mem::take(&mut start.held);
            self.begin(now_s);
            for (bytes, row) in held {
                self.row(now_s, bytes, row);
            }
        } else if rowless_s >= NO_ROWS_S && !self.options.wait {
            // A slow board needs longer than others to show what it sends.
            let error = start.no_rows(self.wire.nonsense());
            self.fail(error);
        }
    }

    /// The head of the file; from here on rows are stored.
    fn begin(&mut self, now_s: f64) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let coding = self.wire.coding;
        let columns = start.columns.take().unwrap_or_else(|| match coding {
            Coding::Text => COLUMNS.into(),
            Coding::Frames => frames::COLUMNS.into(),
        });
        let named = String::from_utf8_lossy(&columns).into_owned();
        if let Some(header) = &self.options.continues
            && *header != columns
        {
            let error = Error::device(
                "columns-changed",
                format!(
                    "the file has the columns {}, the board sends {named}",
                    String::from_utf8_lossy(header),
                ),
            );
            self.fail(
                error.with_hint("record into another file, or set the board as it was: --format"),
            );
            return;
        }
        let mut head = String::new();
        for line in &self.options.preamble {
            head.push_str(&format!("# {line}\n"));
        }
        for line in start.all_said() {
            head.push_str(&format!("{line}\n"));
        }
        let mut run = Run::new(now_s, columns, start.settings, coding);
        if self.options.continues.is_some() {
            run.open_gap(now_s, Cause::Continued);
            run.comments = head.into_bytes();
            run.resumed = true;
        } else {
            if let Some(settings) = &run.settings {
                head.push_str(&format!("# rate: {:.2} Hz\n", settings.rate_hz));
            }
            self.keep.mark(head.into_bytes());
            self.keep.mark([&run.columns[..], b"\n"].concat());
        }
        self.wire.record(run.settings.is_some());
        self.state = State::Storing(run);
        self.tell(Event::Started { columns: named });
    }

    /// All that was asked for is there.
    fn is_complete(&mut self, why: End) {
        if !matches!(self.state, State::Over(_)) {
            self.ended = Some(why);
            self.state.goes_on(State::Over);
        }
    }

    /// It cannot go on.
    fn fail(&mut self, error: Error) {
        self.fatal.get_or_insert(error);
        self.state.goes_on(State::Over);
    }

    // What is told.

    fn tell(&mut self, event: Event) {
        self.actions.push(Action::Tell(event));
    }

    fn status(&self, now_s: f64) -> Event {
        Event::Status {
            rows: self.account.stored,
            elapsed_s: self.elapsed_s(now_s),
            paused: self.state.run().is_some_and(Run::is_paused),
            rejected: self.account.rejected,
            live: self.live.status(now_s),
        }
    }

    fn close_gap(&mut self, gap: Option<Gap>) {
        if let Some(gap) = gap {
            self.keep.mark(gap.line().into_bytes());
            self.count_gap(gap);
        }
    }

    fn count_gap(&mut self, gap: Gap) {
        self.account.gaps += 1;
        self.account.incomplete += u64::from(gap.is_incomplete());
        self.tell(Event::Gap(gap));
    }

    // What goes to the disk.

    /// Whole lines that are to be written next, if any. Answer with
    /// [`stored`](Self::stored) or [`failed`](Self::failed).
    pub fn batch(&mut self) -> Option<Vec<u8>> {
        if let Some(run) = self.state.run_mut()
            && !run.is_in_gap()
        {
            self.keep.comment(std::mem::take(&mut run.comments));
        }
        self.keep.batch()
    }

    /// So much waits that it should be written before more comes.
    pub fn is_crowded(&self) -> bool {
        self.keep.is_crowded()
    }

    /// Rejected lines to be written next. Answer with
    /// [`rejects_stored`](Self::rejects_stored) when they are.
    pub fn rejects(&mut self) -> Option<Vec<u8>> {
        self.keep.rejects()
    }

    /// The batch is handed to the system.
    pub fn stored(&mut self) {
        let (rows, gap) = self.keep.stored();
        self.account.stored += rows;
        if let Some(gap) = gap {
            if gap.rows > 0 {
                self.count_gap(gap);
            }
            self.tell(Event::DiskRecovered);
        }
    }

    /// The disk did not take the batch; it will be asked again.
    pub fn failed(&mut self, now_s: f64, why: &str) {
        let first = self.keep.failed(now_s);
        self.account.unstored = self.keep.dropped();
        if first {
            self.tell(Event::DiskFailed {
                text: why.to_owned(),
            });
        }
    }

    /// Rejected lines are handed to the system.
    pub fn rejects_stored(&mut self) {
        self.keep.rejects_stored();
    }

    /// The disk takes nothing any more, and there is no more time: what waits is lost.
    pub fn give_up(&mut self) {
        self.account.rejected_unstored += self.keep.give_up();
        self.account.unstored = self.keep.dropped();
    }
}

/// Whether the first name is one of those that a stamp has, and no rest of one:
/// `stamp (ms)` is not.
fn begins_with_time(header: &[u8]) -> bool {
    let ends = |b: &u8| !b.is_ascii_alphanumeric();
    let word = header.split(ends).next();
    [&b"timestamp"[..], b"time", b"t", b"millis", b"micros"]
        .iter()
        .any(|name| word.is_some_and(|word| word.eq_ignore_ascii_case(name)))
}

fn columns_changed(columns: &[u8]) -> Error {
    let columns = String::from_utf8_lossy(columns);
    Error::device(
        "columns-changed",
        format!("the board sends other columns now: {columns}"),
    )
    .with_hint("what was recorded is in the file; record the rest into another one")
}

fn settings_refused(speaks: bool) -> Error {
    Error::device(
        "settings-refused",
        if speaks {
            "the board does not take the settings: what it says after them is another one"
        } else {
            "the board does not say how it is set: it is not known whether it took the settings"
        },
    )
    .with_hint("put firmware/mpu6050_logger onto the board, or leave the settings out")
}
