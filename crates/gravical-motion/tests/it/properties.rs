//! What must not matter, what has to agree, and what must not break it.

use gravical_motion::{Motion, MotionOptions, PathNode, estimate_motion};
use proptest::prelude::*;

use crate::simulated::{Recording, Scene, Trouble};
use crate::study::{
    estimate, interpolate, not_interpolated, options, resolutions, with_interpolated,
};

fn motion_of(recording: &Recording) -> Motion {
    let samples = not_interpolated(&recording.time_s, &recording.force, &recording.rate);
    estimate_motion(&samples, &options())
}

fn assert_near(a: [f64; 3], b: [f64; 3], limit: f64) {
    assert!((0..3).all(|c| (a[c] - b[c]).abs() < limit), "{a:?} {b:?}");
}

#[test]
fn a_sensor_that_is_mounted_turned_moves_the_same() {
    let recording = Scene::new(8, Trouble::Wobble(0.05)).record();
    let mut turned = recording.clone();
    // A quarter turn about z: its x-axis, and with it the heading, is the old y-axis.
    for v in turned.force.iter_mut().chain(&mut turned.rate) {
        *v = [v[1], -v[0], v[2]];
    }
    let [a, b] = [&recording, &turned].map(|r| motion_of(r).moves[0].clone());
    let [x, y, z] = a.displacement_m;
    // y level is not exactly a quarter turn from x level on a tilted table.
    assert_near([y, -x, z], b.displacement_m, 2e-3);
    assert!((a.sd_m[2] / b.sd_m[2] - 1.0).abs() < 0.02);
}

#[test]
fn the_epoch_does_not_matter() {
    let recording = Scene::new(9, Trouble::None).record();
    let mut later = recording.clone();
    later.time_s.iter_mut().for_each(|t| *t += 1.7e9);
    let (a, b) = (&motion_of(&recording).moves[0], &motion_of(&later).moves[0]);
    // Stamps of that size resolve 0.2 µs.
    assert_near(a.displacement_m, b.displacement_m, 1e-4);
    assert_near(a.sd_m, b.sd_m, 1e-4);
}

#[test]
fn results_agree_with_each_other() {
    let scene = Scene::new(13, Trouble::Wobble(0.1)).with(|s| s.moves = 3);
    let (_, motion) = estimate(&scene, &options());
    let mut sum = [0.0; 3];
    for one in &motion.moves {
        (0..3).for_each(|c| sum[c] += one.displacement_m[c]);
        let budget = one.budget;
        for c in 0..3 {
            let parts = [budget.noise, budget.calibration, budget.attitude];
            let sum: f64 = parts.iter().map(|part| part[c].powi(2)).sum();
            assert!((sum / one.sd_m[c].powi(2) - 1.0).abs() < 1e-9);
            assert!(budget.noise[c] > 0.0 && budget.attitude[c] > 0.0);
        }
    }
    // The path rests between moves, whose displacements lead from rest to rest.
    let last = motion.path.last().unwrap();
    assert_near(sum, last.position_m, 2e-3);
    assert!(motion.path.windows(2).all(|w| w[0].sample <= w[1].sample));
    let square = |node: &PathNode| node.attitude.iter().map(|q| q * q).sum::<f64>();
    assert!(motion.path.iter().all(|n| (square(n) - 1.0).abs() < 1e-9));
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -20.0..20.0_f64,
        2 => Just(9.81),
        2 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::MAX),
        1 => -1e6..1e6_f64,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_is_read_is_answered(
        numbers in prop::collection::vec(number(), 0..400),
        still in 0_usize..400,
        gyro in any::<bool>(),
        given in any::<bool>(),
        step in prop_oneof![Just(0.01), Just(0.0), Just(-0.01), Just(1e-9), Just(1e9), Just(f64::NAN)],
    ) {
        let mut force: Vec<[f64; 3]> = (0..still).map(|i| [0.01 * (i % 3) as f64, 0.0, 9.81]).collect();
        force.extend(numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
        force.extend((0..still / 2).map(|i| [0.01 * (i % 2) as f64, 0.0, 9.81]));
        let odd = numbers.first().copied().unwrap_or(0.0);
        let time_s: Vec<f64> = (0..force.len())
            .map(|i| if i % 37 == 36 { odd } else { i as f64 * step })
            .collect();
        let rate = if gyro { force.iter().map(|f| [f[1], f[0], f[1] * 0.1]).collect() } else { Vec::new() };
        let interpolated = interpolate(&time_s, &mut force, &[19.6, 0.0], 5.0);
        let samples = with_interpolated(&time_s, &force, &rate, interpolated, resolutions(&force, &rate));
        let rests = given.then(|| vec![0..still / 2, still / 2 + 3..still]);
        let options = MotionOptions { rests, ..options() };
        let motion = estimate_motion(&samples, &options);
        prop_assert!(motion.rests.iter().all(|r| r.start < r.end && r.end <= samples.len()));
        prop_assert!(motion.rests.windows(2).all(|w| w[0].end <= w[1].start));
        prop_assert!(motion.path.windows(2).all(|w| w[0].sample <= w[1].sample));
        prop_assert_eq!(motion.states(&samples).count(), samples.len());
        let _ = motion.hidden_displacement_m(odd);
    }
}
