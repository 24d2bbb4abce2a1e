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

/// Ends of a sensor's range, in the unit of the file.
#[derive(Debug, Clone)]
pub struct FullScale {
    /// Intervals of magnitudes that are at the end.
    ends: Vec<[f64; 2]>,
    /// The values are counts, whose end is certain. In physical units a single value at a full
    /// scale can be a coincidence; clipping shows as repeats of one value.
    counts: bool,
}

impl FullScale {
    fn of_counts() -> Self {
        FullScale {
            ends: vec![[MIN_END_COUNT, MAX_END_COUNT]],
            counts: true,
        }
    }

    /// Of an accelerometer.
    #[must_use]
    pub fn of_accel(scale: &AccelScale) -> Self {
        if scale.unit == AccelUnit::Counts {
            return Self::of_counts();
        }
        let per_g = scale.nominal().map(|n| n * STANDARD_GRAVITY_MPS2);
        let given = scale.lsb_per_g.map(|lsb| 32768.0 / lsb);
        let ranges = FULL_SCALES_G.into_iter().chain(given);
        FullScale {
            // Within two counts of the full scale.
            ends: per_g
                .map(|per_g| ranges.map(move |g| g * per_g))
                .into_iter()
                .flatten()
                .map(|full| [full * (1.0 - 2.5 / 32768.0), full * 1.0005])
                .collect(),
            counts: false,
        }
    }

    /// Of a gyroscope. If the unit is unknown, °/s or rad/s is assumed.
    #[must_use]
    pub fn of_gyro(scale: &GyroScale) -> Self {
        if scale.unit == GyroUnit::Counts {
            return Self::of_counts();
        }
        let given_deg_s = scale.lsb_per_deg_s.map(|lsb| 32768.0 / lsb);
        let full_deg_s: Vec<f64> = match given_deg_s {
            Some(given) => vec![given],
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
        let ends = full_deg_s
            .iter()
            .flat_map(|deg_s| units.iter().map(move |unit| deg_s * unit));
        FullScale {
            // Tolerance for rounded sensitivities and two decimals.
            ends: ends
                .map(|full| [full * 0.9985 - 0.005, full * 1.0015 + 0.005])
                .collect(),
            counts: false,
        }
    }

    /// Smallest magnitude at the end.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.ends
            .iter()
            .fold(f64::INFINITY, |least, e| least.min(e[0]))
    }

    fn is_at_end(&self, magnitude: f64) -> bool {
        self.ends
            .iter()
            .any(|[from, to]| magnitude >= *from && magnitude <= *to)
    }
}

/// Detects clipping of a channel.
#[derive(Debug, Clone)]
pub struct Clipping {
    full: FullScale,
    lines: LineSpans,
    largest: f64,
    last: f64,
    repeats: u64,
}

impl Clipping {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(full: FullScale) -> Self {
        Clipping {
            full,
            lines: LineSpans::default(),
            largest: 0.0,
            last: f64::NAN,
            repeats: 0,
        }
    }

    /// Processes a value, with the offset subtracted; values below [`FullScale::least`] may be
    /// left out.
    pub fn observe(&mut self, value: f64, line: u64) {
        let magnitude = value.abs();
        if magnitude > self.largest {
            // A value that is exceeded is not the end of the range.
            if magnitude > 1.004 * self.largest && !self.full.counts {
                self.lines = LineSpans::default();
                self.repeats = 0;
            }
            self.largest = magnitude;
        }
        let near_largest = self.full.counts || magnitude > 0.996 * self.largest;
        if near_largest && self.full.is_at_end(magnitude) {
            self.repeats += u64::from(self.last == value);
            self.last = value;
            self.lines.push(line);
        }
    }

    /// Processes the values of rows, with the offset subtracted, and their lines.
    pub fn observe_all(&mut self, values: &[f64], lines: &[u32]) {
        let least = self.full.least();
        for (value, line) in values.iter().zip(lines).filter(|(v, _)| v.abs() >= least) {
            self.observe(*value, u64::from(*line));
        }
    }

    /// Number of clipped values.
    fn count(&self) -> u64 {
        let shown = if self.full.counts {
            self.largest <= MAX_END_COUNT
        } else {
            self.repeats >= 3
        };
        if shown { self.lines.count() } else { 0 }
    }

    /// What was found; `None` without clipping.
    #[must_use]
    pub fn finding(&self, channel: &str) -> Option<Finding> {
        (self.count() > 0).then(|| {
            Finding::new(
                FindingKind::Clipped,
                format!(
                    "{channel} reaches the end of its range in {} rows: the true value is larger; record at a wider range",
                    self.lines.count()
                ),
            )
            .at_lines(&self.lines)
        })
    }
}

/// Number of values of a channel at rest that are clipped.
#[must_use]
pub fn clipped_count(values: &[f64], scale: &AccelScale) -> usize {
    let mut clipping = Clipping::new(FullScale::of_accel(scale));
    for (value, line) in values.iter().zip(1..) {
        clipping.observe(*value, line);
    }
    clipping.count() as usize
}
