//! What goes wrong in real recordings, each with the right answer.

use std::f64::consts::TAU;

use gravical_motion::{Ends, Motion, Samples, Unusable, estimate_motion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::simulated::{G, Recording, Scene, Trouble, norm};
use crate::study::{estimate, not_interpolated, options, options_with, samples};
use crate::walks::walks;

fn holds(motion: &Motion, recording: &Recording) -> bool {
    let one = &motion.moves[0];
    (0..3).all(|c| (one.displacement_m[c] - recording.displacement[c]).abs() < 3.0 * one.sd_m[c])
}

/// Force and rate of a time over noise, at 100 Hz, as means over the period before each stamp.
pub fn noisy(seed: u64, seconds: f64, truth: impl Fn(f64) -> [[f64; 3]; 2]) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sd: f64| -> f64 { sd * rng.sample::<f64, _>(StandardNormal) };
    let times = 0..(seconds * 100.0) as usize;
    let time_s: Vec<f64> = times.map(|i| i as f64 * 0.01).collect();
    let (mut force, mut rate) = (Vec::new(), Vec::new());
    for t in &time_s {
        let [f, r] = truth(t - 0.005);
        force.push(f.map(|v| v + noise(0.03)));
        rate.push(r.map(|v| v + noise(1e-3)));
    }
    not_interpolated(&time_s, &force, &rate)
}

/// Accelerations along z, without turning.
fn vertical(seed: u64, seconds: f64, acceleration: impl Fn(f64) -> f64) -> Samples {
    let force = |t| [0.0, 0.0, G + acceleration(t)];
    noisy(seed, seconds, |t| [force(t), [0.0; 3]])
}

#[test]
fn the_cruise_of_a_lift_is_no_rest() {
    let acceleration = |t: f64| match t {
        5.0..9.0 => 1.0,
        19.0..23.0 => -1.0,
        _ => 0.0,
    };
    let motion = estimate_motion(&vertical(1, 30.0, acceleration), &options());
    assert_eq!(motion.rests.len(), 2, "{:?}", motion.rests);
    let (z, sd) = (motion.moves[0].displacement_m[2], motion.moves[0].sd_m[2]);
    assert!((z - 56.0).abs() < 3.0 * sd && sd < 0.5, "{z} ± {sd}");
}

#[test]
fn a_failed_closure_widens_all_axes_alike() {
    let scene = Scene::new(7, Trouble::BiasStep(0.3));
    let (recording, motion) = estimate(&scene, &options());
    let mut sd = motion.moves[0].sd_m;
    assert!(motion.moves[0].closure.unwrap().widened);
    sd.sort_by(f64::total_cmp);
    assert!(sd[2] < 1.2 * sd[0] && holds(&motion, &recording), "{sd:?}");
}

#[test]
fn a_gyroscope_is_clipped_where_it_stands_whatever_its_range() {
    for seed in 0..5 {
        let scene =
            Scene::new(seed, Trouble::Tilt(2.0)).with(|s| (s.move_s, s.ranges[1]) = (1.0, 4.0));
        let recording = scene.record();
        let samples = samples(&recording, [1e3; 2]);
        assert!(
            samples
                .interpolated
                .iter()
                .any(|b| b.is_clipped && b.channel > 2)
        );
        let motion = estimate_motion(&samples, &options());
        assert!(motion.moves[0].unusable.is_some() || holds(&motion, &recording));
    }
}

#[test]
fn a_turn_without_a_gyroscope_leaves_the_way_unknown() {
    for (trouble, unusable) in [
        (Trouble::Tilt(0.01), None),
        (Trouble::LastingTilt(0.1), Some(Unusable::Unseen)),
        (Trouble::Tilt(0.8), Some(Unusable::Unseen)),
    ] {
        let scene = Scene::new(2, trouble).with(|s| s.gyro = false);
        assert_eq!(
            estimate(&scene, &options()).1.moves[0].unusable,
            unusable,
            "{trouble:?}"
        );
    }
}

