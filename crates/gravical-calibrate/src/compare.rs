//! Do two calibrations of one sensor differ by more than their uncertainty?
//!
//! A board that sits differently in its case, or faces that lie crookedly, turn the frame: that
//! changes the direction of what is measured and never its length. So a difference is reported in
//! two parts, each with its own test: what changes ‖a‖ (bias, scale, angles between the axes), and
//! the rotation between the frames ([`gravical_fit::consistency::compare`]).
//!
//! It rests on the covariances of both files. What they leave out (drift with temperature, another
//! gravity, shared recordings) is said.

use gravical_core::matrix3::norm;
use gravical_core::unit::DEGREES_PER_RADIAN;
use gravical_fit::{Sensor, Test, consistency};
use gravical_judge::numfmt::{COVERAGE, decimals_for, fixed, signed, unit};
use serde::Serialize;

use crate::Result;
use crate::calibration_file::{Accelerometer, Calibration, TemperatureRange};
use crate::finding::{Case, Finding};
use crate::judgement::{
    Judgement, PART_SIGNIFICANCE, Side, Verdict, gravity_differs, judge, sensor,
};
use crate::problem::Problem;
use crate::recording::AccelUnit;

/// Scales within this fraction of each other are of one unit and range: far beyond any sensor, far
/// below the next range.
const SAME_SCALE: f64 = 0.2;

/// Sessions further apart than this were at different temperatures, °C: by data sheet the bias of
/// an MPU6050 moves by 1.5 to 2.7 mg over that.
const TEMPERATURE_STEP_C: f64 = 3.0;

/// Two calibrations, compared. A is the first one, B the second; every difference is B − A.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The files as they were given.
    pub files: [String; 2],
    /// Their dates and sensors.
    pub sides: [Side; 2],
    /// Days from A to B, by their recordings, else by when they were computed.
    pub age_days: Option<f64>,
    /// Gravity that each scale rests on, m/s².
    pub gravity_mps2: [f64; 2],
    /// Temperatures of the two sessions, °C.
    pub temperature_c: [Option<TemperatureRange>; 2],
    /// The differences, one entry a parameter.
    pub parameters: Vec<ParameterDifference>,
    /// What changes ‖a‖: bias, scale and the angles between the sensor's axes.
    pub magnitude: MagnitudeDifference,
    /// How the frames are turned against each other; null when one is the mirror image of the
    /// other.
    pub orientation: Option<OrientationDifference>,
    /// Names or types, where the files are of two sensors.
    pub two_sensors: Option<[String; 2]>,
    /// What has to be known to read the result.
    pub findings: Vec<Finding>,
    /// The judgement of both parts together.
    pub verdict: Verdict,
}

/// One parameter of two calibrations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterDifference {
    /// `bias_x` … `scale_z`, `angle_xy` …, `rotation_x` ….
    pub name: String,
    /// `m/s^2` for the bias, `%` of nominal for the scale, `deg` for angles.
    pub unit: &'static str,
    /// Value in A; null for the rotation, which is between the two.
    pub a: Option<f64>,
    /// Value in B.
    pub b: Option<f64>,
    /// B − A.
    pub difference: f64,
    /// Its standard deviation by both covariances; null without them.
    pub sigma: Option<f64>,
    /// difference / sigma.
    pub z: Option<f64>,
}

/// Names of the nine invariants and of the turn; three of each have a unit and a factor to it.
const PARTS: [(&str, [&str; 3], &str, f64); 4] = [
    ("bias", ["x", "y", "z"], "m/s^2", 1.0),
    ("scale", ["x", "y", "z"], "%", 100.0),
    ("angle", ["xy", "xz", "yz"], "deg", DEGREES_PER_RADIAN),
    ("rotation", ["x", "y", "z"], "deg", DEGREES_PER_RADIAN),
];

/// The differences one by one; `with_sigma`: both have a covariance.
fn parameters(found: &consistency::Compare, with_sigma: bool) -> Vec<ParameterDifference> {
    let turn = found.turn.as_ref();
    let [a, b] = &found.invariants;
    let one = |k: usize| {
        let (part_name, axes, unit, factor) = PARTS[k / 3];
        let (i, is_invariant) = (k % 9, k < 9);
        let part = if is_invariant {
            &found.magnitude
        } else {
            turn?
        };
        let (difference, sigma) = (factor * part.value[i], factor * part.sd[i]);
        Some(ParameterDifference {
            name: format!("{part_name}_{}", axes[k % 3]),
            unit,
            a: is_invariant.then(|| factor * a[i]),
            b: is_invariant.then(|| factor * b[i]),
            difference,
            sigma: with_sigma.then_some(sigma),
            z: (with_sigma && sigma > 0.0).then(|| difference / sigma),
        })
    };
    (0..12).filter_map(one).collect()
}

