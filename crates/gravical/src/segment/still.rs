//! Stills: the parts of a recording in which the sensor lies or is held still.
//!
//! The recording is cut into short blocks. Its own noise is the variance of
//! its quietest blocks; a block is quiet while its variance stays under
//! [`StillOptions::noise_factor`]² times that, of the gyroscope likewise. A
//! still is a run of quiet blocks whose means agree: a slow turn is quiet and
//! drifts. Nothing here is a constant in m/s², so that it fits any sensor in
//! any unit. Noise is never taken for less than what rounding makes of it
//! ([`crate::recording::resolution`]): at rest two decimals may never change.
//!
//! It fails where a recording is never still: then its quietest motion is
//! taken for noise. The drift of the block means unmasks that in most cases;
//! what is left are a few short stills, which the caller judges.

use std::ops::Range;

use gravical_core::rounding;

use crate::recording::resolution::floors;
use crate::recording::{Finding, FindingKind, Recording, between};

/// How stills are found.
#[derive(Debug, Clone, PartialEq)]
pub struct StillOptions {
    /// Length of a block, s (5 to 25 rows, and at least 0.05 s). Default 0.2.
    pub block_s: f64,
    /// A block is quiet under this many times the standard deviation of the
    /// quietest ones. Default 3.
    pub noise_factor: f64,
    /// The same for the gyroscope, which a hand that holds still moves more than
    /// the accelerometer. Default 18.
    pub gyro_noise_factor: f64,
    /// Means of blocks agree within this many times noise/√width. Default 10.
    pub mean_factor: f64,
    /// … or within this share of gravity, what a resting table may tremble.
    /// Default 0.004.
    pub tremor: f64,
    /// Shortest still, s, where there are fewer rows than `enough_rows` in it.
    /// Default 1.
    pub shortest_s: f64,
    /// So many rows are always enough, however little time they take.
    /// Default 200.
    pub enough_rows: usize,
    /// But nothing shorter than this is a still, s. Default 0.2.
    pub least_s: f64,
    /// Let a still grow row by row into the blocks at its ends, while the rows
    /// are within noise of its mean: a short rest loses up to two blocks to
    /// where the blocks happen to begin. Default false.
    pub grow_edges: bool,
}

impl StillOptions {
    /// For a rest in the hand or on something that shakes: what is taken for a
    /// hold has to be said with a warning.
    #[must_use]
    pub fn unsteady() -> Self {
        StillOptions {
            noise_factor: 6.0,
            gyro_noise_factor: 50.0,
            mean_factor: 30.0,
            tremor: 0.03,
            ..Self::default()
        }
    }

    /// For short rests, as after setting the sensor down, where the mean of any
    /// pose is of use: 0.15 s and 150 rows, counted after the edges have grown.
    /// A rest of that length holds two whole blocks wherever they begin; what its
    /// mean is worth, its standard error has to say.
    #[must_use]
    pub fn short_rests() -> Self {
        StillOptions {
            enough_rows: 150,
            least_s: 0.15,
            grow_edges: true,
            ..Self::default()
        }
    }
}

impl Default for StillOptions {
    fn default() -> Self {
        StillOptions {
            block_s: 0.2,
            noise_factor: 3.0,
            gyro_noise_factor: 18.0,
            mean_factor: 10.0,
            tremor: 0.004,
            shortest_s: 1.0,
            enough_rows: 200,
            least_s: 0.2,
            grow_edges: false,
        }
    }
}

/// Stills of a recording and the noise they were found with.
#[derive(Debug, Clone, Default)]
pub struct Stills {
    /// Rows of each still, in order.
    pub spans: Vec<Range<usize>>,
    /// Standard deviation of the quietest blocks, the three axes together
    /// (root of the sum of variances), in the unit of the file.
    pub noise: f64,
}

