//! Recordings of one session that are of different sensors.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::joint::{JointFit, JointOptions, JointPose, joint};
use crate::numfmt::milli_g;
use crate::uncertainty::{chi_square, invariant_derivatives, invariants};
use crate::{Error, Result};

/// A recording is fitted alone from so many placements: scale, angles and bias
/// are nine parameters, or six faces.
const LEAST_PLACEMENTS: usize = 6;
/// One sensor differs by more than this less often.
const CHANCE: f64 = 1e-6;
/// What a sensor changes by from one recording to the next, with temperature and
/// from start to start: scale (relative), cosines between the axes, bias (m/s²,
/// 5 mg). Two parts differ by ten times that.
const CHANGES: [f64; 3] = [2e-3, 2e-3, 0.05];

/// Refuses recordings whose own fits contradict each other by more than their
/// covariances and the changes of one sensor allow. `recording_of` is the index
/// of every pose's recording, `names` what these are called.
///
/// Recordings with too few placements to be fitted alone are not judged.
///
/// # Errors
///
/// `sensors-differ`, at the recording that contradicts all others where they
/// agree.
pub fn one_sensor(
    poses: &[JointPose],
    recording_of: &[usize],
    names: &[&str],
    options: &JointOptions,
) -> Result<()> {
    let alone: Vec<(usize, JointFit)> = (0..names.len())
        .filter_map(|index| {
            let own: Vec<JointPose> = poses
                .iter()
                .zip(recording_of)
                .filter(|(_, of)| **of == index)
                .map(|(pose, _)| *pose)
                .collect();
            let fit = (own.len() >= LEAST_PLACEMENTS).then(|| joint(&own, options));
            Some((index, fit?.ok()?))
        })
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
    let name = |i: usize| names[alone[i].0];
    let others: Vec<&str> = (0..alone.len())
        .filter(|&i| differ[worst][i])
        .map(name)
        .collect();
    let odd = alone.len() > 2 && (0..alone.len()).all(|i| i == worst || against(i) == 1);
    let ([scale, bias], with) = apart(&alone, worst, &differ[worst]);
    let message = format!(
        "{}{} and {} are of different sensors: fitted alone, their scales are {scale:.1} % and their biases {bias:.0} mg apart, more than one sensor changes",
        if odd {
            "one recording does not belong to the others: "
        } else {
            ""
        },
        name(worst),
        if odd {
            "the others".to_owned()
        } else {
            others.join(", ")
        },
    );
    let hint = if odd {
        format!(
            "calibrate without {}, and calibrate that one alone",
            name(worst)
        )
    } else {
        format!(
            "calibrate the recordings of each sensor alone: {} and {} do not go together",
            name(worst),
            name(with)
        )
    };
    Err(Error::input("sensors-differ", message)
        .at(name(worst).as_ref(), None)
        .with_hint(hint))
}

/// Chance that one sensor gives two fits that lie so far apart.
fn chance(a: &JointFit, b: &JointFit) -> f64 {
    let (x, y) = (invariants(&a.model, &a.bias), invariants(&b.model, &b.bias));
    let k = matrix3::row_norms(&a.model);
    // Everything in m/s² of 1 g or without unit, so that components compare.
    let unit: [f64; 9] = std::array::from_fn(|i| match i {
        0..3 => k[i],
        3..6 => 1.0,
        _ => k[i - 6],
    });
    let difference = DVector::from_fn(9, |i, _| (x[i] - y[i]) / unit[i]);
    let mut covariance = DMatrix::from_fn(
        9,
        9,
        |i, j| {
            if i == j { CHANGES[i / 3].powi(2) } else { 0.0 }
        },
    );
    for fit in [a, b] {
        let h = invariant_derivatives(&fit.model);
        let h = DMatrix::from_fn(9, 12, |i, j| h[i][j] / unit[i]);
        let c = DMatrix::from_fn(12, 12, |i, j| fit.covariance[i][j]);
        covariance += &h * c * h.transpose();
    }
    chi_square(&difference, &covariance, None).map_or(1.0, |(test, _)| test.p_value)
}

/// Largest distances of scales in % and of biases in mg to the recording that
/// `worst` differs from most, and which that is.
fn apart(alone: &[(usize, JointFit)], worst: usize, differ: &[bool]) -> ([f64; 2], usize) {
    let of = |i: usize| invariants(&alone[i].1.model, &alone[i].1.bias);
    let own = of(worst);
    (0..alone.len())
        .filter(|&i| differ[i])
        .map(|i| {
            let other = of(i);
            let far = |range: std::ops::Range<usize>, unit: &dyn Fn(usize) -> f64| {
                range.fold(0.0_f64, |m, e| m.max((own[e] - other[e]).abs() / unit(e)))
            };
            let scale = 100.0 * far(0..3, &|e| own[e]);
            let bias = milli_g(far(6..9, &|e| own[e - 6]));
            ([scale, bias], i)
        })
        .max_by(|a, b| (a.0[0] + a.0[1]).total_cmp(&(b.0[0] + b.0[1])))
        .unwrap_or(([0.0; 2], worst))
}
