//! Does a calibration still fit new still readings?
//!
//! At rest ‖a‖ is g in every pose. The mean of each still is calibrated, its
//! length compared with g, and the errors of all stills are held against what
//! the calibration's covariance, the noise of the means and the model error
//! predict together: the stills share the errors of the calibration.
//!
//! It tests what was recorded and nothing else; [`Coverage`] says which axes
//! were not. A still in which the sensor really moved at a constant velocity or
//! acceleration looks like rest and is judged as one.

mod coverage;
mod drift;
mod explain;
mod findings;
mod gyroscope;
mod rests;
mod types;
mod uncertainty;
mod verdict;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use nalgebra::DVector;

use crate::Result;
use crate::calibration_file::{CalibrationFile, judge_unit};
use crate::gravity::Gravity;
use crate::recording::{Finding, Recording};
use crate::segment::face::{AxisMap, Face};
use crate::segment::still::StillOptions;
use crate::uncertainty::{chi_square, covariance_at_its_gravity, covariance_of};

use rests::{Rest, rests};
use uncertainty::{Place, assumed, at_another_time, spread};
use verdict::Evidence;

#[doc(hidden)]
pub use gyroscope::GYRO_LIMIT_DEG_S;
pub use types::*;
#[doc(hidden)]
pub use uncertainty::{FLOOR_MPS2, REST_SPEED_MPS};

/// A calibration that does not say how uncertain it is does not fit when the
/// RMS of its errors is above this, mg: twice and a half what six faces placed
/// within 1° leave, half of what a sensor without any calibration shows.
#[doc(hidden)]
pub const LIMIT_WITHOUT_COVARIANCE_MG: f64 = 20.0;

/// More stills than this say nothing new; the longest are taken.
const MOST_STILLS: usize = 400;

/// How to check.
#[derive(Debug, Clone)]
pub struct CheckOptions {
    /// Local gravity; default: that of the calibration.
    pub gravity: Option<Gravity>,
    /// How the board sits in its case, for the names of directions.
    pub axes: AxisMap,
    /// How stills are found; default: short ones, too.
    pub still: StillOptions,
}

impl Default for CheckOptions {
    fn default() -> Self {
        CheckOptions {
            gravity: None,
            axes: AxisMap::default(),
            still: StillOptions::short_rests(),
        }
    }
}

