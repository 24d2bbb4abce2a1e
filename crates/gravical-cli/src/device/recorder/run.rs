//! A recording that has begun: its time, the board's clock, and the gap that is open.

use crate::device::board::{Settings, Wanted};
use crate::device::gap::{Cause, Gap};
use crate::device::item::Row;
use crate::device::row_counts::RowCounts;
use crate::device::stamps::Stamps;

/// Fewer rows than this are not a gap of their own: the reader counts them as missing.
const FEWEST_MISSING: u64 = 4;
/// Without a row for this time, and this many usual steps, the end is a gap, s.
const SILENT_END_S: f64 = 1.0;
const SILENT_END_STEPS: f64 = 4.5;

/// Rows are missing from `since_s` on.
#[derive(Debug)]
struct OpenGap {
    since_s: f64,
    /// It began in a pause.
    in_pause: bool,
    gap: Gap,
}

/// A recording that has begun.
#[derive(Debug)]
pub struct Run {
    /// The header of the board; none where it sent none.
    pub header: Option<Vec<u8>>,
    /// Arrival of the first row in the file, s.
    first_row_s: Option<f64>,
    /// Settings of the board at the beginning.
    pub settings: Option<Settings>,
    started_s: f64,
    paused_from_s: Option<f64>,
    paused_s: f64,
    /// A pause ended since the last row.
    pub resumed: bool,
    stamps: Stamps,
    gap: Option<OpenGap>,
    /// Messages of the board that wait for the gap before them.
    pub comments: Vec<u8>,
    /// The board reported its settings since the last row.
    pub sent_settings: bool,
    pub rejected_since_row: u64,
    /// The last row by the computer's clock, by the time of the recording, and the step to
    /// it, s.
    last_row_s: f64,
    last_row_elapsed_s: f64,
    row_step_s: f64,
    /// A row has arrived, stored or not.
    pub has_arrived_rows: bool,
    pub last_status_s: f64,
    /// The silence of the board was reported.
    pub silent: bool,
    /// Rows are missing right before the end.
    pub ended_in_gap: bool,
}

impl Run {
    pub fn new(now_s: f64, header: Option<Vec<u8>>, settings: Option<Settings>) -> Self {
        let mut run = Run {
            header,
            first_row_s: None,
            settings,
            started_s: now_s,
            paused_from_s: None,
            paused_s: 0.0,
            resumed: false,
            stamps: Stamps::default(),
            gap: None,
            comments: Vec::new(),
            sent_settings: false,
            rejected_since_row: 0,
            last_row_s: now_s,
            last_row_elapsed_s: 0.0,
            row_step_s: 0.0,
            has_arrived_rows: false,
            last_status_s: now_s,
            silent: false,
            ended_in_gap: false,
        };
        if let Some(settings) = &settings {
            run.is_set(settings);
        }
        run
    }

    /// The settings that have to be restored after a reset.
    pub fn goal(&self) -> Wanted {
        self.settings
            .as_ref()
            .map(Wanted::exactly)
            .unwrap_or_default()
    }

    /// The board reported its settings.
    pub fn is_set(&mut self, settings: &Settings) {
        self.stamps.steps_are(Some(1e3 / settings.rate_hz));
    }

    /// A row goes into the file; returns the time since the first one, s.
    pub fn store_row(&mut self, now_s: f64) -> f64 {
        now_s - *self.first_row_s.get_or_insert(now_s)
    }

    fn has_rows(&self) -> bool {
        self.first_row_s.is_some()
    }

