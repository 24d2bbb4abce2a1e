//! The motion as samples come, beside the causal run.

use std::f64::consts::TAU;

use gravical_motion::{Motion, MotionOptions, SampleState, Samples, Stepper, estimate_motion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::simulated::{G, Scene, Trouble};
use crate::study::{causal, samples, unbridged};

fn stepper(samples: &Samples, options: &MotionOptions) -> Stepper {
    let channels = samples.channels();
    Stepper::new(options, channels.period_s, channels.resolution)
}

fn step_through(samples: &Samples, options: &MotionOptions) -> Vec<SampleState> {
    let mut stepper = stepper(samples, options);
    let force = samples.force_mps2().iter();
    let states = samples.time_s().iter().zip(force).enumerate();
    states
        .filter_map(|(i, (t, f))| stepper.push(*t, *f, samples.rate_rad_s().get(i).copied()))
        .collect()
}

/// Steps of a foot by half a metre in half a second, as long apart, between rests: it swings to and fro.
fn walk(steps: usize) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut normal = |sd: f64| -> f64 { sd * rng.sample::<f64, _>(StandardNormal) };
    let walk_s = steps as f64;
    let time_s: Vec<f64> = (0..((walk_s + 10.0) * 100.0) as usize)
        .map(|i| i as f64 * 0.01)
        .collect();
    let (mut force, mut rate) = (Vec::new(), Vec::new());
    for t in &time_s {
        let u = ((t - 5.0).rem_euclid(1.0) / 0.5).min(1.0);
        let u = if (5.0..5.0 + walk_s).contains(t) {
            u
        } else {
            0.0
        };
        let (turned, omega) = (
            0.4 * (1.0 - (TAU * u).cos()),
            0.4 * TAU / 0.5 * (TAU * u).sin(),
        );
        let acceleration = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * 0.5 / 0.25;
        let (sin, cos) = turned.sin_cos();
        force.push([
            cos * acceleration - sin * G + normal(0.03),
            normal(0.03),
            sin * acceleration + cos * G + normal(0.03),
        ]);
        rate.push([normal(1e-3), omega + normal(1e-3), normal(1e-3)]);
    }
    unbridged(&time_s, &force, &rate)
}

fn assert_equal(motion: &Motion, states: &[SampleState]) {
    let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 1e-9);
    let ends = motion.rests.iter().map(|r| r.end - 1);
    let last = states.len() - 1;
    for sample in ends.chain([last]) {
        let node = if sample == last {
            motion.path.last().unwrap()
        } else {
            motion.path.iter().find(|n| n.sample == sample).unwrap()
        };
        let state = &states[sample];
        assert_eq!(node.sample, sample);
        assert!(
            near(&state.position_m, &node.position_m),
            "{state:?} {node:?}"
        );
        assert!(
            near(&state.position_sd_m, &node.position_sd_m),
            "{state:?} {node:?}"
        );
        assert!(
            near(&state.velocity_mps, &node.velocity_mps),
            "{state:?} {node:?}"
        );
        assert!(
            near(&state.velocity_sd_mps, &node.velocity_sd_mps),
            "{state:?} {node:?}"
        );
    }
}

#[test]
fn it_is_the_causal_run() {
    let scene = |scene: Scene| samples(&scene.record(), scene.ranges);
    let plain = Scene::new(1, Trouble::Wobble(0.1)).with(|s| s.moves = 3);
    let recordings = [
        ("plain", scene(plain.clone()), 3),
        // Longer than what is kept of a rest.
        (
            "long",
            scene(plain.clone().with(|s| s.rests_s = [70.0, 5.0])),
            3,
        ),
        (
            "no gyroscope",
            scene(Scene::new(2, Trouble::None).with(|s| (s.gyro, s.moves) = (false, 2))),
            2,
        ),
        (
            "from motion",
            scene(plain.clone().with(|s| s.cut_s = 6.2)),
            3,
        ),
        (
            "into motion",
            scene(plain.with(|s| s.rests_s = [5.0, -0.5])),
            3,
        ),
        (
            "long move",
            scene(
                Scene::new(6, Trouble::Cart(0.5, 0.05))
                    .with(|s| (s.moves, s.move_s, s.distance_m) = (1, 200.0, 50.0)),
            ),
            1,
        ),
        ("walk", walk(12), 1),
    ];
    for (name, samples, moves) in recordings {
        let motion = estimate_motion(&samples, &causal());
        assert_eq!(motion.moves.len(), moves, "{name} {:?}", motion.rests);
        assert_eq!(motion.stances.is_empty(), name != "walk", "{name}");
        assert_equal(&motion, &step_through(&samples, &causal()));
    }
}

#[test]
fn a_walk_is_held_by_its_stances() {
    let samples = walk(12);
    let states = step_through(&samples, &causal());
    // Half a second into the stance after the tenth step.
    let during = &states[1495];
    assert!(
        !during.at_rest && during.position_sd_m[0] < 0.1,
        "{during:?}"
    );
    let last = states.last().unwrap();
    assert!(
        (last.position_m[0] - 6.0).abs() < 3.0 * last.position_sd_m[0],
        "{last:?}"
    );
    assert!(last.at_rest && last.position_sd_m[0] < 0.2, "{last:?}");
}

#[test]
fn nothing_is_known_before_the_first_rest() {
    let scene = Scene::new(3, Trouble::None);
    let samples = samples(&scene.record(), scene.ranges);
    let states = step_through(&samples, &causal());
    let known = states.iter().position(|s| s.position_m[0].is_finite());
    assert!((299..330).contains(&known.unwrap()), "{known:?}");
    assert!(states[450].at_rest && !states[600].at_rest && states[1000].at_rest);
    // What is no measurement changes nothing.
    let mut stepper = stepper(&samples, &causal());
    let push = |stepper: &mut Stepper, i: usize| {
        stepper.push(
            samples.time_s()[i],
            samples.force_mps2()[i],
            Some(samples.rate_rad_s()[i]),
        )
    };
    for i in 0..=400 {
        push(&mut stepper, i);
    }
    assert_eq!(push(&mut stepper, 200), None);
    assert_eq!(stepper.push(4.01, [f64::NAN; 3], Some([0.0; 3])), None);
    assert_eq!(stepper.push(4.01, [0.0, 0.0, 9.81], None), None);
    assert_eq!(push(&mut stepper, 401), Some(states[401]));
}

#[test]
fn an_interruption_is_one_in_both() {
    let scene = Scene::new(4, Trouble::None).with(|s| s.moves = 2);
    let samples = samples(&scene.record(), scene.ranges).with_breaks(&[600]);
    let motion = estimate_motion(&samples, &causal());
    assert!(motion.moves[0].unusable.is_some() && motion.moves[1].unusable.is_none());
    let mut stepper = stepper(&samples, &causal());
    let mut states = Vec::new();
    for i in 0..samples.len() {
        if i == 600 {
            stepper.interrupt();
        }
        let rate = samples.rate_rad_s()[i];
        states.extend(stepper.push(samples.time_s()[i], samples.force_mps2()[i], Some(rate)));
    }
    assert_equal(&motion, &states);
}