/// Holds `calibration` (its file is called `name`) against the stills of
/// `recordings`.
///
/// # Errors
///
/// Input errors: `no-recordings`, `never-static`, and `unit-mismatch` where the
/// recording is in another unit or range than the calibration, or measures
/// gravity off by more than a fifth.
///
/// # Example
///
/// ```
/// use gravical::calibrate::{CalibrateOptions, calibrate};
/// use gravical::check::{CheckOptions, check};
/// use gravical::estimate::accelerometer::Method;
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let means = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///              -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let read = |text: &str| read_bytes(text.as_bytes(), "means.csv", &ReadOptions::default());
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&[read(means)?], &options)?.file;
///
/// // Later, once more with z up.
/// let later = "label,ax,ay,az\nagain,0.81,-0.15,10.52\n";
/// let report = check(&file, "cal.json", &[read(later)?], &CheckOptions::default())?;
/// assert!((report.static_intervals[0].error_mps2 - 0.1).abs() < 0.005);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn check(
    calibration: &CalibrationFile,
    name: &str,
    recordings: &[Recording],
    options: &CheckOptions,
) -> Result<CheckReport> {
    let section = &calibration.accelerometer;
    let mut findings: Vec<Finding> = recordings
        .iter()
        .flat_map(|r| r.findings.iter().cloned().map(|f| named(f, r)))
        .collect();
    let mut rests = rests(recordings, &options.still, &mut findings)
        .map_err(|error| error.after_losses(recordings.iter().map(|r| (&*r.name, &*r.findings))))?;
    drift::take_off(calibration, &mut rests, &mut findings);
    findings::keep_longest(&mut rests, MOST_STILLS, &mut findings);
    let gravity = options.gravity.unwrap_or(Gravity {
        value_mps2: calibration.gravity_mps2,
        source: calibration.gravity_source,
    });
    let g = gravity.value_mps2;
    let apply = calibration.accelerometer_calibration();
    let calibrated: Vec<[f64; 3]> = rests.iter().map(|r| apply.apply(r.mean)).collect();
    for (index, recording) in recordings.iter().enumerate() {
        let mut norms: Vec<f64> = rests
            .iter()
            .zip(&calibrated)
            .filter(|(r, _)| r.recording == index)
            .map(|(_, a)| norm(a))
            .collect();
        if !norms.is_empty() {
            judge_unit(calibration, recording, &mut norms, g, &mut findings)?;
        }
    }
    findings::circumstances(
        calibration,
        recordings,
        &rests,
        &gravity,
        options,
        &mut findings,
    );

    // Which readings count, where they stand, and how far they are off.
    let differs = calibration.drift_model().is_none()
        && (calibration.temperature_c.is_none() || rests.iter().any(|r| r.temperature_c.is_none()));
    // Held against its own gravity, the error of that counts once, with the stills.
    let known = match options.gravity {
        Some(_) => covariance_of(section),
        None => covariance_at_its_gravity(section, g),
    };
    let covariance = known.map(|c| at_another_time(section, &c, differs));
    let places: Vec<Place> = rests
        .iter()
        .zip(&calibrated)
        .map(|(rest, a)| Place::new(section, covariance.as_ref(), rest, *a, &gravity))
        .collect();
    let fitted = findings::fitted(calibration, recordings, &rests);
    let counted = counted(&rests, &fitted);
    let own = counted.iter().all(|i| fitted[*i]);
    let stills: Vec<StillCheck> = (0..rests.len())
        .map(|i| {
            let recording = &recordings[rests[i].recording];
            let mut still = describe(recording, &rests[i], &places[i], g, &options.axes);
            still.counts = counted.contains(&i);
            still
        })
        .collect();
    let used: Vec<&Place> = counted.iter().map(|i| &places[*i]).collect();
    let errors = DVector::from_iterator(used.len(), counted.iter().map(|i| stills[*i].error_mps2));
    let spread = covariance
        .as_ref()
        .and_then(|c| spread(section, c, &used, &gravity));
    let test = spread
        .as_ref()
        .and_then(|s| chi_square(&s.errors, &s.covariance, s.freedom))
        .map(|(test, _)| test);
    let root_mean_square = |squares: f64| (squares / used.len() as f64).sqrt();
    let rms = root_mean_square(errors.norm_squared());
    let predicted: Option<f64> = counted
        .iter()
        .map(|i| stills[*i].sigma_mps2.map(|s| s * s))
        .sum::<Option<f64>>()
        .map(root_mean_square);

    let board: Vec<[f64; 3]> = used.iter().map(|p| p.direction).collect();
    let limit = LIMIT_WITHOUT_COVARIANCE_MG * STANDARD_GRAVITY_MPS2 / 1000.0;
    let mut explanations = match &spread {
        Some(s) => explain::explanations(&s.errors, &s.covariance, s.freedom, &board, g),
        // Without a covariance half the limit is as good a guess as any.
        None => explain::explanations(&errors, &assumed(&used, limit / 2.0), None, &board, g),
    };
    let freedom = spread.as_ref().and_then(|s| s.freedom);
    let single_fault_p_value = explain::focused(&explanations, freedom).filter(|_| test.is_some());
    // A single still has one test, not two.
    let p_value = match (test, single_fault_p_value) {
        (Some(t), Some(single)) if used.len() > 1 => Some((2.0 * t.p_value.min(single)).min(1.0)),
        (t, _) => t.map(|t| t.p_value),
    };
    let judgement = match verdict::judge(p_value, rms) {
        // What it was fitted to agrees with it.
        Judgement::Fits if own => Judgement::Undecided,
        other => other,
    };
    if judgement != Judgement::DoesNotFit {
        explanations.clear();
    }
    findings::explained(&explanations, &gravity, &mut findings);
    let in_case: Vec<[f64; 3]> = board.iter().map(|n| options.axes.to_case(*n)).collect();
    let gyroscope =
        gyroscope::gyroscope(calibration, recordings, &rests, &calibrated, &mut findings);
    let coverage = coverage::coverage(&in_case);
    let verdict = verdict::verdict(&Evidence {
        judgement,
        test,
        single_fault_p_value,
        p_value,
        rms_mps2: rms,
        predicted_mps2: predicted,
        own,
        gravity: &gravity,
        coverage: &coverage,
        gyroscope: gyroscope.as_ref(),
    });
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    Ok(CheckReport {
        calibration: name.to_owned(),
        recordings: recordings.iter().map(|r| r.name.clone()).collect(),
        gravity_mps2: g,
        gravity_source: gravity.source,
        gravity_of_calibration: options.gravity.is_none(),
        worst: worst(&stills),
        static_intervals: stills,
        rms_mps2: rms,
        predicted_rms_mps2: predicted,
        test,
        single_fault_p_value,
        p_value,
        coverage,
        explanations,
        gyroscope,
        calibration_temperature_c: calibration.temperature_c,
        findings,
        verdict,
    })
}

