//! Channels without noise, breaks, and rests by hand.

// One rest is a range in a list.
#![allow(clippy::single_range_in_vec_init)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::*;

fn found(samples: &Samples) -> Vec<Range<usize>> {
    let rests = find_rests(samples, None).spans;
    for pair in rests.windows(2) {
        assert!(pair[0].end <= pair[1].start, "{rests:?}");
    }
    assert!(
        rests
            .iter()
            .all(|r| r.start < r.end && r.end <= samples.len())
    );
    rests
}

/// White noise, and a push of 1 m/s² there and back along x in `motion_s`.
fn noisy(rate_hz: f64, seconds: f64, sigma: f64, motion_s: Range<f64>) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut out = Samples::default();
    let mut rate: [Vec<f64>; 3] = Default::default();
    let middle = 0.5 * (motion_s.start + motion_s.end);
    for i in 0..(rate_hz * seconds) as usize {
        let t = i as f64 / rate_hz;
        let push = match motion_s.contains(&t) {
            true if t < middle => 1.0,
            true => -1.0,
            false => 0.0,
        };
        for c in 0..3 {
            let noise: f64 = rng.sample(StandardNormal);
            out.force_mps2[c].push([push, 0.0, 9.81][c] + sigma * noise);
            let noise: f64 = rng.sample(StandardNormal);
            rate[c].push(0.03 * sigma * noise);
        }
        out.t_s.push(t);
    }
    out.rate_rad_s = Some(rate);
    out
}

#[test]
fn channels_without_noise() {
    // Nothing moves and nothing is noisy: there is no noise to find a rest by.
    let mut silent = noisy(100.0, 10.0, 0.0, 0.0..0.0);
    assert!(found(&silent).len() <= 1);
    silent.rate_rad_s = None;
    assert!(found(&silent).len() <= 1);
    // One axis is stuck, or all of the gyroscope.
    let mut stuck = noisy(100.0, 12.0, 0.03, 5.0..6.0);
    stuck.force_mps2[1] = vec![0.0; stuck.len()];
    assert_eq!(found(&stuck).len(), 2);
    stuck.rate_rad_s = Some(std::array::from_fn(|_| vec![0.0; stuck.len()]));
    assert_eq!(found(&stuck).len(), 2);
    // Without any noise a push still parts two rests.
    let exact = noisy(100.0, 12.0, 0.0, 5.0..6.0);
    let rests = found(&exact);
    assert_eq!(rests.len(), 2);
    assert!(rests[0].end <= 500 && rests[1].start >= 600, "{rests:?}");
}

#[test]
fn no_rest_spans_a_break() {
    let mut samples = noisy(100.0, 20.0, 0.03, 0.0..0.0);
    samples.breaks = vec![700, 705, 1500];
    assert_eq!(found(&samples), [0..700, 705..1500, 1500..2000]);
}

#[test]
fn given_by_hand() {
    let samples = noisy(100.0, 10.0, 0.03, 0.0..0.0);
    let given = |list: &[(f64, f64)]| {
        (
            check_intervals(list).map_err(|e| e.code()),
            find_rests(&samples, Some(list)).spans,
        )
    };
    let (valid, spans) = given(&[(7.0, f64::INFINITY), (-1.0, 2.0), (1.5, 3.0)]);
    assert_eq!((valid, spans), (Ok(()), vec![0..301, 700..1000]));
    assert_eq!(given(&[(20.0, 30.0)]), (Ok(()), vec![]));
    let error = check_inside(&samples, &[(0.0, 1.0), (20.0, 30.0)]).unwrap_err();
    assert_eq!(error.code(), "rests-outside");
    for bad in [(3.0, 2.0), (2.0, 2.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
        assert_eq!(given(&[bad]).0, Err("rests-syntax"), "{bad:?}");
    }
    let mut broken = samples.clone();
    broken.breaks = vec![100];
    let rests = find_rests(&broken, Some(&[(0.5, 1.5)]));
    assert_eq!(rests.spans, [50..100, 100..151]);
    assert!((rests.accel.unwrap().sigma[0] - 0.03).abs() < 0.01);
}

#[test]
fn intervals_as_text() {
    let parse = |text: &str| text.parse::<Intervals>().map(|i| i.0).map_err(|e| e.code());
    let open = f64::INFINITY;
    assert_eq!(parse("0-5,7.2-"), Ok(vec![(0.0, 5.0), (7.2, open)]));
    assert_eq!(parse(" -3 , 1e1 - 12"), Ok(vec![(0.0, 3.0), (10.0, 12.0)]));
    assert_eq!(parse("1e-3-2.5"), Ok(vec![(0.001, 2.5)]));
    for bad in [
        "", "5", "-", "5-3", "3-3", "a-b", "1-2-3", "1-nan", "1-2,", "1-inf",
    ] {
        assert_eq!(parse(bad), Err("rests-syntax"), "{bad:?}");
    }
}
