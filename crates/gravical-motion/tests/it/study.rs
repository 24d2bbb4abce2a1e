//! Errors against bands over many recordings.

use gravical_motion::{
    Bounds, CalibrationUncertainty, Motion, MotionOptions, Samples, Sensor, bridge_odd,
    estimate_motion,
};

use crate::simulated::{BIAS_SD, FORCE_SD, RATE_SD, Recording, Scene};

pub fn options() -> MotionOptions {
    let mut calibration = CalibrationUncertainty::independent(FORCE_SD, RATE_SD[1], BIAS_SD);
    for (k, matrix) in calibration.rate.iter_mut().enumerate() {
        if k % 4 == 0 {
            matrix[k / 3][k / 3] = RATE_SD[0];
        }
    }
    MotionOptions {
        calibration,
        ..MotionOptions::default()
    }
}

pub fn samples(recording: &Recording, ranges: [f64; 2]) -> Samples {
    let (mut force, mut rate) = (recording.force.clone(), recording.rate.clone());
    let mut bridged = bridge_odd(
        &recording.time_s,
        &mut force,
        Sensor::Accelerometer,
        &[ranges[0]],
        5.0,
    );
    bridged.extend(bridge_odd(
        &recording.time_s,
        &mut rate,
        Sensor::Gyroscope,
        &[ranges[1]],
        2.0,
    ));
    Samples::new(&recording.time_s, &force, &rate, bridged)
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
            let closed = motion
                .moves
                .iter()
                .filter(|m| m.bounds == Bounds::Closed)
                .count();
            if closed != recording.moves_s.len() || closed != motion.moves.len() {
                continue;
            }
            study.found += 1;
            for one in &motion.moves {
                let truth = recording.displacement;
                let error: Vec<f64> = (0..3).map(|c| one.displacement_m[c] - truth[c]).collect();
                study
                    .errors
                    .extend((0..3).map(|c| (error[c], one.sd_m()[c])));
                let along = (0..3).map(|c| error[c] * truth[c]).sum::<f64>() / truth.norm();
                study.along.push(along * along);
            }
        }
        study
    }

    pub fn rms_mm(&self) -> f64 {
        1e3 * (self.along.iter().sum::<f64>() / self.along.len() as f64).sqrt()
    }

    pub fn coverage(&self, sigmas: f64) -> f64 {
        let inside = self
            .errors
            .iter()
            .filter(|(e, s)| e.abs() <= sigmas * s)
            .count();
        inside as f64 / self.errors.len() as f64
    }

    /// Median 2σ over the 95 % quantile of the errors.
    pub fn width(&self) -> f64 {
        let quantile = |mut v: Vec<f64>, q: f64| {
            v.sort_by(f64::total_cmp);
            v.get(((v.len() as f64 - 1.0) * q) as usize)
                .copied()
                .unwrap_or(f64::NAN)
        };
        let error = quantile(self.errors.iter().map(|e| e.0.abs()).collect(), 0.95);
        2.0 * quantile(self.errors.iter().map(|e| e.1).collect(), 0.5) / error
    }
}
