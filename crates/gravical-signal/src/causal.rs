//! Rests by what is past.

use std::ops::Range;

use crate::channels::{Block, Channels, block_len, blocks};
use crate::rests::{BLOCK_S, MIN_BLOCKS, Noise, Partition, end_edge, is_quiet, start_edge};

/// Blocks that the noise is learned from: 3 s.
const LEARNED_BLOCKS: usize = 15;

/// The rests of [`crate::detect_rests`] by what is past: one block at a time, none of which is looked at
/// before its turn. The last rest may go on to the end.
///
/// The noise is that of the first 3 s, and once there is a rest of 3 s, that of this one. A rest begins
/// when it has lasted for a second, and ends when a block is not quiet, when the partition says that the
/// mean has changed, or at a gap. Within 3 s it is dropped if something still moved in it, and begins
/// elsewhere if they say so.
pub fn detect_rests_causally(channels: &Channels<'_>) -> Vec<Range<usize>> {
    let size = block_len(channels.period_s, BLOCK_S);
    let blocks = blocks(channels, &(0..channels.time_s.len()), size);
    if blocks.len() <= MIN_BLOCKS {
        return Vec::new();
    }
    let learned = &blocks[..blocks.len().min(LEARNED_BLOCKS)];
    let mut detector = Detector {
        channels,
        blocks: &blocks,
        size,
        noise: Noise::new(learned, size, &channels.resolution),
        settled: false,
        run: None,
        rests: Vec::new(),
        last_end: 0,
    };
    (0..blocks.len()).for_each(|i| detector.take(i));
    detector.rests.retain(|rest| rest.start < rest.end);
    detector.rests
}

struct Detector<'a> {
    channels: &'a Channels<'a>,
    blocks: &'a [Block],
    size: usize,
    noise: Noise,
    /// True once the noise is that of a rest.
    settled: bool,
    run: Option<Run>,
    /// Those that began; one that is open goes on to the end of the samples.
    rests: Vec<Range<usize>>,
    /// Where the last one ended.
    last_end: usize,
}

/// Adjacent quiet blocks.
struct Run {
    /// The first of them.
    first: usize,
    partition: Partition,
    /// Mean that those of the partition are relative to, and their noise.
    origin: [f64; 6],
    noise: Noise,
    /// First block of the last segment of the rest that has begun, and blocks since that began.
    open: Option<usize>,
    age: usize,
}

impl Run {
    /// Divides the latest blocks again, with other noise.
    fn restart(&mut self, latest: &[Block], noise: Noise) {
        let (count, _) = self.partition.last();
        let dropped = count - latest.len().min(count);
        self.open = self.open.map(|from| from.saturating_sub(dropped));
        self.partition.clear();
        for block in latest {
            self.partition.push(noise.scaled(&block.mean, &self.origin));
        }
        self.noise = noise;
    }

    /// Where the rest begins that has gone on until sample `end`.
    fn begin(&self, channels: &Channels<'_>, size: usize, end: usize, last_end: usize) -> usize {
        let first = end - (self.age * size).min(end);
        let span = first.max(last_end)..end;
        start_edge(channels, &span, size, &self.noise.variance).max(last_end)
    }
}

impl Detector<'_> {
    /// Goes on with block `i`.
    fn take(&mut self, i: usize) {
        let (channels, blocks, size) = (self.channels, self.blocks, self.size);
        let block = &blocks[i];
        let adjacent = channels.piece(block.span.start).start < block.span.start;
        let quiet = is_quiet(block, self.noise.level);
        if let Some(run) = self.run.take_if(|_| !adjacent || !quiet)
            && run.open.is_some()
        {
            self.end(blocks[i - 1].span.end, &run.noise);
        }
        if !quiet {
            return;
        }
        let noise = &self.noise;
        let run = self.run.get_or_insert_with(|| Run {
            first: i,
            partition: Partition::new(channels.count()),
            origin: block.mean,
            noise: noise.clone(),
            open: None,
            age: 0,
        });
        run.partition
            .push(run.noise.scaled(&block.mean, &run.origin));
        let latest = &blocks[(i + 1).saturating_sub(LEARNED_BLOCKS).max(run.first)..=i];
        let trembling = noise.trembling(latest, size, &channels.resolution);
        let now = trembling.unwrap_or_else(|| noise.clone());
        if now.is_other(&run.noise) {
            run.restart(latest, now);
        }

        let (count, start) = run.partition.last();
        let end = block.span.end;
        let Some(from) = run.open else {
            if count - start > MIN_BLOCKS {
                (run.open, run.age) = (Some(start), count - start);
                let begin = run.begin(channels, size, end, self.last_end);
                self.rests.push(begin..channels.time_s.len());
            }
            return;
        };
        run.age += 1;
        if start > from {
            let short = start - from < MIN_BLOCKS;
            if short && run.age < LEARNED_BLOCKS {
                run.open = None;
                self.rests.pop();
                return;
            }
            let (before, after) = (from..start, start..count);
            // What takes longer to show is no move: the segment is one of the same rest.
            if short
                || after.len() >= LEARNED_BLOCKS
                || run.partition.same(&before, &after, &run.noise.slack)
            {
                run.open = Some(start);
                return;
            }
            run.open = None;
            let noise = run.noise.clone();
            self.end(end - (after.len() * size).min(end), &noise);
        } else if !self.settled && count - from == LEARNED_BLOCKS {
            let noise = Noise::new(latest, size, &channels.resolution);
            run.restart(latest, noise.clone());
            (self.noise, self.settled) = (noise, true);
        } else if run.age == LEARNED_BLOCKS {
            // 3 s say better where it begins than its first second did.
            let begin = run.begin(channels, size, end, self.last_end);
            if let Some(open) = self.rests.last_mut()
                && begin.abs_diff(open.start) > size / MIN_BLOCKS
            {
                open.start = begin;
            }
        }
    }

    /// Ends the open rest before sample `end`, or drops it if it is too short.
    fn end(&mut self, end: usize, noise: &Noise) {
        let (channels, size) = (self.channels, self.size);
        let Some(open) = self.rests.last_mut() else {
            return;
        };
        let piece = channels.piece(end.saturating_sub(1));
        let end = if piece.end - end < size {
            // What is left at the end of a piece is no block.
            piece.end
        } else {
            let last = (end + size).min(piece.end) - 1;
            end_edge(channels, &(open.start..end), last, size, &noise.variance)
        };
        if end < open.start + (MIN_BLOCKS - 1) * size {
            self.rests.pop();
        } else {
            open.end = end;
            self.last_end = end;
        }
    }
}
