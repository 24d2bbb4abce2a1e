//! Does a calibration still fit new readings at rest?
//!
//! At rest ‖a‖ is g in every pose. The mean of each static interval is calibrated, its length
//! compared with g, and the errors of all are held against what the calibration's covariance, the
//! noise of the means and the model error predict together ([`gravical_fit::consistency::check`]).
//!
//! It tests what was recorded and nothing else: the verdict says which axes were not. An interval
//! of constant velocity or acceleration looks like rest and is judged as one.

use gravical_core::matrix3::{norm, unit};
use gravical_fit::consistency::{self, Length, StaticMean};
use gravical_fit::model::BIAS;
use gravical_fit::{SIGNIFICANCE, Sensor, Test};
use gravical_judge::numfmt::{mg, milli_g};
use gravical_judge::utc::UtcTime;
use gravical_signal::stats::{mean_of_finite, median, rms};
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::calibrate::DRIFT_MPS2_PER_C;
use crate::calibration_file::{
    Calibration, GravitySource, InputFile, TemperatureRange, judge_unit,
};
use crate::finding::{Case, Finding};
use crate::gravity::Gravity;
use crate::judgement::{ASSUMED_ERROR_MPS2, gravity_differs, judge, sensor};
use crate::poses::face::{AxisMap, Face, axes_where};
use crate::poses::mean::pooled_noise;
use crate::poses::rests::{find_rests, why_never_static};
use crate::poses::{self, Interval, Pose, SegmentOptions, measure_intervals};
use crate::problem::Problem;
use crate::recording::{Recording, after_losses, already_calibrated};
use crate::temperature::{NoTemperature, bring_to_reference, not_applied};

pub use crate::judgement::{Judgement, Side, Verdict};

/// No mean of a cheap accelerometer is better than this, m/s² (0.1 mg): its bias wanders by as
/// much from one minute to the next.
const FLOOR_MPS2: f64 = 0.001;

/// A rest of T seconds, cut out of a motion that comes to its end, may begin and end at speeds
/// that differ by this, m/s; its mean is off by as much over T: 0.7 mg at 0.15 s, nothing at 3 s.
const REST_SPEED_MPS: f64 = 0.001;

/// More static intervals than this say nothing new; the longest are taken.
const MAX_INTERVALS: usize = 400;

/// An axis is tested by an interval within 60° of it.
const TESTED_COSINE: f64 = 0.5;

/// A static interval this far outside the calibration's temperatures is reported, °C.
const TEMPERATURE_MARGIN_C: f64 = 2.0;

/// Temperatures of a calibration and of a check that nobody recorded differ by this, °C: a part
/// that has just been switched on warms up by as much in some minutes.
const UNKNOWN_TEMPERATURE_C: f64 = 2.0;

/// A recording faster than this is averaged down to it when the correlation of
/// its noise is looked at, Hz: after setting down a sensor rocks for a while,
/// at 5 to 20 Hz, and 20 lags of a fast recording do not see that.
const SLOW_RATE_HZ: f64 = 100.0;

/// How to check.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct CheckOptions {
    /// Local gravity; default: that of the calibration.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub gravity: Option<Gravity>,
    /// Axes of the sensor that point along x, y and z of the case.
    #[serde(deserialize_with = "gravical_judge::option_text::one")]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub axes: AxisMap,
}

