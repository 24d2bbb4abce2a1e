//! Real recordings, in nominal units.

use super::*;
use crate::recording::{ReadOptions, join_gyroscope, read};

/// `counts` are those of 1 rad/s, for a gyroscope that does not say its unit.
fn recorded(path: &str, gyro: Option<&str>, counts: f64) -> Option<Samples> {
    let Some(folder) = std::env::var_os("GRAVICAL_DATA") else {
        println!("skipped: GRAVICAL_DATA is not set");
        return None;
    };
    let folder = std::path::Path::new(&folder);
    let mut recording = read(&folder.join(path), &ReadOptions::default()).unwrap();
    if let Some(gyro) = gyro {
        join_gyroscope(&mut recording, &folder.join(gyro), &ReadOptions::default()).unwrap();
    }
    let scale = recording.accel_scale.nominal().unwrap_or(417.0);
    let gyro_scale = recording
        .gyro_scale
        .and_then(|s| s.nominal())
        .unwrap_or(counts);
    let (rate_hz, _) = recording.working_rate_hz();
    let mut out = Samples::default();
    let mut rate: [Vec<f64>; 3] = Default::default();
    let mut breaks = recording.breaks.iter().peekable();
    for row in 0..recording.rows() {
        let force = recording.accel_at(row).map(|v| v / scale);
        let turn = match &recording.gyro {
            Some(gyro) => std::array::from_fn(|c| gyro[c][row] / gyro_scale),
            None => [0.0; 3],
        };
        let t_s = match &recording.time_s {
            Some(t) => t[row],
            None => row as f64 / rate_hz,
        };
        if !t_s.is_finite() || force.iter().chain(&turn).any(|v| !v.is_finite()) {
            continue;
        }
        let mut broken = false;
        while breaks.next_if(|b| **b <= row).is_some() {
            broken = !out.is_empty();
        }
        if broken {
            out.breaks.push(out.len());
        }
        out.t_s
            .push(out.t_s.last().map_or(t_s, |last: &f64| t_s.max(*last)));
        for c in 0..3 {
            out.force_mps2[c].push(force[c]);
            rate[c].push(turn[c]);
        }
    }
    out.rate_rad_s = recording.gyro.is_some().then_some(rate);
    Some(out)
}

/// Start and end of the rests, s.
fn seconds(samples: &Samples) -> Vec<(f64, f64)> {
    println!("{:?}", find_rests(samples, None).doubts);
    let rests: Vec<(f64, f64)> = found(samples)
        .iter()
        .map(|r| (samples.t_s[r.start], samples.t_s[r.end - 1]))
        .collect();
    println!("{rests:.2?}");
    rests
}

fn near(rests: &[(f64, f64)], expected: &[(f64, f64)], by_s: f64) {
    assert_eq!(rests.len(), expected.len(), "{rests:.2?}");
    for (rest, expected) in rests.iter().zip(expected) {
        let off = (rest.0 - expected.0).abs().max((rest.1 - expected.1).abs());
        assert!(off <= by_s, "{rest:.2?} is not {expected:?}");
    }
}

#[test]
fn bouts_of_translation_between_five_rests() {
    let path = "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz";
    let Some(samples) = recorded(path, None, 1.0) else {
        return;
    };
    let expected = [
        (0.0, 41.93),
        (72.8, 81.55),
        (103.5, 113.25),
        (133.75, 144.3),
        (165.55, 193.9),
    ];
    near(&seconds(&samples), &expected, 0.15);
}