#[test]
fn a_sensor_that_hangs_leaves_a_gap() {
    for gyro in [true, false] {
        let scene = Scene::new(4, Trouble::Hang).with(|s| s.gyro = gyro);
        let recording = scene.record();
        let samples = samples(&recording, scene.ranges);
        let lost = recording.time_s.len() - samples.len();
        assert!((138..=141).contains(&lost), "{lost}");
        let motion = estimate_motion(&samples, &options());
        assert_eq!(motion.rests.len(), 2);
        let Some(Unusable::Gap { missing_s }) = motion.moves[0].unusable else {
            panic!("{:?}", motion.moves)
        };
        assert!((missing_s - 1.4).abs() < 0.02, "{missing_s}");
        assert!(motion.moves[0].sd_m[0] > 0.3 && holds(&motion, &recording));
    }
}

#[test]
fn a_recording_may_begin_in_motion() {
    let scene = Scene::new(5, Trouble::Wobble(0.1)).with(|s| (s.moves, s.cut_s) = (2, 6.2));
    let (recording, motion) = estimate(&scene, &options());
    let ends: Vec<Ends> = motion.moves.iter().map(|m| m.ends).collect();
    assert_eq!(ends, [Ends::ToRest, Ends::RestToRest]);
    // Heading is that of the first sample, which a rest after it knows by the gyroscope.
    let found = norm(motion.moves[1].displacement_m);
    let truth = recording.displacement.norm();
    assert!((found - truth).abs() < 0.02, "{found} {truth}");
}

#[test]
fn what_rests_is_at_rest_and_says_what_could_hide() {
    let motion = estimate_motion(&vertical(3, 20.0, |_| 0.0), &options());
    assert!(motion.moves.is_empty());
    let hidden_m = motion.hidden_displacement_m(2.0).unwrap();
    assert!((0.0225..0.045).contains(&hidden_m), "{hidden_m}");
    let hidden_mps = motion.hidden_speed_mps().unwrap();
    assert!((0.015..0.03).contains(&hidden_mps), "{hidden_mps}");
    assert_eq!((motion.rests[0].start, motion.rests[0].end), (0, 2000));
}

#[test]
fn noise_needs_no_long_rest() {
    let scene = Scene::new(6, Trouble::None);
    let (recording, usual) = estimate(&scene, &options());
    let truth = usual.noise.unwrap().accel_n[0];
    // 10 samples, less than a block, and 3, which are no variance.
    for count in [10, 3] {
        let given = options_with(|o| o.rests = Some(vec![490..490 + count, 720..720 + count]));
        let motion = estimate_motion(&samples(&recording, scene.ranges), &given);
        let noise = motion.noise.unwrap().accel_n;
        let is_near = |n: &f64| (0.5..1.6).contains(&(n / truth));
        assert!(noise.iter().all(is_near), "{noise:?} {truth}");
    }
}

#[test]
fn a_hand_that_turns_while_it_moves_does_not_stand() {
    // Its rate passes 2.5 rad/s twice and is nothing between, at full speed.
    let scene = Scene::new(7, Trouble::Wobble(1.0));
    let (recording, motion) = estimate(&scene, &options());
    let is_found = motion.moves.iter().all(|m| m.stances == 0) && holds(&motion, &recording);
    assert!(is_found, "{:?}", motion.moves);
}

#[test]
fn a_hand_that_swings_to_and_fro_does_not_walk() {
    // It turns by ±46°, so slower than 1 rad/s for 0.1 s at each end, and moves on there.
    let samples = noisy(3, 20.0, |t| {
        let (swings, phase) = (f64::from((5.0..15.0).contains(&t)), TAU * 0.8 * (t - 5.0));
        let turned = 0.8 * (1.0 - phase.cos()) * swings;
        let omega = 0.8 * TAU * 0.8 * phase.sin() * swings;
        let acceleration = 2.0 * phase.sin() * swings;
        let (sin, cos) = turned.sin_cos();
        let [forward, up] = [cos * acceleration - sin * G, sin * acceleration + cos * G];
        [[forward, 0.0, up], [0.0, omega, 0.0]]
    });
    let motion = estimate_motion(&samples, &options());
    let stances: Vec<usize> = motion.moves.iter().map(|m| m.stances).collect();
    assert_eq!(stances, [0]);
}

