//! Stances of a walking foot.

use std::ops::Range;

use crate::samples::Samples;

/// Window of the root mean square of the rate, s: a stance lasts 0.3 s and more.
const WINDOW_S: f64 = 0.1;
/// A swing turns faster than this, rad/s: a foot reaches 5 to 10.
const MIN_SWING_RAD_S: f64 = 2.5;
/// What the specific force of a stance differs from gravity at most, m/s².
const MAX_FORCE_MISFIT_MPS2: f64 = 2.0;
/// Stances of a walk between two rests: a hand that turns to and fro looks like one.
const MIN_STANCES: usize = 3;

/// A foot that stands between steps is in stance every so often, s, while it turns less than this, rad/s.
const STANDING_S: f64 = 0.5;
const MAX_STANDING_RAD_S: f64 = 0.06;

/// The quietest sample since `first`.
struct Stance {
    first: usize,
    sample: usize,
    rate: f64,
}

/// Samples at which a foot stands: between two swings the one where the angular rate is least (angular
/// rate energy detector, Skog et al. 2010, doi 10.1109/TBME.2010.2060723), below `max_rate_rad_s`; none
/// near `rests`, which say the same, and none where there are fewer than three between two rests.
pub(crate) fn detect_stances(
    samples: &Samples,
    rests: &[Range<usize>],
    max_rate_rad_s: f64,
) -> Vec<usize> {
    let size = samples.count_in(WINDOW_S).max(3);
    let Some(rest) = rests
        .first()
        .filter(|_| samples.has_gyro() && max_rate_rad_s > 0.0)
    else {
        return Vec::new();
    };
    let mean = samples.channels().mean(rest);
    let gravity = norm(&[mean[0], mean[1], mean[2]]);
    let square = |i: usize| samples.rate[i].iter().map(|w| w * w).sum::<f64>();
    let standing_len = samples.count_in(STANDING_S).max(size);
    let mut stances = Vec::new();
    let mut quietest = None::<Stance>;
    let mut swung = false;
    let mut sum: f64 = (0..size.min(samples.len())).map(square).sum();
    for i in size..samples.len() {
        let middle = i - size / 2;
        let rate = (sum / size as f64).max(0.0).sqrt();
        let force = (norm(&samples.force[middle]) - gravity).abs();
        if norm(&samples.rate[middle]) > MIN_SWING_RAD_S {
            stances.extend(quietest.take().map(|q| q.sample));
            swung = true;
        } else if swung && rate < max_rate_rad_s && force < MAX_FORCE_MISFIT_MPS2 {
            // Who stands between two steps stands all the time.
            let over =
                |q: &mut Stance| rate < MAX_STANDING_RAD_S && middle - q.first > standing_len;
            stances.extend(quietest.take_if(over).map(|q| q.sample));
            let first = quietest.as_ref().map_or(middle, |q| q.first);
            if quietest.as_ref().is_none_or(|q| rate < q.rate) {
                quietest = Some(Stance {
                    first,
                    sample: middle,
                    rate,
                });
            }
        }
        sum += square(i) - square(i - size);
    }
    stances.extend(quietest.map(|q| q.sample));
    let after = |i: usize| rests.partition_point(|r| r.end + size <= i);
    stances.retain(|i| rests.get(after(*i)).is_none_or(|r| r.start > i + size));
    let walks = stances.chunk_by(|a, b| after(*a) == after(*b));
    walks
        .filter(|w| w.len() >= MIN_STANCES)
        .flatten()
        .copied()
        .collect()
}

fn norm(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
