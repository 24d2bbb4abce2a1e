//! The board's clock, and the gaps that it shows.

use super::{FEWEST_MISSING, Recorder, SILENT_END_S, SILENT_END_STEPS};
use crate::device::event::{End, Event};
use crate::device::frames::{Sequence, lost_frames};
use crate::device::gap::{Cause, Gap};
use crate::device::line::Row;
use crate::device::stamps::Step;

impl Recorder {
    /// What the stamp of a row says about those before it.
    pub(super) fn follow(&mut self, now_s: f64, row: &Row) {
        let rejected = std::mem::take(&mut self.rejected_since_row);
        let spoke = std::mem::take(&mut self.spoke);
        let step = self.stamps.see(row.stamp);
        let jump = match step {
            Step::Missing(jump) => jump,
            Step::Follows => 0,
            Step::Anew => {
                self.sequence = Sequence::default();
                self.sequence.see(row.sequence);
                self.reset(now_s);
                if row.sequence.is_some() {
                    self.account.fragments += rejected;
                }
                let known = row.sequence.is_some() || self.start.expected.is_some();
                if !spoke {
                    self.stamps.steps_are(None);
                }
                if known && !spoke && self.ended.is_none() {
                    self.ask_again(now_s);
                }
                return;
            }
        };
        let lost = (self.sequence.see(row.sequence)).map(|lost| lost_frames(lost, jump));
        // Rejected lines are no rows, but they were.
        let (missing, from_sequence) = match lost {
            None => (jump.saturating_sub(rejected), 0),
            Some(lost) => {
                let hurt = rejected.min(lost);
                self.account.fragments += rejected - hurt;
                (lost.max(jump) - hurt, lost - hurt)
            }
        };
        let missing = if self.ended.is_none() {
            self.wanted(now_s, missing)
        } else {
            0
        };
        if self.gap.is_some() || missing >= FEWEST_MISSING {
            let cause = match lost {
                _ if spoke => Cause::Sensor,
                Some(_) if from_sequence < FEWEST_MISSING => Cause::NotSampled,
                _ => Cause::Lost,
            };
            self.account.missing += missing;
            self.account.lost += from_sequence.saturating_sub(missing);
            if missing > 0 {
                self.open_gap(now_s, cause).rows += missing;
            }
        } else {
            self.account.lost += from_sequence;
        }
    }

    /// While it is paused nobody wants rows: of those that are missing since the last
    /// one, the share of the time that was no pause.
    fn wanted(&self, now_s: f64, missing: u64) -> u64 {
        let all_s = now_s - self.last_row_s;
        let wanted_s = self.elapsed_s(now_s) - self.last_row_elapsed_s;
        let paused_s = all_s - wanted_s;
        if paused_s <= 1e-6 {
            return missing;
        }
        (missing as f64 * (wanted_s / all_s).clamp(0.0, 1.0)).round() as u64
    }

    /// The board started anew, and its clock with it.
    pub(super) fn reset(&mut self, now_s: f64) {
        let gap = self.open_gap(now_s, Cause::Reset);
        gap.clock_anew = true;
        if gap.cause == Cause::Settings {
            // That is why it had others.
            gap.cause = Cause::Reset;
        }
    }

    /// Rows are missing from the last one on, or from earlier.
    pub(super) fn open_gap(&mut self, now_s: f64, cause: Cause) -> &mut Gap {
        let since_s = if self.account.stored + self.keep.rows() == 0 {
            now_s
        } else {
            self.last_row_s
        };
        let gap = Gap {
            cause,
            rows: 0,
            clock_anew: false,
            until_end: false,
            duration_s: 0.0,
        };
        if self.gap.is_none() {
            self.gap_in_pause = self.is_paused();
        }
        &mut self.gap.get_or_insert((since_s, gap)).1
    }

    /// At the end of the recording: no row comes after a gap that is open, or no row came
    /// for long. In a pause nobody wants one.
    pub(super) fn gap_until_the_end(&mut self, now_s: f64) {
        let in_pause = self.is_paused() && self.gap_in_pause;
        if in_pause || self.ended == Some(End::Rows) {
            self.gap = None;
        }
        let step_s = self.live.step_s().unwrap_or(self.row_step_s);
        let silent_s = self.elapsed_s(now_s) - self.last_row_elapsed_s;
        let silent = silent_s > SILENT_END_S.max(SILENT_END_STEPS * step_s)
            && self.ended != Some(End::Rows)
            && !self.failed;
        if silent && self.gap.is_none() {
            let since_s = self.last_row_s;
            self.open_gap(now_s, Cause::Silent);
            if let Some((since, _)) = &mut self.gap {
                *since = since_s;
            }
        }
        if let Some((_, gap)) = &mut self.gap {
            gap.until_end = true;
            self.ended_in_gap = silent || gap.cause != Cause::Continued;
        }
    }

    pub(super) fn close_gap(&mut self, now_s: f64) {
        if let Some((since_s, mut gap)) = self.gap.take() {
            if self.gap_in_pause && gap.rows == 0 && !gap.clock_anew && !gap.until_end {
                return;
            }
            gap.duration_s = now_s - since_s;
            self.keep.mark(gap.line().into_bytes());
            self.account.gaps += 1;
            self.account.incomplete += u64::from(gap.is_incomplete());
            self.tell(Event::Gap(gap));
        }
    }
}