/// Some rows that follow each other.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub rows: Range<usize>,
    pub mean: [f64; 3],
    /// Sum over the axes, as that of the gyroscope; NaN without one.
    pub variance: f64,
    gyro_variance: f64,
}

impl Block {
    /// Of the values of `rows`, which stand in the channels at `at`.
    pub fn of(
        accel: &[Vec<f64>; 3],
        gyro: Option<&[Vec<f64>; 3]>,
        at: Range<usize>,
        rows: Range<usize>,
    ) -> Self {
        let (mean, variance) = moments(accel, at.clone());
        Block {
            rows,
            mean,
            variance,
            gyro_variance: gyro.map_or(f64::NAN, |g| moments(g, at).1),
        }
    }
}

/// Which share of the blocks is taken to be still at least.
const QUIET_SHARE: f64 = 0.05;

/// A block is quiet under this many times the standard deviation of rounding: values
/// that go from one step to the next and the one after scatter by less than two.
const ROUNDING_FACTOR: f64 = 6.0;
/// Shorter blocks, s, hold few independent samples behind the low-pass of a usual
/// sensor, 20 Hz and more.
const SHORT_BLOCK_S: f64 = 0.1;
/// Means of blocks agree within this many times their own scatter, which holds
/// the correlation of the samples.
const CORRELATED_FACTOR: f64 = 5.0;
/// Scatter of means over noise/√width beyond which it is motion: the root of the
/// variance inflation factor behind a low-pass of a hundredth of the rate.
const MOST_CORRELATED: f64 = 6.0;
/// Median length of a vector whose three components are normal.
const MAXWELL_MEDIAN: f64 = 1.538;

/// How far means of blocks scatter, the three axes together, by the steps between
/// quiet neighbours; 0 without any.
fn scatter_of_means(segments: &[Vec<Block>], quiet: impl Fn(&Block) -> bool) -> f64 {
    let mut steps: Vec<f64> = segments
        .iter()
        .flat_map(|blocks| blocks.windows(2))
        .filter(|pair| pair.iter().all(&quiet))
        .map(|pair| distance(pair[0].mean, pair[1].mean))
        .filter(|step| step.is_finite())
        .collect();
    // Each component of a step is √2 of that of a mean; together they are √3.
    let components = 3.0_f64.sqrt() / 2.0_f64.sqrt() / MAXWELL_MEDIAN;
    crate::stats::median(&mut steps).unwrap_or(0.0) * components
}

/// What stills are looked for in: channels of equal length, in any unit.
pub(crate) struct Channels<'a> {
    /// Specific force along x, y, z.
    pub accel: &'a [Vec<f64>; 3],
    /// Angular rate about x, y, z.
    pub gyro: Option<&'a [Vec<f64>; 3]>,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Rows that follow each other; no still spans two of these.
    pub segments: Vec<Range<usize>>,
    /// Steps that the values come in, accelerometer and gyroscope.
    pub resolution: [f64; 6],
}

/// Finds the stills. Of an [excerpt](crate::excerpt) these are those of the whole
/// recording; with other options than it was read for, only what is in memory counts.
#[must_use]
pub fn find_stills(recording: &Recording, options: &StillOptions) -> Stills {
    if let Some(stills) = recording.excerpt.as_ref().and_then(|e| e.stills(options)) {
        return stills.clone();
    }
    let channels = Channels {
        accel: &recording.accel,
        gyro: recording.gyro.as_ref(),
        rate_hz: recording.working_rate_hz().0,
        segments: between(&recording.partings(), recording.rows()),
        resolution: recording.resolution,
    };
    find_stills_in(&channels, options)
}

