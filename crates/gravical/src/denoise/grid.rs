//! Uneven samples on an even grid and back, for filters that know no other.

/// Steps that are whole multiples of the usual one within this share of it lost
/// samples; others came at uneven times.
const WHOLE_SHARE: f64 = 0.25;

/// Stamps nearer than this share of the usual step are the same.
const SAME_SHARE: f64 = 0.01;

/// How uneven samples got onto an even grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gridded {
    /// The samples stayed; so many lost ones between them were interpolated.
    Filled(usize),
    /// All of them were interpolated.
    Resampled,
    /// Not at all: the grid has fewer samples than the filter takes.
    TooShort,
}

/// Runs `filter` over samples at `time_s` (rising, some may be equal) as if they were
/// `step_s` apart.
///
/// Where every step is a whole multiple of `step_s`, the lost samples are put in by
/// linear interpolation. Elsewhere the samples are interpolated linearly to an even
/// grid and the result back to the stamps; that alone smooths: white noise to 0.61 of
/// its standard deviation where the grid falls midway between samples. A grid of fewer than
/// `shortest` samples changes nothing.
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

/// The place of each sample on a grid of `step_s`, where all have one.
fn places(time_s: &[f64], step_s: f64) -> Option<Vec<usize>> {
    let mut places = Vec::with_capacity(time_s.len());
    let mut place = 0;
    places.push(place);
    for pair in time_s.windows(2) {
        let steps = (pair[1] - pair[0]) / step_s;
        let off = (steps - steps.round()).abs();
        // Two samples in one place are one that was read twice, or they are two.
        if off > WHOLE_SHARE || (steps > SAME_SHARE && steps.round() < 1.0) {
            return None;
        }
        place += steps.round() as usize;
        places.push(place);
    }
    Some(places)
}

/// The samples at their places, what is missing between them on a line.
fn filled(places: &[usize], x: &[f64], count: usize) -> Vec<f64> {
    let places: Vec<f64> = places.iter().map(|p| *p as f64).collect();
    let (stamps, values) = distinct(&places, x);
    interpolated(&stamps, &values, (0..count).map(|k| k as f64))
}

/// Each stamp once, with the mean of its samples.
fn distinct(time_s: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut stamps, mut means) = (Vec::with_capacity(x.len()), Vec::with_capacity(x.len()));
    let mut from = 0;
    while from < x.len() {
        let same = time_s[from..]
            .iter()
            .take_while(|t| **t == time_s[from])
            .count();
        // A stamp equals itself.
        let to = from + same.max(1);
        stamps.push(time_s[from]);
        means.push(x[from..to].iter().sum::<f64>() / (to - from) as f64);
        from = to;
    }
    (stamps, means)
}

/// Values at rising times on the line between their neighbours; beyond the ends the
/// value there.
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
    fn lost_samples_are_put_in_and_the_others_stay() {
        let time = [0.0, 0.01, 0.02, 0.0501, 0.06, 0.06];
        let mut x = [1.0, 2.0, 3.0, 6.0, 7.0, 9.0];
        let mut seen = Vec::new();
        let how = on_grid(&time, 0.01, 1, &mut [&mut x], |even| seen = even.to_vec());
        assert_eq!(how, Gridded::Filled(2));
        assert_eq!(seen, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]);
        assert_eq!(x, [1.0, 2.0, 3.0, 6.0, 8.0, 8.0]);
    }

    #[test]
    fn a_grid_that_is_too_short_changes_nothing() {
        for time in [[0.0; 5], [0.0, 0.0, 0.004, 0.004, 0.01]] {
            let mut x = [1.0, 2.0, 3.0, 4.0, 5.0];
            let how = on_grid(&time, 0.01, 4, &mut [&mut x], |_| {
                panic!("nothing to filter")
            });
            assert_eq!((how, x), (Gridded::TooShort, [1.0, 2.0, 3.0, 4.0, 5.0]));
        }
    }

    #[test]
    fn a_line_stays_a_line_on_any_grid() {
        let time: Vec<f64> = (0..50)
            .map(|i| 0.01 * f64::from(i) + 0.004 * f64::from(i % 3))
            .collect();
        let line: Vec<f64> = time.iter().map(|t| 9.8 - 3.0 * t).collect();
        let mut x = line.clone();
        let how = on_grid(&time, 0.01, 1, &mut [&mut x], |_| {});
        assert_eq!(how, Gridded::Resampled);
        // The last grid point may lie beyond the last stamp.
        for (a, b) in x.iter().zip(&line).take(49) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