/// A calibration held against readings at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// The calibration as it was given.
    pub calibration: String,
    /// The recordings as they were given.
    pub recordings: Vec<String>,
    /// Dates and sensors of the calibration and of the recordings.
    pub sides: [Side; 2],
    /// Age of the calibration when these were recorded, days: since its session, else since it was computed.
    pub age_days: Option<f64>,
    /// What ‖a‖ has to be at rest, m/s².
    pub gravity_mps2: f64,
    /// How it is known; of the calibration where none was given here.
    pub gravity_source: GravitySource,
    /// True when gravity is the calibration's, for want of another.
    pub gravity_of_calibration: bool,
    /// The static intervals, in the order of the recordings.
    pub static_intervals: Vec<StillCheck>,
    /// Index of the interval with the largest |z| of those that count.
    pub worst: usize,
    /// Root mean square of the errors that count, m/s².
    pub rms_mps2: f64,
    /// What the uncertainty predicts for it, m/s².
    pub predicted_rms_mps2: f64,
    /// All errors together.
    pub test: Test,
    /// Axes of the case that no interval has within 60°: `x` ….
    pub untested_axes: Vec<String>,
    /// Axes that pointed up or down only: bias and scale are not distinguished there.
    pub one_way_axes: Vec<String>,
    /// The calibration was fitted to all intervals that count.
    pub only_fitted: bool,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// The judgement.
    pub verdict: Verdict,
}

/// One static interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StillCheck {
    /// The file.
    pub file: String,
    /// Label of a placement that was named; null for an interval that was found.
    pub label: Option<String>,
    /// First and last line of the file.
    pub lines: [u64; 2],
    /// Seconds from the start of the recording; null without a rate.
    pub start_s: Option<f64>,
    /// When its recording was made; null where that is unknown.
    pub recorded: Option<UtcTime>,
    /// Rows that the mean is over.
    pub rows: u64,
    /// Mean, calibrated, in axes of the case, m/s².
    pub calibrated: [f64; 3],
    /// The axis that is nearest to up: `+x` ….
    pub nearest: String,
    /// Angle to it, degrees.
    pub face_angle_deg: f64,
    /// ‖a‖ − g, m/s².
    pub error_mps2: f64,
    /// Its standard deviation if the calibration fits, m/s².
    pub sigma_mps2: f64,
    /// error / sigma.
    pub z: f64,
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    /// Samples at the end of the range.
    pub clipped: u64,
    /// Whether it counts: not with clipped samples, nor where the calibration was fitted to it,
    /// unless no other is left.
    pub counts: bool,
}

