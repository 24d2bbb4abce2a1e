//! Recordings of one session that are of different sensors.

use gravical_core::matrix3;
use gravical_fit::{Fit, Options, Pose, consistent, fit};
use nalgebra::{DMatrix, DVector};

use crate::numfmt::milli_g;
use crate::uncertainty::{invariant_derivatives, invariants};
use crate::{Error, Result};

use super::session::Session;

/// A recording is fitted alone from so many poses: scale, angles and bias are nine parameters, or six
/// faces.
const MIN_POSES: usize = 6;
/// One sensor differs by more than this less often.
const CHANCE: f64 = 1e-6;
/// What a sensor changes by from one recording to the next, with temperature and from start to start:
/// scale (relative), cosines between the axes, bias (m/s², 5 mg). Two parts differ by ten times that.
const CHANGES: [f64; 3] = [2e-3, 2e-3, 0.05];

/// Refuses recordings whose own fits contradict each other by more than their covariances and the
/// changes of one sensor allow. Recordings with too few poses to be fitted alone are not judged.
///
/// # Errors
///
/// `sensors-differ`, at the recording that contradicts all others where they agree.
pub(super) fn one_sensor(session: &Session<'_>, poses: &[Pose], options: &Options) -> Result<()> {
    let placements = &session.segmentation.placements;
    let fit_alone = |index: usize| {
        let of_recording = poses
            .iter()
            .zip(placements)
            .filter(|(_, p)| p.recording == index)
            .map(|(pose, _)| pose.clone());
        let poses: Vec<Pose> = of_recording.collect();
        (poses.len() >= MIN_POSES).then(|| fit(&poses, options).ok())?
    };
    let alone: Vec<(&str, Fit)> = session
        .recordings
        .iter()
        .enumerate()
        .filter_map(|(index, recording)| Some((recording.name.as_str(), fit_alone(index)?)))
        .collect();
    let differ: Vec<Vec<bool>> = alone
        .iter()
        .map(|(_, a)| alone.iter().map(|(_, b)| chance(a, b) < CHANCE).collect())
        .collect();
    let against = |i: usize| differ[i].iter().filter(|d| **d).count();
    let Some(worst) = (0..alone.len()).max_by_key(|&i| against(i)) else {
        return Ok(());
    };
    if against(worst) == 0 {
        return Ok(());
    }
    let name = alone[worst].0;
    let others: Vec<&str> = (0..alone.len())
        .filter(|&i| differ[worst][i])
        .map(|i| alone[i].0)
        .collect();
    let is_odd_one = alone.len() > 2 && (0..alone.len()).all(|i| i == worst || against(i) == 1);
    let ([scale, bias], with) = apart(&alone, worst, &differ[worst]);
    let (prefix, rest, hint) = if is_odd_one {
        (
            "one recording does not belong to the others: ",
            "the others".to_owned(),
            format!("calibrate without {name}, and calibrate that one alone"),
        )
    } else {
        (
            "",
            others.join(", "),
            format!(
                "calibrate the recordings of each sensor alone: {name} and {with} do not go together"
            ),
        )
    };
    let message = format!(
        "{prefix}{name} and {rest} are of different sensors: fitted alone, their scales are {scale:.1} % and their biases {bias:.0} mg apart, more than one sensor changes"
    );
    Err(Error::input("sensors-differ", message)
        .at(name.as_ref(), None)
        .with_hint(hint))
}

/// Chance that one sensor gives two fits that lie so far apart.
fn chance(a: &Fit, b: &Fit) -> f64 {
    let [x, y] = [a, b].map(|fit| invariants(&fit.model(), &fit.bias()));
    let scale = matrix3::row_norms(&a.model());
    // Everything in m/s² of 1 g or without unit, so that components compare.
    let unit: [f64; 9] = std::array::from_fn(|i| match i {
        0..3 => scale[i],
        3..6 => 1.0,
        _ => scale[i - 6],
    });
    let difference = DVector::from_fn(9, |i, _| (x[i] - y[i]) / unit[i]);
    let changes = DVector::from_fn(9, |i, _| CHANGES[i / 3].powi(2));
    let mut covariance = DMatrix::from_diagonal(&changes);
    for fit in [a, b] {
        let (h, c) = (invariant_derivatives(&fit.model()), fit.covariance());
        let h = DMatrix::from_fn(9, 12, |i, j| h[i][j] / unit[i]);
        let c = DMatrix::from_fn(12, 12, |i, j| c[i][j]);
        covariance += &h * c * h.transpose();
    }
    consistent(&difference, &covariance).p_value
}

/// Largest distances of scales in % and of biases in mg to the recording that `worst` differs from
/// most, and the name of that.
fn apart<'a>(alone: &[(&'a str, Fit)], worst: usize, differ: &[bool]) -> ([f64; 2], &'a str) {
    let of = |i: usize| invariants(&alone[i].1.model(), &alone[i].1.bias());
    let this = of(worst);
    let distance = |i: usize| {
        let other = of(i);
        let largest = |range: std::ops::Range<usize>, unit: usize| {
            range.fold(0.0_f64, |m, e| {
                m.max((this[e] - other[e]).abs() / this[e - unit])
            })
        };
        (
            [100.0 * largest(0..3, 0), milli_g(largest(6..9, 6))],
            alone[i].0,
        )
    };
    (0..alone.len())
        .filter(|&i| differ[i])
        .map(distance)
        .max_by(|a, b| (a.0[0] + a.0[1]).total_cmp(&(b.0[0] + b.0[1])))
        .unwrap_or(([0.0; 2], alone[worst].0))
}
