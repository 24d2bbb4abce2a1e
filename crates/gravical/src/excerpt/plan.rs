//! Selection of the rows of a long recording that are stored.

use std::collections::BTreeMap;
use std::ops::Range;

use gravical_core::matrix3::{cross, norm};

use super::Bounds;
use crate::poses::is_too_short;
use crate::stills::{Block, Levels};

/// A run of quiet blocks that may be a static interval.
#[derive(Debug, Clone)]
pub(super) struct Quiet {
    /// Its rows in the file.
    pub rows: Range<usize>,
    /// Mean of the accelerometer.
    mean: [f64; 3],
}

/// Adds the quiet runs of a segment's blocks.
pub(super) fn find_quiet(levels: Option<&Levels>, segment: &[Block], out: &mut Vec<Quiet>) {
    let Some(levels) = levels else { return };
    let runs = levels.quiet_rows(segment).into_iter();
    let runs = runs.filter(|rows| rows.len() >= levels.shortest);
    out.extend(runs.map(|rows| {
        let from = segment.partition_point(|b| b.rows.start < rows.start);
        let to = segment.partition_point(|b| b.rows.start < rows.end);
        let blocks = &segment[from..to];
        let n = blocks.len() as f64;
        let mean = std::array::from_fn(|i| blocks.iter().map(|b| b.mean[i]).sum::<f64>() / n);
        Quiet { rows, mean }
    }));
}

/// The rows that are stored, and what is left out.
#[derive(Debug, Default)]
pub(super) struct Plan {
    /// Rows of the file, in order, not overlapping.
    pub rows: Vec<Range<usize>>,
    /// Quiet runs that are stored.
    pub quiet: Vec<Range<usize>>,
    /// Number of quiet runs that are left out, and of their rows.
    pub left_out: (usize, usize),
    /// If only the ends of long runs are stored: number of such runs, and rows stored of each.
    pub shortened: Option<(usize, usize)>,
    /// Number of motions between neighbouring static intervals; those left out.
    pub motions: usize,
    pub motions_left_out: Vec<Range<usize>>,
}

/// A quiet run that may be stored.
struct Chosen {
    rows: Range<usize>,
    mean: [f64; 3],
    segment: usize,
}

impl Plan {
    /// Plans from the `quiet` runs of all `segments`, at a rate in Hz, with `width` rows per
    /// block.
    pub fn new(
        quiet: &[Quiet],
        segments: &[Range<usize>],
        rate: f64,
        width: usize,
        gyro: bool,
        bounds: &Bounds,
    ) -> Self {
        let mut plan = Plan::default();
        let mut all: Vec<Chosen> = Vec::new();
        for (at, segment) in segments.iter().enumerate() {
            let from = quiet.partition_point(|q| q.rows.start < segment.start);
            let to = quiet.partition_point(|q| q.rows.start < segment.end);
            let of_segment = &quiet[from..to];
            if of_segment.is_empty() {
                // Its lines are reported, and a short segment is used as it is.
                plan.rows.push(match is_too_short(segment.len(), rate) {
                    true => segment.clone(),
                    false => segment.start..segment.start + 1,
                });
            }
            plan.rows.push(segment.start..segment.start + 1);
            plan.rows.push(segment.end - 1..segment.end);
            all.extend(of_segment.iter().map(|q| Chosen {
                rows: q.rows.clone(),
                mean: q.mean,
                segment: at,
            }));
        }
        let room = bounds.still_rows / bounds.least;
        let longest_first = |c: &Chosen| (grid(c.mean), usize::MAX - c.rows.len(), 1);
        let selected = select(&all, longest_first, room, usize::MAX);
        plan.add_motions(&all, &selected, rate, gyro, bounds);
        let left_out = all
            .iter()
            .zip(&selected)
            .filter(|(_, selected)| !**selected);
        for (chosen, _) in left_out {
            plan.left_out.0 += 1;
            plan.left_out.1 += chosen.rows.len();
        }
        let mut selected = selected.iter();
        all.retain(|_| selected.next().is_some_and(|selected| *selected));
        plan.add_stills(&all, segments, 2 * width, bounds);
        plan.rows = merged(std::mem::take(&mut plan.rows));
        plan
    }

    /// Stores static intervals with `margin` rows before and after; of long ones only the ends.
    fn add_stills(
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
        for Chosen { rows, segment, .. } in all {
            let within = &segments[*segment];
            let from = rows.start.saturating_sub(margin).max(within.start);
            let to = (rows.end + margin).min(within.end);
            if rows.len() > most {
                shortened += 1;
                self.rows.push(from..rows.start + most / 2);
                self.rows.push(rows.end - most / 2..to);
            } else {
                self.rows.push(from..to);
            }
            self.quiet.push(rows.clone());
        }
        self.shortened = (shortened > 0).then_some((shortened, most));
    }