/// Holds `calibration` (its file is called `name`) against the static intervals of `recordings`.
///
/// # Errors
///
/// Input errors: `no-recordings`, `never-static`, `calibration-values` for a singular matrix, and
/// `unit-mismatch` where the recording is in another unit or range than the calibration, or
/// measures gravity off by more than a fifth.
///
/// # Example
///
/// ```
/// # use gravical_calibrate as gravical;
/// use gravical::calibrate::{CalibrateOptions, calibrate};
/// use gravical::check::{CheckOptions, check};
/// use gravical::calibrate::Method;
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let means = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///              -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let read = |text: &str| read_bytes(text.as_bytes(), "means.csv", &ReadOptions::default());
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&[read(means)?], &options)?.calibration;
///
/// // Later, once more with z up and down.
/// let later = "label,ax,ay,az\n+z,0.81,-0.15,10.52\n-z,-0.05,-0.08,-9.54\n";
/// let report = check(&file, "cal.json", &[read(later)?], &CheckOptions::default())?;
/// assert!((report.static_intervals[0].error_mps2 - 0.1).abs() < 0.005);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn check(
    calibration: &Calibration,
    name: &str,
    recordings: &[Recording],
    options: &CheckOptions,
) -> Result<CheckReport> {
    let read = recordings.iter().flat_map(|r| &r.findings);
    let mut findings: Vec<Finding> = read.cloned().collect();
    let mut intervals = static_intervals(recordings, options, &mut findings)
        .map_err(|error| after_losses(error, recordings))?;
    at_reference(calibration, &mut intervals, &mut findings);
    if intervals.len() > MAX_INTERVALS {
        intervals.sort_by_key(|p| std::cmp::Reverse(p.count));
        intervals.truncate(MAX_INTERVALS);
        intervals.sort_by_key(|p| (p.recording, p.lines));
    }
    let gravity = options.gravity.unwrap_or(Gravity {
        value_mps2: calibration.gravity_mps2,
        source: calibration.gravity_source,
    });
    judge_units(calibration, recordings, &intervals, &gravity, &mut findings)?;
    let covariance = calibration.accelerometer.covariance_of_parameters();
    let mut sensor = sensor(calibration, name, 1.0, 0.0)?;
    if covariance.is_some() {
        widen_for_temperature(&mut sensor, calibration, &intervals);
    }
    let of = |interval: &Pose| &recordings[interval.recording];
    let fitted = intervals.iter().map(|p| is_fitted(calibration, of(p), p));
    let fitted: Vec<bool> = fitted.collect();
    let counts = counts(&intervals, &fitted);
    let means: Vec<StaticMean> = intervals.iter().map(|p| static_mean(of(p), p)).collect();
    let here = options.gravity.map(|g| g.for_fit());
    let (lengths, test) = consistency::check(&sensor, here, &means, |i| counts[i])
        .ok_or_else(|| Problem::Singular.error().at(name.as_ref(), None))?;
    let stills = intervals.iter().zip(&lengths).zip(&counts);
    let stills = stills.map(|((interval, length), counts)| {
        StillCheck::new(of(interval), interval, length, *counts, &options.axes)
    });
    let static_intervals: Vec<StillCheck> = stills.collect();
    context_findings(calibration, recordings, &intervals, &mut findings);
    let values = [calibration.gravity_mps2, gravity.value_mps2];
    findings.extend(gravity_differs(values, ["in the calibration", "here"]));
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    let only_fitted = !fitted.contains(&false);
    // What it was fitted to agrees with it; what is assumed is no proof.
    let no_proof = match covariance {
        _ if only_fitted => Some("the calibration was fitted to these static intervals"),
        None => Some("the calibration has no covariance"),
        Some(_) => None,
    };
    let level = (SIGNIFICANCE, Judgement::DoesNotFit);
    let what = "‖a‖ at rest and gravity";
    let (judgement, reason) = judge(what, Some(&test), level, no_proof);
    let used: Vec<&StillCheck> = static_intervals.iter().filter(|s| s.counts).collect();
    let size = |i: &usize| static_intervals[*i].z.abs();
    let counted = (0..counts.len()).filter(|i| counts[*i]);
    let worst = counted.max_by(|i, j| size(i).total_cmp(&size(j)));
    // Axes of the case that intervals have up, down, both or none of it.
    let ways = |axis: usize| {
        let along = |sign: f64| {
            let is_along = |s: &&StillCheck| sign * unit(&s.calibrated)[axis] >= TESTED_COSINE;
            usize::from(used.iter().any(is_along))
        };
        along(1.0) + along(-1.0)
    };
    let sides = [
        Side::of_calibration(calibration),
        Side::of_recordings(recordings),
    ];
    let mut report = CheckReport {
        calibration: name.to_owned(),
        recordings: recordings.iter().map(|r| r.name.clone()).collect(),
        gravity_mps2: gravity.value_mps2,
        gravity_source: gravity.source,
        gravity_of_calibration: options.gravity.is_none(),
        worst: worst.unwrap_or(0),
        rms_mps2: rms(used.iter().map(|s| s.error_mps2)),
        predicted_rms_mps2: rms(used.iter().map(|s| s.sigma_mps2)),
        test,
        untested_axes: axes_where(|axis| ways(axis) == 0),
        one_way_axes: axes_where(|axis| ways(axis) == 1),
        static_intervals,
        only_fitted,
        findings,
        age_days: sides[0].days_to(&sides[1]),
        sides,
        verdict: Verdict {
            judgement,
            reasons: vec![reason],
        },
    };
    complete(&mut report, covariance.is_some(), &gravity);
    Ok(report)
}

