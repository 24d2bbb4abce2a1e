//! When a motion began: a ramp in all channels at once.

use super::CHANNELS;
use crate::Real;

/// The onset τ of the motion that was noticed at sample `alarm`, a number of a
/// sample: of all τ in the last `length` samples the one at which the ramps
/// s_c (t − τ)₊, fitted to what every channel is off its mean at rest, take most
/// of the squares away, each channel by its variance.
///
/// The gain of a channel is (Σ y u)²/(σ² Σ u²), u = t − τ, y the reading less
/// `rest`. Going back in τ both sums follow from those of the next one, so the
/// search is linear. `at` gives the sample of a number, from `alarm` back to
/// `alarm` + 1 − `length`.
pub fn onset<T: Real>(
    alarm: usize,
    length: usize,
    rest: &[T; CHANNELS],
    variance: &[T; CHANNELS],
    at: impl Fn(usize) -> [T; CHANNELS],
) -> usize {
    let from = (alarm + 1).saturating_sub(length);
    let mut total = [T::zero(); CHANNELS];
    let mut moment = [T::zero(); CHANNELS];
    let mut squares = T::zero();
    let mut best = (T::neg_infinity(), alarm);
    for tau in (from..alarm).rev() {
        // Every sample after τ is now one further from it; the one at τ + 1
        // joins with u = 1.
        let next = at(tau + 1);
        let count = T::from_f64((alarm - tau) as f64);
        squares = squares + count * count;
        let mut gain = T::zero();
        for c in 0..CHANNELS {
            total[c] = total[c] + (next[c] - rest[c]);
            moment[c] = moment[c] + total[c];
            gain = gain + moment[c] * moment[c] / variance[c];
        }
        gain = gain / squares;
        if gain > best.0 {
            best = (gain, tau);
        }
    }
    best.1
}
