//! The motion at every sample.

use gravical_motion::{Motion, SampleState, estimate_motion};

use crate::simulated::{Scene, Trouble, norm};
use crate::study::{not_interpolated, options, samples};

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] - b[c])
}

/// Mean of two, times a duration.
fn trapezoid(a: [f64; 3], b: [f64; 3], seconds: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]) * seconds)
}

#[test]
fn states_agree_with_each_other_and_with_the_nodes() {
    for (seed, gyro) in [(1, true), (2, false)] {
        let scene = Scene::new(seed, Trouble::Wobble(0.3)).with(|s| (s.moves, s.gyro) = (2, gyro));
        let samples = samples(&scene.record(), scene.ranges);
        let motion = estimate_motion(&samples, &options());
        let states: Vec<SampleState> = motion.states(&samples).collect();
        assert_eq!(states.len(), samples.len());
        let time_s = samples.time_s;
        for one in &motion.moves {
            let mut velocity = states[one.samples.start].velocity_mps;
            let (mut peak, mut worst, mut slip) = (0.0_f64, 0.0_f64, 0.0_f64);
            for i in one.samples.clone() {
                let h = time_s[i + 1] - time_s[i];
                let (a, b) = (&states[i], &states[i + 1]);
                velocity = [0, 1, 2].map(|c| velocity[c] + b.acceleration_mps2[c] * h);
                let step = trapezoid(a.velocity_mps, b.velocity_mps, h);
                let moved = minus(b.position_m, a.position_m);
                peak = peak.max(norm(b.velocity_mps));
                worst = worst.max(norm(minus(velocity, b.velocity_mps)));
                slip = slip.max(norm(minus(moved, step)) / h);
            }
            assert!(peak > 0.5 && worst < 1e-6 * peak, "{worst} of {peak}");
            assert!(slip < 1e-3 * peak, "{slip} of {peak}");
        }
        for (k, node) in motion.path.iter().enumerate() {
            let repeated = k > 0 && motion.path[k - 1].sample == node.sample;
            let state = &states[node.sample];
            let dot: f64 = (0..4).map(|c| state.attitude[c] * node.attitude[c]).sum();
            if !repeated {
                assert_eq!(state.position_m, node.position_m);
                assert_eq!(state.velocity_mps, node.velocity_mps);
                assert_eq!(state.position_sd_m, node.position_sd_m);
                assert!((dot.abs() - 1.0).abs() < 1e-12, "{dot}");
            }
        }
        let resting = states.iter().filter(|s| s.at_rest).count();
        assert_eq!(resting, motion.rests.iter().map(|r| r.len()).sum::<usize>());
    }
}

#[test]
fn a_simulated_move_is_in_the_bands_all_the_way() {
    let (mut inside, mut count) = ([0, 0], 0);
    for seed in 0..60 {
        let scene = Scene::new(seed, Trouble::None);
        let recording = scene.record();
        let samples = samples(&recording, scene.ranges);
        let motion = estimate_motion(&samples, &options());
        let (from_s, to_s) = recording.moves_s[0];
        for (state, t) in motion.states(&samples).zip(&samples.time_s) {
            let u = ((t - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
            let share = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            let speed = 30.0 * (u * (1.0 - u)).powi(2) / (to_s - from_s);
            if !(0.1..0.9).contains(&u) {
                continue;
            }
            count += 3;
            for c in 0..3 {
                let position = state.position_m[c] - recording.displacement[c] * share;
                let velocity = state.velocity_mps[c] - recording.displacement[c] * speed;
                inside[0] += usize::from(position.abs() < 2.0 * state.position_sd_m[c]);
                inside[1] += usize::from(velocity.abs() < 2.0 * state.velocity_sd_mps[c]);
            }
        }
    }
    let coverage = inside.map(|n| n as f64 / count as f64);
    let holds = coverage.iter().all(|c| (0.88..1.0).contains(c));
    assert!(holds, "{coverage:?}");
}

#[test]
fn nothing_is_integrated_over_a_gap_nor_known_without_a_rest() {
    let scene = Scene::new(5, Trouble::Hang);
    let recording = scene.record();
    let hung = samples(&recording, scene.ranges);
    let motion = estimate_motion(&hung, &options());
    let states: Vec<SampleState> = motion.states(&hung).collect();
    let after = hung.pieces[1].start;
    let still = |s: &SampleState| s.acceleration_mps2.iter().all(|a| a.abs() < 5.0);
    assert!(states[after - 5..after + 5].iter().all(still));
    assert!(states.iter().all(|s| norm(s.velocity_mps) < 3.0));

    let [force, rate] = [&recording.force, &recording.rate].map(|v| &v[..20]);
    let short = not_interpolated(&recording.time_s[..20], force, rate);
    let unknown: Vec<SampleState> = Motion::default().states(&short).collect();
    let is_unknown = |s: &SampleState| !s.at_rest && s.position_m[0].is_nan();
    assert!(unknown.len() == 20 && unknown.iter().all(is_unknown));
}
