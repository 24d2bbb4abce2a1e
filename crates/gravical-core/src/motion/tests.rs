use std::vec::Vec;

use super::*;
use crate::still::RestNoise;

fn noise() -> RestNoise<f64> {
    RestNoise::new([0.02; 3], 1.0, Some(([1e-3; 3], 1.0)))
}

/// Small noise that repeats after a long time.
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(self.0 >> 8) / f64::from(1 << 24) - 0.5) * 12.0_f64.sqrt()
    }
}

/// 4 s at rest, a sine of acceleration along x over 2 s (0.5 m in all), 4 s at rest,
/// 100 Hz, tilted by 0.1 rad about x.
fn line(i: usize, draw: &mut Draw) -> ([f64; 3], [f64; 3]) {
    let t = i as f64 * 0.01 - 4.0;
    let a = if (0.0..=2.0).contains(&t) {
        0.25 * core::f64::consts::PI * (core::f64::consts::PI * t).sin()
    } else {
        0.0
    };
    let (s, c) = 0.1_f64.sin_cos();
    let mut force = [a, 9.81 * s, 9.81 * c];
    force.iter_mut().for_each(|f| *f += 0.02 * draw.next());
    (force, core::array::from_fn(|_| 0.01 + 1e-3 * draw.next()))
}

fn run<T: Real>(config: MotionConfig<T>, rows: usize) -> (Motion<T, 128>, Vec<Phase>) {
    let mut motion = Motion::new(config).unwrap();
    let mut draw = Draw(1);
    let mut phases = Vec::new();
    for i in 0..rows {
        let (force, rate) = line(i, &mut draw);
        let h = if i == 0 { 0.0 } else { 0.01 };
        motion.update(
            force.map(T::from_f64),
            rate.map(T::from_f64),
            T::from_f64(h),
        );
        phases.push(motion.phase());
    }
    (motion, phases)
}

#[test]
fn a_move_between_two_rests_that_are_found() {
    let config = MotionConfig {
        rests: Some((Plan::new(100.0), noise())),
        ..MotionConfig::strapdown()
    };
    let (motion, phases) = run(config, 1000);
    let p = motion.position_m();
    assert!((p[0] - 0.5).abs() < 0.02, "{p:?}");
    assert!(p[1].abs() < 0.02 && p[2].abs() < 0.02, "{p:?}");
    assert_eq!(motion.velocity_mps(), [0.0; 3]);
    assert_eq!(phases[98], Phase::Waiting);
    assert_eq!(phases[390], Phase::Resting);
    assert_eq!(phases[500], Phase::Moving);
    assert_eq!(phases[999], Phase::Resting);
}

#[test]
fn single_precision_goes_the_same_way() {
    let config = MotionConfig {
        rests: Some((
            Plan::new(100.0),
            RestNoise::new([0.02_f32; 3], 1.0, Some(([1e-3; 3], 1.0))),
        )),
        ..MotionConfig::strapdown()
    };
    let (single, _) = run::<f32>(config, 1000);
    let config = MotionConfig {
        rests: Some((Plan::new(100.0), noise())),
        ..MotionConfig::strapdown()
    };
    let (double, _) = run::<f64>(config, 1000);
    for (a, b) in single.position_m().iter().zip(double.position_m()) {
        assert!((f64::from(*a) - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_sample_that_is_no_number_is_stepped_over() {
    let mut whole = Motion::<f64, 0>::new(MotionConfig::initial_mean(2)).unwrap();
    let mut holed = whole.clone();
    for i in 0..20 {
        let force = [f64::from(i), 0.0, 9.8];
        if i % 5 == 3 {
            assert!(!holed.update([f64::NAN; 3], [0.0; 3], 0.01));
        } else {
            holed.update(force, [0.0; 3], 0.01);
        }
        whole.update(force, [0.0; 3], 0.01);
    }
    let (a, b) = (holed.velocity_mps()[0], whole.velocity_mps()[0]);
    assert!((a - b).abs() < 1e-12, "{a} {b}");
    assert!(
        Motion::<f64, 50>::new(MotionConfig {
            rests: Some((Plan::new(100.0), noise())),
            ..MotionConfig::strapdown()
        })
        .is_err()
    );
}