impl StillCheck {
    fn new(
        recording: &Recording,
        interval: &Pose,
        length: &Length,
        counts: bool,
        axes: &AxisMap,
    ) -> StillCheck {
        let is_named = recording.labels.is_some() && !interval.is_found;
        let calibrated = axes.to_case(length.force);
        let (nearest, face_angle_deg) = Face::nearest(calibrated);
        StillCheck {
            file: recording.name.clone(),
            label: is_named.then(|| interval.label.clone()),
            lines: interval.lines,
            start_s: recording.time_at(interval.rows.start),
            recorded: recording.recorded_at(),
            rows: interval.count as u64,
            calibrated,
            nearest: nearest.name(),
            face_angle_deg,
            error_mps2: length.error_mps2,
            sigma_mps2: length.sd_mps2,
            z: length.error_mps2 / length.sd_mps2,
            temperature_c: interval.temperature_c,
            clipped: interval.clipped as u64,
            counts,
        }
    }
}

/// Adds to the reason by the test how large the errors are, and what was not tested.
fn complete(report: &mut CheckReport, has_covariance: bool, gravity: &Gravity) {
    let expected = if has_covariance {
        let predicted = mg(report.predicted_rms_mps2);
        format!("its uncertainty predicts {predicted} mg rms")
    } else {
        let assumed = mg(ASSUMED_ERROR_MPS2);
        format!("the file has no covariance, so {assumed} mg are assumed")
    };
    let off = mg(report.rms_mps2);
    let reasons = &mut report.verdict.reasons;
    reasons.insert(0, format!("‖a‖ is off by {off} mg rms; {expected}"));
    // Agreement with what it was fitted to tests no axis.
    if !report.only_fitted || report.verdict.judgement.is_change() {
        reasons.push(untested(&report.untested_axes, &report.one_way_axes));
    }
    if gravity.source == GravitySource::Standard {
        reasons.push(format!(
            "gravity is assumed, which hides an error of scale of up to {:.0} mg; the latitude is enough to know it",
            milli_g(2.0 * gravity.uncertainty_mps2())
        ));
    }
}

fn untested(none: &[String], one_way: &[String]) -> String {
    let axes = if none.len() == 1 { "axis" } else { "axes" };
    let none =
        (!none.is_empty()).then(|| format!("does not test the {} {axes}", none.join(" and ")));
    let one_way = (!one_way.is_empty()).then(|| {
        format!(
            "{} pointed one way only, where bias and scale are not distinguished",
            one_way.join(" and ")
        )
    });
    let parts: Vec<String> = none.into_iter().chain(one_way).collect();
    if parts.is_empty() {
        return "every axis was tested in both directions".to_owned();
    }
    parts.join("; ")
}

/// All static intervals of all recordings. Means are in the numbers of the file, zero offset
/// added back.
///
/// # Errors
///
/// `no-recordings`; `never-static` when no recording has one.
fn static_intervals(
    recordings: &[Recording],
    options: &CheckOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Pose>> {
    let Some(first) = recordings.first() else {
        return Err(Problem::NoRecording.error());
    };
    let mut intervals = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let found = in_one(index, recording);
        if found.is_empty() {
            let why = why_never_static(recording);
            let never = Case::NeverAtRest { why }.finding();
            findings.push(never.in_file(&recording.name));
        }
        intervals.extend(found);
    }
    let (mut intervals, held, _) =
        measure_intervals(recordings, intervals, &options.axes, findings);
    include_slow_noise(recordings, &held, &mut intervals);
    for interval in &mut intervals {
        let offset = recordings[interval.recording].units.zero_offset;
        interval.mean = interval.mean.map(|m| m + offset);
    }
    poses::leave_out_empty(&mut intervals, findings);
    if intervals.is_empty() {
        let none = Problem::NoneToCheck.error();
        return Err(none.at(first.name.as_ref(), None));
    }
    Ok(intervals)
}

