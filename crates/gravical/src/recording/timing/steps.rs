//! Statistics of the steps between time stamps (median, spread, missing samples), in memory that
//! does not grow with the recording.

use std::collections::BTreeMap;

/// Bits of the mantissa that select a bin: a bin is at most 0.4 % wide. Bins are represented by
/// the mean of their steps; for stamps of a counter all steps of a bin are equal.
const BITS: u32 = 8;

/// Steps of nearly equal length.
#[derive(Debug, Clone, Copy)]
struct Bin {
    count: u64,
    /// The first of them; sums are of the differences from it.
    first: f64,
    sum: f64,
    squares: f64,
    /// Of the steps with an earlier change of the stamp: rows since that change, and the steps,
    /// both summed.
    rows: u64,
    span: f64,
}

impl Bin {
    fn mean(&self) -> f64 {
        self.first + self.sum / self.count as f64
    }
}

/// Steps between time stamps, in their unit.
#[derive(Debug, Clone, Default)]
pub(super) struct Steps {
    bins: Vec<Bin>,
    of_key: BTreeMap<u32, usize>,
    /// The bin that was used last, and its key.
    last: (u32, usize),
    /// Number of zero steps.
    zero: u64,
    /// Number of all steps, including negative ones and NaN.
    number: u64,
    /// Number of the last step at which the stamp changed.
    changed: Option<u64>,
}

/// Steps in a range of lengths.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Group {
    pub count: u64,
    pub mean: f64,
    squares: f64,
}

impl Group {
    fn add(&mut self, count: u64, mean: f64, squares: f64) {
        if count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, count as f64);
        let off = mean - self.mean;
        self.count += count;
        self.mean += off * b / (a + b);
        self.squares += squares + off * off * a * b / (a + b);
    }

    /// Sample standard deviation; `None` for fewer than three steps.
    pub fn deviation(&self) -> Option<f64> {
        (self.count > 2).then(|| (self.squares / (self.count - 1) as f64).sqrt())
    }
}

impl Steps {
    #[inline]
    pub fn push(&mut self, step: f64) {
        let number = self.number;
        self.number += 1;
        if step > 0.0 {
            let since = self.changed.replace(number).map(|at| number - at);
            let key = (step.to_bits() >> (52 - BITS)) as u32;
            let at = match self.last {
                (last, at) if last == key && at < self.bins.len() => at,
                _ => self.bin(key, step),
            };
            if let Some(bin) = self.bins.get_mut(at) {
                let off = step - bin.first;
                bin.count += 1;
                bin.sum += off;
                bin.squares += off * off;
                bin.rows += since.unwrap_or(0);
                bin.span += since.map_or(0.0, |_| step);
            }
        } else if step == 0.0 {
            self.zero += 1;
        } else {
            self.changed = Some(number);
        }
    }

    #[cold]
    fn bin(&mut self, key: u32, step: f64) -> usize {
        let at = *self.of_key.entry(key).or_insert_with(|| {
            self.bins.push(Bin {
                count: 0,
                first: step,
                sum: 0.0,
                squares: 0.0,
                rows: 0,
                span: 0.0,
            });
            self.bins.len() - 1
        });
        self.last = (key, at);
        at
    }

    /// A copy in which the steps of `odd` are replaced by `corrected`.
    pub fn with(&self, odd: &Steps, corrected: &Steps) -> Steps {
        let mut out = self.clone();
        out.add(odd, -1.0);
        out.add(corrected, 1.0);
        out.bins.retain(|bin| bin.count > 0);
        // The indices are no longer valid.
        out.of_key.clear();
        out
    }

    /// Adds the steps of `other` (`sign` 1) or removes them (−1); `changed` is left.
    fn add(&mut self, other: &Steps, sign: f64) {
        let signed = |count: u64| {
            if sign > 0.0 {
                count as i64
            } else {
                -(count as i64)
            }
        };
        let change = |count: &mut u64, by: u64| *count = count.saturating_add_signed(signed(by));
        change(&mut self.number, other.number);
        change(&mut self.zero, other.zero);
        for (key, place) in &other.of_key {
            let Some(from) = other.bins.get(*place) else {
                continue;
            };
            let at = self.bin(*key, from.first);
            if let Some(bin) = self.bins.get_mut(at) {
                // Sums are relative to the first step of each bin.
                let n = from.count as f64;
                let off = from.first - bin.first;
                change(&mut bin.count, from.count);
                bin.sum += sign * (from.sum + n * off);
                bin.squares += sign * (from.squares + 2.0 * off * from.sum + n * off * off);
            }
        }
    }

