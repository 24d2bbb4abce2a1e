//! How a recording begins and fails.

use gravical::Error;

use super::run::Run;
use super::start::Held;
use super::{Recorder, State};
use crate::device::event::{End, Event};
use crate::device::gap::Cause;
use crate::device::item::Reason;
use crate::device::live::Live;
use crate::device::shape::{LEAST_ROWS, RowShape};

/// A board that has sent no header for this time sends none, s.
const NO_HEADER_S: f64 = 6.0;
/// Without a row for this time something is wrong, s.
const NO_ROWS_S: f64 = 8.0;

impl Recorder {
    pub(super) fn start_if_ready(&mut self, now_s: f64) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let wanted = self.options.wanted;
        let set = wanted.is_empty()
            || (start.settings()).is_some_and(|settings| wanted.is_met_by(settings));
        let Some(header) = start.columns.clone().filter(|_| set) else {
            return;
        };
        // Rows before the header are of another clock, or of other settings.
        self.counts.before_start += start.drop_held();
        match RowShape::of_header(&header, self.options.columns.as_ref()) {
            Ok(Some(shape)) => self.begin(now_s, Some(header), shape),
            Ok(None) => {}
            Err(error) => self.fail(error),
        }
    }

    /// The board names no columns: the recording begins without a header, once there are
    /// rows, or fails.
    pub(super) fn start_without_header(&mut self, now_s: f64) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let waited_s = now_s - start.opened_s;
        let rowless_s = now_s - start.last_row_s;
        if waited_s >= NO_HEADER_S && start.held.len() >= LEAST_ROWS {
            let header = start.possible_header.as_deref();
            let lines = start.held.iter().map(|held| &held.bytes[..]);
            match RowShape::of_rows(lines, header, self.options.columns.as_ref()) {
                Ok(Some(shape)) => return self.begin_with_held(now_s, shape),
                Ok(None) => {}
                Err(error) => return self.fail(error),
            }
        }
        if let State::Starting(start) = &self.state
            && rowless_s >= NO_ROWS_S
            && !self.options.wait
        {
            // A slow board needs longer than others until its rows are known.
            let error = start.no_rows(self.wire.invalid());
            self.fail(error);
        }
    }

    /// Begins with the rows that were held.
    fn begin_with_held(&mut self, now_s: f64, shape: RowShape) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let mut header = None;
        if let Some(possible) = start.possible_header.take() {
            match shape.fits(&possible) {
                true => header = Some(possible),
                false => self.reject(possible, Reason::FieldCount),
            }
        }
        let State::Starting(start) = &mut self.state else {
            return;
        };
        let held = std::mem::take(&mut start.held);
        // The rows are followed again, now with their columns.
        self.live = Live::default();
        let first_s = held.first().map_or(now_s, |held| held.at_s);
        self.begin(first_s, header, shape.clone());
        for Held { at_s, bytes } in held {
            match shape.row(&bytes) {
                Ok((bytes, row)) => self.row(at_s, bytes, row),
                Err(reason) => {
                    self.counts.received -= 1;
                    self.reject(bytes, reason);
                }
            }
        }
    }

    /// Writes the head of the file; from here on rows are stored.
    fn begin(&mut self, now_s: f64, header: Option<Vec<u8>>, shape: RowShape) {
        let State::Starting(start) = &mut self.state else {
            return;
        };
        if let Some(possible) = start.possible_header.take() {
            self.reject(possible, Reason::FieldCount);
        }
        let columns = shape.columns().to_vec();
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
            return self.fail(
                error.with_hint("record into another file, or set the board as it was: --format"),
            );
        }
        let State::Starting(start) = &self.state else {
            return;
        };
        let mut head = String::new();
        for line in &self.options.preamble {
            head.push_str(&format!("# {line}\n"));
        }
        for line in start.messages().chain(shape.notes()) {
            head.push_str(&format!("{line}\n"));
        }
        let settings = start.settings().copied();
        let mut run = Run::new(now_s, header, settings);
        self.wire.record(shape);
        if self.options.continues.is_some() {
            run.open_gap(now_s, Cause::Continued);
            run.comments = head.into_bytes();
            run.resumed = true;
        } else {
            if let Some(settings) = &run.settings {
                head.push_str(&format!("# rate: {:.2} Hz\n", settings.rate_hz));
            }
            self.queue.push_mark(head.into_bytes());
            self.queue.push_mark([&columns[..], b"\n"].concat());
        }
        self.state = State::Storing(run);
        self.report(Event::Started { columns: named });
    }

    /// All that was asked for is there.
    pub(super) fn complete(&mut self, why: End) {
        if !matches!(self.state, State::Over(_)) {
            self.ended = Some(why);
            self.state.change(State::Over);
        }
    }

    /// The recording cannot continue.
    pub(super) fn fail(&mut self, error: Error) {
        self.fatal.get_or_insert(error);
        self.state.change(State::Over);
    }
}
