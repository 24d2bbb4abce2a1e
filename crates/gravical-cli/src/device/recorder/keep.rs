//! What waits for the disk. A disk that is full is asked again and again; meanwhile the
//! last rows are kept, older ones are counted.

use std::collections::VecDeque;

use crate::device::gap::{Cause, Gap};

/// Rows that are kept while the disk takes none: half a minute at 100 Hz.
pub const KEPT_ROWS: u64 = 3000;
/// Lines of the board, kept likewise.
const KEPT_COMMENTS: usize = 500;
/// Bytes of rejected lines, kept likewise.
const KEPT_REJECTS: usize = 1 << 16;

#[derive(Debug, Clone)]
enum Item {
    /// Whole lines between the rows.
    Lines(Vec<u8>),
    Row(Vec<u8>),
}

/// What waits.
#[derive(Debug, Clone, Default)]
pub struct Keep {
    items: VecDeque<Item>,
    rows: u64,
    comments: usize,
    /// Since when the disk fails, s, and what was lost.
    failing: Option<(f64, Gap)>,
    last_failure_s: f64,
    dropped: u64,
    rejects: Vec<u8>,
    reject_lines: u64,
}

impl Keep {
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Rows that were dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// A header, a gap, a pause: what the file cannot do without.
    pub fn mark(&mut self, bytes: Vec<u8>) {
        self.items.push_back(Item::Lines(bytes));
    }

    /// What the board said; beyond what is kept it is dropped.
    pub fn comment(&mut self, bytes: Vec<u8>) {
        if !bytes.is_empty() && self.comments < KEPT_COMMENTS {
            self.comments += 1;
            self.mark(bytes);
        }
    }

    pub fn row(&mut self, bytes: Vec<u8>) {
        self.rows += 1;
        self.items.push_back(Item::Row(bytes));
    }

    /// Whether there is room for a rejected line.
    pub fn reject(&mut self, bytes: &[u8]) -> bool {
        let room = self.rejects.len() < KEPT_REJECTS;
        if room {
            self.rejects.extend_from_slice(bytes);
            self.rejects.push(b'\n');
            self.reject_lines += 1;
        }
        room
    }

    /// Half of the room for rejected lines is taken.
    pub fn is_crowded(&self) -> bool {
        self.rejects.len() >= KEPT_REJECTS / 2
    }

    pub fn batch(&self) -> Option<Vec<u8>> {
        if self.items.is_empty() {
            return None;
        }
        let mut bytes = Vec::new();
        // Rows that were dropped are missing before the first one that is left.
        let mut lost = self.lost().filter(|gap| gap.rows > 0);
        for item in &self.items {
            match item {
                Item::Lines(lines) => bytes.extend_from_slice(lines),
                Item::Row(row) => {
                    if let Some(gap) = lost.take() {
                        bytes.extend_from_slice(gap.line().as_bytes());
                    }
                    bytes.extend_from_slice(row);
                    bytes.push(b'\n');
                }
            }
        }
        if let Some(gap) = lost {
            bytes.extend_from_slice(gap.line().as_bytes());
        }
        Some(bytes)
    }

    /// The gap of the disk that fails.
    fn lost(&self) -> Option<Gap> {
        let (since_s, gap) = self.failing.as_ref()?;
        Some(Gap {
            duration_s: self.last_failure_s - since_s,
            ..gap.clone()
        })
    }

    /// The rows that are on their way now, and what was lost before them.
    pub fn stored(&mut self) -> (u64, Option<Gap>) {
        self.items.clear();
        self.comments = 0;
        let gap = self.lost();
        self.failing = None;
        (std::mem::take(&mut self.rows), gap)
    }

    /// Drops what is too much; true for the first failure of a row of them.
    pub fn failed(&mut self, now_s: f64) -> bool {
        self.last_failure_s = now_s;
        let first = self.failing.is_none();
        self.failing
            .get_or_insert((now_s, Gap::new(Cause::DiskFull)));
        self.drop_rows_over(KEPT_ROWS);
        first
    }

    /// Nothing is kept any more; the number of rejected lines that are lost by it.
    pub fn give_up(&mut self) -> u64 {
        self.drop_rows_over(0);
        self.rejects.clear();
        std::mem::take(&mut self.reject_lines)
    }

    fn drop_rows_over(&mut self, kept: u64) {
        let mut surplus = self.rows.saturating_sub(kept);
        let lost = surplus;
        self.rows -= surplus;
        self.dropped += surplus;
        self.items.retain(|item| {
            let drop = matches!(item, Item::Row(_)) && surplus > 0;
            surplus -= u64::from(drop);
            !drop
        });
        if let Some((_, gap)) = &mut self.failing {
            gap.rows += lost;
        }
    }

    pub fn rejects(&self) -> Option<Vec<u8>> {
        (!self.rejects.is_empty()).then(|| self.rejects.clone())
    }

    pub fn rejects_stored(&mut self) {
        self.rejects.clear();
        self.reject_lines = 0;
    }
}
