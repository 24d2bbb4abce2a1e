//! Stances of a walking foot: between two swings the sample where the angular rate is least (angular rate
//! energy detector, Skog et al. 2010, doi 10.1109/TBME.2010.2060723), and more of them while it stands there.

use std::ops::Range;

use gravical_signal::Samples;

/// Window of the root mean square of the rate, s.
const WINDOW_S: f64 = 0.1;
/// Duration of a stance of a walk at least, s, its rate slower than that of a foot in stance throughout: a hand that
/// turns back does so for less.
const MIN_STANCE_S: f64 = 0.3;
/// A swing turns faster than this, rad/s: a foot reaches 5 to 10.
const MIN_SWING_RAD_S: f64 = 2.5;
/// A foot in stance turns slower, rad/s.
const MAX_STANCE_RAD_S: f64 = 1.0;
/// What the specific force of a stance differs from gravity at most, m/s².
const MAX_FORCE_MISFIT_MPS2: f64 = 2.0;
/// Swings of a walk between two rests: a hand that turns to and fro looks like one.
const MIN_SWINGS: usize = 3;
/// A foot that stands between steps is in stance every so often, s, while it turns less than this, rad/s.
const STANDING_S: f64 = 0.5;
const MAX_STANDING_RAD_S: f64 = 0.06;

/// A stance.
#[derive(Debug, Clone)]
pub(crate) struct Stance {
    /// The first sample that may be its quietest.
    first: usize,
    /// The quietest.
    pub sample: usize,
    rate: f64,
    /// Number of the swing before it.
    pub swing: usize,
}

/// The stances of the move from sample `from` to `end`: a window away from the rests there, which say the same,
/// and none if they are not those of a foot: it swings often enough, or stands after the last step of the walk
/// before.
pub(crate) fn steps<'a>(
    stances: &'a [Stance],
    samples: &Samples,
    (from, end): (usize, usize),
    last_step: Option<usize>,
) -> &'a [Stance] {
    let size = window_len(samples);
    let first = stances.partition_point(|s| s.sample < from + size);
    let after = stances.partition_point(|s| s.sample.saturating_add(size) < end);
    let stances = stances.get(first..after).unwrap_or_default();
    let swings = stances.chunk_by(|a, b| a.swing == b.swing).count();
    let is_walk = swings >= MIN_SWINGS || stances.iter().all(|s| Some(s.swing) == last_step);
    if is_walk { stances } else { &[] }
}

fn window_len(samples: &Samples) -> usize {
    samples.count_in(WINDOW_S).max(3)
}

/// Where the rate is least after each swing; `rest` says what gravity is.
pub(crate) fn detect_stances(samples: &Samples, rest: &Range<usize>) -> Vec<Stance> {
    let mut found = Vec::new();
    let size = window_len(samples);
    let standing_len = samples.count_in(STANDING_S).max(size);
    let [x, y, z, ..] = samples.mean(rest);
    let gravity = norm(&[x, y, z]);
    let (mut swing, mut sum) = (0, 0.0);
    let mut quietest: Option<Stance> = None;
    for (i, rate) in samples.rate_rad_s.iter().enumerate() {
        if let Some(before) = i.checked_sub(size) {
            // Σ ω² over the window around `sample`.
            let (sample, rms) = (i - size / 2, (sum / size as f64).max(0.0).sqrt());
            let misfit = (norm(&samples.force_mps2[sample]) - gravity).abs();
            if norm(&samples.rate_rad_s[sample]) > MIN_SWING_RAD_S {
                swing += usize::from(swing == 0 || quietest.is_some());
                found.extend(quietest.take());
            } else if swing > 0 && rms < MAX_STANCE_RAD_S && misfit < MAX_FORCE_MISFIT_MPS2 {
                let stands = rms < MAX_STANDING_RAD_S;
                found.extend(quietest.take_if(|q| stands && sample - q.first > standing_len));
                if quietest.as_ref().is_none_or(|q| rms < q.rate) {
                    quietest = Some(Stance {
                        first: quietest.as_ref().map_or(sample, |q| q.first),
                        sample,
                        rate: rms,
                        swing,
                    });
                }
            }
            sum -= norm(&samples.rate_rad_s[before]).powi(2);
        }
        sum += norm(rate).powi(2);
    }
    found.extend(quietest);
    let shortest = samples.count_in(MIN_STANCE_S);
    found.retain(|stance| lasts(&samples.rate_rad_s, stance.sample, shortest));
    found
}

/// The rate around `sample` is that of a stance for so many samples.
fn lasts(rate: &[[f64; 3]], sample: usize, shortest: usize) -> bool {
    let is_stance = |rate: &&[f64; 3]| norm(rate) < MAX_STANCE_RAD_S;
    let (before, after) = rate.split_at(sample);
    let before = before.iter().rev().take(shortest).take_while(is_stance);
    let after = after.iter().take(shortest).take_while(is_stance);
    before.count() + after.count() >= shortest
}

fn norm(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
