//! Recordings of one session that are of different sensors.

use gravical_fit::later::{Compare, ParameterDifference, compare};
use gravical_fit::model::{BIAS, DRIFT};
use gravical_fit::{Fit, Options, Pose, Sensor, fit};

use crate::numfmt::milli_g;
use crate::{Error, Result};

use super::estimate::Session;

/// A recording is fitted alone from so many poses: scale, angles and bias are nine parameters, or six
/// faces.
const MIN_POSES: usize = 6;
/// One sensor differs by more than this less often.
const CHANCE: f64 = 1e-6;
/// What a sensor changes by from one recording to the next, with temperature and from start to start:
/// elements of M (relative) and bias (m/s², 5 mg). Two parts differ by ten times that.
const CHANGES: [f64; 2] = [2e-3, 0.05];

/// Refuses recordings whose own fits contradict each other by more than their covariances and the
/// changes of one sensor allow. Recordings with too few poses to be fitted alone are not judged.
///
/// # Errors
///
/// `sensors-differ`, at the first recording that contradicts one before it.
pub(super) fn one_sensor(session: &Session<'_>, poses: &[Pose], options: &Options) -> Result<()> {
    let placements = &session.segmentation.poses;
    let fit_alone = |index: usize| {
        let of_recording = poses
            .iter()
            .zip(placements)
            .filter(|(_, p)| p.recording == index);
        let poses: Vec<Pose> = of_recording.map(|(pose, _)| pose.clone()).collect();
        (poses.len() >= MIN_POSES).then(|| fit(&poses, options).ok())?
    };
    let mut alone: Vec<(&str, Sensor)> = Vec::new();
    for (index, recording) in session.recordings.iter().enumerate() {
        let Some(fit) = fit_alone(index) else {
            continue;
        };
        let sensor = sensor(&fit, session.scale());
        for (other, before) in &alone {
            let differ = compare(before, &sensor).filter(|c| c.magnitude.p_value < CHANCE);
            let Some([scale, bias]) = differ.map(|c| apart(&c)) else {
                continue;
            };
            let name = &recording.name;
            return Err(Error::input("sensors-differ", format!(
                "{other} and {name} are of different sensors: fitted alone, their scales are {scale:.1} % and their biases {bias:.0} mg apart, more than one sensor changes"
            ))
            .at(name.as_ref(), None)
            .with_hint("calibrate the recordings of each sensor alone"));
        }
        alone.push((&recording.name, sensor));
    }
    Ok(())
}

/// The fit of a recording in nominal m/s², with what a sensor changes by from one recording to the next
/// added to its covariance.
fn sensor(fit: &Fit, unit: f64) -> Sensor {
    let mut sensor = fit.sensor(unit);
    for i in 0..DRIFT {
        let change = CHANGES[usize::from(i >= BIAS)];
        sensor.covariance[(i, i)] += 0.5 * change * change;
    }
    sensor
}

/// Largest differences of scales in % and of biases in mg.
fn apart(compared: &Compare) -> [f64; 2] {
    let largest = |range: &[ParameterDifference]| {
        let sizes = range.iter().map(|d| d.difference.abs());
        sizes.fold(0.0, f64::max)
    };
    let [bias, scale] = [&compared.parameters[..3], &compared.parameters[3..6]].map(largest);
    [scale, milli_g(bias)]
}
