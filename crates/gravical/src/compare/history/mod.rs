//! Several calibrations of one sensor: did it change?
//!
//! The nine numbers that change ‖a‖ and the rotation of the frame are tested as [`compare`] tests
//! those of two calibrations, each against a constant and against one step between any two
//! neighbours ([`change`]). What [`compare`] says of each pair of neighbours is listed beside it and
//! does not count for the verdict.

mod change;
mod types;

use nalgebra::{DMatrix, DVector};

use crate::calibration_file::{CalibrationFile, Grade};
use crate::recording::{Finding, FindingKind};
use crate::uncertainty::{ChiSquare, covariance_of};

use super::findings::{SAME_GRAVITY, TEMPERATURE_STEP_C, orientation_is_known, shared_recording};
use super::parameters::{invariants, propagate, rotation, second_order};
use super::types::ParameterKind;
use super::unit::{NominalModel, sides_with};
use super::{PART_SIGNIFICANCE, compare, names};

use change::{Change, Measured};

pub use types::*;

/// 95 % of a normal distribution, for files that do not give their own factor.
const COVERAGE_95: f64 = 1.96;

/// Number of parameters that change ‖a‖.
const NINE: usize = 9;

/// A calibration that is tested.
struct Point<'a> {
    index: usize,
    name: &'a str,
    file: &'a CalibrationFile,
    side: NominalModel,
    /// The files that rest on one gravity share its error.
    group: usize,
}

/// The history of a sensor: `files` with their names, in order of time.
///
/// Not tested, with the reason, are calibrations with the verdict poor, without covariance, in a unit
/// that cannot be converted, and those made from recordings that a later one of the list uses, too.
/// Drift with temperature is in no covariance: sessions at different temperatures are a finding.
///
/// # Example
///
/// ```
/// use gravical::calibrate::{CalibrateOptions, calibrate};
/// use gravical::compare::{Stability, history};
/// use gravical::estimate::accelerometer::Method;
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&session, &options)?.file;
/// // One calibration, and without a covariance: nothing to test.
/// let result = history(&[(&file, "march.json")]);
/// assert_eq!(result.verdict.judgement, Stability::Undecided);
/// assert!((result.entries[0].parameters[0].value - 0.385).abs() < 1e-9);
/// # Ok::<(), gravical::Error>(())
/// ```
#[must_use]
pub fn history(files: &[(&CalibrationFile, &str)]) -> History {
    let mut findings = Vec::new();
    let left_out = left_out(files);
    let (mut entries, points) = read(files, left_out, &mut findings);
    for pair in points.windows(2) {
        let [a, b] = pair else { continue };
        // Their units have been converted.
        let Ok(c) = compare(a.file, b.file, [a.name, b.name]) else {
            continue;
        };
        entries[b.index].since_previous = Some(SincePrevious {
            name: a.name.to_owned(),
            magnitude: c.magnitude.test,
            orientation: c.orientation.as_ref().and_then(|o| o.test),
            judgement: c.verdict.judgement,
        });
        findings.extend(c.findings.into_iter().map(|f| match f.file {
            Some(_) => f,
            None => f.in_file(b.name),
        }));
    }
    let gravity = points.last().map_or(1.0, |p| p.side.gravity);
    let change = magnitude(&points, gravity, false);
    let mean = change.as_ref().map_or_else(Vec::new, |change| {
        let value = |i: usize| change.mean[i] * unit_of(i, gravity);
        listed(0, &(0..NINE).map(value).collect::<Vec<_>>(), None, 0.0)
    });
    let differs = |p: &Point<'_>| (p.side.gravity / gravity - 1.0).abs() > SAME_GRAVITY;
    let at_one_gravity = match points.iter().any(differs) {
        true => magnitude(&points, gravity, true).map(|c| described(&c, &points, 0, gravity)),
        false => None,
    };
    let magnitude = change.map(|c| described(&c, &points, 0, gravity));
    let orientation = orientation(&points);
    let verdict = verdict(
        &points,
        magnitude.as_ref(),
        at_one_gravity.as_ref(),
        &orientation,
    );
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    History {
        tested: points.len(),
        entries,
        mean,
        magnitude,
        magnitude_at_one_gravity: at_one_gravity,
        orientation: orientation.test,
        findings,
        verdict,
    }
}

