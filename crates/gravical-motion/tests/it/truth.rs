//! Accuracy and coverage.

use gravical_motion::{MotionOptions, estimate_motion};

use crate::simulated::{Scene, Trouble};
use crate::study::{Study, causal, estimate, kinds, options, options_with, samples};

/// 150 seeds of the tables are 1000 to 1149; these are others.
fn study(name: &str, seeds: u64, options: &MotionOptions) -> Study {
    let (_, scene) = kinds().into_iter().find(|k| k.0 == name).unwrap();
    Study::of((0..seeds).map(scene), options)
}

#[test]
fn plain_moves_are_as_accurate_as_noise_allows() {
    // 2.7 mm by noise alone in 2 s (METHODS: N √(T³/12)), 7.6 in 4 s.
    for (name, rms_mm) in [
        ("plain", 3.4),
        ("slow 4 s", 9.5),
        ("drops", 3.6),
        ("noise × 3", 11.0),
        ("wobble ±3°", 5.2),
    ] {
        let study = study(name, 40, &options());
        assert_eq!(study.found, 40, "{name}");
        assert!(study.rms_mm() < rms_mm, "{name}: {} mm", study.rms_mm());
        // 120 values, not all independent.
        let coverage = [study.coverage(1.0), study.coverage(2.0)];
        assert!(
            (0.60..0.83).contains(&coverage[0]) && coverage[1] > 0.91,
            "{name}: {coverage:?}"
        );
        assert!(study.width() < 1.5, "{name}: {}", study.width());
    }
}

#[test]
fn bands_hold_where_the_model_is_wrong() {
    for name in [
        "cart",
        "varied cart",
        "knocks",
        "vibration",
        "jerk",
        "bias step",
        "tremble",
        "clipped force",
        "clipped rate",
    ] {
        let study = study(name, 20, &options());
        assert_eq!(study.found, 20, "{name}");
        assert!(
            study.coverage(2.0) > 0.89,
            "{name}: {}",
            study.coverage(2.0)
        );
        assert!(study.width() < 3.0, "{name}: {}", study.width());
    }
}

#[test]
fn a_second_rest_is_never_lost() {
    for name in ["cart 60 s", "three spiked, 60 s"] {
        let study = study(name, 6, &options());
        assert_eq!(study.found, 6, "{name}");
        assert!(
            study.coverage(2.0) > 0.89,
            "{name}: {}",
            study.coverage(2.0)
        );
    }
}

#[test]
fn tilts_are_in_the_bands_without_a_gyroscope() {
    for name in ["no gyro", "no gyro, tilt 0.5°", "no gyro, stays 0.5°"] {
        let study = study(name, 40, &options());
        assert!(study.found >= 38, "{name}: {}", study.found);
        assert!(study.coverage(2.0) > 0.9, "{name}: {}", study.coverage(2.0));
    }
    let slow = study("no gyro, 0.1 m 5 s", 40, &options());
    assert!(
        slow.found >= 34 && slow.coverage(2.0) > 0.85,
        "{} {}",
        slow.found,
        slow.coverage(2.0)
    );
}

#[test]
fn causal_bands_hold() {
    for (name, rms_mm) in [
        ("plain", 3.6),
        ("slow 8 s", 40.0),
        ("wobble ±3°", 5.5),
        ("cart", 100.0),
    ] {
        let study = study(name, 20, &causal());
        assert!(study.found >= 19, "{name}: {}", study.found);
        assert!(study.rms_mm() < rms_mm, "{name}: {} mm", study.rms_mm());
        assert!(study.coverage(2.0) > 0.9, "{name}: {}", study.coverage(2.0));
    }
}

#[test]
fn what_a_matched_filter_sees_is_found() {
    // 35, 13 and 16 σ.
    for (distance_m, move_s) in [(0.01, 0.5), (0.03, 2.0), (0.1, 4.0)] {
        let scene = |seed| {
            Scene::new(seed, Trouble::None)
                .with(|s| (s.distance_m, s.move_s, s.rests_s) = (distance_m, move_s, [3.0, 3.0]))
        };
        let study = Study::of((0..12).map(scene), &options());
        assert!(study.found >= 11, "{distance_m} m: {}", study.found);
    }
}

#[test]
fn turns_calibrate_the_gyroscope_on_the_way() {
    // A scale that is off by 2 % makes 0.1 m/s² of a tilt by 0.5 rad, 60 mm; the closure knows it.
    let scene = |s| Scene::new(s, Trouble::Tilt(0.5));
    let study = Study::of((0..15).map(scene), &options());
    assert!(study.rms_mm() < 6.0, "{} mm", study.rms_mm());
    assert!(study.coverage(2.0) > 0.9, "{}", study.coverage(2.0));
}

#[test]
#[ignore = "slow: an hour without a rest"]
fn a_long_leg() {
    let scene =
        Scene::new(1, Trouble::Cart(0.5, 0.05)).with(|s| (s.distance_m, s.move_s) = (1e3, 3600.0));
    let (recording, motion) = estimate(&scene, &options());
    println!(
        "{:?} ± {:?}, {} nodes",
        motion.moves[0].displacement_m,
        motion.moves[0].sd_m(),
        motion.path.len()
    );
    assert!((0..3).all(|c| {
        let error = motion.moves[0].displacement_m[c] - recording.displacement[c];
        error.abs() < 3.5 * motion.moves[0].sd_m()[c]
    }));
}

#[test]
fn options_must_be_possible() {
    let scene = Scene::new(3, Trouble::None);
    let samples = samples(&scene.record(), scene.ranges);
    for sd in [f64::NAN, -1.0] {
        let options = options_with(|o| o.calibration.gravity_sd_mps2 = sd);
        assert_eq!(estimate_motion(&samples, &options).moves, []);
    }
}
