//! Do two calibrations of one sensor differ by more than their uncertainty?
//!
//! A board that sits differently in its case, or faces that lay crookedly, turn
//! the frame: that changes the direction of what is measured and never its
//! length. So a difference is reported in two parts, each with its own test: what
//! changes ‖a‖ (bias, scale, angles between the axes: M Mᵀ and b of u = M a + b),
//! and the rotation between the frames.
//!
//! It rests on the covariances of both files. What they leave out (drift with
//! temperature, another gravity, shared recordings) is reported as a finding.

mod findings;
mod norms;
mod parameters;
mod types;
mod unit;
mod verdict;

use nalgebra::{DMatrix, DVector};

use crate::Result;
use crate::calibration_file::CalibrationFile;
use crate::recording::{Finding, FindingKind};
use crate::segment::face::AXES;
use crate::uncertainty::{chi_square, freedom_of_sum};

use findings::{Independence, SAME_GRAVITY, circumstances, independence, orientation_is_known};
use parameters::{Jacobian, PAIRS, Rotation, invariants, propagate, rotation, second_order};
use unit::{NominalModel, sides};

pub use types::*;

/// Probability at which two calibrations that do not differ are said to: the
/// exit code of `compare` and the verdict rest on it.
pub const SIGNIFICANCE: f64 = 0.01;

/// The same for each of the two parts, so that both together keep
/// [`SIGNIFICANCE`] (Bonferroni).
pub const PART_SIGNIFICANCE: f64 = SIGNIFICANCE / 2.0;

/// A difference in directions without variance is reported above this (share of
/// gravity, share of scale, or rad).
const OUTSIDE: f64 = 1e-6;

/// Names of a rotation's components, and of all parameters.
fn names() -> Vec<(String, ParameterKind)> {
    let each = |prefix: &'static str, kind| AXES.map(|a| (format!("{prefix}_{a}"), kind));
    let mut out: Vec<_> = each("bias", ParameterKind::Bias).into();
    out.extend(each("scale", ParameterKind::Scale));
    out.extend(PAIRS.map(|(i, j)| {
        (
            format!("angle_{}{}", AXES[i], AXES[j]),
            ParameterKind::Misalignment,
        )
    }));
    out.extend(each("rotation", ParameterKind::Orientation));
    out
}

/// Differences B − A of the twelve with their covariance: bias in m/s², scale as
/// share of nominal, angles in rad, the rotation vector in rad.
struct Difference {
    a: [f64; 9],
    b: [f64; 9],
    values: DVector<f64>,
    covariance: Option<DMatrix<f64>>,
    /// Degrees of freedom that the covariance of the rotation is estimated with: it is
    /// that of the tilts.
    turn_freedom: Option<f64>,
    /// Nine without a rotation.
    count: usize,
}

impl Difference {
    fn new(a: &NominalModel, b: &NominalModel, rotation: Option<&Rotation>) -> Self {
        let ((va, ja), (vb, jb)) = (invariants(a), invariants(b));
        let count = if rotation.is_some() { 12 } else { 9 };
        let values = DVector::from_fn(count, |i, _| match rotation {
            Some(rotation) if i >= 9 => rotation.vector[i - 9],
            _ => vb[i] - va[i],
        });
        // Rows of both kinds, with the sign of their side in the difference.
        let rows = |j: &Jacobian<9>, sign: f64, which: usize| -> Jacobian<12> {
            Jacobian::<12>::from_fn(|r, c| match rotation {
                Some(rotation) if r >= 9 => rotation.jacobians[which][(r - 9, c)],
                None if r >= 9 => 0.0,
                _ => sign * j[(r, c)],
            })
        };
        let covariance = a.covariance.as_ref().zip(b.covariance.as_ref());
        let mut turn_freedom = None;
        let covariance = covariance.map(|(ca, cb)| {
            let [of_a, of_b] = [
                propagate(&rows(&ja, -1.0, 0), ca),
                propagate(&rows(&jb, 1.0, 1), cb),
            ];
            let turned = |c: &DMatrix<f64>| (9..12).map(|i| c[(i, i)]).sum::<f64>();
            turn_freedom = freedom_of_sum(&[
                (turned(&of_a), a.tilt_degrees_of_freedom),
                (turned(&of_b), b.tilt_degrees_of_freedom),
            ]);
            let sum = of_a + of_b;
            let mut sum = sum.view((0, 0), (count, count)).into_owned();
            let second = second_order(a, ca) + second_order(b, cb);
            let mut block = sum.view_mut((0, 0), (9, 9));
            block += second;
            sum
        });
        Difference {
            a: va,
            b: vb,
            values,
            covariance,
            turn_freedom,
            count,
        }
    }

