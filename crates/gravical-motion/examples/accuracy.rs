//! What a motion and its bands are worth: simulated moves whose truth is known.
//!
//! ```console
//! $ cargo run --release -p gravical-motion --example accuracy -- 150
//! $ cargo run --release -p gravical-motion --example accuracy -- 150 cart
//! $ cargo run --release -p gravical-motion --example accuracy -- detection
//! $ cargo run --release -p gravical-motion --example accuracy -- drives
//! $ cargo run --release -p gravical-motion --example accuracy -- walks
//! $ cargo run --release -p gravical-motion --example accuracy -- cameras
//! ```
//!
//! Of each kind of recording: errors along the track, how often the bands hold the truth, and how wide they
//! are beside the errors. The number is that of recordings, a word selects kinds. `detection`: which moves are
//! found, by distance and duration. `drives`: turns, slides, lifts, short rests. `cameras`: attitude of real
//! recordings, of `GRAVICAL_DATA`.
// The exemption of tests in clippy.toml does not reach what this shares with them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../tests/it/simulated.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod simulated;
#[path = "../tests/it/study.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod study;

#[path = "../tests/it/cameras.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod cameras;
#[path = "../tests/it/drives.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod drives;
#[path = "../tests/it/real.rs"]
#[allow(dead_code, unused_imports, reason = "the tests use more of it")]
mod real;

#[path = "../tests/it/walks.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod walks;

use cameras::{TRIALS, attitude, uncalibrated};
use drives::drives;
use simulated::{Scene, Trouble};
use study::{Study, kinds, options, options_with};
use walks::{Walk, walks};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let first = arguments.next().unwrap_or_else(|| "60".to_owned());
    match first.parse() {
        Err(_) if first == "drives" => table_of_drives(&arguments.next().unwrap_or_default()),
        Err(_) if first == "walks" => table_of_walks(&arguments.next().unwrap_or_default()),
        Err(_) if first == "cameras" => table_of_cameras(),
        Ok(seeds) => table_of_kinds(seeds, &arguments.next().unwrap_or_default()),
        Err(_) => map_of_detection(),
    }
}

fn table_of_kinds(seeds: u64, wanted: &str) {
    println!("| kind | found | rms, mm | 1σ | 2σ | width |");
    println!("|---|---|---|---|---|---|");
    for kind in kinds().into_iter().filter(|k| k.0.contains(wanted)) {
        let study = Study::of_kind(kind, 1000..1000 + seeds, &options());
        println!(
            "| {} | {} of {} | {:.2} | {:.2} | {:.2} | {:.2} |",
            kind.0,
            study.found,
            study.count,
            study.rms_mm(),
            study.coverage(1.0),
            study.coverage(2.0),
            study.width()
        );
    }
}

fn table_of_drives(wanted: &str) {
    println!(
        "| drive | beyond 4σ, of 40 | open moves | rests found, of | rms, mm | median σ, mm |"
    );
    println!("|---|---|---|---|---|---|");
    for drive in drives().into_iter().filter(|d| d.0.contains(wanted)) {
        let mut out = drive.outcome(500..540);
        let ([found, all], name) = (out.rests, &drive.0);
        let (beyond, open, count) = (out.beyond, out.open, out.sds_m.len());
        let rms = 1e3 * (out.squares_m2.iter().sum::<f64>() / count as f64).sqrt();
        out.sds_m.sort_by(f64::total_cmp);
        let sd = 1e3 * out.sds_m.get(count / 2).unwrap_or(&f64::NAN);
        println!("| {name} | {beyond} | {open} | {found}, {all} | {rms:.1} | {sd:.1} |");
    }
}

fn table_of_walks(wanted: &str) {
    println!("| walk | rms, m | 1σ | 2σ | width | beyond 4σ, unwarned, of 32 |");
    println!("|---|---|---|---|---|---|");
    let is_wanted = |(_, walk): &(u64, Walk)| walk.name.contains(wanted);
    for (kind, walk) in (0..).zip(walks()).filter(is_wanted) {
        let first = 700 + 32 * kind;
        let out = walk.outcome(first..first + 32);
        let axes = |value: fn(&Study) -> f64| {
            let [x, y, z] = out.axes.each_ref().map(value);
            format!("{x:.2} / {y:.2} / {z:.2}")
        };
        println!(
            "| {} | {} | {} | {} | {} | {}, {} |",
            walk.name,
            axes(rms_m),
            axes(|s| s.coverage(1.0)),
            axes(|s| s.coverage(2.0)),
            axes(Study::width),
            out.beyond,
            out.unwarned
        );
    }
}

fn rms_m(study: &Study) -> f64 {
    let squares = study.errors.iter().map(|e| e.0 * e.0);
    (squares.sum::<f64>() / study.errors.len() as f64).sqrt()
}

fn table_of_cameras() {
    println!(
        "| trial, stances | inclination, rms | tilt: σ/error | 2σ | heading, rms | σ/error | 2σ |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (trial, no_stances) in TRIALS.into_iter().flat_map(|t| [(t, false), (t, true)]) {
        let options =
            options_with(|o| (o.calibration, o.no_stances) = (uncalibrated(), no_stances));
        let Some((inclination_rad, tilt, heading)) = attitude(trial, &options) else {
            return;
        };
        let ([_, width, inside], [heading, wide, within]) = (tilt.summary(), heading.summary());
        println!(
            "| {}, {} | {:.2}° | {width:.2} | {inside:.3} | {:.2}° | {wide:.2} | {within:.3} |",
            trial,
            if no_stances { "without" } else { "with" },
            inclination_rad.to_degrees(),
            heading.to_degrees()
        );
    }
}

fn map_of_detection() {
    const SECONDS: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
    println!("| found of 20 (σ of a matched filter) | 0.5 s | 1 s | 2 s | 4 s | 8 s |");
    println!("|---|---|---|---|---|---|");
    for distance_m in [0.01, 0.03, 0.1, 0.3, 0.7, 2.0] {
        let cells = SECONDS.map(|move_s| {
            let scene = |seed| {
                Scene::new(seed, Trouble::None).with(|s| {
                    (s.distance_m, s.move_s, s.rests_s) = (distance_m, move_s, [3.0, 3.0])
                })
            };
            let study = Study::of((0..20).map(scene), &options());
            let sigmas = distance_m / (0.0033 * f64::powf(move_s, 1.5) / 4.14);
            format!("{} ({sigmas:.0}σ)", study.found)
        });
        println!("| {distance_m} m | {} |", cells.join(" | "));
    }
}
