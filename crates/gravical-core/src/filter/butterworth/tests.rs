use super::*;
use crate::filter::biquad::settle;
use core::f64::consts::{FRAC_1_SQRT_2, PI};
use std::vec;

/// |H| at a share of the rate.
fn gain(filter: &[Biquad<f64>], share: f64) -> f64 {
    let part = |c: &[f64]| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, c) in c.iter().enumerate() {
            let (s, cos) = (2.0 * PI * share * k as f64).sin_cos();
            re += c * cos;
            im -= c * s;
        }
        f64::hypot(re, im)
    };
    filter
        .iter()
        .map(|s| part(&s.forward()) / part(&[1.0, s.back()[0], s.back()[1]]))
        .product()
}

/// |H|² = 1/(1 + x²ⁿ) at any frequency.
fn holds(filter: &[Biquad<f64>], order: usize, x: impl Fn(f64) -> f64) {
    for i in 1..200 {
        let share = f64::from(i) / 400.0;
        let omega = (PI * share).tan();
        let want = 1.0 / (1.0 + x(omega).powi(2 * order as i32)).sqrt();
        let got = gain(filter, share);
        assert!(
            (got - want).abs() < 1e-11 * want.max(1e-3),
            "order {order} at {share}: {got} {want}"
        );
    }
}

#[test]
fn the_response_is_butterworths() {
    let warp = |share: f64| (PI * share).tan();
    for order in 1..=MAX_ORDER {
        let mut filter = vec![Biquad::default(); sections_of(order)];
        for cutoff in [0.011, 0.1, 0.37, 0.49] {
            low_pass(order, cutoff * 250.0, 250.0, &mut filter).unwrap();
            holds(&filter, order, |omega| omega / warp(cutoff));
            assert!((gain(&filter, cutoff) - FRAC_1_SQRT_2).abs() < 1e-12);
            assert!(filter.iter().all(|s| s.back()[1].abs() < 1.0));
            high_pass(order, cutoff, 1.0, &mut filter).unwrap();
            holds(&filter, order, |omega| warp(cutoff) / omega);
            assert!(filter.iter().all(|s| s.back()[1].abs() < 1.0));
        }
        let mut filter = vec![Biquad::default(); order];
        for (low, high) in [(0.05, 0.2), (0.01, 0.45), (0.2, 0.21), (0.3, 0.49)] {
            band_pass(order, low, high, 1.0, &mut filter).unwrap();
            let (centre, width) = (warp(low) * warp(high), warp(high) - warp(low));
            holds(&filter, order, |omega| {
                (omega * omega - centre) / (omega * width)
            });
        }
    }
}

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