fn in_one(index: usize, recording: &Recording) -> Vec<Interval> {
    let found = find_rests(recording);
    if !found.is_empty() {
        return poses::intervals_of(index, found, None);
    }
    // A table of means, or poses that somebody named: the intervals are given.
    let one = std::slice::from_ref(recording);
    if poses::check_units(one).is_err() || recording.labels.is_none() && recording.rows() >= 40 {
        return Vec::new();
    }
    let untold = [&mut Vec::new(), &mut Vec::new()];
    let given = poses::cut_recordings(one, &SegmentOptions::default(), untold);
    let mut intervals = given.unwrap_or_default();
    intervals.retain(|interval| !interval.is_turn());
    intervals.iter_mut().for_each(|i| i.recording = index);
    intervals
}

/// Raises standard errors of means to what averages of the samples, `held`, say of them.
fn include_slow_noise(recordings: &[Recording], held: &[[Vec<f64>; 3]], intervals: &mut [Pose]) {
    let group = |interval: &Pose| {
        let rate_hz = recordings[interval.recording].working_rate_hz();
        ((rate_hz / SLOW_RATE_HZ) as usize).max(1)
    };
    let average = |(interval, held): (&Pose, &[Vec<f64>; 3])| {
        let size = group(interval);
        held.each_ref()
            .map(|values| values.chunks_exact(size).map(mean_of_finite).collect())
    };
    let averages: Vec<[Vec<f64>; 3]> = intervals.iter().zip(held).map(average).collect();
    let slices: Vec<[&[f64]; 3]> = averages.iter().map(poses::slices).collect();
    // Averages come in no steps.
    let slow = pooled_noise(&slices, [0.0; 3], 1.0);
    for interval in intervals {
        let groups = (interval.count / group(interval)).max(1) as f64;
        if let Some(error) = &mut interval.standard_error {
            let widening = (slow.vif / groups).sqrt();
            *error = std::array::from_fn(|i| error[i].max(slow.sigma[i] * widening));
        }
    }
}

/// Takes the drift of the accepted channels off the means of static intervals, as `apply` does
/// row by row, held at the edges of the model's range.
fn at_reference(calibration: &Calibration, intervals: &mut [Pose], findings: &mut Vec<Finding>) {
    let Some(model) = calibration.drift_model() else {
        return;
    };
    let temperatures = intervals.iter().map(|p| p.temperature_c);
    let without = temperatures.filter(Option::is_none).count();
    if without > 0 {
        let intervals = intervals.len();
        let why = NoTemperature::SomeIntervals { without, intervals };
        findings.push(not_applied(model, why));
    }
    bring_to_reference(intervals, model);
}

/// Is every recording in the unit of the calibration?
///
/// # Errors
///
/// `unit-mismatch`.
fn judge_units(
    calibration: &Calibration,
    recordings: &[Recording],
    intervals: &[Pose],
    gravity: &Gravity,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let apply = calibration.accelerometer_calibration();
    let gravity = gravity.value_mps2;
    for (index, recording) in recordings.iter().enumerate() {
        let own = intervals.iter().filter(|r| r.recording == index);
        let mut norms: Vec<f64> = own.map(|r| norm(&apply.apply(r.mean))).collect();
        if let usual @ Some(_) = median(&mut norms) {
            let at_rest = ("its static intervals", usual);
            judge_unit(calibration, recording, at_rest, gravity, findings)?;
        }
    }
    Ok(())
}

/// Adds to the bias what it drifts by where one of the temperatures is not known.
fn widen_for_temperature(sensor: &mut Sensor, calibration: &Calibration, intervals: &[Pose]) {
    let is_known = (calibration.drift_model().is_some() || calibration.temperature_c.is_some())
        && intervals.iter().all(|r| r.temperature_c.is_some());
    if is_known {
        return;
    }
    let drift = UNKNOWN_TEMPERATURE_C * DRIFT_MPS2_PER_C;
    for axis in 0..3 {
        let scale = calibration.accelerometer.scale()[axis];
        sensor.covariance[(BIAS + axis, BIAS + axis)] += (drift * scale).powi(2);
    }
}

