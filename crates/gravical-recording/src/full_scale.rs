//! Ends of a sensor's range, and values that reach them.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::finding::{Finding, FindingKind};
use crate::spans::LineSpans;
use crate::units::{AccelScale, AccelUnit, GyroScale, GyroUnit, LSB_PER_DEG_S};

/// Full scales in use, g.
const FULL_SCALES_G: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// Full scales of gyroscopes on the market, °/s; those of the sensitivities in [`LSB_PER_DEG_S`]
/// are added.
pub const FULL_SCALES_DEG_S: [f64; 7] = [125.0, 245.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0];

/// Smallest count at the end of a 16-bit converter: some end a few counts early.
const MIN_END_COUNT: f64 = 32764.0;
/// Largest count of a 16-bit converter; larger values come from another converter, whose end is
/// unknown.
const MAX_END_COUNT: f64 = 32768.0;

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
    fn new(ends: Vec<[f64; 2]>, counts: bool) -> Self {
        Clipping {
            ends,
            counts,
            ..Clipping::default()
        }
    }

    fn of_counts() -> Self {
        Clipping::new(vec![[MIN_END_COUNT, MAX_END_COUNT]], true)
    }

    /// Of an accelerometer; nothing seen yet.
    #[must_use]
    pub fn of_accel(scale: &AccelScale) -> Self {
        if scale.unit == AccelUnit::Counts {
            return Self::of_counts();
        }
        let per_g = scale.nominal().map(|n| n * STANDARD_GRAVITY_MPS2);
        let given = scale.lsb_per_g.map(|lsb| 32768.0 / lsb);
        let ranges_g: Vec<f64> = FULL_SCALES_G.into_iter().chain(given).collect();
        let ends = per_g.into_iter().flat_map(|per_g| {
            let full = ranges_g.iter().map(move |g| g * per_g);
            // Within two counts of the full scale.
            full.map(|full| [full * (1.0 - 2.5 / 32768.0), full * 1.0005])
        });
        Clipping::new(ends.collect(), false)
    }

    /// Of a gyroscope. If the unit is unknown, °/s or rad/s is assumed.
    #[must_use]
    pub fn of_gyro(scale: &GyroScale) -> Self {
        if scale.unit == GyroUnit::Counts {
            return Self::of_counts();
        }
        let full_deg_s: Vec<f64> = match scale.lsb_per_deg_s {
            Some(lsb) => vec![32768.0 / lsb],
            None => LSB_PER_DEG_S
                .into_iter()
                .map(|lsb| 32767.0 / lsb)
                .chain(FULL_SCALES_DEG_S)
                .collect(),
        };
        let radian = std::f64::consts::PI / 180.0;
        let units: &[f64] = match scale.unit {
            GyroUnit::RadianPerSecond => &[radian],
            GyroUnit::DegreePerSecond => &[1.0],
            _ => &[1.0, radian],
        };
        let ends = full_deg_s.iter().flat_map(|deg_s| {
            let full = units.iter().map(move |unit| deg_s * unit);
            // Tolerance for rounded sensitivities and two decimals.
            full.map(|full| [full * 0.9985 - 0.005, full * 1.0015 + 0.005])
        });
        Clipping::new(ends.collect(), false)
    }

    /// Processes a value, with the offset subtracted.
    pub fn observe(&mut self, value: f64, line: u64) {
        let magnitude = value.abs();
        if magnitude > self.largest {
            // A value that is exceeded is not the end of the range.
            if magnitude > 1.004 * self.largest && !self.counts {
                self.lines = LineSpans::default();
                self.repeats = 0;
            }
            self.largest = magnitude;
        }
        let is_at_end = |[from, to]: &[f64; 2]| (*from..=*to).contains(&magnitude);
        let near_largest = self.counts || magnitude > 0.996 * self.largest;
        if near_largest && self.ends.iter().any(is_at_end) {
            self.repeats += u64::from(self.last == value);
            self.last = value;
            self.lines.push(line);
        }
    }

    /// Processes the values of rows, with the offset subtracted, and their lines.
    pub fn observe_all(&mut self, values: &[f64], lines: &[u32]) {
        for (value, line) in values.iter().zip(lines) {
            self.observe(*value, u64::from(*line));
        }
    }

    /// Number of clipped values.
    fn count(&self) -> u64 {
        let shown = if self.counts {
            self.largest <= MAX_END_COUNT
        } else {
            self.repeats >= 3
        };
        if shown { self.lines.count() } else { 0 }
    }

    /// What was found; `None` without clipping.
    #[must_use]
    pub fn finding(&self, channel: &str) -> Option<Finding> {
        let count = self.count();
        let text = format!(
            "{channel} reaches the end of its range in {count} rows: the true value is larger; record at a wider range"
        );
        (count > 0).then(|| Finding::new(FindingKind::Clipped, text).at_lines(&self.lines))
    }
}

/// Number of values of a channel at rest that are clipped.
#[must_use]
pub fn clipped_count(values: &[f64], scale: &AccelScale) -> usize {
    let mut clipping = Clipping::of_accel(scale);
    for (value, line) in values.iter().zip(1..) {
        clipping.observe(*value, line);
    }
    clipping.count() as usize
}
