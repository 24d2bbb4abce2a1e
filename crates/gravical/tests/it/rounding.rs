//! One session written with different numbers of digits: static intervals, poses, and rests
//! between moves must be the same.

use gravical::motion::{MotionOptions, motion};
use gravical::poses::rests::find_rests;
use gravical::poses::{SegmentOptions, segment};
use gravical::recording::{ReadOptions, Recording, read_bytes};
use gravical::simulate::{
    LineOptions, PosesOptions, Scenario, SimulateOptions, SimulatedFile, simulate,
};
use gravical_signal::{BLOCK_S, block_len};

const G: f64 = 9.80665;

/// Units per m/s² and rad/s, their names in the header, and decimals.
#[derive(Debug, Clone, Copy)]
struct Writing {
    accel: (&'static str, f64),
    gyro: (&'static str, f64),
    decimals: usize,
    /// Ranges in g and °/s, for counts.
    ranges: Option<(f64, f64)>,
}

impl Writing {
    /// Steps in m/s² and rad/s.
    fn steps(&self) -> [f64; 2] {
        let q = 10_f64.powi(-(self.decimals as i32));
        [q / self.accel.1, q / self.gyro.1]
    }
}

fn writing(accel: &'static str, gyro: &'static str, decimals: usize) -> Writing {
    Writing {
        accel: (accel, if accel == "g" { 1.0 / G } else { 1.0 }),
        gyro: (
            gyro,
            if gyro == "deg/s" {
                1_f64.to_degrees()
            } else {
                1.0
            },
        ),
        decimals,
        ranges: None,
    }
}

fn counts(range_g: f64, range_deg_s: f64) -> Writing {
    let per_rad_s = 32768.0 / range_deg_s * 1_f64.to_degrees();
    Writing {
        accel: ("", 32768.0 / range_g / G),
        gyro: ("", per_rad_s),
        decimals: 0,
        ranges: Some((range_g, range_deg_s)),
    }
}

/// The first one is the reference for the others.
fn writings() -> Vec<Writing> {
    let mut all = vec![writing("m/s^2", "rad/s", 9)];
    for decimals in [4, 3, 2] {
        all.push(writing("m/s^2", "rad/s", decimals));
        all.push(writing("g", "deg/s", decimals));
    }
    all.push(writing("g", "rad/s", 2));
    for (range_g, range_deg_s) in [(2.0, 250.0), (16.0, 2000.0)] {
        all.push(counts(range_g, range_deg_s));
    }
    all
}

fn written(file: &SimulatedFile, how: &Writing) -> Recording {
    let (a, g, d) = (how.accel, how.gyro, how.decimals);
    let mut text = match how.ranges {
        Some(_) => "t_ms,ax,ay,az,gx,gy,gz\n".to_owned(),
        None => format!(
            "t_ms,ax ({0}),ay ({0}),az ({0}),gx ({1}),gy ({1}),gz ({1})\n",
            a.0, g.0
        ),
    };
    for row in 0..file.t_s.len() {
        text += &file.stamp_ms[row].to_string();
        for channel in &file.accel_mps2 {
            text += &format!(",{:.d$}", channel[row] * a.1);
        }
        for channel in &file.gyro_rad_s {
            text += &format!(",{:.d$}", channel[row] * g.1);
        }
        text.push('\n');
    }
    let options = ReadOptions {
        accel_range_g: how.ranges.map(|r| r.0),
        gyro_range_deg_s: how.ranges.map(|r| r.1),
        ..ReadOptions::default()
    };
    read_bytes(text.as_bytes(), "written.csv", &options).unwrap()
}

fn options(scenario: Scenario, rate_hz: f64, noise: f64) -> SimulateOptions {
    let mut options = SimulateOptions::new(scenario);
    options.rate_hz = rate_hz;
    options.sensor.quantise = false;
    options.sensor = options.sensor.with_noise_factor(noise);
    options
}

fn session(rate_hz: f64, noise: f64) -> SimulatedFile {
    let poses = Scenario::Poses(PosesOptions {
        hold_s: 3.0,
        free: 2,
    });
    simulate(&options(poses, rate_hz, noise))
        .unwrap()
        .files
        .remove(0)
}

fn line(rate_hz: f64, noise: f64, tilt_change_deg: f64) -> SimulatedFile {
    let line = Scenario::Line(LineOptions {
        tilt_change_deg,
        ..LineOptions::default()
    });
    simulate(&options(line, rate_hz, noise))
        .unwrap()
        .files
        .remove(0)
}

/// Tolerance of an edge compared with that of `reference`, s: two samples, or the time in which
/// the signal without noise changes by one step of the rounding at any edge of a rest.
fn slack_s(clean: &SimulatedFile, how: &Writing, rate_hz: f64) -> f64 {
    let mut slowest = 0.0_f64;
    let channels = clean.accel_mps2.iter().chain(&clean.gyro_rad_s);
    for (c, values) in channels.enumerate() {
        let step = how.steps()[c / 3];
        for row in 1..values.len() {
            if clean.still[row] == clean.still[row - 1] {
                continue;
            }
            // Away from the rest: forwards from its end, backwards from its start.
            let ends = clean.still[row - 1];
            let first = if ends { row - 1 } else { row };
            let away = |k: usize| {
                let at = if ends {
                    first + k
                } else {
                    first.checked_sub(k)?
                };
                values.get(at).map(|v| (v - values[first]).abs() > step)
            };
            let samples = (0..rate_hz as usize).find(|k| away(*k) == Some(true));
            slowest = slowest.max(samples.unwrap_or(0) as f64 / rate_hz);
        }
    }
    2.0 / rate_hz + slowest + 1e-9
}

/// Sensors with more and with less noise than the steps of two decimals.
const NOISE: [f64; 2] = [1.0, 0.3];

#[test]
fn poses_do_not_depend_on_rounding() {
    for rate_hz in [25.0, 100.0] {
        for noise in NOISE {
            let file = session(rate_hz, noise);
            let mut reference: Option<Vec<std::ops::Range<usize>>> = None;
            for how in writings() {
                let recording = written(&file, &how);
                let what = format!("{rate_hz} Hz, noise {noise}, {how:?}");
                let cut = segment(std::slice::from_ref(&recording), &SegmentOptions::default())
                    .unwrap_or_else(|e| panic!("{what}: {e}"));
                assert_eq!(cut.poses.len(), 8, "{what}");
                let stills = find_rests(&recording).spans;
                let kinds: Vec<&str> = recording.findings.iter().map(|f| f.kind.name()).collect();
                assert!(!kinds.contains(&"frozen-axis"), "{what}: {kinds:?}");
                assert!(!kinds.contains(&"repeated-rows"), "{what}: {kinds:?}");
                let first = reference.get_or_insert_with(|| stills.clone());
                assert_eq!(first.len(), stills.len(), "{what}: {first:?} {stills:?}");
                // Static intervals consist of blocks; the first and last may be lost.
                let most = 2 * block_len(1.0 / rate_hz, BLOCK_S);
                for (a, b) in first.iter().zip(&stills) {
                    let off = a.start.abs_diff(b.start).max(a.end.abs_diff(b.end));
                    assert!(off <= most, "{what}: {a:?} {b:?}");
                }
            }
        }
    }
}

#[test]
fn rests_do_not_depend_on_rounding() {
    for rate_hz in [25.0, 100.0, 400.0] {
        for (noise, tilt_change_deg) in [(1.0, 0.0), (0.3, 2.0)] {
            let file = line(rate_hz, noise, tilt_change_deg);
            let clean = line(rate_hz, 0.0, tilt_change_deg);
            let mut reference: Option<Vec<(f64, f64)>> = None;
            for how in writings() {
                let recording = written(&file, &how);
                let what = format!("{rate_hz} Hz, noise {noise}, {tilt_change_deg}°, {how:?}");
                let result = motion(&recording, None, &MotionOptions::default())
                    .unwrap()
                    .result;
                let rests: Vec<(f64, f64)> =
                    result.rests.iter().map(|s| (s.start_s, s.end_s)).collect();
                assert_eq!(rests.len(), 2, "{what}: {rests:?}");
                let first = *reference
                    .get_or_insert_with(|| rests.clone())
                    .first_chunk::<2>()
                    .unwrap();
                let most = slack_s(&clean, &how, rate_hz);
                let off = (first[0].1 - rests[0].1)
                    .abs()
                    .max((first[1].0 - rests[1].0).abs());
                assert!(off <= most, "{what}: {off} > {most}: {first:?} {rests:?}");
            }
        }
    }
}
