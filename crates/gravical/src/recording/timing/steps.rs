//! Steps between stamps as they come: what [`judge`](super::judge) finds out with all
//! of them in memory.

use super::unit::guess_unit;
use super::{Claims, Clock, Finding, Stamps, Timing, Treatment, mean_rate, rate_findings};

/// Steps within so much of the usual one, relative, are plainly neither lost samples
/// nor bunched ones; the others are kept one by one.
const PLAIN: f64 = 0.45;

/// Steps that are kept at most.
const MOST: usize = 1 << 20;

/// How far the median may be off that of the first rows, relative: none, and so
/// little that only steps at the very edge of a limit ask for more.
const SAME: [f64; 2] = [1e-9, 1e-2];

/// What decides between lost samples, gaps and bunches, in usual steps.
const LIMITS: [f64; 3] = [0.5, 1.5, 4.5];

/// Beyond so many usual steps no lost samples are counted.
const ABSURD: f64 = 1e6;

/// Follows the raw stamps of a recording whose usual step its first rows tell.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    /// The usual step, in units of `per_s` seconds.
    median: f64,
    per_median: f64,
    per_s: f64,
    first: f64,
    last: f64,
    rows: usize,
    latest_s: f64,
    paused: usize,
    plain: usize,
    plain_s: f64,
    /// Plain steps below and above each of [`SAME`].
    below: [usize; 2],
    above: [usize; 2],
    odd: Vec<f64>,
}

impl Steps {
    pub fn new(median: f64, per_s: f64) -> Self {
        Steps {
            median,
            per_median: 1.0 / median,
            per_s,
            first: f64::NAN,
            last: f64::NAN,
            rows: 0,
            latest_s: f64::NEG_INFINITY,
            paused: 0,
            plain: 0,
            plain_s: 0.0,
            below: [0; 2],
            above: [0; 2],
            odd: Vec::new(),
        }
    }

    /// A raw stamp, what it says, and the time that was made of it, s.
    #[inline]
    pub fn see(&mut self, stamp: f64, clock: Clock, t_s: f64) {
        let mut step = stamp - self.last;
        let mut paused = clock == Clock::Paused;
        if let Clock::Wrapped {
            period,
            paused: in_it,
        } = clock
        {
            step += period;
            paused = in_it;
        }
        let off = step * self.per_median - 1.0;
        if off.abs() < PLAIN {
            self.plain += 1;
            self.plain_s += step * self.per_s;
            for (k, same) in SAME.into_iter().enumerate() {
                self.below[k] += usize::from(off < -same);
                self.above[k] += usize::from(off > same);
            }
        } else if self.rows == 0 {
            self.first = stamp;
        } else if paused {
            self.paused += 1;
        } else if self.odd.len() < MOST {
            self.odd.push(step);
        }
        self.latest_s = self.latest_s.max(t_s);
        self.last = stamp;
        self.rows += 1;
    }

    /// What the stamps say; none where that depends on more than was kept: stamps that
    /// are missing, bunched, or so uneven that the usual step is not sure.
    /// `unit_of_head` is the unit that the first rows were read in.
    pub fn finish(&self, claims: &Claims, stamps: &Stamps) -> Option<(Timing, Vec<Finding>)> {
        let steps = self.plain + self.odd.len() + self.paused;
        let known = self.odd.iter().all(|d| d.is_finite()) && self.first.is_finite();
        if self.rows < 2 || steps + 1 != self.rows || !known {
            return None;
        }
        let doubt = self.doubt()?;
        let (median, per_s) = (self.median, self.per_s);
        let mut findings = Vec::new();
        self.same_unit(claims, doubt, &mut findings)?;
        let near_limit = |step: f64| {
            let usual = step / median;
            let near = |limit: f64| (usual - limit).abs() <= 3.0 * doubt * limit;
            // Half a step more or less is another lost sample.
            let half = (usual - usual.floor() - 0.5).abs() <= 3.0 * doubt * usual;
            LIMITS.into_iter().chain([ABSURD]).any(near) || (usual > 1.5 && half)
        };
        let backward = self.odd.iter().any(|d| *d < 0.0);
        if doubt > SAME[0] && (backward || self.odd.iter().any(|d| near_limit(*d))) {
            return None;
        }
        let mean_rate = mean_rate(self.rows, self.latest_s, stamps)?;
        // Bunched ones are shorter than a fifth of the mean step.
        let short = self.odd.iter().filter(|d| **d >= 0.0 && **d < median);
        if mean_rate * median * per_s < 0.4 || short.count() * 2 > steps {
            return None;
        }
        stamps.report(Treatment::Repaired, &mut findings);
        let near = |d: &&f64| **d > 0.5 * median && **d < 1.5 * median;
        let near = self.odd.iter().filter(near);
        let (count, sum) = near.fold((self.plain, self.plain_s), |(n, s), d| {
            (n + 1, s + d * per_s)
        });
        let missing: f64 = self
            .odd
            .iter()
            .filter(|d| **d > 1.5 * median && **d < ABSURD * median)
            .map(|d| (d / median).round() - 1.0)
            .sum();
        let timing = Timing {
            unit: None,
            nominal_rate_hz: claims.nominal_rate_hz,
            median_rate_hz: (count > 0).then(|| count as f64 / sum),
            mean_rate_hz: Some(mean_rate),
            duration_s: Some(self.latest_s),
            jitter_s: None,
            missing_share: Some((missing / (self.rows as f64 + missing).max(1.0)).max(0.0)),
        };
        rate_findings(&timing, missing, &mut findings);
        Some((timing, findings))
    }

    /// How far the median may be off, relative.
    fn doubt(&self) -> Option<f64> {
        let rising = self.odd.iter().filter(|d| **d > 0.0);
        let (short, long): (Vec<f64>, Vec<f64>) = rising.partition(|d| **d < self.median);
        let all = self.plain + short.len() + long.len();
        SAME.into_iter().enumerate().find_map(|(k, same)| {
            let below = self.below[k] + short.len();
            let above = self.above[k] + long.len();
            (2 * below + 1 < all && 2 * above + 1 < all).then_some(same)
        })
    }

    /// The unit is the one that the first rows were read in, whatever the median is.
    fn same_unit(&self, claims: &Claims, doubt: f64, findings: &mut Vec<Finding>) -> Option<()> {
        if let Some(unit) = claims.unit {
            return (unit.seconds() == self.per_s).then_some(());
        }
        for (k, off) in [0.0, -doubt, doubt].into_iter().enumerate() {
            let median = self.median * (1.0 + off);
            let mut told = Vec::new();
            let unit = guess_unit(self.first, self.rows - 1, median, claims, &mut told)?;
            if unit.seconds() != self.per_s || (doubt > SAME[0] && !told.is_empty()) {
                return None;
            }
            if k == 0 {
                findings.append(&mut told);
            }
        }
        Some(())
    }
}