/// Why each file is not tested, as far as it shows by itself.
fn left_out(files: &[(&CalibrationFile, &str)]) -> Vec<Option<(FindingKind, String)>> {
    let own = |i: usize| -> Option<(FindingKind, String)> {
        let (file, _) = files[i];
        if file.verdict.grade == Grade::Poor {
            let why = "the verdict of the calibration is poor";
            return Some((FindingKind::PoorCalibration, why.to_owned()));
        }
        if covariance_of(&file.accelerometer).is_none() {
            let why = "the file has no uncertainty";
            return Some((FindingKind::CovarianceMissing, why.to_owned()));
        }
        None
    };
    let mut reasons: Vec<_> = (0..files.len()).map(own).collect();
    for i in 0..files.len() {
        if reasons[i].is_some() {
            continue;
        }
        let a = files[i].0;
        // Of several calibrations of one session the last one is tested.
        let again = (i + 1..files.len()).find(|j| {
            let b = files[*j].0;
            let same = a.accelerometer.matrix == b.accelerometer.matrix
                && a.accelerometer.bias == b.accelerometer.bias;
            reasons[*j].is_none() && (same || shared_recording(a, b))
        });
        if let Some(j) = again {
            let why = format!("{} was made from the same recordings", files[j].1);
            reasons[i] = Some((FindingKind::SameRecordings, why));
        }
    }
    reasons
}

