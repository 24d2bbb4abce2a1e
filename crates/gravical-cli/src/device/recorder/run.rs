//! A recording that has begun: its time, the board's clock, and the gap that is open.

use crate::device::account::Account;
use crate::device::board::{Settings, Wanted};
use crate::device::gap::{Cause, Gap};
use crate::device::item::Row;
use crate::device::stamps::{Stamps, Step};
use crate::device::wire::Coding;

/// Rows fewer than this are no gap of their own: the reader counts them as lost.
const FEWEST_MISSING: u64 = 4;
/// Without a row for so long, and so many of its steps, at the end: a gap, s.
const SILENT_END_S: f64 = 1.0;
const SILENT_END_STEPS: f64 = 4.5;

/// Rows are missing from `since_s` on.
#[derive(Debug)]
struct OpenGap {
    since_s: f64,
    /// It was paused when it began.
    in_pause: bool,
    gap: Gap,
}

/// A recording that has begun.
#[derive(Debug)]
pub struct Run {
    /// The header.
    pub columns: Vec<u8>,
    /// How the board was set when it began, and how it spoke.
    pub settings: Option<Settings>,
    pub coding: Coding,
    started_s: f64,
    paused_from_s: Option<f64>,
    paused_s: f64,
    /// A pause ended since the last row.
    pub resumed: bool,
    stamps: Stamps,
    gap: Option<OpenGap>,
    /// Lines of the board that wait for the gap before them.
    pub comments: Vec<u8>,
    /// The board said its settings since the last row.
    pub spoke: bool,
    pub rejected_since_row: u64,
    /// The last row, by the computer's clock, by the time of the recording, and from the
    /// row before to it, s.
    last_row_s: f64,
    last_row_elapsed_s: f64,
    row_step_s: f64,
    /// A row was stored, or waits for the disk.
    pub has_rows: bool,
    pub last_status_s: f64,
    /// It was said that nothing comes.
    pub silent: bool,
    /// Rows are missing right before the end.
    pub ended_in_gap: bool,
}

impl Run {
    pub fn new(now_s: f64, columns: Vec<u8>, settings: Option<Settings>, coding: Coding) -> Self {
        let mut run = Run {
            columns,
            settings,
            coding,
            started_s: now_s,
            paused_from_s: None,
            paused_s: 0.0,
            resumed: false,
            stamps: Stamps::default(),
            gap: None,
            comments: Vec::new(),
            spoke: false,
            rejected_since_row: 0,
            last_row_s: now_s,
            last_row_elapsed_s: 0.0,
            row_step_s: 0.0,
            has_rows: false,
            last_status_s: now_s,
            silent: false,
            ended_in_gap: false,
        };
        if let Some(settings) = &settings {
            run.is_set(settings, coding);
        }
        run
    }

    /// What has to come back after a reset.
    pub fn goal(&self) -> Wanted {
        self.settings
            .as_ref()
            .map(Wanted::exactly)
            .unwrap_or_default()
    }

    /// The board says how it is set now.
    pub fn is_set(&mut self, settings: &Settings, coding: Coding) {
        let second = match coding {
            Coding::Text => 1e3,
            Coding::Frames => 1e6,
        };
        self.stamps.steps_are(Some(second / settings.rate_hz));
    }

    /// Seconds since the first row, or since it began where none came; pauses left out.
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
                self.resumed = self.has_rows;
            }
            None => self.paused_from_s = Some(now_s),
        }
    }

    /// A row came, whatever becomes of it. With the first one that is wanted the time of
    /// the recording begins: between header and rows a board may do what it likes.
    pub fn saw_row(&mut self, now_s: f64) {
        if !self.has_rows && !self.is_paused() {
            (self.started_s, self.paused_s) = (now_s, 0.0);
        }
        self.row_step_s = now_s - self.last_row_s;
        self.last_row_s = now_s;
        self.last_row_elapsed_s = self.elapsed_s(now_s);
    }

    /// What the stamp and the number of a row say about those before it. True where the
    /// board's clock started anew, and it has to be asked whether it is set as before.
    pub fn follow(&mut self, now_s: f64, row: &Row, account: &mut Account) -> bool {
        let rejected = std::mem::take(&mut self.rejected_since_row);
        let spoke = std::mem::take(&mut self.spoke);
        let (jump, lost) = match self.stamps.see(row.stamp, row.sequence) {
            Step::On { jump, lost } => (jump, lost),
            Step::Anew => {
                self.clock_anew(now_s);
                if row.sequence.is_some() {
                    account.fragments += rejected;
                }
                if !spoke {
                    self.stamps.steps_are(None);
                }
                return !spoke && (row.sequence.is_some() || self.settings.is_some());
            }
        };
        // Rejected lines are no rows, but they were.
        let (missing, from_sequence) = match lost {
            None => (jump.saturating_sub(rejected), 0),
            Some(lost) => {
                let hurt = rejected.min(lost);
                account.fragments += rejected - hurt;
                (lost.max(jump) - hurt, lost - hurt)
            }
        };
        let missing = self.wanted(now_s, missing);
        if self.gap.is_some() || missing >= FEWEST_MISSING {
            let cause = match lost {
                _ if spoke => Cause::Sensor,
                Some(_) if from_sequence < FEWEST_MISSING => Cause::NotSampled,
                _ => Cause::Lost,
            };
            account.missing += missing;
            account.lost += from_sequence.saturating_sub(missing);
            if missing > 0 {
                self.open_gap(now_s, cause).rows += missing;
            }
        } else {
            account.lost += from_sequence;
        }
        false
    }

    /// While it is paused nobody wants rows: of those that are missing since the last
    /// one, the share of the time that was no pause.
    fn wanted(&self, now_s: f64, missing: u64) -> u64 {
        let all_s = now_s - self.last_row_s;
        let wanted_s = self.elapsed_s(now_s) - self.last_row_elapsed_s;
        if all_s - wanted_s <= 1e-6 {
            return missing;
        }
        (missing as f64 * (wanted_s / all_s).clamp(0.0, 1.0)).round() as u64
    }

    /// The board speaks otherwise than it did: it was reset, and nothing of its clock is
    /// known.
    pub fn board_anew(&mut self, now_s: f64) {
        self.clock_anew(now_s);
        self.stamps = Stamps::default();
    }

    /// The board started anew, and its clock with it.
    fn clock_anew(&mut self, now_s: f64) {
        let gap = self.open_gap(now_s, Cause::Reset);
        gap.clock_anew = true;
        if gap.cause == Cause::Settings {
            // That is why it had others.
            gap.cause = Cause::Reset;
        }
    }

    /// Rows are missing from the last one on, or from earlier.
    pub fn open_gap(&mut self, now_s: f64, cause: Cause) -> &mut Gap {
        let since_s = if self.has_rows {
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

    /// A row that came and is not stored belongs to the gap that is open, if one is.
    pub fn row_in_gap(&mut self) {
        if let Some(open) = &mut self.gap {
            open.gap.rows += 1;
        }
    }

    pub fn is_in_gap(&self) -> bool {
        self.gap.is_some()
    }

    /// The gap that was open; none for one of a pause, in which nobody wanted a row.
    pub fn close_gap(&mut self, now_s: f64) -> Option<Gap> {
        let OpenGap {
            since_s,
            in_pause,
            mut gap,
        } = self.gap.take()?;
        gap.duration_s = now_s - since_s;
        (!in_pause || gap.rows > 0 || gap.clock_anew || gap.until_end).then_some(gap)
    }

    /// The last gap: no row comes after one that is open, or no row came for long. In a
    /// pause nobody wants one. `step_s`: between two rows, where it is known.
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
