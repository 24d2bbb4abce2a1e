//! The board's clock, and the gaps that it shows.

use super::{FEWEST_MISSING, Recorder};
use crate::device::event::Event;
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
        // While it is paused nobody wants them.
        let wanted = !self.is_paused() && self.ended.is_none();
        if self.gap.is_some() || (wanted && missing >= FEWEST_MISSING) {
            let cause = match lost {
                _ if spoke => Cause::Sensor,
                Some(_) if from_sequence < FEWEST_MISSING => Cause::NotSampled,
                _ => Cause::Lost,
            };
            self.account.missing += missing;
            if missing > 0 {
                self.open_gap(now_s, cause).rows += missing;
            }
        } else {
            self.account.lost += from_sequence;
        }
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
        &mut self.gap.get_or_insert((since_s, gap)).1
    }

    pub(super) fn close_gap(&mut self, now_s: f64) {
        if let Some((since_s, mut gap)) = self.gap.take() {
            gap.duration_s = now_s - since_s;
            self.keep.mark(gap.line().into_bytes());
            self.account.gaps += 1;
            self.tell(Event::Gap(gap));
        }
    }
}
