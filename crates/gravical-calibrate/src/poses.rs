//! From recordings to poses: where the sensor lay still, which face was
//! up, and the mean of each.
//!
//! Poses come from several files (one each, or several parted by blank
//! rows), a label column, a section list, or are found in one continuous
//! recording. Faces come from the data; names are claims that the data confirm
//! or refute.

pub mod face;
mod found;
#[doc(hidden)]
pub mod gyro_unit;
#[doc(hidden)]
pub mod mean;
mod named;
mod nominal;
mod pauses;
#[doc(hidden)]
pub mod rests;
#[doc(hidden)]
pub mod sections;
mod spikes;
mod stills;

#[doc(hidden)]
pub use found::is_too_short;
pub(crate) use found::{advise_rate, intervals_of};

use std::ops::Range;

use gravical_core::matrix3::sub;
use gravical_judge::full_scale::clipped_count;
use gravical_signal::stats::mean_of_finite;
use serde::Deserialize;

use crate::finding::{Case, after};
use crate::problem::Problem;
use crate::recording::units::GyroScale;
use crate::recording::{AccelUnit, Finding, Recording};
use crate::{Error, Result};

use face::{AxisMap, Claim, Face};
use mean::{PoseMean, PoseNoise, pooled_noise, pose_mean};
use sections::Section;

pub use crate::axes::MAX_FACE_ANGLE_DEG;

/// How a session is cut into poses.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SegmentOptions {
    /// Sections of the one recording; default: found.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub sections: Option<Vec<Section>>,
    /// Axes of the sensor that point along x, y and z of the case.
    #[serde(deserialize_with = "gravical_judge::option_text::one")]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub axes: AxisMap,
}

/// One pose of the sensor.
#[derive(Debug, Clone)]
pub struct Pose {
    /// What it is called: label, or name of the file.
    pub label: String,
    /// The file it is from.
    pub source: String,
    /// Index of the recording.
    pub recording: usize,
    /// Its rows.
    pub rows: Range<usize>,
    /// First and last line of the file that they stand in.
    pub lines: [u64; 2],
    /// Found, with a robust mean; not given by a section or label, with that of all its rows.
    pub is_found: bool,
    /// Mean reading in the unit of the file, less the zero offset.
    pub mean: [f64; 3],
    /// Standard error of each component; none where a row is a mean itself.
    pub standard_error: Option<[f64; 3]>,
    /// Rows that the mean is over.
    pub count: usize,
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    /// The face that is up, in axes of the case; none when it lies oblique.
    pub face: Option<Face>,
    /// Angle of the mean to the nearest face as seen from [`gravical_fit::centre`], degrees.
    pub angle_deg: f64,
    /// What its name claims.
    pub claim: Option<Claim>,
    /// Samples of it that are clipped.
    pub clipped: usize,
}

/// A session, cut.
#[derive(Debug, Clone)]
pub struct Segmentation {
    /// Poses in the order of the session.
    pub poses: Vec<Pose>,
    /// Full turns that labels or sections name.
    pub turns: Vec<Turn>,
    /// Noise of all poses together.
    pub noise: PoseNoise,
    /// The gyroscope's unit, by the motions between the poses if they show it.
    pub gyro_scale: Option<GyroScale>,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// What of it says that something is no pose, though it may have been meant as one.
    pub unused: Vec<Finding>,
}

/// A pose before its mean is taken, or a turn.
pub(crate) struct Interval {
    pub label: String,
    pub recording: usize,
    pub rows: Range<usize>,
    pub is_found: bool,
    pub claim: Option<Claim>,
}

impl Interval {
    /// It is named as a full turn, not as a pose.
    pub fn is_turn(&self) -> bool {
        matches!(self.claim, Some(Claim::Turn(_)))
    }
}

/// A full turn about an axis of the case.
#[derive(Debug, Clone)]
pub struct Turn {
    /// 0, 1, 2.
    pub axis: usize,
    /// Index of the recording.
    pub recording: usize,
    /// Its rows.
    pub rows: Range<usize>,
}