/// The parameters of all files in one unit, and those that are tested.
fn read<'a>(
    files: &[(&'a CalibrationFile, &'a str)],
    mut left_out: Vec<Option<(FindingKind, String)>>,
    findings: &mut Vec<Finding>,
) -> (Vec<HistoryEntry>, Vec<Point<'a>>) {
    let nominal = |f: &&(&CalibrationFile, &str)| f.0.accelerometer.nominal_per_mps2().is_some();
    let (mut entries, mut points) = (Vec::new(), Vec::<Point<'a>>::new());
    // The unit is that of a calibration with a nominal scale, if there is one.
    let Some((first, first_name)) = files.iter().find(nominal).or(files.first()) else {
        return (entries, points);
    };
    let mut gravities = Vec::new();
    for (index, (file, name)) in files.iter().enumerate() {
        let sides = sides_with(first, file, [first_name, name], true, &mut Vec::new());
        let side = sides.map(|[_, side]| side);
        if let Err(error) = &side {
            let why = error.message().to_owned();
            left_out[index].get_or_insert((FindingKind::UnitMismatch, why));
        }
        if let Some((kind, why)) = &left_out[index] {
            findings.push(Finding::new(*kind, format!("not tested: {why}")).in_file(name));
        }
        // Without enough faces the frame is a convention.
        let oriented = |p: &&Point<'_>| orientation_is_known(p.file);
        let oriented = points.iter().find(oriented).map(|p| &p.side);
        let oriented = oriented.filter(|_| orientation_is_known(file));
        let parameters = side
            .as_ref()
            .map_or_else(|_| Vec::new(), |side| parameters(file, side, oriented));
        entries.push(HistoryEntry {
            name: (*name).to_owned(),
            not_tested: left_out[index].as_ref().map(|(_, why)| why.clone()),
            parameters,
            since_previous: None,
        });
        if let (Ok(side), None) = (side, &left_out[index]) {
            let gravity = (file.gravity_mps2, file.gravity_source);
            let group = gravities.iter().position(|g| *g == gravity);
            let group = group.unwrap_or_else(|| {
                gravities.push(gravity);
                gravities.len() - 1
            });
            points.push(Point {
                index,
                name,
                file,
                side,
                group,
            });
        }
    }
    (entries, points)
}

/// Relative standard uncertainty of the gravity that a scale rests on.
fn gravity_share(file: &CalibrationFile) -> f64 {
    file.accelerometer.gravity_sd_mps2 / file.gravity_mps2
}

/// Parameters of one calibration; the rotation is that against `first`, if there is one.
fn parameters(
    file: &CalibrationFile,
    side: &NominalModel,
    first: Option<&NominalModel>,
) -> Vec<HistoryParameter> {
    let (values, jacobian) = invariants(side);
    let covariance = side.covariance.as_ref().map(|c| {
        let mut sum = propagate(&jacobian, c) + second_order(side, c);
        let share = gravity_share(file);
        for (i, k) in (3..6).flat_map(|i| (3..6).map(move |k| (i, k))) {
            sum[(i, k)] += share * share * values[i] * values[k];
        }
        sum
    });
    let deviations = file.accelerometer.deviations;
    let factor = deviations.map_or(COVERAGE_95, |d| d.coverage_factor_95);
    let mut all = listed(0, &values, covariance.as_ref(), factor);
    let turned = first.map(|first| (rotation(first, side), first));
    if let Some((Some(rotation), _)) = turned {
        let covariance = side.covariance.as_ref();
        let covariance = covariance.map(|c| propagate(&rotation.jacobians[1], c));
        all.extend(listed(NINE, &rotation.vector, covariance.as_ref(), factor));
    }
    all
}

/// Parameters `from` … with their names, in the units of [`HistoryParameter`]. Values are in m/s²,
/// shares of nominal, and rad.
fn listed(
    from: usize,
    values: &[f64],
    covariance: Option<&DMatrix<f64>>,
    factor: f64,
) -> Vec<HistoryParameter> {
    let names = names().into_iter().skip(from).zip(values).enumerate();
    names
        .map(|(i, ((name, kind), value))| {
            let sigma = covariance.map(|c| c[(i, i)].max(0.0).sqrt());
            parameter(name, kind, (*value, 1.0), sigma, factor)
        })
        .collect()
}

/// One of them; `value` with what is taken off a scale.
fn parameter(
    name: String,
    kind: ParameterKind,
    value: (f64, f64),
    sigma: Option<f64>,
    factor: f64,
) -> HistoryParameter {
    let (value, nominal) = value;
    let (unit, per, value) = match kind {
        ParameterKind::Bias => ("m/s^2", 1.0, value),
        ParameterKind::Scale => ("%", 100.0, value - nominal),
        _ => ("deg", 1_f64.to_degrees(), value),
    };
    let (value, sigma) = (per * value, sigma.map(|s| per * s));
    HistoryParameter {
        name,
        kind,
        unit: unit.to_owned(),
        value,
        sigma,
        interval_95: sigma.map(|s| [value - factor * s, value + factor * s]),
    }
}

/// Size in m/s², shares or rad of the unit in which parameter `i` is tested: biases count in
/// gravity, so that all are shares or rad.
fn unit_of(i: usize, gravity: f64) -> f64 {
    if i < 3 { gravity } else { 1.0 }
}

/// Degrees of freedom of a t distribution with tails as heavy as those of the nine numbers; none
/// where they are normal.
///
/// A method that takes faces for exact has errors that are products of tilts. The product of two
/// normal numbers has an excess kurtosis of 6, Student's t with ν degrees of freedom 6/(ν − 4): as
/// a share s of the variance they give ν = 4 + 1/s². With `compare`, at 0.5 %, the difference does
/// not show; the largest of several steps reaches further into the tails.
fn tails(file: &CalibrationFile, second: &DMatrix<f64>, all: &DMatrix<f64>) -> Option<f64> {
    const NORMAL: f64 = 1e3;
    if file.accelerometer.fit.is_some() {
        return None;
    }
    let share = (0..NINE).map(|i| second[(i, i)] / all[(i, i)]);
    let share = share.filter(|s| s.is_finite()).fold(0.0, f64::max);
    Some(4.0 + 1.0 / (share * share)).filter(|nu| *nu < NORMAL)
}

/// Test of the nine; with `at_one_gravity` all scales rest on `gravity`.
fn magnitude(points: &[Point<'_>], gravity: f64, at_one_gravity: bool) -> Option<Change> {
    let measured = |p: &Point<'_>| -> Option<Measured> {
        let moved = at_one_gravity.then(|| p.side.at_gravity(gravity));
        let side = moved.as_ref().unwrap_or(&p.side);
        let covariance = side.covariance.as_ref()?;
        let (values, jacobian) = invariants(side);
        let second = second_order(side, covariance);
        let c = propagate(&jacobian, covariance) + &second;
        let per = |i: usize| unit_of(i, gravity);
        let share = gravity_share(p.file);
        let shared = DVector::from_fn(NINE, |i, _| match i {
            3..6 => share * values[i],
            _ => 0.0,
        });
        Some(Measured {
            values: DVector::from_fn(NINE, |i, _| values[i] / per(i)),
            covariance: DMatrix::from_fn(NINE, NINE, |i, k| c[(i, k)] / per(i) / per(k)),
            shared: (share > 0.0).then_some((p.group, shared)),
            freedom: tails(p.file, &second, &c).filter(|_| points.len() > 2),
        })
    };
    let measured: Option<Vec<_>> = points.iter().map(measured).collect();
    Change::of(&measured?)
}

/// The test of the rotation.
struct Orientation {
    test: Option<ChangeTest>,
    /// Two of the frames are mirror images.
    mirrored: bool,
}

fn orientation(points: &[Point<'_>]) -> Orientation {
    let known: Vec<&Point<'_>> = points
        .iter()
        .filter(|p| orientation_is_known(p.file))
        .collect();
    let Some(first) = known.first() else {
        return Orientation {
            test: None,
            mirrored: false,
        };
    };
    let turns: Vec<_> = known
        .iter()
        .map(|p| rotation(&first.side, &p.side))
        .collect();
    let mirrored = turns.iter().any(Option::is_none);
    let measured = |(p, rotation): (&&Point<'_>, Option<super::parameters::Rotation>)| {
        let rotation = rotation?;
        Some(Measured {
            values: DVector::from_column_slice(&rotation.vector),
            covariance: propagate(&rotation.jacobians[1], p.side.covariance.as_ref()?),
            shared: None,
            freedom: p.side.tilt_degrees_of_freedom,
        })
    };
    let measured: Option<Vec<_>> = known.iter().zip(turns).map(measured).collect();
    let change = measured.and_then(|m| Change::of(&m));
    Orientation {
        test: change.map(|c| described(&c, &known, NINE, 1.0)),
        mirrored,
    }
}

/// A test in words of the calibrations; the parameters are those from `from` on.
fn described<'p, 'a: 'p, P: std::borrow::Borrow<Point<'a>>>(
    change: &Change,
    points: &'p [P],
    from: usize,
    gravity: f64,
) -> ChangeTest {
    let name = |i: usize| points[i].borrow().name.to_owned();
    let step = change.step.as_ref().and_then(|step| {
        let unit = |i: usize| match from {
            0 => unit_of(i, gravity),
            _ => 1.0,
        };
        let sigma = |i: usize| step.covariance[(i, i)].max(0.0).sqrt();
        let weight = |i: usize| match sigma(i) {
            s if s > 0.0 => (step.difference[i] / s).abs(),
            _ => 0.0,
        };
        let most = (0..step.difference.len()).max_by(|a, b| weight(*a).total_cmp(&weight(*b)))?;
        let (name_of, kind) = names().into_iter().nth(from + most)?;
        let per = unit(most);
        let difference = (per * step.difference[most], 0.0);
        let sigma = Some(per * sigma(most));
        Some(StepTest {
            after: name(step.before - 1),
            until: name(step.before),
            test: step.test,
            largest: parameter(name_of, kind, difference, sigma, COVERAGE_95),
        })
    });
    ChangeTest {
        whole: change.whole,
        step,
        p_value: change.p_value(points.len()),
    }
}

fn verdict(
    points: &[Point<'_>],
    magnitude: Option<&ChangeTest>,
    at_one_gravity: Option<&ChangeTest>,
    orientation: &Orientation,
) -> HistoryVerdict {
    let is_changed = |t: &ChangeTest| t.p_value < PART_SIGNIFICANCE;
    let turned = orientation.mirrored || orientation.test.as_ref().is_some_and(is_changed);
    let judgement = match magnitude {
        _ if turned => Stability::Changed,
        Some(test) if is_changed(test) => Stability::Changed,
        Some(_) => Stability::Unchanged,
        None => Stability::Undecided,
    };
    let mut reasons = vec![match (points.len(), magnitude) {
        (_, Some(test)) => sentence("bias, scale and misalignment", "have", test),
        (0, None) => "none of the calibrations can be tested".to_owned(),
        (1, None) => {
            "there is one calibration that can be tested; a second one would show a change"
                .to_owned()
        }
        (_, None) => "the calibrations determine no parameter in common".to_owned(),
    }];
    if let Some(test) = at_one_gravity {
        reasons.push(format!(
            "with one value of gravity for all: {} ({})",
            ChiSquare::probability(test.p_value),
            test.whole.statistic()
        ));
    }
    if orientation.mirrored {
        let why =
            "the orientation of the axes changed: one calibration is the mirror image of another";
        reasons.push(why.to_owned());
    } else if let Some(test) = &orientation.test {
        reasons.push(sentence(
            "the orientation of the axes in the case",
            "has",
            test,
        ));
    }
    let temperatures = points.iter().filter_map(|p| p.file.temperature_c);
    let (low, high) = temperatures.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| {
        (l.min(t.mean), h.max(t.mean))
    });
    if high - low > TEMPERATURE_STEP_C {
        reasons.push(format!(
            "the sessions were at {low:.1} to {high:.1} °C; drift with temperature is not in the uncertainties"
        ));
    }
    HistoryVerdict { judgement, reasons }
}

/// One part in a sentence.
fn sentence(what: &str, have: &str, test: &ChangeTest) -> String {
    let p = ChiSquare::probability(test.p_value);
    let whole = test.whole.statistic();
    if test.p_value >= PART_SIGNIFICANCE {
        return format!(
            "{what} {have} not changed by more than the uncertainty: {p}, a change would be below {PART_SIGNIFICANCE} ({whole} about the mean)"
        );
    }
    let step = test.step.as_ref().map_or(String::new(), |step| {
        let l = &step.largest;
        let digits = crate::numfmt::decimals_by(l.sigma, l.value);
        let value = crate::numfmt::signed(l.value, digits);
        let sigma = l
            .sigma
            .map_or(String::new(), |s| format!(" ± {s:.digits$}"));
        format!(
            "; most of it between {} and {}: {}, {} by {value}{sigma} {}",
            step.after,
            step.until,
            step.test.statistic(),
            l.name.replace('_', " "),
            crate::numfmt::unit(&l.unit)
        )
    });
    format!(
        "{what} {have} changed by more than the uncertainty: {p}, below {PART_SIGNIFICANCE} ({whole} about the mean{step})"
    )
}

#[cfg(test)]
mod tests;