    /// χ² of the parameters `from..to`, and what no variance covers; biases are
    /// counted in `gravity`, so that all are shares or rad.
    fn test(&self, from: usize, to: usize, gravity: f64) -> Option<(ChiSquare, f64)> {
        let covariance = self.covariance.as_ref()?;
        let unit = |i: usize| if i < 3 { gravity } else { 1.0 };
        let n = to.min(self.count) - from;
        let d = DVector::from_fn(n, |i, _| self.values[from + i] / unit(from + i));
        let c = DMatrix::from_fn(n, n, |r, k| {
            covariance[(from + r, from + k)] / unit(from + r) / unit(from + k)
        });
        // What changes ‖a‖ is determined by means whose noise is well known.
        let freedom = self.turn_freedom.filter(|_| from == 9);
        chi_square(&d, &c, freedom)
    }

    fn listed(&self) -> Vec<ParameterDifference> {
        let list = names().into_iter().take(self.count).enumerate();
        list.map(|(i, (name, kind))| {
            let (unit, factor) = match kind {
                ParameterKind::Bias => ("m/s^2", 1.0),
                ParameterKind::Scale => ("%", 100.0),
                ParameterKind::Misalignment | ParameterKind::Orientation => {
                    ("deg", 1_f64.to_degrees())
                }
            };
            let sigma = self
                .covariance
                .as_ref()
                .map(|c| factor * c[(i, i)].max(0.0).sqrt());
            let difference = factor * self.values[i];
            ParameterDifference {
                name,
                kind,
                unit: unit.to_owned(),
                a: self.a.get(i).map(|v| factor * v),
                b: self.b.get(i).map(|v| factor * v),
                difference,
                sigma,
                z: sigma.filter(|s| *s > 0.0).map(|s| difference / s),
            }
        })
        .collect()
    }
}

