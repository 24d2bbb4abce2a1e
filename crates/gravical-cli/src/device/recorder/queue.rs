//! Lines that wait for the disk. A full disk is asked again and again; meanwhile the last
//! rows are held, older ones are counted.

use std::collections::VecDeque;

use crate::device::gap::{Cause, Gap};

/// Rows that are held while the disk takes none: half a minute at 100 Hz.
pub const MOST_ROWS: u64 = 3000;
/// Messages of the board, likewise.
const MOST_COMMENTS: usize = 500;
/// Bytes of rejected lines, likewise.
const MOST_REJECTED_BYTES: usize = 1 << 16;

#[derive(Debug, Clone)]
enum Item {
    /// Whole lines between the rows.
    Lines(Vec<u8>),
    Row(Vec<u8>),
}

/// Lines that wait for the disk.
#[derive(Debug, Clone, Default)]
pub struct Queue {
    items: VecDeque<Item>,
    rows: u64,
    comments: usize,
    /// Time from which the disk fails, s, and the gap of rows that are dropped.
    failing: Option<(f64, Gap)>,
    dropped: u64,
    rejects: Vec<u8>,
}

impl Queue {
    /// Rows that wait.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Rows that were dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Adds a header, a gap or a pause: these are never dropped.
    pub fn push_mark(&mut self, bytes: Vec<u8>) {
        self.items.push_back(Item::Lines(bytes));
    }

    /// Adds a message of the board, or drops it if there are too many.
    pub fn push_comment(&mut self, bytes: Vec<u8>) {
        if !bytes.is_empty() && self.comments < MOST_COMMENTS {
            self.comments += 1;
            self.push_mark(bytes);
        }
    }

    /// Adds a row.
    pub fn push_row(&mut self, bytes: Vec<u8>) {
        self.rows += 1;
        self.items.push_back(Item::Row(bytes));
    }

    /// Adds a rejected line; false where there is no room for it.
    pub fn push_rejected(&mut self, bytes: &[u8]) -> bool {
        let room = self.rejects.len() < MOST_REJECTED_BYTES;
        if room {
            self.rejects.extend_from_slice(bytes);
            self.rejects.push(b'\n');
        }
        room
    }

    /// Half of the room for rejected lines is used.
    pub fn is_crowded(&self) -> bool {
        self.rejects.len() >= MOST_REJECTED_BYTES / 2
    }

    /// All lines that wait, for one write.
    pub fn batch(&self) -> Option<Vec<u8>> {
        if self.items.is_empty() {
            return None;
        }
        let mut bytes = Vec::new();
        // Dropped rows are missing before the first one that is left.
        let failing = self.failing.as_ref().map(|(_, gap)| gap);
        let mut dropped = failing.filter(|gap| gap.rows > 0);
        for item in &self.items {
            match item {
                Item::Lines(lines) => bytes.extend_from_slice(lines),
                Item::Row(row) => {
                    if let Some(gap) = dropped.take() {
                        bytes.extend_from_slice(gap.line().as_bytes());
                    }
                    bytes.extend_from_slice(row);
                    bytes.push(b'\n');
                }
            }
        }
        if let Some(gap) = dropped {
            bytes.extend_from_slice(gap.line().as_bytes());
        }
        Some(bytes)
    }

    /// The batch was written: the number of its rows, and the gap before them.
    pub fn written(&mut self) -> (u64, Option<Gap>) {
        self.items.clear();
        self.comments = 0;
        let gap = self.failing.take().map(|(_, gap)| gap);
        (std::mem::take(&mut self.rows), gap)
    }

    /// The batch was not written: drops rows beyond the limit. True for the first of
    /// successive failures.
    pub fn failed(&mut self, now_s: f64) -> bool {
        let first = self.failing.is_none();
        let begins = (now_s, Gap::new(Cause::DiskFull));
        let (since_s, gap) = self.failing.get_or_insert(begins);
        gap.duration_s = now_s - *since_s;
        self.drop_rows_over(MOST_ROWS);
        first
    }

    /// Drops everything; returns the number of rejected lines that are lost.
    pub fn give_up(&mut self) -> u64 {
        self.drop_rows_over(0);
        let lines = self.rejects.iter().filter(|b| **b == b'\n').count();
        self.rejects.clear();
        lines as u64
    }

    fn drop_rows_over(&mut self, most: u64) {
        let mut surplus = self.rows.saturating_sub(most);
        let dropped = surplus;
        self.rows -= surplus;
        self.dropped += surplus;
        self.items.retain(|item| {
            let drop = matches!(item, Item::Row(_)) && surplus > 0;
            surplus -= u64::from(drop);
            !drop
        });
        if let Some((_, gap)) = &mut self.failing {
            gap.rows += dropped;
        }
    }

    /// Rejected lines that wait, for one write.
    pub fn rejects(&self) -> Option<Vec<u8>> {
        (!self.rejects.is_empty()).then(|| self.rejects.clone())
    }

    /// Rejected lines were written.
    pub fn rejects_written(&mut self) {
        self.rejects.clear();
    }
}
