//! The gyroscope by full turns, named or found between rests, in closed form.

use std::array::from_fn;
use std::f64::consts::TAU;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_recording::range_end;

use super::SCALE_OFF;
use super::readings::GAP_PERIODS;
use crate::calibrate::session::Session;
use crate::calibration_file::{GyroMethod, GyroscopeSection};
use crate::poses::face::Face;
use crate::poses::rests::with_slow_ends;
use crate::poses::{Pose, Turn, sum_of_rows};
use crate::recording::units::GyroUnit;

/// Gravity comes back within 10° after a full turn on a table: the cosine of that.
const COS_BACK: f64 = 0.985;
/// Share of the rotation that is about one axis.
const MIN_SHARE: f64 = 0.9;
/// How far the angle by the nominal scale may be off a full turn, rad.
const MAX_OFF: f64 = TAU / 6.0;

/// The gyroscope u = M ω + b + S a by the six faces and a full turn about each axis (F. Ferraris,
/// U. Grimaldi and M. Parvis, Sensors and Materials 7(5), 1995): b is the mean over all samples of the
/// faces, S half the difference of opposite faces over g, and the columns of M are the integrals of
/// u − b − S a over the turns, divided by 2π. The direction of a turn is that in which the channel of
/// its axis counts up. Several turns about one axis are averaged. There is no covariance: how exact a
/// turn was, nothing tells.
///
/// None without all of these, where a turn has a gap or reaches the end of the range, and where the
/// scale is so far from nominal that it was another turn.
pub(crate) fn by_turns(
    session: &Session<'_>,
    accelerometer: &Calibration<f64>,
) -> Option<GyroscopeSection> {
    let (cut, recordings) = (session.segmentation, session.recordings);
    let found: Vec<Turn>;
    let turns = if cut.turns.is_empty() {
        found = find_turns(session)?;
        &found
    } else {
        &cut.turns
    };
    let of_face = |face: Face| {
        let poses = cut.poses.iter().filter(|p| p.face == Some(face));
        let sums = poses
            .filter_map(|p| sum_of_rows(recordings[p.recording].gyro.as_ref()?, p.rows.clone()));
        sums.reduce(|(a, n), (b, m)| (matrix3::add(&a, &b), n + m))
    };
    let faces: Vec<([f64; 3], usize)> = Face::all()
        .into_iter()
        .map(of_face)
        .collect::<Option<_>>()?;
    let total = faces
        .iter()
        .fold([0.0; 3], |sum, (s, _)| matrix3::add(&sum, s));
    let count: usize = faces.iter().map(|(_, n)| n).sum();
    let bias = total.map(|t| t / count as f64);
    let mean = |face: usize, channel: usize| faces[face].0[channel] / faces[face].1 as f64;
    let two_g = 2.0 * session.gravity_mps2();
    let g_sensitivity =
        from_fn(|r| from_fn(|axis| (mean(2 * axis, r) - mean(2 * axis + 1, r)) / two_g));
    let left = |rate: [f64; 3], accel: [f64; 3]| {
        let by_force = matrix3::mul_vec(&g_sensitivity, &accelerometer.apply(accel));
        matrix3::sub(&matrix3::sub(&rate, &bias), &by_force)
    };
    let rates = session.axes().of_rates();
    let mut model = [[0.0; 3]; 3];
    for (axis, about) in from_fn::<_, 3, _>(|axis| turns_about(turns, axis))
        .iter()
        .enumerate()
    {
        for turn in about {
            let integral = integral(session, turn, left)?;
            let sense = rates.to_case(integral)[axis].signum();
            let angle = sense * TAU * about.len() as f64;
            (0..3).for_each(|r| model[r][axis] += integral[r] / angle);
        }
    }
    let matrix = matrix3::inverse(&model)?;
    let scale = matrix3::row_norms(&model);
    let nominal = cut.gyro_scale.and_then(|scale| scale.nominal());
    let is_off = |nominal: f64| scale.iter().any(|s| (s / nominal - 1.0).abs() > SCALE_OFF);
    (!nominal.is_some_and(is_off)).then(|| GyroscopeSection {
        method: GyroMethod::Turns,
        input_unit: cut.gyro_scale.map_or(GyroUnit::Unknown, |s| s.unit),
        output_unit: GyroUnit::RadianPerSecond,
        bias,
        matrix,
        scale,
        orientation: matrix3::scale_rows(&model, &scale.map(f64::recip)),
        g_sensitivity,
        ..GyroscopeSection::default()
    })
}

