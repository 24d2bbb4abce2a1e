//! Filters of the pipeline: causal ones.

use core::fmt::Debug;

use crate::Real;
use crate::filter::biquad::Cascade;
use crate::filter::savgol::SavitzkyGolay;

/// A filter for three channels, sample by sample. It has to keep a constant; what it
/// delays, velocity is late by.
pub trait Smooth<T>: Clone + Debug {
    /// The next sample in, the filtered one out; the first counts as if it had been
    /// there for ever.
    fn update(&mut self, input: [T; 3]) -> [T; 3];
    /// Forgets what was put in.
    fn reset(&mut self);
}

/// No filter.
impl<T: Real> Smooth<T> for () {
    #[inline]
    fn update(&mut self, input: [T; 3]) -> [T; 3] {
        input
    }

    fn reset(&mut self) {}
}

/// One Savitzky–Golay filter for each axis.
impl<T: Real, const W: usize> Smooth<T> for [SavitzkyGolay<T, W>; 3] {
    fn update(&mut self, input: [T; 3]) -> [T; 3] {
        core::array::from_fn(|i| self[i].update(input[i]))
    }

    fn reset(&mut self) {
        self.iter_mut().for_each(SavitzkyGolay::reset);
    }
}

/// A low-pass of second-order sections for each axis; it starts where the first
/// sample is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass<T, const N: usize> {
    axes: [Cascade<T, N>; 3],
    started: bool,
}

impl<T: Real, const N: usize> LowPass<T, N> {
    /// The same filter for each axis.
    #[must_use]
    pub fn new(filter: Cascade<T, N>) -> Self {
        LowPass {
            axes: [filter; 3],
            started: false,
        }
    }
}

impl<T: Real, const N: usize> Smooth<T> for LowPass<T, N> {
    fn update(&mut self, input: [T; 3]) -> [T; 3] {
        let first = !core::mem::replace(&mut self.started, true);
        core::array::from_fn(|i| {
            let axis = &mut self.axes[i];
            if first {
                axis.settle(input[i])
            } else {
                axis.update(input[i])
            }
        })
    }

    fn reset(&mut self) {
        self.started = false;
    }
}
