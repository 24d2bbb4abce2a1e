//! Accuracy and coverage.

use crate::simulated::{Scene, Trouble};
use crate::study::{Study, options};

/// Every kind that is studied: its name and a recording of a seed.
pub fn kinds() -> Vec<(&'static str, fn(u64) -> Scene)> {
    use Trouble as T;
    vec![
        ("plain", |s| Scene::new(s, T::None)),
        ("slow 4 s", |s| Scene {
            move_s: 4.0,
            ..Scene::new(s, T::None)
        }),
        ("slow 8 s", |s| Scene {
            move_s: 8.0,
            ..Scene::new(s, T::None)
        }),
        ("drops", |s| Scene::new(s, T::Drops)),
        ("noise × 3", |s| Scene {
            noise: [0.1, 3e-3],
            ..Scene::new(s, T::None)
        }),
        ("wobble ±3°", |s| {
            Scene::new(s, T::Wobble(3.0_f64.to_radians()))
        }),
        ("cart", |s| Scene::new(s, T::Cart(0.7, 0.1))),
        ("cart 60 s", |s| Scene {
            rests_s: [5.0, 60.0],
            ..Scene::new(s, T::Cart(1.4, 0.2))
        }),
        ("varied cart", |s| Scene::new(s, T::VariedCart(1.0, 0.15))),
        ("knocks", |s| Scene::new(s, T::Knocks)),
        ("vibration", |s| Scene::new(s, T::Vibration(3.0))),
        ("jerk", |s| Scene {
            move_s: 1.0,
            ..Scene::new(s, T::Jerk)
        }),
        ("bias step", |s| Scene::new(s, T::BiasStep(0.05))),
        ("tremble", |s| Scene::new(s, T::Tremble)),
        ("clipped force", |s| Scene {
            move_s: 0.4,
            ranges: [2.0 * 9.80665, 1e3],
            ..Scene::new(s, T::None)
        }),
        ("tilt 115°", |s| Scene {
            move_s: 1.0,
            ..Scene::new(s, T::Tilt(2.0))
        }),
        ("wobble 57°", |s| Scene {
            move_s: 1.0,
            ..Scene::new(s, T::Wobble(1.0))
        }),
        ("wobble 57° 2 s", |s| Scene::new(s, T::Wobble(1.0))),
        ("clipped rate", |s| Scene {
            ranges: [1e3, 250.0_f64.to_radians()],
            move_s: 1.0,
            ..Scene::new(s, T::Tilt(2.0))
        }),
        ("no gyro", |s| Scene {
            gyro: false,
            ..Scene::new(s, T::None)
        }),
        ("no gyro, tilt 0.5°", |s| Scene {
            gyro: false,
            ..Scene::new(s, T::Tilt(0.5_f64.to_radians()))
        }),
        ("no gyro, stays 0.5°", |s| Scene {
            gyro: false,
            ..Scene::new(s, T::LastingTilt(0.5_f64.to_radians()))
        }),
        ("no gyro, 0.1 m 5 s", |s| Scene {
            gyro: false,
            move_s: 5.0,
            distance_m: 0.1,
            ..Scene::new(s, T::None)
        }),
        ("spike", |s| Scene::new(s, T::Spikes(1))),
        ("three spiked, 60 s", |s| Scene {
            rests_s: [5.0, 60.0],
            ..Scene::new(s, T::Spikes(3))
        }),
        ("ten moves", |s| Scene {
            moves: 10,
            ..Scene::new(s, T::Wobble(0.1))
        }),
    ]
}

#[test]
#[ignore = "a table"]
fn speed() {
    let seconds = 20_000.0;
    let scene = Scene {
        moves: 1000,
        rests_s: [18.0, 18.0],
        ..Scene::new(1, Trouble::Wobble(0.05))
    };
    let recording = scene.record();
    println!("{} rows {seconds}", recording.time_s.len());
    let samples = crate::study::samples(&recording, scene.ranges);
    drop(recording);
    let peak = || {
        std::fs::read_to_string("/proc/self/status")
            .unwrap()
            .lines()
            .filter(|l| l.starts_with("VmHWM") || l.starts_with("VmRSS"))
            .collect::<Vec<_>>()
            .join(" ")
    };
    println!("{}", peak());
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    println!("{}", peak());
    let start = std::time::Instant::now();
    let motion = gravical_motion::estimate_motion(&samples, &options());
    println!(
        "{:.2} s, {} moves, {} nodes {}",
        start.elapsed().as_secs_f64(),
        motion.moves.len(),
        motion.path.len(),
        peak()
    );
}

#[test]
#[ignore = "a table to read"]
fn table_of_kinds() {
    let seeds: u64 = std::env::var("SEEDS")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(60);
    for causal in [false, true] {
        println!(
            "{:22} {:>7} {:>9} {:>6} {:>6} {:>6}  causal {causal}",
            "kind", "found", "rms mm", "1σ", "2σ", "width"
        );
        let options = gravical_motion::MotionOptions {
            causal,
            ..options()
        };
        for (name, scene) in kinds()
            .into_iter()
            .filter(|k| std::env::var("KIND").is_ok_and(|w| k.0.contains(&w)))
        {
            let study = Study::of((1000..1000 + seeds).map(scene), &options);
            println!(
                "{name:22} {:3}/{:3} {:9.2} {:6.2} {:6.2} {:6.2}",
                study.found,
                study.count,
                study.rms_mm(),
                study.coverage(1.0),
                study.coverage(2.0),
                study.width()
            );
        }
    }
}

#[test]
#[ignore = "a table"]
fn look() {
    let kind = std::env::var("KIND").unwrap();
    for (name, scene) in kinds().into_iter().filter(|k| k.0 == kind) {
        for seed in 1000..1012 {
            let (recording, motion) = crate::study::estimate(&scene(seed), &options());
            let rests: Vec<_> = motion.rests.iter().map(|r| (r.start, r.end)).collect();
            println!(
                "{name} {seed} {:.3?} rests {rests:?}",
                recording.displacement.as_slice()
            );
            for m in &motion.moves {
                println!(
                    "   {:?} {:.3?} ± {:.3?} {:?} excess {:.4?} clipped {} {:.3?} ",
                    m.samples,
                    m.displacement_m,
                    m.sd_m(),
                    m.closure,
                    m.excess_noise,
                    m.clipped,
                    m.budget
                );
            }
        }
    }
}
