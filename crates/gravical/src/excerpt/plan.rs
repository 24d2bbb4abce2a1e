//! Which rows of a long recording are kept.

use std::collections::BTreeMap;
use std::ops::Range;

use gravical_core::matrix3::{cross, norm};

use super::Bounds;
use crate::segment::is_too_short;
use crate::segment::still::MOST_SHAKE;
use crate::still::{Block, Levels};

/// A run of quiet blocks that may be a still.
#[derive(Debug, Clone)]
pub(super) struct Quiet {
    /// Its rows, of the file.
    pub rows: Range<usize>,
    /// Mean of its blocks, accelerometer.
    mean: [f64; 3],
    /// It is a still that does not shake.
    calm: bool,
}

/// Adds the quiet runs of a segment's blocks, by each of the `levels`.
pub(super) fn find_quiet(
    levels: &[Option<Levels>; 2],
    segment: &[Block],
    out: &mut [Vec<Quiet>; 2],
) {
    for (levels, out) in levels.iter().zip(out) {
        let Some(levels) = levels else { continue };
        let runs = levels.quiet_rows(segment).into_iter();
        let runs = runs.filter(|rows| levels.may_be_still(rows));
        out.extend(runs.map(|rows| {
            let from = segment.partition_point(|b| b.rows.start < rows.start);
            let to = segment.partition_point(|b| b.rows.start < rows.end);
            let blocks = &segment[from..to];
            let n = blocks.len() as f64;
            let mean: [f64; 3] =
                std::array::from_fn(|i| blocks.iter().map(|b| b.mean[i]).sum::<f64>() / n);
            let off = |b: &Block| (0..3).map(|i| (b.mean[i] - mean[i]).powi(2)).sum::<f64>();
            let variance = blocks.iter().map(|b| b.variance + off(b)).sum::<f64>() / n;
            // A little less than what still counts as calm, since this is an estimate.
            let shakes = variance.sqrt() >= 0.9 * MOST_SHAKE * norm(&mean);
            let calm = rows.len() >= levels.shortest && !shakes;
            Quiet { rows, mean, calm }
        }));
    }
}

/// Which rows are kept, and why others are not.
#[derive(Debug, Default)]
pub(super) struct Plan {
    /// Rows of the file, in order, apart from each other.
    pub kept: Vec<Range<usize>>,
    /// Quiet runs that are kept, by what they were looked for with.
    pub quiet: [Vec<Range<usize>>; 2],
    /// Those of them that had no room, and their rows.
    pub left_out: (usize, usize),
    /// Runs that are longer than so many rows keep their ends: how many, how many rows.
    pub shortened: Option<(usize, usize)>,
    /// Motions between neighbouring stills, and those of them that are not kept.
    pub motions: usize,
    pub motions_left_out: Vec<Range<usize>>,
}

/// A quiet run that is to be kept.
struct Chosen {
    rows: Range<usize>,
    mean: [f64; 3],
    /// By which options it was found.
    which: usize,
    segment: usize,
}

impl Plan {
    /// By the `quiet` runs of all `segments`, at a rate, Hz, and `width` rows a block. The
    /// second runs count only where a segment has none of the first that is calm.
    pub fn new(
        quiet: &[Vec<Quiet>; 2],
        segments: &[Range<usize>],
        rate: f64,
        width: usize,
        gyro: bool,
        bounds: &Bounds,
    ) -> Self {
        let mut plan = Plan::default();
        let mut all: Vec<Chosen> = Vec::new();
        for (at, segment) in segments.iter().enumerate() {
            let own = |which: usize| {
                let of = &quiet[which];
                let from = of.partition_point(|q| q.rows.start < segment.start);
                let to = of.partition_point(|q| q.rows.start < segment.end);
                of[from..to].iter().map(move |q| (which, q))
            };
            let calm = own(0).any(|(_, q)| q.calm);
            let second = own(1).filter(|_| !calm);
            if own(0).next().is_none() && second.clone().next().is_none() {
                // Its lines are named, and a short one is taken as it is.
                plan.kept.push(match is_too_short(segment.len(), rate) {
                    true => segment.clone(),
                    false => segment.start..segment.start + 1,
                });
            }
            plan.kept.push(segment.start..segment.start + 1);
            plan.kept.push(segment.end - 1..segment.end);
            all.extend(own(0).chain(second).map(|(which, q)| Chosen {
                rows: q.rows.clone(),
                mean: q.mean,
                which,
                segment: at,
            }));
        }
        let room = bounds.still_rows / bounds.least;
        let longest_first = |c: &Chosen| (grid(c.mean), usize::MAX - c.rows.len(), 1);
        let keeps = spread(&all, longest_first, room, usize::MAX);
        plan.keep_motions(&all, &keeps, rate, gyro, bounds);
        let left_out = all.iter().zip(&keeps).filter(|(_, keeps)| !**keeps);
        for (chosen, _) in left_out {
            plan.left_out.0 += 1;
            plan.left_out.1 += if chosen.which == 0 {
                chosen.rows.len()
            } else {
                0
            };
        }
        let mut keeps = keeps.iter();
        all.retain(|_| keeps.next().is_some_and(|keeps| *keeps));
        plan.keep_stills(&all, segments, 2 * width, bounds);
        plan.kept = joined(std::mem::take(&mut plan.kept));
        plan
    }