/// The same in channels that are no recording's.
pub(crate) fn find_stills_in(recording: &Channels<'_>, options: &StillOptions) -> Stills {
    let rate = recording.rate_hz;
    let width = block_rows(rate, options);
    let segments: Vec<Vec<Block>> = recording
        .segments
        .iter()
        .cloned()
        .map(|rows| blocks(recording, rows, width))
        .collect();
    let Some(levels) = Levels::of(&segments, rate, &recording.resolution, options) else {
        return Stills::default();
    };
    let mut spans: Vec<Range<usize>> = Vec::new();
    for segment in &segments {
        let (Some(first), Some(last)) = (segment.first(), segment.last()) else {
            continue;
        };
        let edges = first.rows.start..last.rows.end;
        for mut rows in levels.quiet_rows(segment) {
            let from = spans.last().map_or(0, |s| s.end).max(edges.start);
            rows = levels.grow(recording.accel, rows, from..edges.end);
            if rows.len() >= levels.shortest {
                spans.push(rows);
            }
        }
    }
    Stills {
        spans,
        noise: levels.noise(),
    }
}

/// What tells a still, by the blocks of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Levels {
    /// Variance that the quietest blocks stay under.
    floor: f64,
    /// A block is quiet up to these variances.
    most_accel: f64,
    most_gyro: f64,
    /// Means of blocks agree within this.
    agree: f64,
    /// Rows of a block.
    width: usize,
    /// Rows of the shortest still.
    pub shortest: usize,
    grows: bool,
}

impl Levels {
    /// By blocks that follow each other in each of the `groups`, of a recording whose
    /// values come in steps of `resolution`; none where nothing but zeros is there.
    pub fn of(
        groups: &[Vec<Block>],
        rate: f64,
        resolution: &[f64; 6],
        options: &StillOptions,
    ) -> Option<Self> {
        let width = block_rows(rate, options);
        let all = || groups.iter().flatten();
        let (accel_step, gyro_step) = resolution.split_at(3);
        let floor = quiet_level(all().map(|b| b.variance), accel_step)?;
        let gyro_floor =
            quiet_level(all().map(|b| b.gyro_variance), gyro_step).unwrap_or(f64::INFINITY);
        // What rounding makes of a level is known: only the rest of it is multiplied.
        let most = |level: f64, factor: f64, step: &[f64]| {
            let rounding = floors(step).min(level);
            (level - rounding) * factor * factor + rounding * ROUNDING_FACTOR.min(factor).powi(2)
        };
        let mut levels = Levels {
            floor,
            most_accel: most(floor, options.noise_factor, accel_step),
            most_gyro: most(gyro_floor, options.gyro_noise_factor, gyro_step),
            agree: f64::NAN,
            width,
            shortest: ((options.shortest_s * rate).min(options.enough_rows as f64) as usize)
                .max((options.least_s * rate) as usize)
                .max(10),
            grows: options.grow_edges,
        };
        let gravity = typical_magnitude(all());
        // Means of blocks scatter by noise/√width, correlated noise by some times
        // that: many samples behind a low-pass, by a multiple.
        let white = (floor / width as f64).sqrt();
        let mut scatter = options.mean_factor * white;
        if (width as f64) < SHORT_BLOCK_S * rate {
            let means =
                scatter_of_means(groups, |b| levels.is_quiet(b)).min(MOST_CORRELATED * white);
            scatter = scatter.max(CORRELATED_FACTOR * means);
        }
        levels.agree = scatter.max(options.tremor * gravity) + step_of_means(floor, accel_step);
        Some(levels)
    }

    /// Standard deviation of the quietest blocks, the three axes together.
    pub fn noise(&self) -> f64 {
        self.floor.sqrt()
    }

    pub fn is_quiet(&self, block: &Block) -> bool {
        block.variance <= self.most_accel
            && (block.gyro_variance.is_nan() || block.gyro_variance <= self.most_gyro)
    }

