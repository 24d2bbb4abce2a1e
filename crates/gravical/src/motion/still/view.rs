//! The samples of one piece, forwards or backwards, as six channels.

use std::ops::Range;

use gravical_core::still::CHANNELS;

use crate::motion::samples::Samples;

/// Six values: specific force, then angular rate.
pub(super) type Six = [f64; CHANNELS];

/// One piece of the samples, read from its first to its last or the other way.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    samples: &'a Samples,
    start: usize,
    len: usize,
    backwards: bool,
}

impl<'a> View<'a> {
    pub(super) fn new(samples: &'a Samples, piece: &Range<usize>, backwards: bool) -> Self {
        View {
            samples,
            start: piece.start,
            len: piece.len(),
            backwards,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Sample of the recording at a place of the view, which is below `len`.
    #[inline]
    pub(super) fn sample(&self, at: usize) -> usize {
        if self.backwards {
            self.start + self.len - 1 - at
        } else {
            self.start + at
        }
    }

    /// Samples of the recording, in their order there.
    pub(super) fn range(&self, places: Range<usize>) -> Range<usize> {
        if self.backwards {
            let end = self.start + self.len;
            end - places.end..end - places.start
        } else {
            self.start + places.start..self.start + places.end
        }
    }

    #[inline]
    pub(super) fn at(&self, at: usize) -> Six {
        let i = self.sample(at);
        six(self.samples, i)
    }

    /// Mean over places.
    pub(super) fn mean(&self, places: Range<usize>) -> Six {
        mean_of(self.samples, self.range(places))
    }
}

#[inline]
pub(super) fn six(samples: &Samples, i: usize) -> Six {
    let [a, b, c] = samples.force_at(i);
    let [d, e, f] = samples.rate_at(i);
    [a, b, c, d, e, f]
}

/// One of the six channels; none for the gyroscope that is not there.
pub(super) fn channel(samples: &Samples, c: usize) -> Option<&[f64]> {
    if c < 3 {
        Some(&samples.force_mps2[c])
    } else {
        samples
            .rate_rad_s
            .as_ref()
            .map(|rate| rate[c - 3].as_slice())
    }
}

pub(super) fn mean_of(samples: &Samples, range: Range<usize>) -> Six {
    std::array::from_fn(|c| {
        channel(samples, c).map_or(0.0, |values| {
            let part = &values[range.clone()];
            let first = part.first().copied().unwrap_or(0.0);
            // Less the first one, which keeps the digits under gravity.
            let sum: f64 = part.iter().map(|v| v - first).sum();
            first + sum / part.len().max(1) as f64
        })
    })
}
