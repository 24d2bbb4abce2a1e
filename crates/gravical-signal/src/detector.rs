//! Rests as samples come.

use std::collections::VecDeque;

use crate::channels::{Block, Channels, block_len};
use crate::rests::{BLOCK_S, MIN_BLOCKS, Noise, Partition, end_edge, is_quiet, start_edge};

/// Blocks that the noise is learned from: 3 s.
const LEARNED_BLOCKS: usize = 15;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RestEvent {
    /// A rest began at this sample, a second or more ago.
    Begin(usize),
    /// What began some 3 s ago at most is no rest: something still moved in it, it is too short, or it
    /// begins elsewhere, which a [`RestEvent::Begin`] then says.
    Withdraw,
    /// The rest that began ended before this sample.
    End(usize),
}

/// Finds rests by what is past: the detector of [`crate::detect_rests`], one block at a time.
///
/// The noise is that of the first 3 s, and once there is a rest of 3 s, that of this one. A rest begins
/// when it has lasted for a second, and ends when a block is not quiet, when the partition says that the
/// mean has changed, or at a gap. Work is bounded for each block, and so is what it remembers.
#[derive(Debug, Clone)]
pub struct RestDetector {
    size: usize,
    resolution: [f64; 6],
    /// First sample of the next block.
    next: usize,
    /// Blocks that wait for the noise to be known, or for an event before them.
    waiting: VecDeque<Block>,
    /// The latest blocks.
    recent: VecDeque<Block>,
    noise: Option<Noise>,
    /// True once the noise is that of a rest.
    settled: bool,
    run: Option<Run>,
    /// An event that follows the last one.
    pending: Option<RestEvent>,
    /// Where the open rest begins, and where the last one ended.
    begin: usize,
    last_end: usize,
}

/// Adjacent quiet blocks.
#[derive(Debug, Clone)]
struct Run {
    partition: Partition,
    /// Mean that those of the partition are relative to, and their noise.
    origin: [f64; 6],
    noise: Noise,
    /// Number of blocks.
    len: usize,
    /// End of the last block.
    end: usize,
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
}

impl RestDetector {
    /// For samples every `period_s`, written in steps of `resolution` ([`Channels`]).
    #[must_use]
    pub fn new(period_s: f64, resolution: [f64; 6]) -> RestDetector {
        RestDetector {
            size: block_len(period_s, BLOCK_S),
            resolution,
            next: 0,
            waiting: VecDeque::new(),
            recent: VecDeque::new(),
            noise: None,
            settled: false,
            run: None,
            pending: None,
            begin: 0,
            last_end: 0,
        }
    }

    /// The next event in the samples so far; none if there is none yet.
    pub fn update(&mut self, channels: &Channels<'_>) -> Option<RestEvent> {
        if let Some(event) = self.pending.take() {
            return Some(event);
        }
        while self.noise.is_none() {
            let block = self.next_block(channels)?;
            self.waiting.push_back(block);
            if self.waiting.len() == LEARNED_BLOCKS {
                self.learn();
            }
        }
        loop {
            let block = match self.waiting.pop_front() {
                Some(block) => block,
                None => self.next_block(channels)?,
            };
            if let Some(event) = self.take(block, channels) {
                return Some(event);
            }
        }
    }

    /// The next event where no more samples follow: an open rest goes on to their end.
    pub fn finish(&mut self, channels: &Channels<'_>) -> Option<RestEvent> {
        if self.noise.is_none() && self.waiting.len() > MIN_BLOCKS {
            self.learn();
        }
        self.noise.as_ref()?;
        self.update(channels)
    }

    fn learn(&mut self) {
        let blocks = self.waiting.make_contiguous();
        self.noise = Some(Noise::new(blocks, self.size, &self.resolution));
    }

    fn next_block(&mut self, channels: &Channels<'_>) -> Option<Block> {
        loop {
            let count = channels.time_s.len();
            if self.next >= count {
                return None;
            }
            let piece = channels.piece(self.next);
            if self.next + self.size <= piece.end {
                let span = self.next..self.next + self.size;
                self.next = span.end;
                return Some(Block::new(channels, span));
            }
            if piece.end == count {
                return None;
            }
            self.next = piece.end;
        }
    }