    /// Rows of the runs of quiet blocks of a segment whose means agree, before they
    /// [grow](Self::grow).
    pub fn quiet_rows(&self, segment: &[Block]) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        let stretches = Stretches::new(segment);
        let mut at = 0;
        while at < segment.len() {
            let end = segment[at..]
                .iter()
                .position(|b| !self.is_quiet(b))
                .map_or(segment.len(), |n| at + n);
            if end > at {
                settle(segment, &stretches, at..end, self.agree, &mut runs);
            }
            at = end + 1;
        }
        let whole = 0..segment.len();
        let joined = join(segment, runs, self.agree);
        joined
            .iter()
            .map(|run| trim(segment, run, &whole))
            .collect()
    }

    /// Whether quiet rows may be a still, once they have grown.
    pub fn may_be_still(&self, rows: &Range<usize>) -> bool {
        let grown = if self.grows { 2 * self.width } else { 0 };
        rows.len() + grown >= self.shortest
    }

    /// Takes rows on at both ends, where that is asked for: at most a block each and not
    /// beyond `within`, up to the first that is off by more than [`EDGE_SIGMAS`].
    pub fn grow(
        &self,
        accel: &[Vec<f64>; 3],
        rows: Range<usize>,
        within: Range<usize>,
    ) -> Range<usize> {
        if !self.grows {
            return rows;
        }
        let (mean, _) = moments(accel, rows.clone());
        // The floor is the sum over the three axes.
        let far = EDGE_SIGMAS * (self.floor / 3.0).sqrt();
        let at = |row: usize| std::array::from_fn(|axis| accel[axis][row]);
        let belongs = |row: &usize| distance(at(*row), mean) <= far;
        let before = (within.start..rows.start).rev().take(self.width);
        let after = (rows.end..within.end).take(self.width);
        let from = before.take_while(belongs).last().unwrap_or(rows.start);
        let to = after.take_while(belongs).last().map_or(rows.end, |r| r + 1);
        from..to
    }
}

/// What shakes by more than this share of gravity, rms, is no rest, however even
/// it is: a hand trembles by a hundredth, a running engine by less than a tenth.
pub(crate) const MOST_SHAKE: f64 = 0.1;
/// Calm parts of less than this share of a recording are scraps of motion.
const LEAST_CALM: f64 = 0.1;

/// The stills that do not shake.
pub(crate) fn find_calm(recording: &Recording, options: &StillOptions) -> Vec<Range<usize>> {
    let mut spans = find_stills(recording, options).spans;
    spans.retain(|rows| shake(recording, rows) < MOST_SHAKE);
    spans
}

