//! What is known of sensor and gravity before anything moves, and what is assumed
//! where nothing is.

use std::ops::Range;

use gravical_core::matrix3::norm;

use super::anchors::{Anchors, RandomWalk, Side};
use super::misfit::GravityMisfit;
use super::nominal::Nominal;
use super::options::{GravityRemoval, MotionOptions};
use super::parameters::{self, Assumed, DATA_SHEET, Direction, TURNED, UNSTATED};
use super::samples::{Samples, View};
use super::scales::Scales;
use super::words;
use crate::calibration_file::{CalibrationFile, GyroMethod};
use crate::gravity::Gravity;
use crate::recording::{Finding, Recording};
use gravical_fit::model::Covariance;

/// Mean specific force over the first rest, m/s².
pub(super) fn force_at_rest(
    samples: &Samples,
    rests: &[Range<usize>],
    walk: RandomWalk,
) -> Option<[f64; 3]> {
    (!rests.is_empty()).then(|| {
        Anchors::new(View::calibrated(samples), walk)
            .at(rests, 0, Side::Last)
            .force
    })
}

/// A calibration, how it was applied, and the samples that it gave.
pub(super) struct Applied<'a> {
    pub file: Option<&'a CalibrationFile>,
    pub scales: &'a Scales,
    pub samples: &'a Samples,
    /// The samples by nominal scales alone; none without a calibration.
    pub nominal: Option<&'a Nominal>,
    pub walk: RandomWalk,
}

/// Which parameters may be off, and by how much, before the rests are asked.
pub(super) fn directions(
    applied: &Applied<'_>,
    rests: &[Range<usize>],
    options: &MotionOptions,
) -> Vec<Direction> {
    let Applied { file, samples, .. } = *applied;
    let mut all = match file {
        Some(file) => {
            of_accelerometer(file, file.accelerometer.covariance_of_parameters(), options)
                .unwrap_or_else(|| parameters::by_class(&UNSTATED))
        }
        None => {
            // Gravity itself may show more than a data sheet allows.
            let force = force_at_rest(samples, rests, applied.walk);
            let off = force.map_or(0.0, |f| {
                (norm(&f) / local_gravity(file, options).value_mps2 - 1.0).abs()
            });
            parameters::by_class(&Assumed {
                scale: DATA_SHEET.scale.max(off),
                ..DATA_SHEET
            })
        }
    };
    if samples.rate_rad_s.is_some() && options.gravity_removal == GravityRemoval::Strapdown {
        let own = file.filter(|_| applied.scales.gyro_calibrated);
        let fitted = own
            .and_then(|f| f.gyroscope.as_ref())
            .is_some_and(|g| g.method != GyroMethod::Bias);
        let assumed = if fitted { TURNED } else { DATA_SHEET };
        all.extend(parameters::of_gyroscope(own, &assumed, &options.axes));
    }
    all
}

fn of_accelerometer(
    file: &CalibrationFile,
    covariance: Option<Covariance>,
    options: &MotionOptions,
) -> Option<Vec<Direction>> {
    parameters::by_covariance(&file.accelerometer, &covariance?, &options.axes)
}

/// What the rests say against a calibration.
#[derive(Default)]
pub(super) struct Doubts {
    /// What may be off beside [`directions`].
    pub directions: Vec<Direction>,
    pub misfit: Option<GravityMisfit>,
    pub findings: Vec<Finding>,
}

/// Holds the calibration that was applied against gravity at `rests`, and against what the
/// recording says of itself.
pub(super) fn doubts(
    applied: &Applied<'_>,
    rests: &[Range<usize>],
    directions: &[Direction],
    recording: &Recording,
    options: &MotionOptions,
) -> Doubts {
    let Some(file) = applied.file else {
        return Doubts::default();
    };
    let mut doubts = Doubts::default();
    if file.accelerometer.covariance_of_parameters().is_none() {
        doubts.findings.push(words::no_covariance());
    }
    let gravity = local_gravity(Some(file), options).value_mps2;
    // Where gravity is that of the calibration, its error is the same in both.
    let known = match options.gravity {
        Some(_) => None,
        None => file.sensor().map(|s| s.covariance),
    };
    let own = of_accelerometer(file, known, options);
    let directions = own.as_deref().unwrap_or(directions);
    let worst =
        |view: View<'_>| GravityMisfit::worst(view, rests, applied.walk, directions, gravity);
    let view = View::calibrated(applied.samples);
    doubts.misfit = worst(view);
    if let Some(misfit) = doubts.misfit.filter(|m| m.contradicts) {
        doubts.directions.extend(misfit.directions());
        doubts.findings.extend(words::misfit(&misfit));
    }
    // Raw columns of the same name show other gravity than calibrated ones.
    let raw = applied
        .nominal
        .and_then(|nominal| worst(View::nominal(applied.samples, nominal)));
    let by_board = recording.is_calibrated_by_board;
    let named = recording.is_calibrated && raw.is_none_or(|raw| !raw.contradicts);
    if by_board || named {
        let nominal = 1.0 / applied.scales.by_scale.matrix[0][0];
        let twice = parameters::applied_twice(file, nominal, &options.axes);
        doubts.directions.push(twice);
        doubts.findings.push(words::already_calibrated(by_board));
    }
    doubts
}

pub(super) fn local_gravity(file: Option<&CalibrationFile>, options: &MotionOptions) -> Gravity {
    options.gravity.unwrap_or_else(|| match file {
        Some(file) => Gravity {
            value_mps2: file.gravity_mps2,
            source: file.gravity_source,
        },
        None => Gravity::default(),
    })
}

/// Mean of the first rows, and the seconds that it is over.
pub(super) fn initial_mean(view: View<'_>, rows: usize, walk: RandomWalk) -> ([f64; 3], f64) {
    let rows = 0..rows.min(view.samples.len());
    let anchors = Anchors::new(view, walk);
    let seconds = anchors.seconds(&rows);
    (anchors.whole(rows).force, seconds)
}
