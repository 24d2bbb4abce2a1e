//! Ends of a sensor's range, and values that reach them.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::finding::{Case, Finding};
use crate::spans::LineSpans;
use crate::units::{AccelScale, AccelUnit, GyroScale, GyroUnit, LSB_PER_DEG_S};

/// Full scales in use, g.
const FULL_SCALES_G: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// Full scales of gyroscopes on the market, °/s; those of the sensitivities in [`LSB_PER_DEG_S`]
/// are added.
pub const FULL_SCALES_DEG_S: [f64; 7] = [125.0, 245.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0];

/// Ranges that converters of 16 bits have, g and °/s: what their counts per g or °/s stand for.
const RANGES_OF_16_BITS: [f64; 15] = [
    2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0, 125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0,
];

/// The range of a 16-bit converter with so many counts per g or °/s, rounded as data sheets do; `None`
/// for counts of any other.
pub fn range_of_16_bits(lsb: f64) -> Option<f64> {
    let is_it = |range: &f64| (32_768.0 / lsb / range - 1.0).abs() < 1e-3;
    RANGES_OF_16_BITS.into_iter().find(is_it)
}

/// Counts at the end of a 16-bit converter: some end a few counts early. Larger values come from
/// another converter, whose end is unknown.
const COUNT_ENDS: [f64; 2] = [32764.0, 32768.0];

/// Detects clipping of a channel.
#[derive(Debug, Clone, Default)]
pub struct Clipping {
    /// Intervals of magnitudes at an end of the range, in the unit of the file.
    ends: Vec<[f64; 2]>,
    /// The values are counts, whose end is certain. In physical units a single value at a full
    /// scale can be a coincidence; clipping shows as repeats of one value.
    counts: bool,
    lines: LineSpans,
    largest: f64,
    last: f64,
    repeats: u64,
}

impl Clipping {
    fn new(ends: impl IntoIterator<Item = [f64; 2]>, counts: bool) -> Self {
        Clipping {
            ends: ends.into_iter().collect(),
            counts,
            ..Clipping::default()
        }
    }

    /// Of an accelerometer; nothing seen yet.
    pub fn of_accel(scale: &AccelScale) -> Self {
        if scale.unit == AccelUnit::Counts {
            return Self::new([COUNT_ENDS], true);
        }
        let per_g = scale.nominal().unwrap_or(f64::NAN) * STANDARD_GRAVITY_MPS2;
        let full = FULL_SCALES_G.map(|g| g * per_g).into_iter();
        // Within two counts of the full scale.
        let ends = full.map(|full| [full * (1.0 - 2.5 / 32768.0), full * 1.0005]);
        Self::new(ends, false)
    }

    /// Of a gyroscope. If the unit is unknown, °/s or rad/s is assumed.
    pub fn of_gyro(scale: &GyroScale) -> Self {
        if scale.unit == GyroUnit::Counts {
            return Self::new([COUNT_ENDS], true);
        }
        let full_deg_s: Vec<f64> = match scale.lsb_per_deg_s {
            Some(lsb) => vec![32768.0 / lsb],
            None => {
                let of_counts = LSB_PER_DEG_S.map(|lsb| 32767.0 / lsb);
                of_counts.into_iter().chain(FULL_SCALES_DEG_S).collect()
            }
        };
        let radian = std::f64::consts::PI / 180.0;
        let units: &[f64] = match scale.unit {
            GyroUnit::RadianPerSecond => &[radian],
            GyroUnit::DegreePerSecond => &[1.0],
            _ => &[1.0, radian],
        };
        let full = units
            .iter()
            .flat_map(|unit| full_deg_s.iter().map(move |deg_s| deg_s * unit));
        // Tolerance for rounded sensitivities and two decimals.
        let ends = full.map(|full| [full * 0.9985 - 0.005, full * 1.0015 + 0.005]);
        Self::new(ends, false)
    }

    fn is_at_end(&self, magnitude: f64) -> bool {
        let mut ends = self.ends.iter();
        ends.any(|[from, to]| (*from..=*to).contains(&magnitude))
    }

