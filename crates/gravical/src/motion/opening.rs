//! Rests and noise, where they are looked for.

use super::options::{GravityRemoval, MotionOptions};
use super::samples::Samples;
use super::still::{Rests, find_rests};

/// The rests of a recording; the rows that a mean is over tell the noise where nothing
/// rests. Where nothing but those rows can be a rest, nothing after them is looked at.
pub(super) fn rests(samples: &Samples, options: &MotionOptions) -> Rests {
    if options.rests_at_start() && samples.len() > options.initial_rows {
        return rests(&samples.first(options.initial_rows), options);
    }
    let found = find_rests(samples, options.rests_s.as_deref());
    let last = options.initial_rows.min(samples.len()).checked_sub(1);
    let by_mean = options.gravity_removal == GravityRemoval::InitialMean;
    let (Some(last), true) = (last, found.spans.is_empty() && by_mean) else {
        return found;
    };
    let rows = [(samples.t_s[0], samples.t_s[last])];
    Rests {
        spans: Vec::new(),
        ..find_rests(samples, Some(&rows))
    }
}