fn static_mean(recording: &Recording, interval: &Pose) -> StaticMean {
    // Without a rate, or where a row is a mean itself, the duration is not known.
    let speed = match recording.clock.rate_hz() {
        Some(rate_hz) if interval.count > 1 => REST_SPEED_MPS * rate_hz / interval.count as f64,
        _ => 0.0,
    };
    StaticMean {
        mean: interval.mean,
        sd: interval.standard_error.unwrap_or_default(),
        sd_of_length_mps2: speed.hypot(FLOOR_MPS2),
    }
}

/// True for a static interval that the calibration was fitted to.
fn is_fitted(calibration: &Calibration, recording: &Recording, interval: &Pose) -> bool {
    let [first, last] = interval.lines;
    inputs_of(calibration, recording).any(|input| {
        let poses = calibration.poses.iter();
        let mut poses = poses.filter(|p| p.fitted && p.source == input.path);
        // Without lines the pose may be anywhere in the file.
        poses.any(|p| p.lines.is_none_or(|[from, to]| from <= last && first <= to))
    })
}

/// The inputs of the calibration that are this recording, by its checksum.
fn inputs_of<'a>(
    calibration: &'a Calibration,
    recording: &'a Recording,
) -> impl Iterator<Item = &'a InputFile> {
    let known = recording.sha256.as_ref();
    let inputs = calibration.recordings();
    inputs.filter(move |i| known.is_some() && i.sha256.as_ref() == known)
}

/// The intervals that the judgement uses: those that the calibration was not fitted to, among them
/// those without clipped samples; in both cases all where none is left.
fn counts(intervals: &[Pose], fitted: &[bool]) -> Vec<bool> {
    let is_new = fitted.contains(&false);
    let new: Vec<bool> = fitted.iter().map(|fitted| !(is_new && *fitted)).collect();
    let each = new.iter().zip(intervals);
    let whole: Vec<bool> = each.map(|(new, p)| *new && p.clipped == 0).collect();
    if whole.contains(&true) { whole } else { new }
}

/// Quality, inputs, clipping, temperature.
fn context_findings(
    calibration: &Calibration,
    recordings: &[Recording],
    intervals: &[Pose],
    findings: &mut Vec<Finding>,
) {
    findings.extend(calibration.poor_finding());
    for recording in recordings {
        let case = |by_board| Case::CalibratedForCheck { by_board };
        findings.extend(already_calibrated(recording, case));
        if inputs_of(calibration, recording).next().is_some() {
            let same = Case::RecordingOfCalibration.finding();
            findings.push(same.in_file(&recording.name));
        }
    }
    for interval in intervals.iter().filter(|r| r.clipped > 0) {
        let (samples, lines) = (interval.clipped, interval.lines);
        let clipped = Case::ClippedInterval { samples, lines }.finding();
        findings.push(clipped.in_file(&recordings[interval.recording].name));
    }
    findings.extend(temperature(calibration, intervals));
}

fn temperature(calibration: &Calibration, intervals: &[Pose]) -> Option<Finding> {
    // Within the range of a temperature model the drift is taken off.
    let calibration_c = match (calibration.drift_model(), calibration.temperature_c) {
        (Some(model), _) => model.range_c,
        (None, Some(range)) => [range.min, range.max],
        (None, None) => return None,
    };
    let range = TemperatureRange::of(intervals.iter().filter_map(|r| r.temperature_c))?;
    let ([least, most], intervals_c) = (calibration_c, [range.min, range.max]);
    let outside = (least - range.min).max(range.max - most) > TEMPERATURE_MARGIN_C;
    let case = Case::IntervalsOutside {
        intervals_c,
        calibration_c,
    };
    outside.then(|| case.finding())
}
