//! Runs of quiet blocks whose means agree.

use std::ops::Range;

use super::block::Block;
use super::distance;

fn median_mean(blocks: &[Block]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let mut values: Vec<f64> = blocks.iter().map(|b| b.mean[axis]).collect();
        crate::stats::median(&mut values).unwrap_or(f64::NAN)
    })
}

/// Summary of consecutive blocks, available for any range in a few steps: splitting a day with a
/// thousand motions must not process all blocks for each motion.
#[derive(Clone, Copy)]
struct RangeSummary {
    /// Smallest and largest mean of each axis.
    low: [f64; 3],
    high: [f64; 3],
    /// The largest step of the mean from one block to the next (the last of equal ones), and the
    /// block after it.
    jump: (f64, usize),
}

impl RangeSummary {
    const NOTHING: RangeSummary = RangeSummary {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
        jump: (f64::NEG_INFINITY, 0),
    };

    /// Combines this range with the one after it.
    fn with(&self, after: &RangeSummary) -> RangeSummary {
        RangeSummary {
            low: std::array::from_fn(|i| self.low[i].min(after.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(after.high[i])),
            jump: match self.jump.0.total_cmp(&after.jump.0) {
                std::cmp::Ordering::Greater => self.jump,
                _ => after.jump,
            },
        }
    }
}

/// A segment tree over blocks: node k covers nodes 2k and 2k + 1.
struct RangeTree {
    nodes: Vec<RangeSummary>,
    leaves: usize,
}

impl RangeTree {
    pub fn new(blocks: &[Block]) -> Self {
        let leaves = blocks.len().next_power_of_two();
        let mut nodes = vec![RangeSummary::NOTHING; 2 * leaves];
        for (k, block) in blocks.iter().enumerate() {
            let jump = match k {
                0 => f64::NEG_INFINITY,
                _ => distance(block.mean, blocks[k - 1].mean),
            };
            nodes[leaves + k] = RangeSummary {
                low: block.mean,
                high: block.mean,
                jump: (jump, k),
            };
        }
        for k in (1..leaves).rev() {
            nodes[k] = nodes[2 * k].with(&nodes[2 * k + 1]);
        }
        RangeTree { nodes, leaves }
    }

    fn of(&self, range: Range<usize>) -> RangeSummary {
        let (mut from, mut to) = (range.start + self.leaves, range.end + self.leaves);
        let (mut first, mut last) = (RangeSummary::NOTHING, RangeSummary::NOTHING);
        while from < to {
            if from % 2 == 1 {
                first = first.with(&self.nodes[from]);
                from += 1;
            }
            if to % 2 == 1 {
                to -= 1;
                last = self.nodes[to].with(&last);
            }
            (from, to) = (from / 2, to / 2);
        }
        first.with(&last)
    }

    /// Where to split a run whose blocks cannot all be within `agree` of one centre: the means of
    /// an axis differ by more than twice that.
    fn cut(&self, run: &Range<usize>, agree: f64) -> Option<usize> {
        let all = self.of(run.clone());
        let apart = (0..3).any(|i| all.high[i] - all.low[i] > 2.0 * agree);
        apart.then(|| self.of(run.start + 1..run.end).jump.1)
    }
}

/// Adds a run whose block means agree; splits one that drifts or steps at its largest step,
/// recursively.
pub(super) fn split_run(
    segment: &[Block],
    run: Range<usize>,
    agree: f64,
    out: &mut Vec<Range<usize>>,
) {
    let offset = run.start;
    let segment = &segment[run.clone()];
    let (ranges, run) = (RangeTree::new(segment), 0..run.len());
    let mut pending = vec![run];
    let mut kept = Vec::new();
    while let Some(run) = pending.pop() {
        let part = &segment[run.clone()];
        if part.is_empty() {
            continue;
        }
        if let Some(cut) = ranges.cut(&run, agree) {
            pending.push(run.start..cut);
            pending.push(cut..run.end);
            continue;
        }
        let centre = median_mean(part);
        let worst = part
            .iter()
            .map(|b| distance(b.mean, centre))
            .fold(0.0, f64::max);
        if worst <= agree || part.len() == 1 {
            kept.push(run);
            continue;
        }
        let cut = (1..part.len())
            .max_by(|&i, &j| {
                let jump = |k: usize| distance(part[k].mean, part[k - 1].mean);
                jump(i).total_cmp(&jump(j))
            })
            .unwrap_or(1);
        pending.push(run.start..run.start + cut);
        pending.push(run.start + cut..run.end);
    }
    kept.sort_by_key(|r| r.start);
    out.extend(kept.iter().map(|r| r.start + offset..r.end + offset));
}

/// Joins runs separated by a disturbance of at most two blocks if the means on both sides agree:
/// the robust mean of the interval ignores the disturbance.
pub(super) fn join(segment: &[Block], runs: Vec<Range<usize>>, agree: f64) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for run in runs {
        if let Some(last) = out.last_mut() {
            let near = run.start - last.end <= 2 && run.start > last.end;
            let same = distance(
                median_mean(&segment[last.clone()]),
                median_mean(&segment[run.clone()]),
            ) <= agree;
            if near && same {
                last.end = run.end;
                continue;
            }
        }
        out.push(run);
    }
    out
}

/// Rows of a run, without its edge blocks if it borders on motion.
pub(super) fn trim(segment: &[Block], run: &Range<usize>, whole: &Range<usize>) -> Range<usize> {
    let (mut from, mut to) = (run.start, run.end);
    if run.len() >= 6 {
        from += usize::from(run.start > whole.start);
        to -= usize::from(run.end < whole.end);
    }
    segment[from].rows.start..segment[to - 1].rows.end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_split_at_its_largest_step() {
        // Three repeated levels, so that many steps are equal.
        let blocks: Vec<Block> = (0..101)
            .map(|k| Block {
                rows: k..k + 1,
                mean: [f64::from([0_u8, 0, 5, 5, 1, 9][k % 6]), 0.1 * k as f64, 0.0],
                variance: 0.0,
                gyro_variance: f64::NAN,
            })
            .collect();
        let ranges = RangeTree::new(&blocks);
        for (from, to) in [(0, 101), (3, 64), (7, 9), (40, 41), (99, 101)] {
            let jump = |k: &usize| distance(blocks[*k].mean, blocks[k - 1].mean);
            let plain = (from + 1..to).max_by(|i, j| jump(i).total_cmp(&jump(j)));
            assert_eq!(ranges.cut(&(from..to), 0.01), plain, "{from} {to}");
            assert_eq!(ranges.cut(&(from..to), 6.0), None);
        }
    }
}