    /// Stills with `margin` rows before and after; of long ones the ends.
    fn keep_stills(
        &mut self,
        all: &[Chosen],
        segments: &[Range<usize>],
        margin: usize,
        bounds: &Bounds,
    ) {
        let most = longest(
            all.iter().map(|c| c.rows.len()).collect(),
            bounds.still_rows,
        );
        let mut shortened = 0;
        for Chosen {
            rows,
            which,
            segment,
            ..
        } in all
        {
            let within = &segments[*segment];
            let from = rows.start.saturating_sub(margin).max(within.start);
            let to = (rows.end + margin).min(within.end);
            if rows.len() > most {
                shortened += 1;
                self.kept.push(from..rows.start + most / 2);
                self.kept.push(rows.end - most / 2..to);
            } else {
                self.kept.push(from..to);
            }
            self.quiet[*which].push(rows.clone());
        }
        self.shortened = (shortened > 0).then_some((shortened, most));
    }

    /// The motions between neighbouring stills.
    fn keep_motions(
        &mut self,
        all: &[Chosen],
        keeps: &[bool],
        rate: f64,
        gyro: bool,
        bounds: &Bounds,
    ) {
        if !gyro {
            return;
        }
        let mut motions: Vec<(Range<usize>, [i8; 3])> = Vec::new();
        for which in 0..2 {
            let own: Vec<(&Chosen, bool)> = all
                .iter()
                .zip(keeps.iter().copied())
                .filter(|(c, _)| c.which == which)
                .collect();
            for pair in own.windows(2) {
                let [(a, keeps_a), (b, keeps_b)] = [pair[0], pair[1]];
                if a.segment != b.segment || a.rows.end >= b.rows.start {
                    continue;
                }
                let rows = a.rows.end..b.rows.start;
                self.motions += 1;
                let longest = bounds.motion_s * rate;
                if keeps_a && keeps_b && rows.len() as f64 <= longest {
                    motions.push((rows, turn(a.mean, b.mean)));
                } else {
                    self.motions_left_out.push(rows);
                }
            }
        }
        let shortest_first =
            |(rows, turn): &(Range<usize>, [i8; 3])| (*turn, rows.len(), rows.len());
        let keeps = spread(&motions, shortest_first, bounds.motions, bounds.motion_rows);
        for ((rows, _), keeps) in motions.into_iter().zip(keeps) {
            match keeps {
                true => self.kept.push(rows),
                false => self.motions_left_out.push(rows),
            }
        }
        self.motions_left_out.sort_by_key(|rows| rows.start);
    }
}

/// One of 26 directions that a vector is nearest to.
fn grid(v: [f64; 3]) -> [i8; 3] {
    let length = norm(&v);
    v.map(|c| (1.5 * c / length).round() as i8)
}

/// Gravity that turns by less, as the sine of the angle, shows no axis.
const LEAST_TURN: f64 = 0.17;

/// About which axis gravity turned, roughly; zero for none.
fn turn(before: [f64; 3], after: [f64; 3]) -> [i8; 3] {
    let axis = cross(&before, &after);
    match norm(&axis) > LEAST_TURN * norm(&before) * norm(&after) {
        true => grid(axis),
        false => [0; 3],
    }
}

/// Which of some items are kept, `most` at the most, of `room` in all. `of` an item: its
/// kind, its rank among those of its kind, its size. The first of every kind come first,
/// then the second, so that every kind is there.
fn spread<T>(
    items: &[T],
    of: impl Fn(&T) -> ([i8; 3], usize, usize),
    most: usize,
    room: usize,
) -> Vec<bool> {
    let mut kinds: BTreeMap<[i8; 3], Vec<(usize, usize)>> = BTreeMap::new();
    for (at, item) in items.iter().enumerate() {
        let (kind, rank, _) = of(item);
        kinds.entry(kind).or_default().push((rank, at));
    }
    let mut order: Vec<(usize, usize)> = Vec::with_capacity(items.len());
    for own in kinds.values_mut() {
        own.sort_unstable();
        order.extend(own.iter().enumerate().map(|(turn, (_, at))| (turn, *at)));
    }
    order.sort_unstable();
    let mut keeps = vec![false; items.len()];
    let (mut count, mut sum) = (0, 0_usize);
    for (_, at) in order {
        let (.., size) = of(&items[at]);
        if count < most && sum.saturating_add(size) <= room {
            keeps[at] = true;
            count += 1;
            sum += size;
        }
    }
    keeps
}

/// How many rows a run may keep, that all together keep no more than `room`; even.
fn longest(mut lengths: Vec<usize>, room: usize) -> usize {
    lengths.sort_unstable();
    let mut left = room;
    for (at, length) in lengths.iter().enumerate() {
        let share = left / (lengths.len() - at);
        if *length > share {
            return share & !1;
        }
        left -= length;
    }
    usize::MAX
}

/// Ranges in order, those joined that overlap or touch.
fn joined(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.retain(|r| !r.is_empty());
    ranges.sort_unstable_by_key(|r| r.start);
    let mut out: Vec<Range<usize>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => out.push(range),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_there_is_room_for() {
        assert_eq!(longest(vec![10, 20, 30], 60), usize::MAX);
        assert_eq!(longest(vec![30, 10, 20], 50), 20);
        assert_eq!(longest(vec![100, 100, 1], 51), 24);
        assert_eq!(longest(Vec::new(), 0), usize::MAX);
    }

    #[test]
    fn every_kind_comes_first() {
        // Kind and size; the smaller the better.
        let items = [(0, 3), (0, 1), (0, 2), (1, 9), (2, 5)];
        let of = |(kind, size): &(i8, usize)| ([*kind; 3], *size, *size);
        assert_eq!(spread(&items, of, 3, 100), [false, true, false, true, true]);
        assert_eq!(spread(&items, of, 4, 100), [false, true, true, true, true]);
        // What is too large gives room to what is not.
        assert_eq!(spread(&items, of, 5, 9), [false, true, true, false, true]);
    }

    #[test]
    fn ranges_join() {
        assert_eq!(joined(vec![5..9, 0..2, 2..3, 6..7]), [0..3, 5..9]);
    }
}