    fn take(&mut self, block: Block, channels: &Channels<'_>) -> Option<RestEvent> {
        let noise = self.noise.as_ref()?;
        let adjacent = channels.piece(block.span.start).start < block.span.start;
        let quiet = is_quiet(&block, noise.level);
        if let Some(run) = self.run.take_if(|_| !adjacent || !quiet)
            && run.open.is_some()
        {
            self.waiting.push_front(block);
            return Some(self.end(run.end, &run.noise, channels));
        }
        if !quiet {
            return None;
        }
        self.recent.push_back(block.clone());
        if self.recent.len() > LEARNED_BLOCKS {
            self.recent.pop_front();
        }
        let run = self.run.get_or_insert_with(|| Run {
            partition: Partition::new(channels.count()),
            origin: block.mean,
            noise: noise.clone(),
            len: 0,
            end: block.span.start,
            open: None,
            age: 0,
        });
        (run.end, run.len) = (block.span.end, run.len + 1);
        run.partition
            .push(run.noise.scaled(&block.mean, &run.origin));
        let latest = self.recent.make_contiguous();
        let latest = &latest[latest.len() - run.len.min(latest.len())..];
        let trembling = noise.trembling(latest, self.size, &self.resolution);
        let now = trembling.unwrap_or_else(|| noise.clone());
        if now.is_other(&run.noise) {
            run.restart(latest, now);
        }
        let dropped = run.partition.forget();
        run.open = run.open.map(|from| from.saturating_sub(dropped));

        let (count, start) = run.partition.last();
        let Some(from) = run.open else {
            if count - start <= MIN_BLOCKS {
                return None;
            }
            (run.open, run.age) = (Some(start), count - start);
            let first = run.end - ((count - start) * self.size).min(run.end);
            let span = first.max(self.last_end)..run.end;
            let begin = start_edge(channels, &span, self.size, &run.noise.variance);
            self.begin = begin.max(self.last_end);
            return Some(RestEvent::Begin(self.begin));
        };
        run.age += 1;
        if start > from {
            let short = start - from < MIN_BLOCKS;
            if short && run.age < LEARNED_BLOCKS {
                run.open = None;
                return Some(RestEvent::Withdraw);
            }
            let (before, after) = (from..start, start..count);
            // What takes longer to show is no move: the segment is one of the same rest.
            let same = after.len() >= LEARNED_BLOCKS
                || run.partition.same(&before, &after, &run.noise.slack);
            if !short && !same {
                run.open = None;
                let end = run.end - (after.len() * self.size).min(run.end);
                let noise = run.noise.clone();
                return Some(self.end(end, &noise, channels));
            }
            run.open = Some(start);
        } else if !self.settled && count - from == LEARNED_BLOCKS {
            self.settle();
        } else if run.age == LEARNED_BLOCKS {
            return self.refine(channels);
        }
        None
    }

    /// Begins a rest again where 3 s of it say so better than its first second did.
    fn refine(&mut self, channels: &Channels<'_>) -> Option<RestEvent> {
        let run = self.run.as_ref()?;
        let first = run.end - (run.age * self.size).min(run.end);
        let span = first.max(self.last_end)..run.end;
        let begin = start_edge(channels, &span, self.size, &run.noise.variance).max(self.last_end);
        if begin.abs_diff(self.begin) <= self.size / MIN_BLOCKS {
            return None;
        }
        self.begin = begin;
        self.pending = Some(RestEvent::Begin(begin));
        Some(RestEvent::Withdraw)
    }

    /// Takes the noise of the rest that the last blocks are.
    fn settle(&mut self) {
        let blocks = self.recent.make_contiguous();
        let noise = Noise::new(blocks, self.size, &self.resolution);
        if let Some(run) = &mut self.run {
            run.restart(blocks, noise.clone());
        }
        self.noise = Some(noise);
        self.settled = true;
    }

    fn end(&mut self, end: usize, noise: &Noise, channels: &Channels<'_>) -> RestEvent {
        let piece = channels.piece(end.saturating_sub(1));
        let end = if piece.end - end < self.size {
            // What is left at the end of a piece is no block.
            piece.end
        } else {
            let last = (end + self.size).min(piece.end) - 1;
            end_edge(
                channels,
                &(self.begin..end),
                last,
                self.size,
                &noise.variance,
            )
        };
        if end < self.begin + (MIN_BLOCKS - 1) * self.size {
            return RestEvent::Withdraw;
        }
        self.last_end = end;
        RestEvent::End(end)
    }
}
