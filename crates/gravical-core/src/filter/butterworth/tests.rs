use super::*;
use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// |H| at a share of the rate.
fn gain<const N: usize>(filter: &Cascade<f64, N>, share: f64) -> f64 {
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
        .sections()
        .iter()
        .map(|s| part(&s.forward()) / part(&[1.0, s.back()[0], s.back()[1]]))
        .product()
}

/// |H|² = 1/(1 + x²ⁿ) at any frequency.
fn holds<const N: usize>(filter: &Cascade<f64, N>, order: usize, x: impl Fn(f64) -> f64) {
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

fn every_order<const N: usize>(order: usize) {
    let warp = |share: f64| (PI * share).tan();
    for cutoff in [0.011, 0.1, 0.37, 0.49] {
        let low = low_pass::<f64, N>(order, cutoff * 250.0, 250.0).unwrap();
        holds(&low, order, |omega| omega / warp(cutoff));
        assert!((gain(&low, cutoff) - FRAC_1_SQRT_2).abs() < 1e-12);
        let high = high_pass::<f64, N>(order, cutoff, 1.0).unwrap();
        holds(&high, order, |omega| warp(cutoff) / omega);
        for filter in [low, high] {
            let radius = filter.sections().map(|s| s.back()[1].abs());
            assert!(radius.iter().all(|r| *r < 1.0));
        }
    }
}

fn every_band<const N: usize>() {
    let warp = |share: f64| (PI * share).tan();
    for (low, high) in [(0.05, 0.2), (0.01, 0.45), (0.2, 0.21), (0.3, 0.49)] {
        let filter = band_pass::<f64, N>(N, low, high, 1.0).unwrap();
        let (centre, width) = (warp(low) * warp(high), warp(high) - warp(low));
        holds(&filter, N, |omega| {
            (omega * omega - centre) / (omega * width)
        });
    }
}

#[test]
fn the_response_is_butterworths() {
    every_order::<1>(1);
    every_order::<1>(2);
    every_order::<2>(3);
    every_order::<2>(4);
    every_order::<3>(5);
    every_order::<3>(6);
    every_order::<4>(7);
    every_order::<4>(8);
    every_band::<1>();
    every_band::<2>();
    every_band::<3>();
    every_band::<4>();
    every_band::<5>();
    every_band::<6>();
    every_band::<7>();
    every_band::<8>();
}

#[test]
fn single_precision_is_near() {
    let double = low_pass::<f64, 2>(4, 5.0, 100.0).unwrap();
    let single = low_pass::<f32, 2>(4, 5.0, 100.0).unwrap();
    for (d, s) in double.sections().iter().zip(single.sections()) {
        for (d, s) in d.back().iter().zip(s.back()) {
            assert!((d - f64::from(s)).abs() < 1e-6);
        }
    }
    let mut single = single;
    let out = single.settle(9.81);
    assert!((out - 9.81).abs() < 1e-4, "{out}");
    // What low cutoffs cost, as the head of this file says.
    for rate_hz in [90.0_f32, 95.0, 100.0, 103.0, 110.0] {
        let off = low_pass::<f32, 2>(4, 1.0, rate_hz).unwrap().settle(1.0) - 1.0;
        assert!(off.abs() < 1e-4, "{rate_hz}: {off:e}");
        let rate_hz = 10.0 * f64::from(rate_hz);
        let off = low_pass::<f64, 2>(4, 1.0, rate_hz).unwrap().settle(1.0) - 1.0;
        assert!(off.abs() < 1e-11, "{rate_hz}: {off:e}");
    }
}

#[test]
fn what_cannot_be_had() {
    use DesignError::*;
    assert_eq!(low_pass::<f64, 1>(0, 5.0, 100.0), Err(Order { order: 0 }));
    assert_eq!(high_pass::<f64, 5>(9, 5.0, 100.0), Err(Order { order: 9 }));
    assert_eq!(
        low_pass::<f64, 1>(3, 5.0, 100.0),
        Err(Sections { needed: 2 })
    );
    assert_eq!(
        band_pass::<f64, 2>(4, 5.0, 9.0, 100.0),
        Err(Sections { needed: 4 })
    );
    for wrong in [0.0, -1.0, 50.0, 70.0, f64::NAN, f64::INFINITY] {
        assert_eq!(low_pass::<f64, 1>(2, wrong, 100.0), Err(Cutoff), "{wrong}");
        assert_eq!(
            low_pass::<f64, 1>(2, 5.0, wrong.min(0.0)),
            Err(Cutoff),
            "{wrong}"
        );
    }
    assert_eq!(band_pass::<f64, 1>(1, 9.0, 5.0, 100.0), Err(Cutoff));
    assert_eq!(band_pass::<f64, 1>(1, 5.0, 5.0, 100.0), Err(Cutoff));
}
