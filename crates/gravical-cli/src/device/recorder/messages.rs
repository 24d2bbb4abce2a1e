//! Messages of the board: rows, comments, headers, rejected lines.

use gravical::Error;

use super::start::Setup;
use super::{Recorder, State};
use crate::device::board::Settings;
use crate::device::event::{End, Event};
use crate::device::gap::Cause;
use crate::device::item::{Item, Kind, Reason, Row};
use crate::device::shape::is_certain;

/// Rejected lines that are reported one by one; all are counted and stored.
const REPORTED_REJECTS: u64 = 10;
/// This many rejected lines between the header and the first row: the rows are not those
/// of the header.
const MOST_REJECTS_BEFORE_ROWS: u64 = 50;

impl Recorder {
    pub(super) fn item(&mut self, now_s: f64, item: Item) {
        match item.kind {
            Kind::Row(row) => {
                self.counts.received += 1;
                self.row(now_s, item.bytes, row);
            }
            Kind::Comment => self.comment(now_s, &item.bytes),
            Kind::Header { whole } => self.header(now_s, item.bytes, whole),
            Kind::Rejected(reason) => self.reject(item.bytes, reason),
        }
    }

    /// A row that arrived at `now_s`.
    pub(super) fn row(&mut self, now_s: f64, bytes: Vec<u8>, row: Row) {
        if let State::Starting(start) = &mut self.state {
            self.counts.before_start += start.hold(now_s, bytes);
            self.live.push(now_s, &Row::default(), false);
            return;
        }
        if let State::Storing(run) | State::Restoring(run, _) = &mut self.state
            && run.follow(now_s, &row, &mut self.counts)
        {
            self.restore(Setup::default());
            self.ask(now_s);
        }
        if let Some(run) = self.state.run_mut() {
            run.saw_row(now_s);
        }
        let stores = matches!(&self.state, State::Storing(run) if !run.is_paused());
        self.live.push(now_s, &row, stores);
        match &mut self.state {
            State::Starting(_) | State::Over(_) => self.counts.after_end += 1,
            State::Storing(run) | State::Restoring(run, _) if run.is_paused() => {
                self.counts.paused += 1;
            }
            State::Restoring(run, _) => {
                self.counts.other_settings += 1;
                run.row_in_gap();
            }
            State::Storing(run) => {
                let gap = run.close_gap(now_s);
                let comments = std::mem::take(&mut run.comments);
                let resumed = std::mem::take(&mut run.resumed);
                let time_s = run.store_row(now_s);
                let line = match self.wire.shape() {
                    Some(shape) => shape.with_host_time(bytes, time_s),
                    None => bytes,
                };
                self.close_gap(gap);
                self.queue.push_comment(comments);
                if resumed {
                    // Three blank rows.
                    self.queue.push_mark(b"\n\n\n".to_vec());
                }
                self.queue.push_row(line);
                let rows = self.counts.stored + self.queue.rows();
                if self.options.rows.is_some_and(|wanted| rows >= wanted) {
                    self.complete(End::Rows);
                }
            }
        }
    }

    fn comment(&mut self, now_s: f64, bytes: &[u8]) {
        self.counts.comments += 1;
        let text = String::from_utf8_lossy(bytes).into_owned();
        let settings = Settings::parse(&text);
        match &mut self.state {
            State::Starting(start) => start.add_message(&text, settings),
            State::Storing(run) | State::Restoring(run, _) | State::Over(run) => {
                run.comments.extend_from_slice(text.as_bytes());
                run.comments.push(b'\n');
            }
        }
        self.report(Event::Board { text });
        if let Some(settings) = settings {
            self.settings_are(now_s, settings);
        }
    }

    fn header(&mut self, now_s: f64, bytes: Vec<u8>, whole: bool) {
        let columns = match &self.state {
            State::Starting(start) => start.columns.as_ref(),
            begun => begun.run().and_then(|run| run.header.as_ref()),
        };
        let known = columns == Some(&bytes);
        let starting = matches!(self.state, State::Starting(_));
        let starts_up = starting && self.wire.heard_its_start();
        if !whole && !known && !starts_up && !begins_with_time(&bytes) {
            return self.reject(bytes, Reason::Half);
        }
        let certain = known || is_certain(&bytes);
        match &mut self.state {
            State::Starting(start) if certain => {
                start.columns = Some(bytes);
                self.start_if_ready(now_s);
            }
            // A header, if rows of its form follow.
            State::Starting(start) => {
                if let Some(before) = start.possible_header.replace(bytes) {
                    self.reject(before, Reason::FieldCount);
                }
            }
            State::Storing(_) if known => {}
            _ if !certain => self.reject(bytes, Reason::FieldCount),
            State::Storing(run)
                if run.header.is_none()
                    && self.wire.shape().is_some_and(|shape| shape.fits(&bytes)) =>
            {
                // Its columns were recognised by their numbers.
                run.header = Some(bytes.clone());
                let text = String::from_utf8_lossy(&bytes);
                let line = format!("# the board names its columns {text}\n");
                run.comments.extend_from_slice(line.as_bytes());
            }
            State::Storing(run) if run.settings.is_some() && !run.sent_settings => {
                run.open_gap(now_s, Cause::Settings);
                self.restore(Setup::after_header(bytes));
                self.ask(now_s);
            }
            State::Storing(_) => self.fail(columns_changed(&bytes)),
            // While it is being set, its headers do not matter.
            State::Restoring(..) | State::Over(_) => {}
        }
    }

    pub(super) fn reject(&mut self, bytes: Vec<u8>, reason: Reason) {
        self.counts.rejected += 1;
        if let State::Storing(run) | State::Restoring(run, _) | State::Over(run) = &mut self.state {
            run.rejected_since_row += 1;
        }
        if let State::Storing(run) = &self.state
            && !run.has_arrived_rows
            && run.rejected_since_row >= MOST_REJECTS_BEFORE_ROWS
        {
            let error = rows_differ(run.header.as_deref().unwrap_or_default(), &bytes);
            self.fail(error);
        }
        if self.counts.rejected <= REPORTED_REJECTS {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            self.report(Event::Rejected { reason, text });
        }
        self.counts.rejected_unstored += u64::from(!self.queue.push_rejected(&bytes));
    }
}

/// Whether the first name is that of a stamp, and not the end of one: `stamp (ms)` is
/// the end of `Timestamp (ms)`.
fn begins_with_time(header: &[u8]) -> bool {
    let ends = |b: &u8| !b.is_ascii_alphanumeric();
    let word = header.split(ends).next();
    [&b"timestamp"[..], b"time", b"t", b"millis", b"micros"]
        .iter()
        .any(|name| word.is_some_and(|word| word.eq_ignore_ascii_case(name)))
}

fn rows_differ(header: &[u8], line: &[u8]) -> Error {
    let header = String::from_utf8_lossy(header);
    let line: String = String::from_utf8_lossy(line).chars().take(60).collect();
    Error::device(
        "rows-differ",
        format!("no line of the board has the columns of its header, {header}; the last: {line:?}"),
    )
    .with_hint("have the sketch print one name for each number in its header, or no header")
}

pub(super) fn columns_changed(columns: &[u8]) -> Error {
    let columns = String::from_utf8_lossy(columns);
    Error::device(
        "columns-changed",
        format!("the board sends other columns now: {columns}"),
    )
    .with_hint("the rows up to here are in the file; record the rest into another one")
}
