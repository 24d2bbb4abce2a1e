//! The same session gives the same result, however it was written.
//!
//! Every writing of `tests/support/writings` is held against the plainest one of the same
//! session: where the sensor lay still, the calibration, the verdict, the moves. Where a
//! writing has lost something, an error or a finding has to name the option that brings
//! it back, and with that option the result has to be the same.
//!
//! `GRAVICAL_WRITINGS=2000 cargo test --test it writings::drawn` tries that many at random.

#[path = "../../../../tests/support/writings/mod.rs"]
mod form;
mod judge;

use std::panic::{AssertUnwindSafe, catch_unwind};

use form::cover::pairs;
use form::session::Session;
use form::{Decimals, Scene, Sensors, Values, Writing};
use gravical::recording::{ReadOptions, Recording, join_gyroscope, read};
use judge::{Judge, Subject};

use crate::support::Noise;

/// Writings of which any is not as it should be, with the reasons.
fn wrong(writings: &[Writing]) -> Vec<String> {
    let mut judge = Judge::default();
    let mut out = Vec::new();
    for writing in writings {
        let judged = catch_unwind(AssertUnwindSafe(|| judge.judge(writing)));
        match judged {
            Ok(judged) => out.extend(judged.wrong(&format!("{writing:?}"))),
            Err(_) => out.push(format!("{writing:?}\n  panicked")),
        }
    }
    out
}

fn report(wrong: &[String], of: usize) {
    assert!(
        wrong.is_empty(),
        "{} of {of} writings:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn every_two_choices_about_a_writing_meet_and_change_nothing() {
    let mut noise = Noise::new(1);
    let chosen = pairs(30, |n| (noise.uniform() * n as f64) as usize);
    report(&wrong(&chosen), chosen.len());
}

/// As many as `GRAVICAL_WRITINGS` says, from the seed `GRAVICAL_WRITINGS_SEED`.
#[test]
fn drawn_at_random() {
    let number =
        |name: &str, default: u64| std::env::var(name).map_or(default, |v| v.parse().unwrap());
    let count = number("GRAVICAL_WRITINGS", 10);
    let mut noise = Noise::new(number("GRAVICAL_WRITINGS_SEED", 7));
    let drawn: Vec<Writing> = (0..count)
        .map(|_| Writing::random(|n| (noise.uniform() * n as f64) as usize))
        .collect();
    report(&wrong(&drawn), drawn.len());
}

/// Recordings of real sensors, each written anew in a dozen ways.
#[test]
#[ignore = "slow: 84 writings of whole recordings"]
fn recordings_of_real_sensors() {
    let Some(data) = crate::support::data() else {
        return;
    };
    let mut wrong_ones = Vec::new();
    let mut tried = 0;
    for (name, files, gyro) in [
        (
            "imu_tk-xsens",
            "xsens_acc.txt.gz",
            Some("xsens_gyro.txt.gz"),
        ),
        ("mikoff-mpu9150", "imu0.log", None),
        ("mikoff-mpu9150", "imu1.log", None),
        ("mikoff-mpu9150", "imu2.log", None),
        ("tomisuarez-mpu6050", "calibration.csv", None),
        ("imucal-ferraris", "example_ferraris_session.csv", None),
        (
            "airbrakes-sixmoves",
            "xminus.csv xplus.csv yminus.csv yplus.csv zminus.csv zplus.csv",
            None,
        ),
    ] {
        let options = ReadOptions::default();
        let recordings = files.split(' ').map(|file| {
            let mut recording = read(&data.join(name).join(file), &options).unwrap();
            // The name is a claim about the face, so it stays.
            file.clone_into(&mut recording.name);
            recording
        });
        let mut recordings: Vec<Recording> = recordings.collect();
        if let Some(gyro) = gyro {
            join_gyroscope(&mut recordings[0], &data.join(name).join(gyro), &options).unwrap();
        }
        let gyro = recordings
            .iter()
            .all(|r| r.gyro_scale.is_some_and(|g| g.nominal().is_some()));
        let mut subject = Subject::new(Session::of_recordings(&recordings));
        let mut noise = Noise::new(5);
        for _ in 0..12 {
            let mut writing = Writing::random(|n| (noise.uniform() * n as f64) as usize);
            writing.scene = match recordings.len() {
                1 => Scene::Poses,
                _ => Scene::SixFiles,
            };
            if !gyro {
                writing.sensors = Sensors::AccelerometerOnly;
            }
            // They were rounded when they were recorded: rounded again to steps of that
            // size they are other data. Coarse digits are for the simulator.
            if matches!(writing.decimals, Decimals::Two | Decimals::Three) {
                writing.decimals = Decimals::Four;
            }
            if writing.values == Values::Counts {
                writing.values = Values::Mps2Rad;
            }
            let judged = subject.judge(&writing.possible());
            tried += 1;
            let writing = writing.possible();
            wrong_ones.extend(judged.wrong(&format!("{name} {files} {writing:?}")));
        }
    }
    report(&wrong_ones, tried);
}
