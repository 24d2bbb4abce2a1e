//! How far the clock of a reference is from the recording's: where the two
//! speeds are most alike.
//!
//! Speed over a bin is the distance between the positions at its ends, of both
//! tracks alike. Their correlation coefficient over the bins that both have is
//! computed for every lag, first with wide bins, then around the best lag with
//! narrower ones, and a parabola through the best three gives the fraction.

use super::line::Line;

/// Bins of one track in the widest pass.
const COARSE_BINS: f64 = 2048.0;

/// Bins are not narrower than this, s: below it the noise of a camera (0.1 mm)
/// makes more speed than a slow motion has.
const NARROWEST_S: f64 = 0.02;

/// Share of the bins of the shorter track that have to overlap.
const OVERLAP: f64 = 0.3;

/// Bins of the narrow passes: more than these make nothing clearer.
const MOST_BINS: usize = 200_000;

/// A lag and how alike the speeds are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// To be added to the reference's time, s.
    pub offset_s: f64,
    /// Correlation coefficient of the speeds.
    pub correlation: f64,
}

/// The offset; none where one of the two does not move, or both are too short.
pub(super) fn find(result: &Line<'_>, reference: &Line<'_>) -> Option<Found> {
    let (from, to) = result.range()?;
    let (other_from, other_to) = reference.range()?;
    let longest = (to - from).max(other_to - other_from);
    let finest = result.median_step_s().max(reference.median_step_s());
    let finest = finest.max(NARROWEST_S).max(longest / MOST_BINS as f64);
    let mut bin_s = finest.max(longest / COARSE_BINS);
    // Both start at their own bin 0; the lag in bins is what is looked for.
    let base = from - other_from;
    let (own, other) = (speeds(result, bin_s), speeds(reference, bin_s));
    let span = -(other.len() as i64)..=own.len() as i64;
    let (mut lag, mut correlation) = best(&own, &other, span)?;
    while bin_s > finest {
        let narrower = (0.25 * bin_s).max(finest);
        let middle = (lag as f64 * bin_s / narrower).round() as i64;
        let reach = (1.5 * bin_s / narrower).ceil() as i64;
        bin_s = narrower;
        let (own, other) = (speeds(result, bin_s), speeds(reference, bin_s));
        (lag, correlation) = best(&own, &other, middle - reach..=middle + reach)?;
    }
    let (own, other) = (speeds(result, bin_s), speeds(reference, bin_s));
    let fraction = match (alike(&own, &other, lag - 1), alike(&own, &other, lag + 1)) {
        (Some(before), Some(after)) => {
            let curvature = before - 2.0 * correlation + after;
            if curvature < 0.0 {
                (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
            } else {
                0.0
            }
        }
        _ => 0.0,
    };
    Some(Found {
        offset_s: base + (lag as f64 + fraction) * bin_s,
        correlation,
    })
}

/// Mean speed in bins from the first point on; NaN where the track has a gap.
fn speeds(line: &Line<'_>, bin_s: f64) -> Vec<f64> {
    let Some((from, to)) = line.range() else {
        return Vec::new();
    };
    let bins = ((to - from) / bin_s)
        .floor()
        .clamp(0.0, 4.0 * MOST_BINS as f64) as usize;
    let mut walk = line.walk(bin_s);
    let mut before = walk.at(from);
    (1..=bins)
        .map(|i| {
            let here = walk.at(from + i as f64 * bin_s);
            let speed = match (before, here) {
                (Some(a), Some(b)) => {
                    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
                    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() / bin_s
                }
                _ => f64::NAN,
            };
            before = here;
            speed
        })
        .collect()
}

fn best(own: &[f64], other: &[f64], lags: std::ops::RangeInclusive<i64>) -> Option<(i64, f64)> {
    lags.filter_map(|lag| Some((lag, alike(own, other, lag)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Correlation coefficient of `own[i + lag]` and `other[i]`.
fn alike(own: &[f64], other: &[f64], lag: i64) -> Option<f64> {
    let skip_own = usize::try_from(lag).unwrap_or(0);
    let skip_other = usize::try_from(-lag).unwrap_or(0);
    let (mut n, mut sa, mut sb, mut saa, mut sbb, mut sab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (a, b) in own.iter().skip(skip_own).zip(other.iter().skip(skip_other)) {
        if a.is_finite() && b.is_finite() {
            n += 1.0;
            sa += a;
            sb += b;
            saa += a * a;
            sbb += b * b;
            sab += a * b;
        }
    }
    let shorter = own.len().min(other.len()) as f64;
    if n < (OVERLAP * shorter).max(8.0) {
        return None;
    }
    let (va, vb) = (saa - sa * sa / n, sbb - sb * sb / n);
    // What rounding leaves of a constant is no variance.
    if va <= 1e-12 * saa || vb <= 1e-12 * sbb {
        return None;
    }
    Some((sab - sa * sb / n) / (va * vb).sqrt())
}
