//! Stretches that turn evenly are no stills.

use std::ops::Range;

use crate::stats::weighted_median;

use super::{distance, moments};

/// Leaves out stills that turn. Of most of the time at rest the rate is the bias: from
/// the still that reads the median rate onwards, and backwards, each has about the rate
/// of the one before it, within `most`.
///
/// It fails where the sensor turns evenly, at one rate, for longer than it rests.
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
    // Without a rate nothing is known of turning.
    let Some(nearest) = nearest else {
        return spans;
    };
    let mut rests = vec![true; spans.len()];
    let mut follow = |order: &mut dyn Iterator<Item = usize>| {
        let mut last = rates[nearest];
        // Where the gyroscope was not read it tells nothing.
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

    /// Stills of 100 rows at these rates about z; which of them are left.
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
    fn what_turns_is_left_out_and_a_bias_may_drift() {
        assert_eq!(left(&[0.2, 0.1, 9.0, 0.2, -9.0, -9.0, 0.1]), [0, 1, 3, 6]);
        // From one still to the next it drifts by less than a turn.
        assert_eq!(left(&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5]).len(), 6);
        assert_eq!(left(&[0.1, f64::NAN, 0.1, 5.0]), [0, 1, 2]);
        assert_eq!(left(&[f64::NAN]), [0]);
        assert!(left(&[]).is_empty());
    }
}