/// Cuts a session into poses.
///
/// # Errors
///
/// `no-recordings`, `sections-range` (a section beyond the end or without rows), `several-files`
/// (sections for more than one file), `units-differ`, `unit-unknown`,
/// `never-static`, each with the next thing to do.
pub fn segment(recordings: &[Recording], options: &SegmentOptions) -> Result<Segmentation> {
    if recordings.is_empty() {
        return Err(Problem::NoRecording.error());
    }
    check_units(recordings)?;
    if options.sections.is_some() {
        let hint = "give the part to be cut as a file of its own: `gravical convert` writes one";
        recordings
            .iter()
            .try_for_each(|r| r.refuse_averaged(hint))?;
    }
    let (mut findings, mut unused) = (Vec::new(), Vec::new());
    let named = cut_recordings(recordings, options, [&mut findings, &mut unused])?;
    let (mut turns, mut intervals) = (Vec::new(), Vec::new());
    for interval in named {
        match interval.claim {
            Some(Claim::Turn(axis)) => turns.push(Turn {
                axis,
                recording: interval.recording,
                rows: interval.rows,
            }),
            _ => intervals.push(interval),
        }
    }
    if intervals.is_empty() {
        let error = found::no_rest(&recordings[0]);
        return Err(after(error, &unused));
    }
    let gyro_scale = judge_gyroscope(recordings, &intervals, &mut findings);
    let (mut poses, _, noise) =
        measure_intervals(recordings, intervals, &options.axes, &mut findings);
    leave_out_empty(&mut poses, &mut findings);
    findings.extend(named::check_names(&poses));
    findings.extend(unused.iter().cloned());
    Ok(Segmentation {
        poses,
        turns,
        noise,
        gyro_scale,
        findings,
        unused,
    })
}

/// The poses of a session: named by sections or labels, which may name turns as well, or found. What is odd
/// goes to `findings`, what is no pose to `unused`.
pub(crate) fn cut_recordings(
    recordings: &[Recording],
    options: &SegmentOptions,
    [findings, unused]: [&mut Vec<Finding>; 2],
) -> Result<Vec<Interval>> {
    if let Some(sections) = &options.sections {
        let [one] = recordings else {
            let recordings = recordings.len();
            let of_several = Problem::SectionsOfSeveral { recordings }.error();
            return Err(of_several.of_option("sections"));
        };
        return named::by_sections(one, sections);
    }
    let mut intervals = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let named = named::by_labels(index, recording, findings);
        if named.iter().all(Interval::is_turn) {
            intervals.extend(found::in_recording(index, recordings, [findings, unused])?);
        }
        intervals.extend(named);
    }
    Ok(intervals)
}

/// The unit of the gyroscope, by all recordings of a session.
fn judge_gyroscope(
    recordings: &[Recording],
    intervals: &[Interval],
    findings: &mut Vec<Finding>,
) -> Option<GyroScale> {
    let mut evidence = gyro_unit::Evidence::default();
    for (index, recording) in recordings.iter().enumerate() {
        let own = intervals.iter().filter(|i| i.recording == index);
        let mut rests: Vec<Range<usize>> = own.map(|i| i.rows.clone()).collect();
        rests.sort_by_key(|rows| rows.start);
        evidence.add(recording, &rests);
    }
    let mut recordings = recordings.iter();
    recordings.find_map(|recording| evidence.judge(recording, None, findings))
}

/// One known unit of the accelerometer in all recordings.
#[doc(hidden)]
pub fn check_units<'a>(recordings: impl IntoIterator<Item = &'a Recording>) -> Result<()> {
    let reads = |r: &Recording| {
        (
            r.units.accel.unit,
            r.units.accel.lsb_per_g,
            r.units.zero_offset,
        )
    };
    let mut first: Option<&Recording> = None;
    for recording in recordings {
        let first = *first.get_or_insert(recording);
        if recording.units.accel.unit == AccelUnit::Unknown {
            return Err(unknown_unit(recording));
        }
        if reads(recording) != reads(first) {
            let differ = Problem::RecordingsDiffer {
                first: first.name.clone(),
                scales: [first, recording].map(|r| r.units.accel),
            };
            let error = differ.error().at(recording.name.as_ref(), None);
            return Err(error.advise("accel_unit", ""));
        }
    }
    Ok(())
}

fn unknown_unit(recording: &Recording) -> Error {
    let why = recording.why_unit_unknown.as_ref();
    let unknown = Problem::UnitUnknown {
        why: why.map(|f| f.message.clone()),
    };
    let error = unknown.error().at(recording.name.as_ref(), None);
    let options = why.into_iter().flat_map(|f| &f.options);
    options.fold(error, |error, advice| {
        error.advise(&advice.name, &advice.value)
    })
}