/// The part that changes the length of what is measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MagnitudeDifference {
    /// Of ‖a‖ by both for six readings on faces, and of the three angles; null without covariances.
    pub test: Option<Test>,
    /// The judgement.
    pub judgement: Judgement,
    /// Root mean square over all directions of ‖a‖ by B less ‖a‖ by A for the same reading at
    /// rest, m/s².
    pub norm_rms_mps2: f64,
    /// What the two uncertainties predict for it, m/s².
    pub predicted_rms_mps2: Option<f64>,
    /// Where it is largest: the difference with its sign, m/s².
    pub norm_largest_mps2: f64,
    /// In this direction (calibrated axes of A).
    pub largest_at: [f64; 3],
}

/// The part that changes the direction of what is measured and not its length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrientationDifference {
    /// Angle by which the frame of B is turned against that of A, degrees.
    pub angle_deg: f64,
    /// About this axis; zero for no turn.
    pub axis: [f64; 3],
    /// Of the three components of the rotation vector; null without covariances, or where the
    /// placements of a session do not show how its frame sits in the case.
    pub test: Option<Test>,
    /// The judgement.
    pub judgement: Judgement,
}

/// Compares two calibrations; `names` are the files as they were given.
///
/// # Errors
///
/// `units-differ` (input) where their units or ranges are not the same, `calibration-values` where
/// a matrix is singular.
///
/// # Example
///
/// ```
/// # use gravical_calibrate as gravical;
/// use gravical::calibrate::{CalibrateOptions, calibrate};
/// use gravical::check::Judgement;
/// use gravical::compare::compare;
/// use gravical::calibrate::Method;
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&session, &options)?.calibration;
/// let mut moved = file.clone();
/// moved.accelerometer.bias[0] += 1.0;
/// let result = compare(&file, &moved, ["a.json", "b.json"])?;
/// assert!((result.parameters[0].difference - 1.0).abs() < 1e-9);
/// // Six means without standard errors carry no covariance.
/// assert_eq!(result.verdict.judgement, Judgement::Undecided);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn compare(a: &Calibration, b: &Calibration, names: [&str; 2]) -> Result<Comparison> {
    let pair = [a, b];
    let mut findings = Vec::new();
    let sensors = sensors(pair, names, &mut findings)?;
    let placements = pair.map(Calibration::placements);
    let found = consistency::compare([0, 1].map(|i| (&sensors[i], &placements[i])))
        .ok_or_else(|| Problem::Singular.error().at(names[1].as_ref(), None))?;
    let gravity_mps2 = pair.map(|f| f.gravity_mps2);
    findings.extend(gravity_differs(gravity_mps2, ["in A", "in B"]));
    for (file, name) in pair.into_iter().zip(names) {
        findings.extend(file.poor_finding().map(|f| f.in_file(name)));
    }
    let [x, y] = pair.map(|f| &f.accelerometer);
    let is_same = x.matrix == y.matrix && x.bias == y.bias;
    let has_covariances = [x, y]
        .iter()
        .all(|s| s.covariance_of_parameters().is_some());
    let shared = shared(a, b).filter(|_| !is_same);
    // Why agreement would prove nothing.
    let no_proof = match &shared {
        _ if !has_covariances => Some("one of the files has no covariance"),
        Some(_) => Some("both were made from the same recordings"),
        None => None,
    };
    findings.extend(shared);
    let mut reasons = Vec::new();
    let mut judged = |what: &str, test: Option<Test>, no_proof: Option<&str>| {
        let level = (PART_SIGNIFICANCE, Judgement::Differs);
        let (judgement, reason) = if is_same {
            (Judgement::Agrees, format!("{what}: the same in both"))
        } else {
            judge(what, test.as_ref(), level, no_proof)
        };
        reasons.push(reason);
        judgement
    };
    let tested = |test: Test| Some(test).filter(|t| has_covariances && t.degrees_of_freedom > 0);
    let parameters = parameters(&found, has_covariances);
    let test = tested(found.magnitude.test);
    let magnitude = MagnitudeDifference {
        test,
        judgement: judged("bias, scale and misalignment", test, no_proof),
        norm_rms_mps2: found.norm.rms_mps2,
        predicted_rms_mps2: has_covariances.then_some(found.norm.predicted_rms_mps2),
        norm_largest_mps2: found.norm.largest_mps2,
        largest_at: found.norm.largest_at,
    };
    let fits = pair.map(|f| f.reliability.fit);
    let is_oriented = fits.iter().flatten().all(|fit| fit.oriented);
    let open = "one of the sessions has faces on less than two axes";
    let orientation = found.turn.map(|turn| {
        let test = tested(turn.test).filter(|_| is_oriented);
        let no_proof = no_proof.or((!is_oriented).then_some(open));
        let turn: [f64; 3] = std::array::from_fn(|i| turn.value[i]);
        let angle = norm(&turn);
        OrientationDifference {
            angle_deg: angle.to_degrees(),
            axis: turn.map(|v| if angle > 0.0 { v / angle } else { 0.0 }),
            test,
            judgement: judged("directions of the axes in the case", test, no_proof),
        }
    });
    if magnitude.judgement.is_change() {
        reasons.splice(1..1, most(&parameters[..9]));
    }
    // Mirror images differ, whatever their uncertainty. A rotation that agrees may be a convention;
    // ‖a‖ does not depend on it.
    let judgement = match &orientation {
        Some(orientation) if !orientation.judgement.is_change() => magnitude.judgement,
        _ => Judgement::Differs,
    };
    if orientation.is_none() {
        reasons.push("one frame is the mirror image of the other".to_owned());
        findings.push(Case::FramesMirrored.finding());
    }
    if judgement.is_change() {
        reasons.extend(circumstance(pair));
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    let sides = pair.map(Side::of_calibration);
    Ok(Comparison {
        files: names.map(str::to_owned),
        age_days: sides[0].days_to(&sides[1]),
        sides,
        gravity_mps2,
        temperature_c: pair.map(|f| f.temperature_c),
        two_sensors: two_sensors(pair),
        parameters,
        magnitude,
        orientation,
        findings,
        verdict: Verdict { judgement, reasons },
    })
}