    /// Stores the motions between neighbouring static intervals.
    fn add_motions(
        &mut self,
        all: &[Chosen],
        selected: &[bool],
        rate: f64,
        gyro: bool,
        bounds: &Bounds,
    ) {
        if !gyro {
            return;
        }
        let mut motions: Vec<(Range<usize>, [i8; 3])> = Vec::new();
        let runs: Vec<(&Chosen, bool)> = all.iter().zip(selected.iter().copied()).collect();
        for pair in runs.windows(2) {
            let [(a, selected_a), (b, selected_b)] = [pair[0], pair[1]];
            if a.segment != b.segment || a.rows.end >= b.rows.start {
                continue;
            }
            let rows = a.rows.end..b.rows.start;
            self.motions += 1;
            let longest = bounds.motion_s * rate;
            if selected_a && selected_b && rows.len() as f64 <= longest {
                motions.push((rows, turn(a.mean, b.mean)));
            } else {
                self.motions_left_out.push(rows);
            }
        }
        let shortest_first =
            |(rows, turn): &(Range<usize>, [i8; 3])| (*turn, rows.len(), rows.len());
        let selected = select(&motions, shortest_first, bounds.motions, bounds.motion_rows);
        for ((rows, _), selected) in motions.into_iter().zip(selected) {
            match selected {
                true => self.rows.push(rows),
                false => self.motions_left_out.push(rows),
            }
        }
        self.motions_left_out.sort_by_key(|rows| rows.start);
    }
}

/// The nearest of 26 directions.
fn grid(v: [f64; 3]) -> [i8; 3] {
    let length = norm(&v);
    v.map(|c| (1.5 * c / length).round() as i8)
}

/// Smallest turn of gravity that determines an axis, as the sine of the angle.
const LEAST_TURN: f64 = 0.17;

/// Approximate axis about which gravity turned; zero for a small turn.
fn turn(before: [f64; 3], after: [f64; 3]) -> [i8; 3] {
    let axis = cross(&before, &after);
    match norm(&axis) > LEAST_TURN * norm(&before) * norm(&after) {
        true => grid(axis),
        false => [0; 3],
    }
}

/// Selects at most `most` items with a total size of at most `room`. `of` gives the kind, the
/// rank within the kind and the size of an item. The first item of every kind is selected first,
/// then the second of every kind, so that all kinds are represented.
fn select<T>(
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
    for items in kinds.values_mut() {
        items.sort_unstable();
        order.extend(items.iter().enumerate().map(|(turn, (_, at))| (turn, *at)));
    }
    order.sort_unstable();
    let mut selected = vec![false; items.len()];
    let (mut count, mut sum) = (0, 0_usize);
    for (_, at) in order {
        let (.., size) = of(&items[at]);
        if count < most && sum.saturating_add(size) <= room {
            selected[at] = true;
            count += 1;
            sum += size;
        }
    }
    selected
}

/// Number of rows, even, to which runs must be shortened so that all together have at most
/// `room`.
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

/// Sorted ranges; overlapping and adjacent ones are merged.
pub(super) fn merged(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
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
    fn runs_are_shortened_to_fit() {
        assert_eq!(longest(vec![10, 20, 30], 60), usize::MAX);
        assert_eq!(longest(vec![30, 10, 20], 50), 20);
        assert_eq!(longest(vec![100, 100, 1], 51), 24);
        assert_eq!(longest(Vec::new(), 0), usize::MAX);
    }

    #[test]
    fn every_kind_is_represented() {
        // Kind and size; smaller items are preferred.
        let items = [(0, 3), (0, 1), (0, 2), (1, 9), (2, 5)];
        let of = |(kind, size): &(i8, usize)| ([*kind; 3], *size, *size);
        assert_eq!(select(&items, of, 3, 100), [false, true, false, true, true]);
        assert_eq!(select(&items, of, 4, 100), [false, true, true, true, true]);
        // A large item that does not fit leaves room for smaller ones.
        assert_eq!(select(&items, of, 5, 9), [false, true, true, false, true]);
    }

    #[test]
    fn overlapping_and_adjacent_ranges_are_merged() {
        assert_eq!(merged(vec![5..9, 0..2, 2..3, 6..7]), [0..3, 5..9]);
    }
}
