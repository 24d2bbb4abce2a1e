//! Interpolation of uneven samples to an even grid and back, for filters that need one.

/// Steps that are whole multiples of the usual one within this share are due to lost samples;
/// others are uneven sampling.
const WHOLE_SHARE: f64 = 0.25;

/// Time stamps that differ by less than this share of the usual step are equal.
const SAME_SHARE: f64 = 0.01;

/// How uneven samples were put on an even grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gridded {
    /// Lost samples between the others were interpolated: their number.
    Filled(usize),
    /// All samples were interpolated.
    Resampled,
    /// Not at all: the grid has fewer samples than the filter needs.
    TooShort,
}

/// Runs `filter` over samples at the non-decreasing times `time_s` as if they were `step_s`
/// apart.
///
/// If every step is a whole multiple of `step_s`, the lost samples are added by linear
/// interpolation. Otherwise the samples are interpolated linearly to an even grid and the result
/// back to the time stamps. This alone smooths: white noise to 0.61 of its standard deviation if
/// the grid is midway between the samples. With a grid of fewer than `shortest` samples nothing
/// is changed.
pub(super) fn on_grid(
    time_s: &[f64],
    step_s: f64,
    shortest: usize,
    channels: &mut [&mut [f64]],
    mut filter: impl FnMut(&mut [f64]),
) -> Gridded {
    if let Some(places) = places(time_s, step_s) {
        let count = places.last().map_or(0, |last| last + 1);
        if count < shortest {
            return Gridded::TooShort;
        }
        for x in channels.iter_mut() {
            let mut even = filled(&places, x, count);
            filter(&mut even);
            for (value, place) in x.iter_mut().zip(&places) {
                *value = even[*place];
            }
        }
        let mut there = places;
        there.dedup();
        return Gridded::Filled(count - there.len());
    }
    let start = time_s[0];
    let span = time_s[time_s.len() - 1] - start;
    let count = (span / step_s).ceil() as usize + 1;
    if count < shortest {
        return Gridded::TooShort;
    }
    for x in channels.iter_mut() {
        let (stamps, means) = distinct(time_s, x);
        let mut even = interpolated(
            &stamps,
            &means,
            (0..count).map(|k| start + k as f64 * step_s),
        );
        filter(&mut even);
        let grid: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let back = interpolated(&grid, &even, time_s.iter().map(|t| (t - start) / step_s));
        x.copy_from_slice(&back);
    }
    Gridded::Resampled
}

/// The index of each sample on a grid of `step_s`, if all samples are on it.
fn places(time_s: &[f64], step_s: f64) -> Option<Vec<usize>> {
    let mut places = Vec::with_capacity(time_s.len());
    let mut place = 0;
    places.push(place);
    for pair in time_s.windows(2) {
        let steps = (pair[1] - pair[0]) / step_s;
        let off = (steps - steps.round()).abs();
        // Two samples with one index must have equal time stamps.
        if off > WHOLE_SHARE || (steps > SAME_SHARE && steps.round() < 1.0) {
            return None;
        }
        place += steps.round() as usize;
        places.push(place);
    }
    Some(places)
}

/// The samples at their indices, with linear interpolation between them.
fn filled(places: &[usize], x: &[f64], count: usize) -> Vec<f64> {
    let places: Vec<f64> = places.iter().map(|p| *p as f64).collect();
    let (stamps, values) = distinct(&places, x);
    interpolated(&stamps, &values, (0..count).map(|k| k as f64))
}

/// Each time stamp once, with the mean of its samples.
fn distinct(time_s: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut stamps, mut means) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
    let mut from = 0;
    while from < x.len() {
        let same = time_s[from..]
            .iter()
            .take_while(|t| **t == time_s[from])
            .count();
        // At least one sample.
        let to = from + same.max(1);
        stamps.push(time_s[from]);
        means.push(x[from..to].iter().sum::<f64>() / (to - from) as f64);
        from = to;
    }
    (stamps, means)
}

/// Linear interpolation at ascending times; constant beyond the ends.
fn interpolated(stamps: &[f64], values: &[f64], at: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut after = 0;
    at.map(|t| {
        while after < stamps.len() && stamps[after] <= t {
            after += 1;
        }
        match (after.checked_sub(1), stamps.get(after)) {
            (None, _) => values[0],
            (Some(i), None) => values[i],
            (Some(i), Some(next)) => {
                let share = (t - stamps[i]) / (next - stamps[i]);
                values[i] + share * (values[i + 1] - values[i])
            }
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_samples_are_interpolated() {
        let time = [0.0, 0.01, 0.02, 0.0501, 0.06, 0.06];
        let mut x = [1.0, 2.0, 3.0, 6.0, 7.0, 9.0];
        let mut seen = Vec::new();
        let how = on_grid(&time, 0.01, 1, &mut [&mut x], |even| seen = even.to_vec());
        assert_eq!(how, Gridded::Filled(2));
        assert_eq!(seen, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]);
        assert_eq!(x, [1.0, 2.0, 3.0, 6.0, 8.0, 8.0]);
    }

    #[test]
    fn too_short_a_grid_changes_nothing() {
        for time in [[0.0; 5], [0.0, 0.0, 0.004, 0.004, 0.01]] {
            let mut x = [1.0, 2.0, 3.0, 4.0, 5.0];
            let how = on_grid(&time, 0.01, 4, &mut [&mut x], |_| {
                panic!("nothing to filter")
            });
            assert_eq!((how, x), (Gridded::TooShort, [1.0, 2.0, 3.0, 4.0, 5.0]));
        }
    }

    #[test]
    fn a_line_is_unchanged_by_resampling() {
        let time: Vec<f64> = (0..50)
            .map(|i| 0.01 * f64::from(i) + 0.004 * f64::from(i % 3))
            .collect();
        let line: Vec<f64> = time.iter().map(|t| 9.8 - 3.0 * t).collect();
        let mut x = line.clone();
        let how = on_grid(&time, 0.01, 1, &mut [&mut x], |_| {});
        assert_eq!(how, Gridded::Resampled);
        // The last grid point may be after the last time stamp.
        for (a, b) in x.iter().zip(&line).take(49) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
