//! What the motions determine, and what they do not.

use super::fit::Covariance;
use crate::recording::{Finding, FindingKind};
use crate::segment::face::AXES;

/// A matrix that is not known better than this is no better than the data
/// sheet's, which allows 3 %.
const LIMIT: f64 = 0.03;

/// Motions with two residuals each for nine parameters, and three residuals to
/// judge them by.
pub(super) const LEAST_MOTIONS: usize = 6;

/// Which axes lack a turn: none when the covariance of E says that all nine
/// elements are known to [`LIMIT`] in every direction.
pub(super) fn lacking(
    covariance: Option<&Covariance>,
    motions: usize,
    nominal: bool,
) -> Option<Finding> {
    let (axes, worst) = match covariance {
        Some(c) if motions >= LEAST_MOTIONS => weak_axes(c),
        _ => (vec![0, 1, 2], f64::INFINITY),
    };
    if axes.is_empty() {
        return None;
    }
    let names = |list: &[usize]| -> String {
        let names: Vec<String> = list.iter().map(|i| AXES[*i].to_string()).collect();
        names.join(" and ")
    };
    let strong: Vec<usize> = (0..3).filter(|i| !axes.contains(i)).collect();
    let how_well = if worst < 10.0 {
        format!("known to {:.0} %", 100.0 * worst)
    } else {
        "not known at all".to_owned()
    };
    let then = if nominal {
        "it gets its bias only, with the nominal scale"
    } else {
        "it is not calibrated"
    };
    let message = if motions < LEAST_MOTIONS {
        format!(
            "{motions} usable motions between static intervals are too few for the gyroscope: {LEAST_MOTIONS} are needed, and twice as many are good; {then}"
        )
    } else if strong.is_empty() {
        format!(
            "the {motions} usable motions between static intervals do not determine the gyroscope: its matrix is {how_well}, no better than the data sheet says; {then}. Turn it more often, by 90° and more about each axis while that axis is level"
        )
    } else {
        format!(
            "the {motions} usable motions between static intervals turn about {} of 3 axes enough ({}), but too little about {} ({how_well}); {then}. Turn it about {} too, by 90° and more, with that axis level",
            strong.len(),
            names(&strong),
            names(&axes),
            names(&axes)
        )
    };
    Some(Finding::new(FindingKind::GyroUndetermined, message))
}

/// Axes whose column of E has a part in a direction known worse than
/// [`LIMIT`], and the standard deviation in the worst direction.
fn weak_axes(covariance: &Covariance) -> (Vec<usize>, f64) {
    let elements = covariance.fixed_view::<9, 9>(0, 0).into_owned();
    let eigen = elements.symmetric_eigen();
    let mut load = [0.0_f64; 3];
    let mut worst = 0.0_f64;
    for (i, &value) in eigen.eigenvalues.iter().enumerate() {
        let deviation = value.max(0.0).sqrt();
        if deviation.is_nan() || deviation > LIMIT {
            worst = worst.max(deviation);
            for row in 0..3 {
                for axis in 0..3 {
                    load[axis] += value * eigen.eigenvectors[(3 * row + axis, i)].powi(2);
                }
            }
        }
    }
    let total: f64 = load.iter().sum();
    let axes = (0..3).filter(|i| load[*i] > 0.1 * total).collect();
    (axes, worst)
}
