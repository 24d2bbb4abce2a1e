//! Removal of intervals in which the sensor turns evenly.

use std::ops::Range;

use crate::stats::weighted_median;

use super::{distance, moments};

/// Removes intervals in which the sensor turns. If the sensor rests most of the time, the median
/// rate is the bias: starting at the interval with the rate nearest to the median, forwards and
/// backwards, each interval must have the rate of the previous one within `most`.
///
/// Fails if the sensor turns evenly, at one rate, for longer than it rests.
pub(super) fn without_turning(
    gyro: &[Vec<f64>; 3],
    most: f64,
    spans: Vec<Range<usize>>,
) -> Vec<Range<usize>> {
    let rates: Vec<[f64; 3]> = spans.iter().map(|s| moments(gyro, s.clone()).0).collect();
    let middle: [f64; 3] = std::array::from_fn(|axis| {
        let all = rates.iter().zip(&spans);
        let mut all: Vec<(f64, f64)> = all.map(|(r, s)| (r[axis], s.len() as f64)).collect();
        weighted_median(&mut all).unwrap_or(f64::NAN)
    });
    let nearest = (0..spans.len())
        .filter(|k| distance(rates[*k], middle).is_finite())
        .min_by(|a, b| distance(rates[*a], middle).total_cmp(&distance(rates[*b], middle)));
    // Without a gyroscope turns cannot be detected.
    let Some(nearest) = nearest else {
        return spans;
    };
    let mut rests = vec![true; spans.len()];
    let mut follow = |order: &mut dyn Iterator<Item = usize>| {
        let mut last = rates[nearest];
        // Intervals without gyroscope values are kept.
        for k in order {
            let step = distance(rates[k], last);
            if step > most {
                rests[k] = false;
            } else if step.is_finite() {
                last = rates[k];
            }
        }
    };
    follow(&mut (nearest + 1..spans.len()));
    follow(&mut (0..nearest).rev());
    let kept = spans.into_iter().zip(rests);
    kept.filter_map(|(span, rests)| rests.then_some(span))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices of the remaining intervals, of 100 rows each with these rates about z.
    fn left(rates: &[f64]) -> Vec<usize> {
        let z = rates.iter().flat_map(|r| vec![*r; 100]).collect();
        let gyro = [
            vec![0.0; 100 * rates.len()],
            vec![0.1; 100 * rates.len()],
            z,
        ];
        let spans = (0..rates.len()).map(|k| 100 * k..100 * k + 100).collect();
        let left = without_turning(&gyro, 0.6, spans);
        left.iter().map(|s| s.start / 100).collect()
    }

    #[test]
    fn turns_are_removed_and_bias_drift_is_not() {
        assert_eq!(left(&[0.2, 0.1, 9.0, 0.2, -9.0, -9.0, 0.1]), [0, 1, 3, 6]);
        // Between consecutive intervals the drift is less than a turn.
        assert_eq!(left(&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5]).len(), 6);
        assert_eq!(left(&[0.1, f64::NAN, 0.1, 5.0]), [0, 1, 2]);
        assert_eq!(left(&[f64::NAN]), [0]);
        assert!(left(&[]).is_empty());
    }
}
