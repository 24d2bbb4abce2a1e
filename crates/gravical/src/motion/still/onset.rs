//! When a motion began: a ramp in all channels at once.

use gravical_core::still::CHANNELS;

use super::view::{Six, View};

/// The onset τ, as a place of the view, of the motion that was noticed at `alarm`:
/// of all τ in the last `length` samples the one at which the ramps
/// s_c (t − τ)₊, fitted to what every channel is off the mean at rest, take most
/// of the squares away, each channel by its variance.
///
/// The gain of a channel is (Σ y u)²/Σ u²/σ², u = t − τ. Going back in τ both
/// sums follow from those of the next one, so the search is linear.
pub(super) fn onset(
    view: &View<'_>,
    alarm: usize,
    length: usize,
    rest: &Six,
    variance: &Six,
) -> usize {
    let from = (alarm + 1).saturating_sub(length);
    let mut total = [0.0; CHANNELS];
    let mut moment = [0.0; CHANNELS];
    let mut squares = 0.0;
    let mut best = (f64::NEG_INFINITY, alarm);
    for tau in (from..alarm).rev() {
        // Every sample after τ is now one further from it; the one at τ + 1
        // joins with u = 1.
        let next = view.at(tau + 1);
        let count = (alarm - tau) as f64;
        squares += count * count;
        let mut gain = 0.0;
        for c in 0..CHANNELS {
            total[c] += next[c] - rest[c];
            moment[c] += total[c];
            gain += moment[c] * moment[c] / variance[c];
        }
        gain /= squares;
        if gain > best.0 {
            best = (gain, tau);
        }
    }
    best.1
}