#[test]
fn how_far_it_went_is_not_known_over_an_interruption_or_a_missed_turn() {
    let scene = Scene::new(8, Trouble::None).with(|s| s.moves = 2);
    let recording = scene.record();
    let whole = samples(&recording, scene.ranges);
    // A second is cut out of the second move, and the stamps count on.
    let mut cut = recording.clone();
    let from_s = recording.moves_s[1].0 + 0.5;
    let from = cut.time_s.partition_point(|t| *t < from_s);
    for values in [&mut cut.force, &mut cut.rate] {
        values.drain(from..from + 100);
    }
    cut.time_s.truncate(cut.force.len());
    let broken = samples(&cut, scene.ranges).with_breaks(&[from]);
    assert_eq!(broken.pieces, [0..from, from..broken.len()]);
    assert_eq!((broken.rows[from] as usize, whole.pieces.len()), (from, 1));
    let motion = estimate_motion(&broken, &options());
    assert_eq!(motion.rests.len(), 3, "{:?}", motion.rests);
    assert!(motion.moves[0].unusable.is_none());
    assert_eq!(motion.moves[1].unusable, Some(Unusable::Interrupted));

    // In a rest: nobody knows whether it came back.
    let motion = estimate_motion(&whole.with_breaks(&[250]), &options());
    assert_eq!(motion.rests.len(), 4);
    assert_eq!(motion.moves[0].unusable, Some(Unusable::Interrupted));

    let turned = |range: f64| {
        let scene =
            Scene::new(9, Trouble::Tilt(2.0)).with(|s| (s.ranges, s.move_s) = ([1e3, range], 1.0));
        estimate(&scene, &options()).1.moves[0].unusable
    };
    assert_eq!((turned(1e3), turned(1.2)), (None, Some(Unusable::Turn)));
}

/// Steps of a foot by half a metre in half a second, as long apart, between rests: it swings to and fro.
fn walk(steps: usize) -> Samples {
    let walk_s = steps as f64;
    noisy(1, walk_s + 10.0, |t| {
        let walks = (5.0..5.0 + walk_s).contains(&t);
        let u = ((t - 5.0).rem_euclid(1.0) / 0.5).min(1.0);
        let u = if walks { u } else { 0.0 };
        let turned = 0.4 * (1.0 - (TAU * u).cos());
        let omega = 0.4 * TAU / 0.5 * (TAU * u).sin();
        let acceleration = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * 0.5 / 0.25;
        let (sin, cos) = turned.sin_cos();
        let [forward, up] = [cos * acceleration - sin * G, sin * acceleration + cos * G];
        [[forward, 0.0, up], [0.0, omega, 0.0]]
    })
}

#[test]
fn a_walk_is_held_by_its_stances() {
    let samples = walk(12);
    let motion = estimate_motion(&samples, &options());
    let states: Vec<_> = motion.states(&samples).collect();
    // Half a second into the stance after the tenth step.
    let during = &states[1495];
    let is_held = !during.at_rest && during.position_sd_m[0] < 0.2;
    assert!(is_held, "{during:?}");
    let last = states.last().unwrap();
    let (error_m, sd_m) = (last.position_m[0] - 6.0, last.position_sd_m[0]);
    let holds = last.at_rest && sd_m < 0.25 && error_m.abs() < 3.0 * sd_m;
    assert!(holds, "{last:?}");
}

#[test]
fn a_foot_that_rises_in_every_stance_ends_within_its_band() {
    let out = walks()[0].outcome(0..8);
    let holds = out.axes.iter().all(|axis| axis.coverage(2.0) > 0.8);
    let is_narrow = out.axes[2].errors.iter().all(|(_, sd_m)| *sd_m < 1.2);
    assert!(out.beyond == 0 && holds && is_narrow, "{out:?}");
}
