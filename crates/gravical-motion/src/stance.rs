//! Stances of a walking foot.

use std::ops::Range;

use crate::samples::Samples;

/// Window of the root mean square of the rate, s: a stance lasts 0.3 s and more.
const WINDOW_S: f64 = 0.1;
/// A swing turns faster than this, rad/s: a foot reaches 5 to 10.
const MIN_SWING_RAD_S: f64 = 2.5;
/// What the specific force of a stance differs from gravity at most, m/s².
const MAX_FORCE_MISFIT_MPS2: f64 = 2.0;
/// Swings of a walk between two rests: a hand that turns to and fro looks like one.
const MIN_SWINGS: usize = 3;
/// A foot that stands between steps is in stance every so often, s, while it turns less than this, rad/s.
const STANDING_S: f64 = 0.5;
const MAX_STANDING_RAD_S: f64 = 0.06;

/// The quietest sample since `first`.
struct Stance {
    first: usize,
    sample: usize,
    rate: f64,
    /// Number of the swing before it.
    swing: usize,
}

/// Samples at which a foot stands: between two swings the one where the angular rate is least (angular
/// rate energy detector, Skog et al. 2010, doi 10.1109/TBME.2010.2060723), below `max_rate_rad_s`, and
/// more of them while it stands there; none near `rests`, which say the same, and none where it swings
/// fewer than three times between two rests.
pub(crate) fn detect_stances(
    samples: &Samples,
    rests: &[Range<usize>],
    max_rate_rad_s: f64,
) -> Vec<usize> {
    let usable = samples.has_gyro() && max_rate_rad_s > 0.0;
    let Some(rest) = rests.first().filter(|_| usable) else {
        return Vec::new();
    };
    let size = samples.count_in(WINDOW_S).max(3);
    let mean = samples.channels().mean(rest);
    let gravity = norm(&[mean[0], mean[1], mean[2]]);
    let mut stances = quietest_moments(samples, size, gravity, max_rate_rad_s);
    let leg = |s: &Stance| rests.partition_point(|r| r.end + size <= s.sample);
    stances.retain(|s| rests.get(leg(s)).is_none_or(|r| r.start > s.sample + size));
    let (mut kept, mut last_step) = (Vec::new(), None);
    for walk in stances.chunk_by(|a, b| leg(a) == leg(b)) {
        let swings = walk.chunk_by(|a, b| a.swing == b.swing).count();
        // After its last step a foot stands.
        if swings >= MIN_SWINGS || walk.iter().all(|s| Some(s.swing) == last_step) {
            last_step = walk.last().map(|s| s.swing);
            kept.extend(walk.iter().map(|s| s.sample));
        }
    }
    kept
}

/// Where the rate over `size` samples is least after each swing.
fn quietest_moments(
    samples: &Samples,
    size: usize,
    gravity: f64,
    max_rate_rad_s: f64,
) -> Vec<Stance> {
    let square = |i: usize| samples.rate[i].iter().map(|w| w * w).sum::<f64>();
    let standing_len = samples.count_in(STANDING_S).max(size);
    let mut stances = Vec::new();
    let (mut swing, mut quietest) = (0, None::<Stance>);
    let mut sum: f64 = (0..size.min(samples.len())).map(square).sum();
    for i in size..samples.len() {
        let sample = i - size / 2;
        let rate = (sum / size as f64).max(0.0).sqrt();
        let force = (norm(&samples.force[sample]) - gravity).abs();
        if norm(&samples.rate[sample]) > MIN_SWING_RAD_S {
            swing += usize::from(swing == 0 || quietest.is_some());
            stances.extend(quietest.take());
        } else if swing > 0 && rate < max_rate_rad_s && force < MAX_FORCE_MISFIT_MPS2 {
            let stands = rate < MAX_STANDING_RAD_S;
            stances.extend(quietest.take_if(|q| stands && sample - q.first > standing_len));
            if quietest.as_ref().is_none_or(|q| rate < q.rate) {
                let first = quietest.map_or(sample, |q| q.first);
                quietest = Some(Stance {
                    first,
                    sample,
                    rate,
                    swing,
                });
            }
        }
        sum += square(i) - square(i - size);
    }
    stances.extend(quietest);
    stances
}

fn norm(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
