//! From the recorder to the disk.

use super::{Batch, Recorder};
use crate::device::event::Event;

impl Recorder {
    /// What is to be written next, if anything. Answer with [`stored`](Self::stored) or
    /// [`failed`](Self::failed).
    pub fn batch(&mut self) -> Option<Batch> {
        if self.gap.is_none() {
            self.keep.comment(std::mem::take(&mut self.comments));
        }
        self.keep.batch()
    }

    /// Rejected lines to be written next; answer as to [`batch`](Self::batch).
    pub fn rejects(&mut self) -> Option<Batch> {
        self.keep.rejects()
    }

    /// The batch is handed to the system.
    pub fn stored(&mut self) {
        let (rows, gap) = self.keep.stored();
        self.account.stored += rows;
        if let Some(gap) = gap {
            self.account.gaps += u64::from(gap.rows > 0);
            self.account.incomplete += u64::from(gap.is_incomplete());
            if gap.rows > 0 {
                self.tell(Event::Gap(gap));
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

    /// Rejected lines are handed to the system, or it did not take them.
    pub fn rejects_done(&mut self, stored: bool) {
        self.account.rejected_unstored += self.keep.rejects_done(stored);
    }

    /// The disk takes nothing any more, and there is no more time: what waits is lost.
    pub fn give_up(&mut self) {
        self.account.rejected_unstored += self.keep.give_up();
        self.account.unstored = self.keep.dropped();
    }
}