/// The calmest parts of a recording without a still, each with a finding; none where
/// it moves throughout.
pub(crate) fn find_calmest(
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Vec<Range<usize>> {
    let spans = find_calm(recording, &StillOptions::unsteady());
    let held: usize = spans.iter().map(|s| recording.length(s)).sum();
    if (held as f64) < LEAST_CALM * recording.rows_in_file() as f64 {
        return Vec::new();
    }
    for span in &spans {
        findings.push(
            Finding::new(
                FindingKind::UnsteadyHold,
                format!(
                    "never quite still; the calmest part, lines {} to {}, shakes by {:.0} mg rms and is taken",
                    recording.line(span.start),
                    recording.line(span.end - 1),
                    1000.0 * shake(recording, span)
                ),
            )
            .in_file(&recording.name),
        );
    }
    spans
}

/// Standard deviation of the rows, the three axes together, over their mean
/// magnitude.
fn shake(recording: &Recording, rows: &Range<usize>) -> f64 {
    let (mean, variance) = moments(&recording.accel, rows.clone());
    variance.sqrt() / gravical_core::matrix3::norm(&mean)
}

/// A row further than this many standard deviations of an axis from the mean of
/// a still does not belong to it: one in 65,000 of those that do.
const EDGE_SIGMAS: f64 = 5.0;

/// Rows of a block at a rate.
#[must_use]
pub fn block_rows(rate_hz: f64, options: &StillOptions) -> usize {
    let wanted = (options.block_s * rate_hz).round();
    let least = (0.05 * rate_hz).round().max(5.0);
    wanted.clamp(5.0, 25.0).max(least) as usize
}

fn blocks(recording: &Channels<'_>, rows: Range<usize>, width: usize) -> Vec<Block> {
    let mut out = Vec::with_capacity(rows.len() / width);
    let mut from = rows.start;
    while from + width <= rows.end {
        // What is left at the end joins the last block.
        let to = if from + 2 * width > rows.end {
            rows.end
        } else {
            from + width
        };
        out.push(Block::of(
            recording.accel,
            recording.gyro,
            from..to,
            from..to,
        ));
        from = to;
    }
    out
}

/// Mean of each axis and the sum of the variances; empty cells are left out.
pub(crate) fn moments(channels: &[Vec<f64>; 3], rows: Range<usize>) -> ([f64; 3], f64) {
    let mut means = [f64::NAN; 3];
    let mut total = 0.0;
    for (axis, channel) in channels.iter().enumerate() {
        // Empty cells count as nothing; without branches, since this is half of
        // the work of finding stills.
        let part = &channel[rows.clone()];
        let (mut n, mut sum) = (0.0, 0.0);
        for &v in part {
            let there = v.is_finite();
            n += f64::from(u8::from(there));
            sum += if there { v } else { 0.0 };
        }
        let mean = sum / n;
        means[axis] = mean;
        let mut squares = 0.0;
        for &v in part {
            let off = v - mean;
            squares += if v.is_finite() { off * off } else { 0.0 };
        }
        total += if n > 1.0 {
            squares / (n - 1.0)
        } else {
            f64::NAN
        };
    }
    (means, total)
}

/// The level that the quietest twentieth of the blocks stays under, and no less than
/// rounding to `step` makes. None where nothing but zeros is there and the steps are
/// not known either.
pub(crate) fn quiet_level(variances: impl Iterator<Item = f64>, step: &[f64]) -> Option<f64> {
    let least = floors(step);
    let mut some: Vec<f64> = variances
        .filter(|v| *v > 0.0 || least > 0.0 && *v >= 0.0)
        .collect();
    if some.is_empty() {
        return None;
    }
    let at = ((some.len() as f64 * QUIET_SHARE) as usize).min(some.len() - 1);
    let (_, level, _) = some.select_nth_unstable_by(at, f64::total_cmp);
    Some(level.max(least))
}

/// How far two means of one reading may be apart by rounding alone: where noise is
/// less than a step, they go from one step to the next at once.
pub(crate) fn step_of_means(floor: f64, step: &[f64]) -> f64 {
    // Of a level as low as rounding itself nothing has to be noise.
    let left: f64 = step
        .iter()
        .map(|q| rounding::mean_variance(floor / 3.0 - rounding::floor(*q), *q))
        .sum();
    (12.0 * left).sqrt()
}

fn typical_magnitude<'a>(blocks: impl Iterator<Item = &'a Block>) -> f64 {
    let mut norms: Vec<f64> = blocks
        .map(|b| b.mean.iter().map(|m| m * m).sum::<f64>().sqrt())
        .filter(|n| n.is_finite())
        .collect();
    crate::stats::median(&mut norms).unwrap_or(0.0)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn middle(blocks: &[Block]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let mut values: Vec<f64> = blocks.iter().map(|b| b.mean[axis]).collect();
        crate::stats::median(&mut values).unwrap_or(f64::NAN)
    })
}

/// What a stretch of blocks holds, for stretches of any length in a few steps: cutting a
/// day with a thousand motions must not look at all of it for each.
#[derive(Clone, Copy)]
struct Stretch {
    /// Least and greatest mean of each axis.
    low: [f64; 3],
    high: [f64; 3],
    /// The largest step of the mean from one block to the next, the last of equal ones,
    /// and the block after it.
    jump: (f64, usize),
}

impl Stretch {
    const NOTHING: Stretch = Stretch {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
        jump: (f64::NEG_INFINITY, 0),
    };