    /// Processes the values of rows, with the offset subtracted, and their lines.
    pub fn observe(&mut self, values: &[f64], lines: &[u32]) {
        for (value, line) in values.iter().zip(lines) {
            let magnitude = value.abs();
            if magnitude > self.largest {
                // A value that is exceeded is not the end of the range.
                if magnitude > 1.004 * self.largest && !self.counts {
                    self.lines = LineSpans::default();
                    self.repeats = 0;
                }
                self.largest = magnitude;
            }
            let near_largest = self.counts || magnitude > 0.996 * self.largest;
            if near_largest && self.is_at_end(magnitude) {
                self.repeats += u64::from(self.last == *value);
                self.last = *value;
                self.lines.push(u64::from(*line));
            }
        }
    }

    /// Number of clipped values.
    fn count(&self) -> u64 {
        let shown = if self.counts {
            self.largest <= COUNT_ENDS[1]
        } else {
            self.repeats >= 3
        };
        if shown { self.lines.count() } else { 0 }
    }

    /// What was found; `None` without clipping.
    pub fn finding(&self, channel: &str) -> Option<Finding> {
        let rows = self.count();
        let channel = channel.to_owned();
        let clipped = || Case::Clipped { channel, rows }.finding();
        (rows > 0).then(|| clipped().at_lines(&self.lines))
    }
}

/// Number of values of a channel at rest that are clipped.
pub fn clipped_count(values: &[f64], scale: &AccelScale) -> usize {
    let mut clipping = Clipping::of_accel(scale);
    let lines: Vec<u32> = (1..).take(values.len()).collect();
    clipping.observe(values, &lines);
    clipping.count() as usize
}

/// Values of a channel at and beyond which it is clipped; none when it never
/// is. The end of the range is known where the unit is; everywhere it shows as
/// three or more readings in a row at the channel's own extreme that the signal comes
/// to, or leaves, in a step far above its last digit: the top of a smooth
/// motion is reached in small ones.
pub fn range_end(channel: &[f64], scale: Option<GyroScale>) -> Option<[f64; 2]> {
    let low = channel.iter().copied().fold(f64::INFINITY, f64::min);
    let high = channel.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let changes = channel.windows(2).map(|w| (w[1] - w[0]).abs());
    let digit = changes.filter(|change| *change > 0.0).reduce(f64::min)?;
    let known = scale.filter(|scale| scale.unit != GyroUnit::Unknown);
    let known = known.map(|scale| Clipping::of_gyro(&scale));
    let repeats = |extreme: f64| channel.iter().filter(|v| **v == extreme).take(3).count() == 3;
    let at_end = |extreme: f64| {
        let is_known =
            |known: &Clipping| known.is_at_end(extreme.abs()) && (known.counts || repeats(extreme));
        known.as_ref().is_some_and(is_known) || flat_top(channel, extreme, digit)
    };
    let (bottom, top) = (at_end(low), at_end(high));
    (bottom || top).then_some([
        if bottom { low } else { f64::NEG_INFINITY },
        if top { high } else { f64::INFINITY },
    ])
}

/// Last digits of a step to a flat top: beside three rows of a smooth top that are equal by chance the next
/// step may have a dozen.
const TOP_STEP: f64 = 20.0;

fn flat_top(channel: &[f64], extreme: f64, digit: f64) -> bool {
    if !channel.windows(3).any(|w| w == [extreme; 3]) {
        return false;
    }
    // Lengths of the runs that begin or end with such a step.
    let mut lengths = Vec::new();
    let (mut from, mut longest) = (0, 0);
    for run in channel.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        let beside = [from.checked_sub(1), Some(to)].map(|i| channel.get(i?));
        let mut steps = beside.into_iter().flatten().map(|v| (v - run[0]).abs());
        if steps.any(|step| step > TOP_STEP * digit) {
            lengths.push(run.len());
            if run[0] == extreme {
                longest = longest.max(run.len());
            }
        }
        from = to;
    }
    // Where values are held, or read faster than they are measured, each of them
    // stands in several rows.
    let quarter = lengths.len() / 4;
    longest > 0 && longest >= 3 * *lengths.select_nth_unstable(quarter).1
}
