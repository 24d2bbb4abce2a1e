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
    let low = |order, cutoff_hz, rate_hz, count| {
        low_pass(
            order,
            cutoff_hz,
            rate_hz,
            &mut vec![Biquad::<f64>::default(); count],
        )
    };
    let band = |order, low_hz, high_hz, count| {
        band_pass(
            order,
            low_hz,
            high_hz,
            100.0,
            &mut vec![Biquad::<f64>::default(); count],
        )
    };
    assert_eq!(low(0, 5.0, 100.0, 1), Err(Order { order: 0 }));
    assert_eq!(low(9, 5.0, 100.0, 5), Err(Order { order: 9 }));
    assert_eq!(low(3, 5.0, 100.0, 1), Err(Sections { needed: 2 }));
    assert_eq!(band(4, 5.0, 9.0, 2), Err(Sections { needed: 4 }));
    for wrong in [0.0, -1.0, 50.0, 70.0, f64::NAN, f64::INFINITY] {
        assert_eq!(low(2, wrong, 100.0, 1), Err(Cutoff), "{wrong}");
        assert_eq!(low(2, 5.0, wrong.min(0.0), 1), Err(Cutoff), "{wrong}");
    }
    assert_eq!(band(1, 9.0, 5.0, 1), Err(Cutoff));
    assert_eq!(band(1, 5.0, 5.0, 1), Err(Cutoff));
}