    /// This one and the one after it.
    fn with(&self, after: &Stretch) -> Stretch {
        Stretch {
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
struct Stretches {
    nodes: Vec<Stretch>,
    leaves: usize,
}

impl Stretches {
    fn new(blocks: &[Block]) -> Self {
        let leaves = blocks.len().next_power_of_two();
        let mut nodes = vec![Stretch::NOTHING; 2 * leaves];
        for (k, block) in blocks.iter().enumerate() {
            let jump = match k {
                0 => f64::NEG_INFINITY,
                _ => distance(block.mean, blocks[k - 1].mean),
            };
            nodes[leaves + k] = Stretch {
                low: block.mean,
                high: block.mean,
                jump: (jump, k),
            };
        }
        for k in (1..leaves).rev() {
            nodes[k] = nodes[2 * k].with(&nodes[2 * k + 1]);
        }
        Stretches { nodes, leaves }
    }

    fn of(&self, range: Range<usize>) -> Stretch {
        let (mut from, mut to) = (range.start + self.leaves, range.end + self.leaves);
        let (mut first, mut last) = (Stretch::NOTHING, Stretch::NOTHING);
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

    /// Where to cut a run of which no centre is within `agree` of all blocks: the means
    /// of an axis are further apart than twice that.
    fn cut(&self, run: &Range<usize>, agree: f64) -> Option<usize> {
        let all = self.of(run.clone());
        let apart = (0..3).any(|i| all.high[i] - all.low[i] > 2.0 * agree);
        apart.then(|| self.of(run.start + 1..run.end).jump.1)
    }
}

/// Keeps a run whose block means agree; cuts one that drifts or steps where it
/// changes most, and looks at the parts.
fn settle(
    segment: &[Block],
    stretches: &Stretches,
    run: Range<usize>,
    agree: f64,
    out: &mut Vec<Range<usize>>,
) {
    let mut pending = vec![run];
    let mut kept = Vec::new();
    while let Some(run) = pending.pop() {
        let part = &segment[run.clone()];
        if part.is_empty() {
            continue;
        }
        if let Some(cut) = stretches.cut(&run, agree) {
            pending.push(run.start..cut);
            pending.push(cut..run.end);
            continue;
        }
        let centre = middle(part);
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
    out.extend(kept);
}

/// Joins runs that a bump of at most two blocks parts while the means on both
/// sides agree: the robust mean of the hold leaves the bump out.
fn join(segment: &[Block], runs: Vec<Range<usize>>, agree: f64) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for run in runs {
        if let Some(last) = out.last_mut() {
            let near = run.start - last.end <= 2 && run.start > last.end;
            let same = distance(
                middle(&segment[last.clone()]),
                middle(&segment[run.clone()]),
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

/// Rows of a run, its edges taken off where it borders on motion.
fn trim(segment: &[Block], run: &Range<usize>, whole: &Range<usize>) -> Range<usize> {
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
    fn a_run_is_cut_where_its_means_step_most() {
        // Three levels over and over, so that many steps are alike.
        let blocks: Vec<Block> = (0..101)
            .map(|k| Block {
                rows: k..k + 1,
                mean: [f64::from([0_u8, 0, 5, 5, 1, 9][k % 6]), 0.1 * k as f64, 0.0],
                variance: 0.0,
                gyro_variance: f64::NAN,
            })
            .collect();
        let stretches = Stretches::new(&blocks);
        for (from, to) in [(0, 101), (3, 64), (7, 9), (40, 41), (99, 101)] {
            let jump = |k: &usize| distance(blocks[*k].mean, blocks[k - 1].mean);
            let plain = (from + 1..to).max_by(|i, j| jump(i).total_cmp(&jump(j)));
            assert_eq!(stretches.cut(&(from..to), 0.01), plain, "{from} {to}");
            assert_eq!(stretches.cut(&(from..to), 6.0), None);
        }
    }
}