fn most(parameters: &[ParameterDifference]) -> Option<String> {
    let size = |p: &&ParameterDifference| p.z.map_or(-1.0, f64::abs);
    let p = parameters
        .iter()
        .max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let within = COVERAGE * p.sigma?;
    let n = decimals_for(within);
    let (change, within) = (signed(p.difference, n), fixed(within, n));
    let (name, unit) = (p.name.replace('_', " "), unit(p.unit));
    Some(format!("most of all {name}, by {change} ± {within} {unit}"))
}

/// Names or types, where the files are of two sensors.
fn two_sensors([a, b]: [&Calibration; 2]) -> Option<[String; 2]> {
    let differ = |x: &Option<String>, y: &Option<String>| {
        let both = x.clone().zip(y.clone());
        both.filter(|(x, y)| x != y).map(|(x, y)| [x, y])
    };
    differ(&a.sensor.id, &b.sensor.id).or_else(|| differ(&a.sensor.model, &b.sensor.model))
}

/// What may be behind a difference, beside a change of the sensor.
fn circumstance(pair: [&Calibration; 2]) -> Option<String> {
    if let Some([a, b]) = two_sensors(pair) {
        return Some(format!("these are two sensors, \"{a}\" and \"{b}\""));
    }
    let [a, b] = pair.map(|f| f.temperature_c.map(|range| range.mean));
    let (a, b) = a.zip(b)?;
    ((b - a).abs() > TEMPERATURE_STEP_C).then(|| format!(
        "the sessions were at {a:.1} °C and {b:.1} °C; the bias of an MPU6050 moves by 0.5 mg (x, y) to 0.9 mg (z) per °C, which the uncertainties do not include"
    ))
}

/// Says which recordings both were made from.
fn shared(a: &Calibration, b: &Calibration) -> Option<Finding> {
    let mut shared = a
        .recordings()
        .filter(|i| i.sha256.is_some() && b.recordings().any(|j| j.sha256 == i.sha256));
    let first = shared.next()?.path.clone();
    let (shared, all) = (1 + shared.count(), a.recordings().count());
    Some(Case::RecordingsShared { shared, all, first }.finding())
}

/// Both as numbers, with readings divided by their nominal scale.
///
/// # Errors
///
/// `units-differ` (input) where units or ranges are not the same; `calibration-values` for a singular
/// matrix.
fn sensors(
    pair: [&Calibration; 2],
    names: [&str; 2],
    findings: &mut Vec<Finding>,
) -> Result<[Sensor; 2]> {
    let both = pair.map(|f| &f.accelerometer);
    let (units, per_mps2) = (
        both.map(|s| s.input_unit),
        both.map(Accelerometer::mean_scale),
    );
    let is_unknown = units.contains(&AccelUnit::Unknown);
    let is_one_unit = is_unknown || units[0] == units[1];
    if !is_one_unit || (per_mps2[1] / per_mps2[0] - 1.0).abs() > SAME_SCALE {
        let names = names.map(str::to_owned);
        return Err(Problem::CalibrationsDiffer {
            names,
            units,
            per_mps2,
        }
        .error());
    }
    findings.extend(is_unknown.then(|| Case::ScalesAlike.finding()));
    let nominal = both[0].nominal_per_mps2().or(both[1].nominal_per_mps2());
    let one = |i: usize| {
        sensor(
            pair[i],
            names[i],
            nominal.unwrap_or(per_mps2[0]),
            both[i].zero_offset(),
        )
    };
    Ok([one(0)?, one(1)?])
}
