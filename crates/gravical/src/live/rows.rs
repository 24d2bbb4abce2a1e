//! The rows that a session keeps: those of its poses and of the motions between them.

use std::collections::VecDeque;
use std::ops::Range;

use crate::Result;
use crate::recording::collect::Columns;

use crate::recording::growing::{Sample, keep};

/// Motions longer than this are not kept, s.
pub(super) const LONGEST_S: f64 = 60.0;
/// With more rows than these no motions are kept any more, only poses.
pub(super) const MOST_ROWS: usize = 300_000;

/// Rows of the session.
#[derive(Default)]
pub(super) struct SessionRows {
    /// The last rows, which no pose has taken yet.
    recent: VecDeque<Sample>,
    kept: Option<Columns>,
    /// The row after the last one that was kept.
    kept_end: usize,
}

impl SessionRows {
    /// Adds a row.
    pub fn push(&mut self, sample: Sample) {
        self.recent.push_back(sample);
        let old = |s: &Sample| sample.t_s - s.t_s > LONGEST_S;
        while self.recent.front().is_some_and(old) {
            self.recent.pop_front();
        }
    }

    /// The recent rows.
    pub fn recent(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.recent.iter()
    }

    /// The recent rows among `rows`.
    pub fn within(&self, rows: &Range<usize>) -> Vec<Sample> {
        let (from, to) = (rows.start, rows.end);
        let all = self.recent.iter().filter(|s| s.row >= from && s.row < to);
        all.copied().collect()
    }

    /// Keeps the rows up to the end of a pose, and returns where its rows are in
    /// [`kept`](Self::kept).
    ///
    /// # Errors
    ///
    /// `no-memory` if there is not enough.
    pub fn keep(
        &mut self,
        pose: &Range<usize>,
        empty: impl FnOnce() -> Columns,
    ) -> Result<Range<usize>> {
        let columns = self.kept.get_or_insert_with(empty);
        if columns.rows() > MOST_ROWS {
            self.recent.retain(|s| s.row >= pose.start);
        }
        let mut start = None;
        while let Some(sample) = self.recent.front().filter(|s| s.row < pose.end) {
            if sample.row >= pose.start {
                start.get_or_insert(columns.rows());
            }
            let cut = sample.row > 0 && sample.row != self.kept_end;
            keep(columns, sample, sample.is_break || cut)?;
            self.kept_end = sample.row + 1;
            self.recent.pop_front();
        }
        let end = columns.rows();
        Ok(start.unwrap_or(end)..end)
    }

    /// All rows that were kept.
    pub fn kept_mut(&mut self) -> Option<&mut Columns> {
        self.kept.as_mut()
    }
}
