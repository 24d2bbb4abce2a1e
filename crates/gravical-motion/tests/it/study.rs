//! Errors against bands over many recordings.

use std::ops::Range;

use gravical_motion::{
    CalibrationUncertainty, ElementErrors, Ends, Interpolated, Motion, MotionOptions, Samples,
    estimate_motion,
};
use gravical_signal::{interpolate_outliers, quantile};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion};

use crate::simulated::{BIAS_SD, FORCE_SD, RATE_SD, Recording, Scene, Trouble};

pub fn options() -> MotionOptions {
    let errors = |scale: f64, cross: f64| ElementErrors {
        scale,
        cross,
        bias_mps2: BIAS_SD,
    };
    MotionOptions {
        calibration: CalibrationUncertainty {
            force: errors(FORCE_SD, FORCE_SD).force(),
            rate: errors(RATE_SD[0], RATE_SD[1]).rate(),
            ..CalibrationUncertainty::default()
        },
        ..MotionOptions::default()
    }
}

/// The usual options with a change.
pub fn options_with(change: impl FnOnce(&mut MotionOptions)) -> MotionOptions {
    let mut options = options();
    change(&mut options);
    options
}

/// Sensor → world.
pub fn rotation([w, x, y, z]: [f64; 4]) -> Rotation3<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)).into()
}

pub fn with_interpolated(
    time_s: &[f64],
    force: &[[f64; 3]],
    rate: &[[f64; 3]],
    interpolated: Vec<Interpolated>,
    resolution: [f64; 6],
) -> Samples {
    let rows = time_s.iter().zip(force).enumerate();
    let rows = rows.map(|(i, (t, force))| (*t, *force, rate.get(i).copied()));
    Samples::new(rows, interpolated, resolution)
}

/// Interpolates what is clipped or spiked.
pub fn interpolate(
    time_s: &[f64],
    values: &mut [[f64; 3]],
    ranges: &[f64],
    min_spike: f64,
) -> Vec<Interpolated> {
    let read: [Vec<f64>; 3] = std::array::from_fn(|c| values.iter().map(|v| v[c]).collect());
    let (columns, interpolated) = interpolate_outliers(
        time_s,
        read.each_ref().map(Vec::as_slice),
        ranges,
        min_spike,
    );
    for (c, column) in columns.iter().enumerate() {
        values
            .iter_mut()
            .zip(column.iter())
            .for_each(|(v, x)| v[c] = *x);
    }
    interpolated
}

/// Steps that the values of each channel are written in: most neighbouring ones of those that occur are one apart.
pub fn resolutions(force: &[[f64; 3]], rate: &[[f64; 3]]) -> [f64; 6] {
    std::array::from_fn(|c| {
        let column = [force, rate][c / 3].iter().map(|v| v[c % 3]);
        let mut sorted: Vec<f64> = column.filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let steps = sorted.windows(2).map(|w| w[1] - w[0]);
        quantile(steps.filter(|d| *d > 1e-9).collect(), 0.5)
    })
}

/// Samples of which nothing was interpolated.
pub fn not_interpolated(time_s: &[f64], force: &[[f64; 3]], rate: &[[f64; 3]]) -> Samples {
    with_interpolated(time_s, force, rate, Vec::new(), resolutions(force, rate))
}

pub fn samples(recording: &Recording, ranges: [f64; 2]) -> Samples {
    let (mut force, mut rate) = (recording.force.clone(), recording.rate.clone());
    // What repeats for ten rows is set aside when a recording is read.
    let repeats = |i: &usize| {
        force[*i] == force[i - 1] && recording.rate.get(*i) == recording.rate.get(i - 1)
    };
    let repeated: Vec<usize> = (1..force.len()).filter(repeats).collect();
    let runs = repeated.chunk_by(|a, b| b - a == 1);
    for row in runs.filter(|run| run.len() >= 10).flatten() {
        force[*row] = [f64::NAN; 3];
    }
    let mut interpolated = interpolate(&recording.time_s, &mut force, &[ranges[0]], 5.0);
    let of_rate = interpolate(&recording.time_s, &mut rate, &[ranges[1]], 2.0);
    interpolated.extend(of_rate.into_iter().map(|b| Interpolated {
        channel: b.channel + 3,
        ..b
    }));
    let resolution = resolutions(&recording.force, &recording.rate);
    with_interpolated(&recording.time_s, &force, &rate, interpolated, resolution)
}

pub fn estimate(scene: &Scene, options: &MotionOptions) -> (Recording, Motion) {
    let recording = scene.record();
    let motion = estimate_motion(&samples(&recording, scene.ranges), options);
    (recording, motion)
}

/// Over many recordings of one kind.
#[derive(Debug, Default)]
pub struct Study {
    pub count: usize,
    /// Recordings with as many closed moves as there are.
    pub found: usize,
    /// Errors along each axis and their standard deviations, of the moves of these.
    pub errors: Vec<(f64, f64)>,
    /// Squared errors along the track.
    along: Vec<f64>,
}