    /// Seconds since the first row, or since the beginning where there is none, without
    /// pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        let paused_s = self.paused_s + self.paused_from_s.map_or(0.0, |from_s| now_s - from_s);
        (now_s - self.started_s - paused_s).max(0.0)
    }

    pub fn is_paused(&self) -> bool {
        self.paused_from_s.is_some()
    }

    pub fn toggle_pause(&mut self, now_s: f64) {
        match self.paused_from_s.take() {
            Some(from_s) => {
                self.paused_s += now_s - from_s;
                self.resumed = self.has_rows();
            }
            None => self.paused_from_s = Some(now_s),
        }
    }

    /// A row arrived, stored or not. The time of the recording begins with the first one
    /// outside of a pause: a board may wait between header and rows.
    pub fn saw_row(&mut self, now_s: f64) {
        self.has_arrived_rows = true;
        if !self.has_rows() && !self.is_paused() {
            (self.started_s, self.paused_s) = (now_s, 0.0);
        }
        self.row_step_s = now_s - self.last_row_s;
        self.last_row_s = now_s;
        self.last_row_elapsed_s = self.elapsed_s(now_s);
    }

    /// Counts the rows that are missing before this one, by its stamp.
    /// Returns true where the board's clock restarted, so that the board has to be asked
    /// for its settings.
    pub fn follow(&mut self, now_s: f64, row: &Row, counts: &mut RowCounts) -> bool {
        let rejected = std::mem::take(&mut self.rejected_since_row);
        let sent_settings = std::mem::take(&mut self.sent_settings);
        let Some(jump) = self.stamps.next(row.stamp) else {
            self.clock_restarted(now_s);
            if !sent_settings {
                self.stamps.steps_are(None);
            }
            return !sent_settings && self.settings.is_some();
        };
        // Rejected lines were rows.
        let missing = self.outside_pauses(now_s, jump.saturating_sub(rejected));
        if self.gap.is_some() || missing >= FEWEST_MISSING {
            let cause = match sent_settings {
                true => Cause::Sensor,
                false => Cause::Lost,
            };
            counts.missing += missing;
            if missing > 0 {
                self.open_gap(now_s, cause).rows += missing;
            }
        }
        false
    }

    /// Of the rows that are missing since the last one, the share of the time that was not
    /// a pause.
    fn outside_pauses(&self, now_s: f64, missing: u64) -> u64 {
        let all_s = now_s - self.last_row_s;
        let wanted_s = self.elapsed_s(now_s) - self.last_row_elapsed_s;
        if all_s - wanted_s <= 1e-6 {
            return missing;
        }
        (missing as f64 * (wanted_s / all_s).clamp(0.0, 1.0)).round() as u64
    }

    /// The board restarted, and its clock with it.
    fn clock_restarted(&mut self, now_s: f64) {
        let gap = self.open_gap(now_s, Cause::Reset);
        gap.clock_anew = true;
        if gap.cause == Cause::Settings {
            // The reset changed the settings.
            gap.cause = Cause::Reset;
        }
    }

    /// Rows are missing from the last one on, or from earlier.
    pub fn open_gap(&mut self, now_s: f64, cause: Cause) -> &mut Gap {
        let since_s = if self.has_rows() {
            self.last_row_s
        } else {
            now_s
        };
        let in_pause = self.is_paused();
        let gap = Gap::new(cause);
        let opened = self.gap.get_or_insert(OpenGap {
            since_s,
            in_pause,
            gap,
        });
        &mut opened.gap
    }

    /// A row that is not stored is counted in the gap that is open, if any.
    pub fn row_in_gap(&mut self) {
        if let Some(open) = &mut self.gap {
            open.gap.rows += 1;
        }
    }

    pub fn is_in_gap(&self) -> bool {
        self.gap.is_some()
    }

    /// The gap that was open; none for a gap within a pause.
    pub fn close_gap(&mut self, now_s: f64) -> Option<Gap> {
        let OpenGap {
            since_s,
            in_pause,
            mut gap,
        } = self.gap.take()?;
        gap.duration_s = now_s - since_s;
        (!in_pause || gap.rows > 0 || gap.clock_anew || gap.until_end).then_some(gap)
    }

    /// The gap at the end: one that is open, or a silence. A gap within a pause does not
    /// count. `step_s`: between two rows, where it is known.
    pub fn last_gap(&mut self, now_s: f64, step_s: Option<f64>) -> Option<Gap> {
        if self.is_paused() && self.gap.as_ref().is_some_and(|open| open.in_pause) {
            self.gap = None;
        }
        let step_s = step_s.unwrap_or(self.row_step_s);
        let silent_s = self.elapsed_s(now_s) - self.last_row_elapsed_s;
        let silent = silent_s > SILENT_END_S.max(SILENT_END_STEPS * step_s);
        if silent && self.gap.is_none() {
            self.gap = Some(OpenGap {
                since_s: self.last_row_s,
                in_pause: false,
                gap: Gap::new(Cause::Silent),
            });
        }
        let open = self.gap.as_mut()?;
        open.gap.until_end = true;
        self.ended_in_gap = silent || open.gap.cause != Cause::Continued;
        self.close_gap(now_s)
    }
}