fn named(finding: Finding, recording: &Recording) -> Finding {
    if finding.file.is_some() {
        finding
    } else {
        finding.in_file(&recording.name)
    }
}

/// The stills that the judgement uses: those that the calibration was not fitted to, among them
/// those without clipped samples; in both cases all where none is left.
fn counted(rests: &[Rest], fitted: &[bool]) -> Vec<usize> {
    let or_all = |all: Vec<usize>, keep: &dyn Fn(usize) -> bool| {
        let some: Vec<usize> = all.iter().copied().filter(|i| keep(*i)).collect();
        if some.is_empty() { all } else { some }
    };
    let new = or_all((0..rests.len()).collect(), &|i| !fitted[i]);
    or_all(new, &|i| rests[i].clipped == 0)
}

/// The entry of one still; whether it counts is for the caller to say.
fn describe(
    recording: &Recording,
    rest: &Rest,
    place: &Place,
    gravity: f64,
    axes: &AxisMap,
) -> StillCheck {
    let error = place.length - gravity;
    let (rate, assumed) = recording.working_rate_hz();
    let start_s = match &recording.time_s {
        Some(t) => t.get(rest.first()).copied().filter(|t| t.is_finite()),
        None => (!assumed).then(|| recording.row_in_file(rest.first()) as f64 / rate),
    };
    let in_case = axes.to_case(place.direction.map(|n| n * place.length));
    let (nearest, face_angle_deg) = Face::nearest(in_case);
    let sigma = place
        .calibration_variance
        .map(|v| (v + place.reading_variance).sqrt());
    StillCheck {
        file: recording.name.clone(),
        label: rest.label.clone(),
        lines: [recording.line(rest.first()), recording.line(rest.last())],
        start_s,
        rows: rest.count as u64,
        raw: rest.mean,
        calibrated: in_case,
        norm_mps2: place.length,
        nearest: nearest.name(),
        face_angle_deg,
        error_mps2: error,
        error_mg: 1000.0 * error / STANDARD_GRAVITY_MPS2,
        sigma_calibration_mps2: place.calibration_variance.map(f64::sqrt),
        sigma_reading_mps2: place.reading_variance.sqrt(),
        sigma_mps2: sigma,
        z: sigma.filter(|s| *s > 0.0).map(|s| error / s),
        temperature_c: rest.temperature_c,
        clipped: rest.clipped as u64,
        counts: true,
    }
}

fn worst(stills: &[StillCheck]) -> usize {
    let badness = |s: &StillCheck| s.z.unwrap_or(s.error_mps2).abs();
    (0..stills.len())
        .filter(|i| stills[*i].counts)
        .max_by(|i, j| badness(&stills[*i]).total_cmp(&badness(&stills[*j])))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests;
