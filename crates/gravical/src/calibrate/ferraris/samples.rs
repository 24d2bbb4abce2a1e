//! The closed form of named samples in memory: means and turns, and nothing else.
//!
//! Nothing is searched, tested or left out, and there is no uncertainty: for that there is
//! [`calibrate`](crate::calibrate::calibrate), which gives the same parameters where it leaves no
//! row out.

use gravical_core::calibration::GyroscopeCalibration;
use gravical_core::six_position::{
    GyroscopeParameters, SixPositionError, SixPositionMeans, TurnIntegral, ferraris_gyroscope,
    g_sensitivity,
};

use super::faces::Faces;
use super::{AccelerometerFit, accelerometer, turns_are_singular};
use crate::segment::face::{AXES, Claim, Face, claim};
use crate::{Error, Result};

/// Samples of one pose or turn.
#[derive(Debug, Clone, Copy)]
pub struct NamedSamples<'a> {
    /// What names the pose or the turn, as a label: `+x`, `x_a`, `y_rot` ….
    pub name: &'a str,
    /// Row by row: specific force along x, y, z, then the angular rate, if there is one; raw units.
    pub rows: &'a [f64],
    /// Values in a row: 3 or 6.
    pub width: usize,
}

/// What the closed form gives.
#[derive(Debug, Clone)]
pub struct ClosedForm {
    /// The accelerometer.
    pub accelerometer: AccelerometerFit,
    /// The gyroscope, in rad/s; none without turns.
    pub gyroscope: Option<(GyroscopeParameters<f64>, GyroscopeCalibration<f64>)>,
}

/// Sums of the rows of a face, and their number.
type Sums = ([f64; 6], usize);

/// The closed form of six faces and, for the gyroscope, a turn by `angle_rad` about each axis, with
/// samples `period_s` apart. Faces and turns with the same name are pooled.
///
/// # Errors
///
/// `usage` for a name that is no face and no turn; `missing-face`; `missing-gyro` (turns without its
/// values); `rate-unknown` (turns without a period); `singular`, also for a value that is not finite.
pub fn of_samples(
    samples: &[NamedSamples<'_>],
    gravity: f64,
    angle_rad: f64,
    period_s: Option<f64>,
) -> Result<ClosedForm> {
    let mut faces = [([0.0; 6], 0); 6];
    let mut turns: Vec<(usize, &NamedSamples<'_>)> = Vec::new();
    let mut width = 6;
    for one in samples {
        if !matches!(one.width, 3 | 6) {
            let what = format!("{:?} has {} values in a row", one.name, one.width);
            return Err(
                Error::usage("usage", what).with_hint("give three, or six with the gyroscope")
            );
        }
        match claim(one.name) {
            Some(Claim::Face(face)) => {
                add(&mut faces[face.index()], one);
                width = width.min(one.width);
            }
            Some(Claim::Turn(axis)) => turns.push((axis, one)),
            _ => {
                let what = format!("{:?} names no face and no turn", one.name);
                let error = Error::usage("usage", what);
                return Err(
                    error.with_hint("name the faces +x, -x … -z and the turns x_rot, y_rot, z_rot")
                );
            }
        }
    }
    let missing: Vec<String> = Face::all()
        .into_iter()
        .filter(|face| faces[face.index()].1 == 0)
        .map(|face| face.name())
        .collect();
    if !missing.is_empty() {
        let what = format!("there is no sample of {}", missing.join(" and "));
        return Err(Error::input("missing-face", what)
            .with_hint("the closed form needs all six faces; `calibrate` takes other poses"));
    }
    let sorted = Faces {
        of_face: Default::default(),
        means: means(&faces, 0),
        standard_errors: None,
    };
    let accelerometer = accelerometer(&sorted, gravity, None)?;
    let gyroscope = match turns.is_empty() {
        true => None,
        false if width < 6 || turns.iter().any(|(_, turn)| turn.width < 6) => {
            return Err(Error::input(
                "missing-gyro",
                "the turns need the gyroscope in all poses and turns",
            )
            .with_hint("give six values in a row, or leave the turns out"));
        }
        false => {
            let period_s = period_s.ok_or_else(|| {
                let what = "the turns need the time between samples";
                Error::usage("rate-unknown", what).with_hint("give the rate: --rate 100")
            })?;
            Some(gyroscope(
                &faces,
                &turns,
                &accelerometer,
                [gravity, angle_rad, period_s],
            )?)
        }
    };
    Ok(ClosedForm {
        accelerometer,
        gyroscope,
    })
}

fn add((sums, count): &mut Sums, samples: &NamedSamples<'_>) {
    for row in samples.rows.chunks_exact(samples.width) {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value;
        }
        *count += 1;
    }
}

/// The means of three values of a row, from place `at` on.
fn means(faces: &[Sums; 6], at: usize) -> SixPositionMeans<f64> {
    let mean = |axis: usize, up: bool| {
        let (sums, count) = faces[Face { axis, up }.index()];
        std::array::from_fn(|i| sums[at + i] / count as f64)
    };
    SixPositionMeans {
        plus: std::array::from_fn(|axis| mean(axis, true)),
        minus: std::array::from_fn(|axis| mean(axis, false)),
    }
}

fn gyroscope(
    faces: &[Sums; 6],
    turns: &[(usize, &NamedSamples<'_>)],
    accelerometer: &AccelerometerFit,
    [gravity, angle_rad, period_s]: [f64; 3],
) -> Result<(GyroscopeParameters<f64>, GyroscopeCalibration<f64>)> {
    let rows: usize = faces.iter().map(|(_, count)| count).sum();
    let total = |i: usize| faces.iter().map(|(sums, _)| sums[3 + i]).sum::<f64>();
    let bias = std::array::from_fn(|i| total(i) / rows as f64);
    let means = means(faces, 3);
    let sensitivity = g_sensitivity(&means, gravity).map_err(turns_are_singular)?;
    let mut integrals = [[0.0; 3]; 3];
    for (axis, sum) in integrals.iter_mut().enumerate() {
        let about = || turns.iter().filter(|(of, _)| *of == axis);
        let count = about().count();
        if count == 0 {
            let what = format!("there is no turn about {}", AXES[axis]);
            return Err(
                Error::input("singular", what).with_hint("give a turn about each axis, or none")
            );
        }
        for (_, turn) in about() {
            let mut integral = TurnIntegral::new(bias, sensitivity);
            for row in turn.rows.chunks_exact(turn.width) {
                if let [ax, ay, az, gx, gy, gz] = *row {
                    let force = accelerometer.calibration.apply([ax, ay, az]);
                    integral.add([gx, gy, gz], force, period_s);
                }
            }
            let integral = integral.finish();
            (0..3).for_each(|i| sum[i] += integral[i] / count as f64);
        }
    }
    let parameters = ferraris_gyroscope(bias, &means, gravity, &integrals, angle_rad);
    let parameters = parameters.map_err(turns_are_singular)?;
    let calibration = parameters.calibration();
    let calibration = calibration.ok_or_else(|| turns_are_singular(SixPositionError::Singular))?;
    Ok((parameters, calibration))
}