/// Compares two calibrations; `names` are the files as they were given.
///
/// # Errors
///
/// `units-differ` (input) where their units cannot be brought together,
/// `calibration-values` where a matrix is singular.
///
/// # Example
///
/// ```
/// use gravical::calibrate::{CalibrateOptions, calibrate};
/// use gravical::compare::{Agreement, compare};
/// use gravical::estimate::accelerometer::Method;
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&session, &options)?.file;
/// let mut moved = file.clone();
/// moved.accelerometer.bias[0] += 1.0;
/// let result = compare(&file, &moved, ["a.json", "b.json"])?;
/// assert!((result.parameters[0].difference - 1.0).abs() < 1e-9);
/// // Six means without standard errors carry no covariance.
/// assert_eq!(result.verdict.judgement, Agreement::Undecided);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn compare(a: &CalibrationFile, b: &CalibrationFile, names: [&str; 2]) -> Result<Comparison> {
    let mut findings = Vec::new();
    let [side_a, side_b] = sides(a, b, names, &mut findings)?;
    let independence = independence(a, b, &mut findings);
    circumstances(a, b, names, &mut findings);
    let turned = rotation(&side_a, &side_b);
    let difference = Difference::new(&side_a, &side_b, turned.as_ref());
    let gravity = side_a.gravity;

    let magnitude_test = difference.test(0, 9, gravity);
    tell_outside(magnitude_test, "bias, scale or misalignment", &mut findings);
    let ratio = side_b.gravity / side_a.gravity;
    let test_at_one_gravity = ((ratio - 1.0).abs() > SAME_GRAVITY)
        .then(|| {
            let same = side_b.at_gravity(side_a.gravity);
            let turned = rotation(&side_a, &same);
            Difference::new(&side_a, &same, turned.as_ref()).test(0, 9, gravity)
        })
        .flatten()
        .map(|(test, _)| test);
    let known = orientation_is_known(a) && orientation_is_known(b);
    let orientation = turned.as_ref().map(|t| {
        let test = difference.test(9, 12, gravity);
        orientation(t, test, known, independence, &mut findings)
    });
    if orientation.is_none() {
        findings.push(Finding::new(
            FindingKind::FramesMirrored,
            "one calibration describes the mirror image of the other: in one of the sessions two poses were swapped, or an axis has the wrong sign",
        ));
    }
    let norms = norms::difference(&side_a, &side_b);
    let magnitude = MagnitudeDifference {
        test: magnitude_test.map(|(test, _)| test),
        test_at_one_gravity,
        judgement: judge(magnitude_test.map(|(test, _)| test), independence),
        norm_rms_mps2: norms.rms,
        norm_largest_mps2: norms.largest,
        largest_at: norms.largest_at,
        predicted_rms_mps2: norms.predicted_rms,
        predicted_at_largest_mps2: norms.predicted_at_largest,
    };
    let verdict = verdict::verdict(&magnitude, orientation.as_ref(), independence, known);
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    Ok(Comparison {
        files: names.map(str::to_owned),
        gravity_mps2: [a.gravity_mps2, b.gravity_mps2],
        temperature_c: [a.temperature_c, b.temperature_c],
        parameters: difference.listed(),
        magnitude,
        orientation,
        gyroscope: norms::gyroscope(a, b),
        findings,
        verdict,
    })
}

fn judge(test: Option<ChiSquare>, independence: Independence) -> Agreement {
    match (test, independence) {
        (None, _) | (_, Independence::Same) => Agreement::Undecided,
        (Some(test), _) if test.p_value < PART_SIGNIFICANCE => Agreement::Differ,
        (_, Independence::SharedRecordings) => Agreement::Undecided,
        _ => Agreement::Agree,
    }
}

fn tell_outside(test: Option<(ChiSquare, f64)>, what: &str, findings: &mut Vec<Finding>) {
    if let Some((test, outside)) = test
        && outside > OUTSIDE
    {
        findings.push(Finding::new(
            FindingKind::UndeterminedDirection,
            format!(
                "neither file determines some combinations of {what}; the difference in them, {:.2} ‰, is not tested. {}",
                1000.0 * outside,
                match test.degrees_of_freedom {
                    1 => "1 combination is tested".to_owned(),
                    n => format!("{n} combinations are tested"),
                }
            ),
        ));
    }
}

fn orientation(
    rotation: &Rotation,
    test: Option<(ChiSquare, f64)>,
    known: bool,
    independence: Independence,
    findings: &mut Vec<Finding>,
) -> OrientationDifference {
    let length = gravical_core::matrix3::norm(&rotation.vector);
    if known {
        tell_outside(test, "rotation", findings);
    } else {
        findings.push(Finding::new(
            FindingKind::OrientationUnknown,
            "one of the sessions has faces on less than two axes: how its frame sits in the case is a convention, and the rotation between the frames is not tested",
        ));
    }
    let test = test.map(|(test, _)| test).filter(|_| known);
    OrientationDifference {
        angle_deg: length.to_degrees(),
        axis: rotation
            .vector
            .map(|v| if length > 0.0 { v / length } else { 0.0 }),
        judgement: judge(test, independence),
        test,
    }
}

#[cfg(test)]
mod tests;
