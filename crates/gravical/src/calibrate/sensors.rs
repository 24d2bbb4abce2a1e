//! Recordings of one session that are of different sensors.

use gravical_fit::later::{Compare, Difference, compare};
use gravical_fit::model::{BIAS, DRIFT};
use gravical_fit::{Fit, Options, Pose, Sensor, fit};

use crate::numfmt::milli_g;
use crate::{Error, Result};

use super::session::Session;

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
/// `sensors-differ`, at the recording that contradicts all others where they agree.
pub(super) fn one_sensor(session: &Session<'_>, poses: &[Pose], options: &Options) -> Result<()> {
    let placements = &session.segmentation.poses;
    let fit_alone = |index: usize| {
        let of_recording = poses
            .iter()
            .zip(placements)
            .filter(|(_, p)| p.recording == index)
            .map(|(pose, _)| pose.clone());
        let poses: Vec<Pose> = of_recording.collect();
        (poses.len() >= MIN_POSES).then(|| fit(&poses, options).ok())?
    };
    let unit = session.scale();
    let alone: Vec<(&str, Sensor)> = session
        .recordings
        .iter()
        .enumerate()
        .filter_map(|(index, recording)| Some((&*recording.name, sensor(&fit_alone(index)?, unit))))
        .collect();
    // Pairs that differ, both ways round, and how far they are apart.
    let mut differ = Vec::new();
    for (i, (_, a)) in alone.iter().enumerate() {
        for (j, (_, b)) in alone.iter().enumerate().skip(i + 1) {
            let Some(compared) = compare(a, b).filter(|c| c.magnitude.p_value < CHANCE) else {
                continue;
            };
            differ.extend([(i, j, apart(&compared)), (j, i, apart(&compared))]);
        }
    }
    let of = |i: usize| differ.iter().filter(move |(one, ..)| *one == i);
    let Some(worst) = (0..alone.len()).max_by_key(|&i| of(i).count()) else {
        return Ok(());
    };
    let furthest = of(worst).max_by(|(.., a), (.., b)| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
    let Some((_, with, [scale, bias])) = furthest else {
        return Ok(());
    };
    let (name, with) = (alone[worst].0, alone[*with].0);
    let others: Vec<&str> = of(worst).map(|(_, other, _)| alone[*other].0).collect();
    let is_odd_one = alone.len() > 2 && (0..alone.len()).all(|i| i == worst || of(i).count() == 1);
    let (prefix, rest, hint) = if is_odd_one {
        (
            "one recording does not belong to the others: ",
            "the others".to_owned(),
            format!("calibrate without {name}, and calibrate that one alone"),
        )
    } else {
        (
            "",
            others.join(", "),
            format!(
                "calibrate the recordings of each sensor alone: {name} and {with} do not go together"
            ),
        )
    };
    let message = format!(
        "{prefix}{name} and {rest} are of different sensors: fitted alone, their scales are {scale:.1} % and their biases {bias:.0} mg apart, more than one sensor changes"
    );
    Err(Error::input("sensors-differ", message)
        .at(name.as_ref(), None)
        .with_hint(hint))
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
    let largest = |range: &[Difference]| range.iter().fold(0.0_f64, |m, d| m.max(d.change.abs()));
    [
        100.0 * largest(&compared.invariants[3..6]),
        milli_g(largest(&compared.invariants[..3])),
    ]
}