/// The motions between neighbouring rests of each recording that are full turns: gravity is back within
/// 10°, and the rotation is one of 360° ± 60° about one axis, to nine tenths.
fn find_turns(session: &Session<'_>) -> Option<Vec<Turn>> {
    let nominal = session.segmentation.gyro_scale?.nominal()?;
    let rates = session.axes().of_rates();
    let mut turns = Vec::new();
    for (index, recording) in session.recordings.iter().enumerate() {
        let Some(gyro) = &recording.gyro else {
            continue;
        };
        let poses = session.segmentation.poses.iter();
        let mut rests: Vec<&Pose> = poses.filter(|p| p.recording == index).collect();
        rests.sort_by_key(|p| p.rows.start);
        for pair in rests.windows(2) {
            let [before, after] = [pair[0], pair[1]];
            let [from, to] = [before, after].map(|rest| matrix3::unit(&rest.mean));
            if matrix3::dot(&from, &to) < COS_BACK {
                continue;
            }
            let bias = |rest: &Pose| {
                let (sum, count) = sum_of_rows(gyro, rest.rows.clone())?;
                Some(sum.map(|s| s / count as f64))
            };
            let (Some(a), Some(b)) = (bias(before), bias(after)) else {
                continue;
            };
            let turn = |axis| Turn {
                axis,
                recording: index,
                rows: with_slow_ends(recording, &before.rows, &after.rows),
            };
            let less_bias = |rate: [f64; 3], _| from_fn(|i| rate[i] - 0.5 * (a[i] + b[i]));
            let Some(integral) = integral(session, &turn(0), less_bias) else {
                continue;
            };
            let rotation = rates.to_case(integral).map(|v| v / nominal);
            let angle = matrix3::norm(&rotation);
            let about = (0..3).find(|&axis| rotation[axis].abs() > MIN_SHARE * angle);
            if (angle - TAU).abs() < MAX_OFF {
                turns.extend(about.map(turn));
            }
        }
    }
    Some(turns)
}

fn turns_about(turns: &[Turn], axis: usize) -> Vec<&Turn> {
    turns.iter().filter(|turn| turn.axis == axis).collect()
}

/// ∫ u dt of what is `left` of the readings, unit of the file · s. Each sample stands for half the time
/// between its neighbours.
fn integral(
    session: &Session<'_>,
    turn: &Turn,
    left: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> Option<[f64; 3]> {
    let recording = &session.recordings[turn.recording];
    let gyro = recording.gyro.as_ref()?;
    let rate_hz = recording.timing.rate_hz()?;
    if recording.is_averaged() || recording.is_broken(&turn.rows) {
        return None;
    }
    let ends = gyro
        .each_ref()
        .map(|c| range_end(c, session.segmentation.gyro_scale));
    let last = recording.rows() - 1;
    let mut sum = [0.0; 3];
    for row in turn.rows.clone() {
        let rate = gyro.each_ref().map(|channel| channel[row]);
        let at_end =
            |i: usize| ends[i].is_some_and(|[low, high]| rate[i] <= low || rate[i] >= high);
        let period_s = match &recording.time_s {
            Some(t) if (1..last).contains(&row) => 0.5 * (t[row + 1] - t[row - 1]),
            _ => rate_hz.recip(),
        };
        let part = left(rate, recording.accel_at(row)).map(|rate| rate * period_s);
        let is_gap = !(period_s > 0.0 && period_s * rate_hz < GAP_PERIODS);
        if is_gap || (0..3).any(at_end) || part.iter().any(|p| !p.is_finite()) {
            return None;
        }
        sum = matrix3::add(&sum, &part);
    }
    Some(sum)
}
