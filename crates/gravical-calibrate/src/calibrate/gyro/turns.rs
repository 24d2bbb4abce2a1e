//! The gyroscope by full turns, named or found between rests, in closed form.

use std::array::from_fn;
use std::f64::consts::TAU;

use gravical_core::calibration::LinearCalibration;
use gravical_core::matrix3;
use gravical_fit::Motion;

use super::readings::{Place, Readings};
use super::{SCALE_OFF, section};
use crate::calibrate::session::Session;
use crate::calibration_file::{GyroMethod, Gyroscope};
use crate::poses::face::Face;
use crate::poses::{Turn, sum_of_rows};

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
pub(super) fn by_turns(
    session: &Session<'_>,
    readings: &Readings<'_>,
    accelerometer: &LinearCalibration<f64>,
) -> Option<Gyroscope> {
    let (cut, recordings) = (session.segmentation, session.recordings);
    let mut turns = cut.turns.clone();
    if turns.is_empty() {
        turns = find_turns(session, readings);
    }
    let both = |(a, n): ([f64; 3], usize), (b, m): ([f64; 3], usize)| (matrix3::add(&a, &b), n + m);
    let of_face = |face: Face| {
        let poses = cut.poses.iter().filter(|p| p.face == Some(face));
        let sums = poses
            .filter_map(|p| sum_of_rows(recordings[p.recording].gyro.as_ref()?, p.rows.clone()));
        sums.reduce(both)
    };
    let faces = Face::all().into_iter().map(of_face);
    let faces: Vec<([f64; 3], usize)> = faces.collect::<Option<_>>()?;
    let (total, count) = faces.iter().copied().reduce(both)?;
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
    for axis in 0..3 {
        let about = || turns.iter().filter(move |turn| turn.axis == axis);
        for turn in about() {
            let track = readings.tracks[turn.recording].as_ref()?;
            let integral = track.integral(&turn.rows, left)?;
            let sense = rates.to_case(integral)[axis].signum();
            let angle = sense * TAU * about().count() as f64;
            (0..3).for_each(|r| model[r][axis] += integral[r] / angle);
        }
    }
    let matrix = matrix3::inverse(&model)?;
    let section = Gyroscope {
        g_sensitivity,
        ..section(readings, GyroMethod::Turns, matrix, bias)
    };
    let is_off = |nominal: f64| {
        let mut scale = section.scale().into_iter();
        scale.any(|s| (s / nominal - 1.0).abs() > SCALE_OFF)
    };
    (!readings.nominal().is_some_and(is_off)).then_some(section)
}

/// The motions between neighbouring rests that are full turns: gravity is back within 10°, and the rotation
/// is one of 360° ± 60° about one axis, to nine tenths.
fn find_turns(session: &Session<'_>, readings: &Readings<'_>) -> Vec<Turn> {
    let rates = session.axes().of_rates();
    let turn = |(motion, place): (&Motion, &Place)| {
        let nominal = readings.nominal()?;
        let [before, after] = [motion.before, motion.after].map(|i| &readings.intervals[i]);
        let [from, to] = [before, after].map(|rest| matrix3::unit(&rest.accel));
        if matrix3::dot(&from, &to) < COS_BACK {
            return None;
        }
        let less_bias =
            |rate: [f64; 3], _| from_fn(|i| rate[i] - 0.5 * (before.rate[i] + after.rate[i]));
        let track = readings.tracks[place.recording].as_ref()?;
        let integral = track.integral(&place.rows, less_bias)?;
        let rotation = rates.to_case(integral).map(|v| v / nominal);
        let angle = matrix3::norm(&rotation);
        let axis = (0..3).find(|&axis| rotation[axis].abs() > MIN_SHARE * angle)?;
        ((angle - TAU).abs() < MAX_OFF).then(|| Turn {
            axis,
            recording: place.recording,
            rows: place.rows.clone(),
        })
    };
    let motions = readings.motions.iter().zip(&readings.places);
    motions.filter_map(turn).collect()
}