#[test]
fn lifted_and_put_down() {
    for (name, lifted_s) in [("zplus", 1.3), ("zminus", 2.3)] {
        let Some(samples) = recorded(&format!("airbrakes-sixmoves/{name}.csv"), None, 1.0) else {
            return;
        };
        let rests = seconds(&samples);
        assert_eq!(rests.len(), 2, "{name}");
        assert!(rests[0].0 < 0.05 && (rests[0].1 - lifted_s).abs() < 0.1);
        let last_s = rests[1].1 - rests[1].0;
        assert!((0.15..0.28).contains(&last_s), "{name}: {last_s}");
    }
    // In a hand all along, and in motion at the end.
    for name in ["xplus", "xminus", "yplus", "yminus"] {
        let Some(samples) = recorded(&format!("airbrakes-sixmoves/{name}.csv"), None, 1.0) else {
            return;
        };
        let end = samples.t_s[samples.len() - 1];
        assert!(seconds(&samples).iter().all(|r| r.1 < end - 0.2), "{name}");
    }
}

#[test]
fn a_lift() {
    let Some(samples) = recorded("pabrod-elevator/skyscrapper_up.csv", None, 1.0) else {
        return;
    };
    let rests = seconds(&samples);
    let covered = |from: f64, to: f64| rests.iter().any(|r| r.0 <= from && to <= r.1);
    assert!(covered(4.6, 8.7), "before the ride");
    assert!(covered(15.0, 27.0), "constant speed looks like rest");
    assert!(covered(33.1, 35.4), "after it");
    assert!(rests.iter().all(|r| r.0 > 3.0 && r.1 < 36.0), "handling");
}

#[test]
fn placed_by_hand() {
    let Some(samples) = recorded("tomisuarez-mpu6050/calibration.csv", None, 7506.0) else {
        return;
    };
    let rests = seconds(&samples);
    // Ten holds, as published.
    assert_eq!(rests.len(), 10);
    assert!(rests[0].0 == 0.0 && rests[0].1 > 37.0);
    for (path, gyro, counts, stills, most) in [
        ("mikoff-mpu9150/imu0.log", None, 1.0, 22, 23),
        (
            "imu_tk-xsens/xsens_acc.txt.gz",
            Some("imu_tk-xsens/xsens_gyro.txt.gz"),
            // 1/K of its published calibration.
            4780.0,
            38,
            44,
        ),
        (
            "imucal-ferraris/example_ferraris_session.csv",
            None,
            1.0,
            13,
            13,
        ),
    ] {
        let Some(samples) = recorded(path, gyro, counts) else {
            return;
        };
        println!("{:?}", find_rests(&samples, None).doubts);
        let rests = found(&samples);
        let plan = plan(&samples).unwrap();
        let coarse = coarse(&samples, &plan);
        println!("{path}: {} rests, {} stills", rests.len(), coarse.len());
        assert_eq!(coarse.len(), stills, "{path}");
        assert!(
            (stills..=most).contains(&rests.len()),
            "{path}: {}",
            rests.len()
        );
        let common = |of: &Range<usize>| -> usize {
            rests
                .iter()
                .map(|r| r.end.min(of.end).saturating_sub(r.start.max(of.start)))
                .sum()
        };
        let (all, shared): (Vec<usize>, Vec<usize>) =
            coarse.iter().map(|c| (c.len(), common(c))).unzip();
        assert!(shared.iter().all(|n| *n > 0), "{path}");
        let share = shared.iter().sum::<usize>() as f64 / all.iter().sum::<usize>() as f64;
        assert!(share > 0.9, "{path}: {share}");
    }
}

#[test]
fn on_a_foot() {
    let Some(samples) = recorded("openshoe-square2/square2_u.csv", None, 1.0) else {
        return;
    };
    let rests = seconds(&samples);
    let (first, last) = (rests[0], rests[rests.len() - 1]);
    assert!(first.0 == 0.0 && (15.8..16.2).contains(&first.1));
    assert!(last.0 < 81.9 && last.1 > 85.9);
    let Some(samples) = recorded("xio-gait/short_walk.csv", None, 1.0) else {
        return;
    };
    let rests = seconds(&samples);
    assert!(rests.iter().any(|r| r.0 < 7.5 && r.1 > 13.0));
    assert!(rests.iter().all(|r| r.1 < 14.0 || r.0 > 35.0));
}