/// Measures static intervals: means with the noise of all together, single spikes left out. The poses, the
/// accelerometer in each, rows with a spike empty, and the noise.
pub(crate) fn measure_intervals(
    recordings: &[Recording],
    intervals: Vec<Interval>,
    axes: &AxisMap,
    findings: &mut Vec<Finding>,
) -> (Vec<Pose>, Vec<[Vec<f64>; 3]>, PoseNoise) {
    let held = without_spikes(recordings, &intervals, findings);
    let steps = recordings.iter().map(|r| r.units.resolution[0]);
    let coarsest = steps.fold([0.0; 3], |most: [f64; 3], step| {
        std::array::from_fn(|i| step[i].max(most[i]))
    });
    let channels: Vec<[&[f64]; 3]> = held.iter().map(slices).collect();
    let noise = pooled_noise(&channels, coarsest, Recording::samples_per_row(recordings));
    let means = channels.iter().zip(&intervals).map(|(held, interval)| {
        let rate_hz = recordings[interval.recording].working_rate_hz();
        pose_mean(held, &noise, rate_hz, interval.is_found)
    });
    let means: Vec<PoseMean> = means.collect();
    let centre = gravical_fit::centre(means.iter().map(|m| &m.mean));
    let measured = intervals.into_iter().zip(means).zip(&held);
    let poses = measured.map(|((interval, mean), held)| {
        let nearest = Face::nearest(axes.to_case(sub(&mean.mean, &centre)));
        let recording = &recordings[interval.recording];
        pose(interval, mean, nearest, held, recording)
    });
    let poses = poses.collect();
    (poses, held, noise)
}

/// The channels of a sensor as slices.
pub(crate) fn slices(channels: &[Vec<f64>; 3]) -> [&[f64]; 3] {
    channels.each_ref().map(|c| &c[..])
}

/// The accelerometer in every static interval, rows with a spike empty.
fn without_spikes(
    recordings: &[Recording],
    intervals: &[Interval],
    findings: &mut Vec<Finding>,
) -> Vec<[Vec<f64>; 3]> {
    let mut counts = vec![0; recordings.len()];
    let take_out = |interval: &Interval| {
        let recording = &recordings[interval.recording];
        let accel = recording.accel.each_ref();
        let mut values = accel.map(|c| c[interval.rows.clone()].to_vec());
        counts[interval.recording] += spikes::take_out(
            &mut values,
            recording.units.resolution[0],
            0..interval.rows.len(),
        );
        values
    };
    let held = intervals.iter().map(take_out).collect();
    for (recording, samples) in recordings.iter().zip(counts) {
        if samples > 0 {
            let spikes = Case::SpikesLeftOut { samples }.finding();
            findings.push(spikes.in_file(&recording.name));
        }
    }
    held
}

fn pose(
    interval: Interval,
    mean: PoseMean,
    (nearest, angle_deg): (Face, f64),
    held: &[Vec<f64>; 3],
    recording: &Recording,
) -> Pose {
    let clipped = held.iter();
    let clipped = clipped.map(|values| clipped_count(values, &recording.units.accel));
    let rows = interval.rows;
    let temperatures = recording.temperature_c.as_ref();
    let temperature_c = temperatures.map(|t| mean_of_finite(&t[rows.clone()]));
    Pose {
        label: interval.label,
        source: recording.name.clone(),
        recording: interval.recording,
        lines: recording.lines_of(&rows),
        is_found: interval.is_found,
        mean: mean.mean,
        standard_error: mean.standard_error,
        count: mean.rows,
        temperature_c: temperature_c.filter(|t| t.is_finite()),
        face: (angle_deg <= MAX_FACE_ANGLE_DEG).then_some(nearest),
        angle_deg,
        claim: interval.claim,
        clipped: clipped.sum(),
        rows,
    }
}

/// Sum of the rows of a sensor that have all three values, and their number; none without any.
pub(crate) fn sum_of_rows(
    sensor: &[Vec<f64>; 3],
    rows: impl IntoIterator<Item = usize>,
) -> Option<([f64; 3], usize)> {
    let (mut sum, mut count) = ([0.0; 3], 0);
    for row in rows {
        let values = sensor.each_ref().map(|channel| channel[row]);
        if values.iter().all(|v| v.is_finite()) {
            (0..3).for_each(|i| sum[i] += values[i]);
            count += 1;
        }
    }
    (count > 0).then_some((sum, count))
}

/// A pose that a section or label names may have rows, but no value of
/// some axis in any of them: it has no mean.
pub(crate) fn leave_out_empty(poses: &mut Vec<Pose>, findings: &mut Vec<Finding>) {
    poses.retain(|pose| {
        let Some(axis) = pose.mean.iter().position(|m| !m.is_finite()) else {
            return true;
        };
        let empty = Case::EmptyPose {
            pose: pose.label.clone(),
            axis: face::AXES[axis],
        };
        findings.push(empty.finding().in_file(&pose.source));
        false
    });
}