impl Study {
    pub fn of(scenes: impl Iterator<Item = Scene>, options: &MotionOptions) -> Study {
        let mut study = Study::default();
        for scene in scenes {
            study.count += 1;
            let (recording, motion) = estimate(&scene, options);
            let are_closed = motion.moves.iter().all(|m| m.ends == Ends::RestToRest);
            if !are_closed || motion.moves.len() != recording.moves_s.len() {
                continue;
            }
            study.found += 1;
            for one in &motion.moves {
                let truth = recording.displacement;
                let error: Vec<f64> = (0..3).map(|c| one.displacement_m[c] - truth[c]).collect();
                study.errors.extend((0..3).map(|c| (error[c], one.sd_m[c])));
                let along = (0..3).map(|c| error[c] * truth[c]).sum::<f64>() / truth.norm();
                study.along.push(along * along);
            }
        }
        study
    }

    /// Of recordings of a kind.
    pub fn of_kind(
        (_, trouble, change): Kind,
        seeds: Range<u64>,
        options: &MotionOptions,
    ) -> Study {
        let scene = |seed| Scene::new(seed, trouble).with(change);
        Study::of(seeds.map(scene), options)
    }

    pub fn rms_mm(&self) -> f64 {
        1e3 * (self.along.iter().sum::<f64>() / self.along.len() as f64).sqrt()
    }

    pub fn coverage(&self, sigmas: f64) -> f64 {
        let inside = self.errors.iter().filter(|(e, s)| e.abs() <= sigmas * s);
        inside.count() as f64 / self.errors.len() as f64
    }

    /// Median 2σ over the 95 % quantile of the errors.
    pub fn width(&self) -> f64 {
        let quantile = |mut v: Vec<f64>, q: f64| {
            v.sort_by(f64::total_cmp);
            let at = ((v.len() as f64 - 1.0) * q) as usize;
            v.get(at).copied().unwrap_or(f64::NAN)
        };
        let error = quantile(self.errors.iter().map(|e| e.0.abs()).collect(), 0.95);
        2.0 * quantile(self.errors.iter().map(|e| e.1).collect(), 0.5) / error
    }
}

/// A name, and how its recordings differ from plain ones.
pub type Kind = (&'static str, Trouble, fn(&mut Scene));

/// Every kind that is studied.
pub fn kinds() -> Vec<Kind> {
    use Trouble as T;
    const G: f64 = 9.80665;
    let half = 0.5_f64.to_radians();
    vec![
        ("plain", T::None, |_| {}),
        ("slow 4 s", T::None, |s| s.move_s = 4.0),
        ("slow 8 s", T::None, |s| s.move_s = 8.0),
        ("drops", T::Drops, |_| {}),
        ("noise × 3", T::None, |s| s.noise = [0.1, 3e-3]),
        ("wobble ±3°", T::Wobble(3.0_f64.to_radians()), |_| {}),
        ("cart", T::Cart(0.7, 0.1), |_| {}),
        ("cart 60 s", T::Cart(1.4, 0.2), |s| s.rests_s[1] = 60.0),
        ("varied cart", T::VariedCart(1.0, 0.15), |_| {}),
        ("knocks", T::Knocks, |_| {}),
        ("vibration", T::Vibration(3.0), |_| {}),
        ("jerk", T::Jerk, |s| s.move_s = 1.0),
        ("bias step", T::BiasStep(0.05), |_| {}),
        ("tremble", T::Tremble, |_| {}),
        ("clipped force", T::None, |s| {
            (s.move_s, s.ranges[0]) = (0.4, 2.0 * G)
        }),
        ("clipped rate", T::Tilt(2.0), |s| {
            (s.move_s, s.ranges[1]) = (1.0, 250.0_f64.to_radians())
        }),
        ("no gyro", T::None, |s| s.gyro = false),
        ("no gyro, tilt 0.5°", T::Tilt(half), |s| s.gyro = false),
        ("no gyro, stays 0.5°", T::LastingTilt(half), |s| {
            s.gyro = false
        }),
        ("no gyro, 0.1 m 5 s", T::None, |s| {
            (s.gyro, s.move_s, s.distance_m) = (false, 5.0, 0.1)
        }),
        ("spike", T::Spikes(1), |_| {}),
        ("three spiked, 60 s", T::Spikes(3), |s| s.rests_s[1] = 60.0),
        ("plain, rests of 1 s", T::None, |s| {
            (s.rests_s, s.moves) = ([1.0, 1.2], 3)
        }),
        ("calibrated", T::Wobble(0.05), |s| s.miscalibrated = 0.2),
        ("16 s", T::None, |s| s.move_s = 16.0),
    ]
}