    /// Number of all steps.
    pub fn count(&self) -> u64 {
        self.number
    }

    /// Number of stamps that repeat the one before.
    pub fn repeats(&self) -> u64 {
        self.zero
    }

    /// Lengths of the positive steps and their numbers, in ascending order.
    fn rising(&self) -> Vec<(f64, u64)> {
        let mut lengths: Vec<(f64, u64)> = self.bins.iter().map(|b| (b.mean(), b.count)).collect();
        lengths.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        lengths
    }

    /// Median of the positive steps; `None` without any.
    pub fn median(&self) -> Option<f64> {
        let rising = self.rising();
        let all: u64 = rising.iter().map(|r| r.1).sum();
        let upper = nth(&rising, all / 2)?;
        Some(match all.is_multiple_of(2) {
            true => 0.5 * (nth(&rising, all / 2 - 1)? + upper),
            false => upper,
        })
    }

    /// Number of steps from 0 to below `limit`.
    pub fn shorter(&self, limit: f64) -> u64 {
        let zero = if limit > 0.0 { self.zero } else { 0 };
        let bins = self.bins.iter().filter(|b| b.mean() < limit);
        zero + bins.map(|b| b.count).sum::<u64>()
    }

    /// The steps between `low` and `high`, both excluded.
    pub fn between(&self, low: f64, high: f64) -> Group {
        let mut group = Group::default();
        if low < 0.0 {
            group.add(self.zero, 0.0, 0.0);
        }
        for bin in &self.bins {
            let mean = bin.mean();
            if mean > low && mean < high {
                let n = bin.count as f64;
                let squares = (bin.squares - bin.sum * bin.sum / n).max(0.0);
                group.add(bin.count, mean, squares);
            }
        }
        group
    }

    /// Number of samples missing in steps longer than 1.5 and shorter than a million times
    /// `usual`.
    pub fn missing(&self, usual: f64) -> f64 {
        self.rising()
            .iter()
            .filter(|(step, _)| *step > 1.5 * usual && *step < 1e6 * usual)
            .map(|(step, count)| ((step / usual).round() - 1.0) * *count as f64)
            .sum()
    }

    /// Rows per unit of time for stamps that most rows share with the row before. Counted from
    /// one change of the stamp to the next, since the recording begins and ends within a stamp;
    /// without waits of `longest` or more and steps back. `None` for other stamps and for fewer
    /// than three.
    pub fn coarse_rate(&self, longest: f64) -> Option<f64> {
        if self.zero * 2 <= self.number {
            return None;
        }
        let some = self.bins.iter().filter(|b| b.mean() < longest);
        let (rows, span) = some.fold((0, 0.0), |(n, s), b| (n + b.rows, s + b.span));
        (rows > 0).then(|| rows as f64 / span)
    }

    /// True if the steps longer than `long` are pauses of the recorder and not waits for a full
    /// buffer: they are rare and of different lengths, and the stamps between them are evenly
    /// spaced.
    pub fn pauses_only(&self, usual: f64, long: f64) -> bool {
        let waits: Vec<(f64, u64)> = self.rising().into_iter().filter(|r| r.0 > long).collect();
        let count: u64 = waits.iter().map(|w| w.1).sum();
        let even = self.between(0.5 * usual, 1.5 * usual).count;
        // Allows for some lost samples.
        if count * super::RAREST_BURST > self.number || even * 10 < (self.number - count) * 9 {
            return false;
        }
        let quarter = count / 4;
        let from_the_end = count.checked_sub(1 + quarter);
        match (
            nth(&waits, quarter),
            from_the_end.and_then(|at| nth(&waits, at)),
        ) {
            (Some(low), Some(high)) if count >= super::FEWEST_BURSTS => high > 1.5 * low,
            _ => true,
        }
    }
}

/// The length at index `n` of the sorted list with repetitions.
fn nth(lengths: &[(f64, u64)], n: u64) -> Option<f64> {
    let mut before = 0;
    let found = lengths.iter().find(|(_, count)| {
        before += count;
        before > n
    });
    found.map(|(length, _)| *length)
}
