//! What is known of sensor and gravity before anything moves, and what is assumed
//! where nothing is.

use std::ops::Range;

use gravical_core::matrix3::norm;

use super::anchors::{Anchors, Side, Walk};
use super::options::{GravityRemoval, MotionOptions};
use super::parameters::{self, Assumed, DATA_SHEET, Direction, TURNED, UNSTATED};
use super::samples::{Samples, View};
use super::words;
use crate::calibration_file::CalibrationFile;
use crate::gravity::Gravity;
use crate::recording::Finding;

/// Mean magnitude over the first rest, m/s².
pub(super) fn size_at_rest(samples: &Samples, rests: &[Range<usize>], walk: Walk) -> Option<f64> {
    force_at_rest(samples, rests, walk).map(|f| norm(&f))
}

/// Mean specific force over the first rest, m/s².
pub(super) fn force_at_rest(
    samples: &Samples,
    rests: &[Range<usize>],
    walk: Walk,
) -> Option<[f64; 3]> {
    (!rests.is_empty()).then(|| {
        Anchors::new(View::calibrated(samples), walk)
            .at(rests, 0, Side::Last)
            .force
    })
}

/// Which parameters may be off, and by how much.
pub(super) fn directions(
    file: Option<&CalibrationFile>,
    gyro_calibrated: bool,
    samples: &Samples,
    size: Option<f64>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Vec<Direction> {
    let mut all = match file {
        Some(file) => parameters::by_covariance(file, &options.axes).unwrap_or_else(|| {
            findings.push(words::no_covariance());
            parameters::by_class(&UNSTATED)
        }),
        None => {
            // Gravity itself may show more than a data sheet allows.
            let off = size.map_or(0.0, |s| {
                (s / local_gravity(file, options).value_mps2 - 1.0).abs()
            });
            parameters::by_class(&Assumed {
                scale: DATA_SHEET.scale.max(off),
                ..DATA_SHEET
            })
        }
    };
    if samples.rate_rad_s.is_some() && options.gravity_removal == GravityRemoval::Strapdown {
        let own = file.filter(|_| gyro_calibrated);
        let fitted = own
            .and_then(|f| f.gyroscope.as_ref())
            .is_some_and(|g| g.method != "bias");
        let assumed = if fitted { TURNED } else { DATA_SHEET };
        all.extend(parameters::of_gyroscope(own, &assumed, &options.axes));
    }
    all
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
pub(super) fn initial_mean(view: View<'_>, rows: usize, walk: Walk) -> ([f64; 3], f64) {
    let rows = 0..rows.min(view.samples.len());
    let anchors = Anchors::new(view, walk);
    let seconds = anchors.seconds(&rows);
    (anchors.whole(rows).force, seconds)
}
