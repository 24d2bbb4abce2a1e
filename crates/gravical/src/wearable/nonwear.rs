//! Non-wear, by the rule of van Hees et al. 2013, in one pass.

use std::array::from_fn;
use std::collections::VecDeque;

/// Length of a part, s: the largest by which windows and blocks are both divided.
pub(super) const PART_S: i64 = 450;
/// Parts of a block of 15 min, which is judged as a whole.
const BLOCK: i64 = 2;
/// Parts of the window of 60 min around it, by which it is judged.
const WINDOW: i64 = 8;
/// Parts of the window before the block.
const BEFORE: i64 = (WINDOW - BLOCK) / 2;
/// Fewest parts of a window that have samples: half of them.
const FEWEST: usize = 4;
/// Standard deviation and range of an axis that is at rest, g: less than these.
const MOST_SD_G: f64 = 0.013;
const MOST_RANGE_G: f64 = 0.05;
/// Fewest axes at rest.
const FEWEST_AXES: usize = 2;

/// Samples of one axis.
#[derive(Debug, Clone, Copy)]
struct Spread {
    count: f64,
    mean: f64,
    squares: f64,
    low: f64,
    high: f64,
}

impl Spread {
    const NONE: Spread = Spread {
        count: 0.0,
        mean: 0.0,
        squares: 0.0,
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    #[inline]
    fn push(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    fn join(self, other: Spread) -> Spread {
        if other.count == 0.0 || self.count == 0.0 {
            return if self.count == 0.0 { other } else { self };
        }
        let count = self.count + other.count;
        let off = other.mean - self.mean;
        Spread {
            count,
            mean: self.mean + off * other.count / count,
            squares: self.squares + other.squares + off * off * self.count * other.count / count,
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn rests(&self) -> bool {
        let sd = (self.squares / (self.count - 1.0)).sqrt();
        sd < MOST_SD_G && self.high - self.low < MOST_RANGE_G
    }
}

/// Judges blocks of a stretch of time, in order.
#[derive(Debug, Clone)]
pub(super) struct NonWear {
    /// The parts that are still needed, without gaps; the last one is being filled.
    parts: VecDeque<[Spread; 3]>,
    /// Number of the first of them, and of the first of the stretch.
    from: i64,
    first: i64,
    /// The next block to judge.
    block: i64,
}

impl NonWear {
    /// A stretch that begins in `part`.
    pub fn new(part: i64) -> Self {
        NonWear {
            parts: VecDeque::from([[Spread::NONE; 3]]),
            from: part,
            first: part,
            block: part.div_euclid(BLOCK),
        }
    }

    /// The block of a part.
    pub fn block_of(part: i64) -> i64 {
        part.div_euclid(BLOCK)
    }

    /// The part that is being filled.
    pub fn now(&self) -> i64 {
        self.from + self.parts.len() as i64 - 1
    }

    /// Adds a sample of the part [`now`](Self::now).
    #[inline]
    pub fn push(&mut self, accel_g: [f64; 3]) {
        if let Some(part) = self.parts.back_mut() {
            for (axis, value) in part.iter_mut().zip(accel_g) {
                axis.push(value);
            }
        }
    }

    /// Ends the part that is being filled and begins the next one; judges what can be judged.
    pub fn end_part(&mut self, judged: &mut VecDeque<Option<bool>>) {
        let end = self.now() + 1;
        while self.lowest() + WINDOW <= end {
            judged.push_back(self.judge(self.lowest()));
            self.block += 1;
        }
        self.parts.push_back([Spread::NONE; 3]);
        while self.from < self.lowest() && self.now() + 1 - self.from > WINDOW {
            self.parts.pop_front();
            self.from += 1;
        }
    }

    /// Judges the rest of the stretch: by its last hour.
    pub fn finish(mut self, judged: &mut VecDeque<Option<bool>>) {
        let end = self.now() + 1;
        while self.block <= Self::block_of(end - 1) {
            let lowest = self.lowest().min(end - WINDOW);
            judged.push_back(match lowest >= self.first {
                true => self.judge(lowest),
                false => None,
            });
            self.block += 1;
        }
    }

    /// The first part of the window of the next block: the window is within the stretch.
    fn lowest(&self) -> i64 {
        (self.block * BLOCK - BEFORE).max(self.first)
    }

    /// Whether the sensor was not worn in the window from the part `lowest` on; `None` with too few
    /// samples.
    fn judge(&self, lowest: i64) -> Option<bool> {
        let skipped = usize::try_from(lowest - self.from).ok()?;
        let window = || self.parts.iter().skip(skipped).take(WINDOW as usize);
        if window().filter(|part| part[0].count > 0.0).count() < FEWEST {
            return None;
        }
        let axes: [Spread; 3] = from_fn(|i| window().fold(Spread::NONE, |all, p| all.join(p[i])));
        Some(axes.iter().filter(|axis| axis.rests()).count() >= FEWEST_AXES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Verdicts of blocks over parts, each of which has 45 samples or none.
    fn verdicts(first: i64, parts: &[Option<[f64; 3]>]) -> Vec<Option<bool>> {
        let mut judged = VecDeque::new();
        let mut stretch = NonWear::new(first);
        for (i, amplitude) in parts.iter().enumerate() {
            if i > 0 {
                stretch.end_part(&mut judged);
            }
            for k in 0..45 {
                if let Some(a) = amplitude {
                    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                    stretch.push([a[0] * sign, a[1] * sign, 1.0 + a[2] * sign]);
                }
            }
        }
        stretch.finish(&mut judged);
        judged.into()
    }

    const STILL: Option<[f64; 3]> = Some([0.002; 3]);
    const MOVED: Option<[f64; 3]> = Some([0.3; 3]);

    #[test]
    fn a_block_is_judged_by_the_hour_around_it() {
        // Two hours at rest, one of motion, two at rest: 40 parts, 20 blocks.
        let mut parts = vec![STILL; 40];
        parts[16..24].fill(MOVED);
        let judged = verdicts(0, &parts);
        assert_eq!(judged.len(), 20);
        // The window of block 6 is parts 9 to 16, and touches the motion; that of 5 ends at 14.
        let expected: Vec<Option<bool>> = (0..20).map(|b| Some(!(6..14).contains(&b))).collect();
        assert_eq!(judged, expected);
    }

    #[test]
    fn it_needs_two_axes_and_both_limits() {
        let all = |a: [f64; 3]| verdicts(0, &[Some(a); 8]);
        // Alternating between ±a: the standard deviation is a, the range 2a.
        assert_eq!(all([0.0125, 0.0125, 0.3]), [Some(true); 4]);
        assert_eq!(all([0.0125, 0.3, 0.3]), [Some(false); 4]);
        assert_eq!(all([0.0135, 0.0135, 0.0135]), [Some(false); 4]);
        // A knock in each hour: small deviation, large range.
        let mut judged = VecDeque::new();
        let mut stretch = NonWear::new(0);
        for part in 0..8 {
            if part > 0 {
                stretch.end_part(&mut judged);
            }
            (0..4500).for_each(|k| stretch.push([if k == 9 { 0.06 } else { 0.0 }; 3]));
        }
        stretch.finish(&mut judged);
        assert_eq!(judged, [Some(false); 4]);
    }

    #[test]
    fn too_little_is_not_judged() {
        assert_eq!(verdicts(0, &[STILL; 7]), [None; 4]);
        assert_eq!(verdicts(0, &[STILL; 8]), [Some(true); 4]);
        // Of a gap only the hours next to it are known; numbers may begin anywhere.
        for first in [0, -2, 1_000_000] {
            let mut parts = vec![STILL; 40];
            parts[10..30].fill(None);
            let judged = verdicts(first, &parts);
            let unknown: Vec<usize> = (0..20).filter(|b| judged[*b].is_none()).collect();
            assert_eq!(unknown, (5..15).collect::<Vec<_>>());
        }
    }

    #[test]
    fn any_start_gives_each_block_one_verdict() {
        for (first, parts) in [(0, 1), (1, 1), (1, 2), (-3, 30), (7, 9), (8, 200)] {
            let blocks = NonWear::block_of(first + parts - 1) - NonWear::block_of(first) + 1;
            let judged = verdicts(first, &vec![STILL; parts as usize]);
            assert_eq!(judged.len() as i64, blocks, "{first} {parts}");
        }
    }
}
