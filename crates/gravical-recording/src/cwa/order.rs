//! Blocks of samples in order: which of them are used, and where something is missing.

use super::block::{BLOCK_BYTES, Block, Defect, HEADER_BYTES};
use crate::finding::{Finding, FindingKind};
use crate::spans::LineSpans;
use crate::text::Reason;

/// What the stamps of successive blocks may deviate from the nominal rate before a piece is
/// missing between them: sensors are off by some percent, and a stamp belongs to a sample only
/// within a few samples.
const RATE_TOLERANCE: f64 = 0.1;
const STAMP_TOLERANCE_S: f64 = 0.1;

/// What comes next in a file.
#[derive(Debug)]
pub(super) enum Event {
    /// A block that is skipped, and why.
    Skipped(Reason, String),
    /// A block of samples.
    Block(Box<Placed>),
}

fn place(number: u64) -> String {
    let byte = HEADER_BYTES as u64 + (number - 1) * BLOCK_BYTES as u64;
    format!("block {number} at byte {byte}")
}

/// A block within its run.
#[derive(Debug)]
pub(super) struct Placed {
    pub block: Block,
    /// Samples of the run before it.
    pub first: i64,
    /// It does not continue the block before.
    pub is_after_gap: bool,
}

impl Placed {
    /// The sample of the run to which the stamp belongs.
    pub fn stamp_sample(&self) -> i64 {
        self.first + self.block.stamp_sample
    }
}

/// The last block that was used.
#[derive(Debug, Clone, Copy)]
struct Last {
    session: u32,
    sequence: u32,
    rate_hz: f64,
    stamp_s: f64,
    /// When the numbers of the blocks began, s, at the earliest.
    began_s: f64,
    /// The sample of the run to which its stamp belongs.
    stamp_sample: i64,
    /// Samples of the run up to its end.
    samples: i64,
}

/// The order of the blocks of a file.
#[derive(Debug, Default)]
pub(super) struct Order {
    last: Option<Last>,
    /// Blocks skipped since then.
    skipped: u64,
    /// Blocks that are missing, jumps of the stamps, and the first of either.
    missing: (u64, u64, Option<String>),
    sessions: u64,
    /// Lines after the gaps.
    pub breaks: LineSpans,
}

impl Order {
    /// A block of this number, from 1, that cannot be used, and why.
    pub fn skip(&mut self, number: u64, (reason, why): Defect) -> Event {
        // Repeated and late blocks take no number of those that are missing.
        let counts = matches!(reason, Reason::CorruptBlock | Reason::ErasedBlock);
        self.skipped += u64::from(counts);
        Event::Skipped(reason, format!("{}: {why}", place(number)))
    }

    /// Where a block of this number belongs.
    pub fn place(&mut self, number: u64, block: Block) -> Event {
        let mut first = 0;
        let mut is_after_gap = false;
        let mut began_s = block.earliest_s();
        match self.last {
            Some(last) if last.session == block.session => {
                // Numbers that begin anew: at a time of its own, also by a clock that was set back.
                let restarted = block.sequence < last.sequence
                    && (block.stamp_s > last.stamp_s || block.stamp_s < last.began_s);
                if !restarted {
                    began_s = last.began_s;
                }
                if block.sequence == last.sequence {
                    let why = (Reason::RepeatedBlock, "the one before again");
                    return self.skip(number, why);
                }
                if block.sequence < last.sequence && !restarted {
                    let why = (Reason::LateBlock, "earlier than the one before");
                    return self.skip(number, why);
                }
                if last.sequence.checked_add(1) == Some(block.sequence)
                    && last.continues_with(&block)
                {
                    first = last.samples;
                } else {
                    is_after_gap = true;
                    self.miss(last, &block, number);
                }
            }
            Some(_) => {
                is_after_gap = true;
                self.sessions += 1;
            }
            None => self.sessions = 1,
        }
        self.skipped = 0;
        self.last = Some(Last {
            session: block.session,
            sequence: block.sequence,
            rate_hz: block.rate_hz,
            stamp_s: block.stamp_s,
            began_s,
            stamp_sample: first + block.stamp_sample,
            samples: first + block.samples as i64,
        });
        Event::Block(Box::new(Placed {
            block,
            first,
            is_after_gap,
        }))
    }

    fn miss(&mut self, last: Last, block: &Block, number: u64) {
        let between = block
            .sequence
            .saturating_sub(last.sequence.saturating_add(1));
        let missing = u64::from(between).saturating_sub(self.skipped);
        let (blocks, jumps, first) = &mut self.missing;
        *blocks += missing;
        // Where the numbers go on, the stamps jump; skipped blocks are named elsewhere.
        let jump = between == 0;
        *jumps += u64::from(jump);
        if jump || missing > 0 {
            let before_s = block.stamp_s - last.stamp_s;
            let text = || format!("{}, {before_s:.1} s after", place(number));
            first.get_or_insert_with(text);
        }
    }

    /// What is missing.
    pub fn findings(&self) -> Vec<Finding> {
        let (blocks, jumps, first) = &self.missing;
        let mut findings = Vec::new();
        if let Some(first) = first {
            let count = |n: u64, noun: &str| {
                let s = if n == 1 { "" } else { "s" };
                format!("{n} {noun}{s}")
            };
            let (blocks, jumps) = (count(*blocks, "block"), count(*jumps, "jump"));
            let text = format!(
                "{blocks} missing by the sequence numbers, {jumps} of the time stamps without missing blocks; each place is a break, first: {first} the one before"
            );
            findings.push(Finding::new(FindingKind::MissingBlocks, text).at_lines(&self.breaks));
        }
        if self.sessions > 1 {
            let sessions = self.sessions;
            let text = format!("{sessions} sessions in one file; a break between them");
            findings.push(Finding::new(FindingKind::SeveralSessions, text));
        }
        findings
    }
}

impl Block {
    /// When the first block of its session was recorded, s, at the earliest.
    fn earliest_s(&self) -> f64 {
        let samples = (f64::from(self.sequence) + 1.0) * self.samples as f64;
        self.stamp_s - (1.0 + RATE_TOLERANCE) * samples / self.rate_hz - STAMP_TOLERANCE_S
    }
}

impl Last {
    /// The stamps leave no room for missing samples.
    fn continues_with(&self, block: &Block) -> bool {
        let steps = (self.samples + block.stamp_sample - self.stamp_sample) as f64;
        let expected_s = steps / self.rate_hz;
        let elapsed_s = block.stamp_s - self.stamp_s;
        let off_s = (elapsed_s - expected_s).abs();
        let same_rate = self.rate_hz == block.rate_hz;
        let rises = steps > 0.0 && elapsed_s > 0.0;
        same_rate && rises && off_s <= RATE_TOLERANCE * expected_s + STAMP_TOLERANCE_S
    }
}
