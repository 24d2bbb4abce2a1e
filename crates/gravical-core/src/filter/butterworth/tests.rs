use super::*;
use crate::filter::biquad::settle;
use std::vec;

/// What low cutoffs cost, as the head of this file says.
#[test]
fn single_precision_is_near() {
    let mut double = [Biquad::<f64>::default(); 2];
    let mut single = [Biquad::<f32>::default(); 2];
    for rate_hz in [90.0_f32, 95.0, 100.0, 103.0, 110.0] {
        low_pass(4, 1.0, rate_hz, &mut single).unwrap();
        let off = settle(&mut single, 1.0) - 1.0;
        assert!(off.abs() < 1e-4, "{rate_hz}: {off:e}");
        let rate_hz = 10.0 * f64::from(rate_hz);
        low_pass(4, 1.0, rate_hz, &mut double).unwrap();
        let off = settle(&mut double, 1.0) - 1.0;
        assert!(off.abs() < 1e-11, "{rate_hz}: {off:e}");
    }
}

#[test]
fn what_cannot_be_had() {
    use DesignError::*;
    let filter = |count| vec![Biquad::<f64>::default(); count];
    for (order, cutoff_hz, rate_hz, count, error) in [
        (0, 5.0, 100.0, 1, Order { order: 0 }),
        (9, 5.0, 100.0, 5, Order { order: 9 }),
        (3, 5.0, 100.0, 1, Sections { needed: 2 }),
        (2, 0.0, 100.0, 1, Cutoff),
        (2, -1.0, 100.0, 1, Cutoff),
        (2, 50.0, 100.0, 1, Cutoff),
        (2, f64::NAN, 100.0, 1, Cutoff),
        (2, f64::INFINITY, 100.0, 1, Cutoff),
        (2, 5.0, 0.0, 1, Cutoff),
        (2, 5.0, f64::NAN, 1, Cutoff),
    ] {
        let refused = low_pass(order, cutoff_hz, rate_hz, &mut filter(count));
        assert_eq!(refused, Err(error), "{cutoff_hz} Hz at {rate_hz} Hz");
    }
    for (order, low_hz, high_hz, count, error) in [
        (4, 5.0, 9.0, 2, Sections { needed: 4 }),
        (1, 9.0, 5.0, 1, Cutoff),
        (1, 5.0, 5.0, 1, Cutoff),
    ] {
        let refused = band_pass(order, low_hz, high_hz, 100.0, &mut filter(count));
        assert_eq!(refused, Err(error), "{low_hz} to {high_hz} Hz");
    }
}
