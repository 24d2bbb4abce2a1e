//! A session as the estimators see it, and what makes it impossible to estimate: recordings of different
//! sensors, and poses that leave parameters open.

use std::cmp::Ordering;

use gravical_core::matrix3::{norm, sub};
use gravical_fit::consistency::{Placements, compare};
use gravical_fit::model::{BIAS, DRIFT};
use gravical_fit::{Options, Sensor, Undetermined, centre, fit};

use crate::calibrate::CalibrateOptions;
use crate::finding::OrderOf;
use crate::poses::face::{AxisMap, Face, axes_where};
use crate::poses::{Pose, Segmentation, advise_rate};
use crate::problem::Problem;
use crate::recording::Recording;
use crate::{Error, Result};

/// Recordings, poses, and what the user says of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Session<'a> {
    pub recordings: &'a [Recording],
    pub segmentation: &'a Segmentation,
    pub options: &'a CalibrateOptions,
}

impl Session<'_> {
    pub fn axes(&self) -> &AxisMap {
        &self.options.segment.axes
    }

    pub fn gravity_mps2(&self) -> f64 {
        self.options.gravity.value_mps2
    }

    /// What is taken off the readings of the accelerometer, input unit.
    pub fn zero_offset(&self) -> f64 {
        self.recordings.first().map_or(0.0, |r| r.units.zero_offset)
    }

    /// Numbers of the poses in the order of time, and where that is from: lines of one recording, the stamps of several,
    /// else the order of their names.
    pub fn order(&self) -> (Vec<usize>, OrderOf) {
        let stamps = self.recordings.iter().map(Recording::start_unix_s);
        let stamps: Option<Vec<f64>> = stamps.collect();
        let order_of = match (self.recordings.len(), &stamps) {
            (..=1, _) => OrderOf::Lines,
            (_, Some(_)) => OrderOf::Stamps,
            _ => OrderOf::Names,
        };
        let place = |k: &usize| {
            let pose = &self.segmentation.poses[*k];
            let start_s = stamps.as_ref().and_then(|s| s.get(pose.recording).copied());
            (start_s.unwrap_or(0.0), pose.recording, pose.lines)
        };
        let mut order: Vec<usize> = (0..self.segmentation.poses.len()).collect();
        order.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(Ordering::Equal));
        (order, order_of)
    }

    pub fn nominal(&self) -> Option<f64> {
        self.recordings.first()?.units.accel.nominal()
    }

    /// Input units per m/s²: nominal, or as gravity reads.
    pub fn scale(&self) -> f64 {
        let poses = &self.segmentation.poses;
        let centre = centre(poses.iter().map(|p| &p.mean));
        let lengths = poses.iter().map(|p| norm(&sub(&p.mean, &centre)));
        let mut lengths: Vec<f64> = lengths.collect();
        let usual =
            || gravical_signal::stats::median(&mut lengths).unwrap_or(1.0) / self.gravity_mps2();
        self.nominal().unwrap_or_else(usual)
    }
}

/// A recording is fitted alone from so many poses: scale, angles and bias are nine parameters, or six
/// faces.
const MIN_POSES: usize = 6;
/// One sensor differs by more than this less often.
const CHANCE: f64 = 1e-6;
/// What a sensor changes by from one recording to the next, with temperature and from start to start:
/// elements of M (relative) and bias (m/s², 5 mg). Two parts differ by ten times that.
const CHANGES: [f64; 2] = [2e-3, 0.05];

/// Refuses recordings whose own fits contradict each other by more than their covariances and the
/// changes of one sensor allow. Recordings with too few poses to be fitted alone are not judged.
///
/// # Errors
///
/// `sensors-differ`, at the first recording that contradicts one before it.
pub(super) fn one_sensor(
    session: &Session<'_>,
    poses: &[gravical_fit::Pose],
    mut options: Options,
) -> Result<()> {
    let placements = &session.segmentation.poses;
    options.drift = false;
    let mut alone: Vec<(&str, Sensor)> = Vec::new();
    for (index, recording) in session.recordings.iter().enumerate() {
        let each = poses.iter().zip(placements);
        let own = each.filter(|(_, placement)| placement.recording == index);
        let own: Vec<_> = own.map(|(pose, _)| pose.clone()).collect();
        let Some(fit) = Some(own)
            .filter(|own| own.len() >= MIN_POSES)
            .and_then(|own| fit(&own, &options).ok())
        else {
            continue;
        };
        let mut sensor = fit.sensor(session.scale());
        for i in 0..DRIFT {
            let change = CHANGES[usize::from(i >= BIAS)];
            sensor.covariance[(i, i)] += 0.5 * change * change;
        }
        let name = &recording.name;
        let placements = Placements::default();
        let differs = alone.iter().find_map(|(other, before)| {
            let apart = compare([before, &sensor].map(|s| (s, &placements)))?.magnitude;
            (apart.test.p_value < CHANCE).then_some((*other, apart.value))
        });
        if let Some((other, apart)) = differs {
            let largest = |first: usize| {
                apart[first..first + 3]
                    .iter()
                    .map(|v| v.abs())
                    .fold(0.0, f64::max)
            };
            let differ = Problem::FitsDiffer {
                files: [other, name.as_str()].map(str::to_owned),
                scale_percent: 100.0 * largest(3),
                bias_mps2: largest(0),
            };
            return Err(differ.error().at(name.as_ref(), None));
        }
        alone.push((name, sensor));
    }
    Ok(())
}

/// The error for poses that leave the parameters open.
pub(super) fn explain(open: Undetermined, session: &Session<'_>) -> Error {
    let poses = &session.segmentation.poses;
    if poses.is_empty() {
        return at_only(session.recordings, Problem::NoPoses.error());
    }
    let centre = centre(poses.iter().map(|p| &p.mean));
    let nearest = |pose: &Pose| {
        Face::nearest(session.axes().to_case(sub(&pose.mean, &centre)))
            .0
            .axis
    };
    let is_up = |axis: usize| poses.iter().any(|pose| nearest(pose) == axis);
    let problem = Problem::Underdetermined {
        poses: poses.len(),
        covered: axes_where(is_up),
        missing: axes_where(|axis| !is_up(axis)),
        open: open.direction,
        sd_mps2: open.sd_mps2,
    };
    let found = poses.iter().filter(|pose| pose.is_found);
    let found = found.map(|pose| &session.recordings[pose.recording]);
    at_only(session.recordings, advise_rate(problem.error(), found))
}

/// The error at the only recording; of several none is meant.
pub(super) fn at_only(recordings: &[Recording], error: Error) -> Error {
    match recordings {
        [one] => error.at(one.name.as_ref(), None),
        _ => error,
    }
}
