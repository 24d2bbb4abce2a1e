//! Resolution of channels whose rows pass one by one.

use gravical_recording::judge::{Axis, resolution_of};

use crate::stats::Thinned;

/// Largest number of values examined, evenly distributed over a channel (of a long one at least
/// half as many).
const MAX_VALUES: usize = 1 << 12;
/// Tables with fewer rows contain means, whose differences are not steps.
const MIN_ROWS: u64 = 40;
/// Relative difference up to which values are equal: 9.81 − 9.80 is not exactly 0.01 in binary,
/// and 32-bit floats computed differently differ in their last bit.
const SAME: f64 = 3e-7;

/// Variance of rounding to these steps, all axes together.
pub(crate) fn floors(step: &[f64]) -> f64 {
    step.iter()
        .map(|q| gravical_core::rounding::floor(*q))
        .sum()
}

/// Values of `N` axes from which their resolution is computed.
#[derive(Debug, Clone)]
pub(crate) struct AxisValues<const N: usize> {
    rows: u64,
    some: Thinned<[f64; N], MAX_VALUES>,
    /// The first value of each axis, the smallest distance of another value from it, and the
    /// number of other values.
    first: [f64; N],
    least: [f64; N],
    others: [u32; N],
    /// Some axes change so rarely that all rows must be examined.
    rarely_changes: bool,
}

/// Number of values other than the first after which the stored ones are sufficient.
const ENOUGH: u32 = 1 << 12;

impl<const N: usize> Default for AxisValues<N> {
    fn default() -> Self {
        AxisValues {
            rows: 0,
            some: Thinned::default(),
            first: [f64::NAN; N],
            least: [f64::INFINITY; N],
            others: [0; N],
            rarely_changes: true,
        }
    }
}

impl<const N: usize> AxisValues<N> {
    /// Adds the next values; NaN if there is none.
    #[inline]
    pub fn observe(&mut self, values: [f64; N]) {
        self.rows += 1;
        self.some.push_with(|| values);
        if self.rarely_changes {
            self.observe_all(values);
        }
    }

    #[inline(never)]
    fn observe_all(&mut self, values: [f64; N]) {
        for (i, v) in values.into_iter().enumerate() {
            if self.first[i].is_nan() {
                self.first[i] = v;
            }
            let off = (v - self.first[i]).abs();
            if off > SAME * self.first[i].abs() {
                self.least[i] = self.least[i].min(off);
                self.others[i] += 1;
            }
        }
        // An axis without values never changes.
        let open = |i: usize| self.others[i] < ENOUGH && !self.first[i].is_nan();
        self.rarely_changes = (0..N).any(open) || self.rows < MIN_ROWS;
    }

    fn axis(&self, i: usize) -> Axis {
        let values = self.some.items().iter().map(|values| values[i]);
        Axis {
            rows: self.rows as usize,
            some: values.filter(|v| v.is_finite()).collect(),
            least: self.least[i],
        }
    }

    /// The resolution of three axes, from `from` on; 0 if unknown.
    pub fn resolution(&self, from: usize) -> [f64; 3] {
        resolution_of([0, 1, 2].map(|i| self.axis(from + i)))
    }
}
