//! The gyroscope from the motions between stills.
//!
//! # Overview
//!
//! Between two stills the sensor is turned, by hand and anyhow. Gravity's
//! direction is known in both from the calibrated accelerometer, so that the
//! integrated angular rate has to turn the one into the other:
//!
//! ```text
//! C(∫ω dt) v₀ − v₁ = 0,   ω = G (u − b − S a)
//! ```
//!
//! over all motions, for the nine elements of G and the bias b, which the stills
//! hold (Tedaldi, Pretto, Menegatti, "A robust and easy to implement method for
//! IMU calibration without external equipments", ICRA 2014). No turn has to be
//! known. The axes of the result are those of the calibrated accelerometer, so
//! that both sensors agree.
//!
//! The order: what the stills say of bias, drift, reaction to gravity and noise
//! (`rest`); the motions (`motions`) without those that have a gap or are
//! clipped, of all recordings of the session; a start where the scale is not known (`start`); a check of what the
//! motions can determine (`determined`); a robust fit, then generalised least
//! squares without the motions that contradict the others (`fit`, `problem`,
//! with `integrate` as the inner loop).
//!
//! It fails where the sensor never turns about one of its axes while that axis
//! is level: a turn about the vertical leaves gravity where it is. Then
//! [`of_session`] returns the bias alone.

mod bias;
mod determined;
mod fit;
mod integrate;
mod motions;
mod problem;
mod rest;
mod result;
mod start;
#[cfg(test)]
mod tests;

use std::ops::Range;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use nalgebra::{Matrix3, Vector3};

use crate::calibration_file::GyroscopeSection;
use crate::recording::units::{GyroScale, GyroUnit};
use crate::recording::{Finding, FindingKind, Recording};
use crate::segment::{Placement, Segmentation, sum_of_rows};

/// One still of a continuous recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Its rows.
    pub rows: Range<usize>,
    /// Mean of the accelerometer over them, as in [`Recording::accel`].
    pub accel: [f64; 3],
    /// Its standard error; none where it is not known.
    pub standard_error: Option<[f64; 3]>,
}

impl Still {
    /// The stills of a recording, in the order of its rows: every stretch of
    /// every placement.
    #[must_use]
    pub fn of(placements: &[Placement], recording: usize) -> Vec<Still> {
        let mut stills: Vec<Still> = placements
            .iter()
            .filter(|p| p.recording == recording)
            .flat_map(|p| {
                p.rows.iter().map(|rows| Still {
                    rows: rows.clone(),
                    accel: p.mean,
                    standard_error: p.standard_error,
                })
            })
            .collect();
        stills.sort_by_key(|s| s.rows.start);
        stills
    }
}

/// A gyroscope, or why there is none.
#[derive(Debug, Clone, Default)]
pub struct GyroFit {
    /// The parameters, method `motion` or `bias`; none where not even a nominal
    /// scale is known.
    pub section: Option<GyroscopeSection>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

impl GyroFit {
    /// With what was found about known turns before: that some are missing
    /// matters only where the motions do not do without them.
    #[must_use]
    pub fn or_after(mut self, turns: Vec<Finding>) -> Self {
        if self.section.as_ref().is_none_or(|s| s.method != "motion") {
            self.findings.splice(0..0, turns);
        }
        self
    }
}

/// Motions whose typical residual is above this do not fit at all, degrees.
const MISFIT_DEG: f64 = 3.0;

/// A recording and its stills.
type Part<'a> = (&'a Recording, &'a [Still]);

/// The gyroscope of a session without three known turns: from the motions of all
/// its recordings, or the bias alone where they do not determine more: what cannot be
/// determined is a finding. Neither section nor finding where there is no gyroscope.
///
/// `accelerometer` calibrates the values of [`Recording::accel`] (its zero offset taken off) to
/// m/s²; its axes become those of the gyroscope.
///
/// The covariance is that of noise, drift and what else the residuals show; an error of the
/// accelerometer's calibration is in it only as far as the residuals show it.
#[must_use]
pub fn of_session(
    recordings: &[Recording],
    session: &Segmentation,
    accelerometer: &Calibration<f64>,
) -> GyroFit {
    let stills: Vec<Vec<Still>> = (0..recordings.len())
        .map(|index| Still::of(&session.placements, index))
        .collect();
    let parts: Vec<Part<'_>> = recordings
        .iter()
        .zip(&stills)
        .map(|(recording, stills)| (recording, &stills[..]))
        .collect();
    fit_of(&parts, accelerometer, session.gyro_scale)
}

/// The same for the stills of `parts`; without a nominal `scale` the motions give it.
fn fit_of(
    parts: &[Part<'_>],
    accelerometer: &Calibration<f64>,
    scale: Option<GyroScale>,
) -> GyroFit {
    let mut out = GyroFit::default();
    let Some(prepared) = Prepared::new(parts, accelerometer, scale, &mut out.findings) else {
        return out;
    };
    // What concerns several recordings stands in no file.
    let recordings: Vec<&Recording> = parts.iter().map(|(recording, _)| *recording).collect();
    let file = |finding: Finding| match recordings[..] {
        [one] => finding.in_file(&one.name),
        _ => finding,
    };
    let Prepared {
        rest,
        mut motions,
        spread,
        ..
    } = prepared;
    let unit = scale.map_or(GyroUnit::Unknown, |s| s.unit);
    let nominal = scale.and_then(|s| s.nominal());
    let bias_only = |findings: &mut Vec<Finding>| {
        let (section, found) = bias::section(&rest, unit, nominal);
        findings.extend(found.map(file));
        section
    };
    if motions.list.is_empty() {
        out.section = bias_only(&mut out.findings);
        return out;
    }
    // Rad/s per unit of the file: nominal, or as the motions show it.
    let Some(per_unit) = nominal.map(f64::recip).or_else(|| start::scale(&motions)) else {
        out.section = bias_only(&mut out.findings);
        return out;
    };
    for sample in &mut motions.samples {
        (0..3).for_each(|i| sample[i] *= per_unit);
    }
    let size = per_unit.abs();
    let root_mean_square = |v: [f64; 3]| (v.iter().map(|x| x * x).sum::<f64>() / 3.0).sqrt() * size;
    let known = fit::Known {
        spread,
        noise: root_mean_square(rest.noise),
        drift: root_mean_square(rest.local_sd),
        beta_sigma: rest.bias_error.map(|s| (s * size).max(1e-9)),
    };
    let setup = fit::Setup::new(&motions, &known);
    let at_start = setup.at(problem::State::start());
    let expected = setup.expected_covariance(&at_start);
    if let Some(why) = determined::lacking(expected.as_ref(), motions.list.len(), nominal.is_some())
    {
        out.findings.push(file(why));
        out.section = bias_only(&mut out.findings);
        return out;
    }
    let mut robust = setup.robust(at_start);
    if robust.typical.to_degrees() > MISFIT_DEG
        && let Some(e) = start::matrix(&motions)
    {
        // Perhaps the axes are not the accelerometer's.
        let other = setup.robust(setup.at(problem::State { e, beta: [0.0; 3] }));
        if other.typical < robust.typical {
            robust = other;
        }
    }
    let typical = robust.typical;
    let fitted = setup
        .fit(robust)
        .filter(|f| matrix3::is_finite(&f.state.e) && matrix3::inverse(&f.state.e).is_some());
    let lacking = determined::lacking(
        fitted.as_ref().and_then(|f| f.covariance.as_ref()),
        motions.list.len(),
        nominal.is_some(),
    );
    let (Some(fitted), None) = (fitted, &lacking) else {
        out.findings.extend(lacking.map(file));
        out.section = bias_only(&mut out.findings);
        return out;
    };
    result::tell_outliers(&recordings, &motions, &fitted, &mut out.findings);
    let findings = result::findings(&fitted, nominal, per_unit, typical);
    out.findings.extend(findings.into_iter().map(file));
    out.section = result::section(&rest, &motions, &fitted, per_unit, unit);
    out
}

/// True where a still follows another without a break between them.
fn moves((recording, stills): Part<'_>) -> bool {
    let between = |pair: &[Still]| pair[0].rows.end.saturating_sub(1)..pair[1].rows.start + 1;
    let mut pairs = stills.windows(2);
    let whole = |rows: Range<usize>| !recording.is_broken(&rows) && !recording.is_cut(&rows);
    recording.gyro.is_some() && pairs.any(|p| whole(between(p)))
}

/// Stills and motions, looked at.
struct Prepared {
    rest: rest::Rest,
    motions: motions::Motions,
    spread: Vec<Matrix3<f64>>,
}

impl Prepared {
    fn new(
        parts: &[Part<'_>],
        accelerometer: &Calibration<f64>,
        scale: Option<GyroScale>,
        findings: &mut Vec<Finding>,
    ) -> Option<Prepared> {
        let mut stills: Vec<rest::Rested<'_>> = Vec::new();
        let mut step = [0.0_f64; 3];
        // Of each recording the range of its stills.
        let mut ranges = Vec::new();
        for (recording, own) in parts {
            let first = stills.len();
            if let Some(gyro) = &recording.gyro {
                let finest = recording.gyro_resolution();
                (0..3).for_each(|i| step[i] = step[i].max(finest[i]));
                // Without a time the noise only weighs stills against each other.
                let period_s = recording.working_rate_hz().0.recip();
                // A still without a reading says nothing and parts two motions.
                let read = |s: &&Still| sum_of_rows(gyro, s.rows.clone()).is_some();
                stills.extend(own.iter().filter(read).map(|still| rest::Rested {
                    still,
                    gyro,
                    period_s,
                    accel: accelerometer.apply(still.accel),
                }));
            }
            ranges.push(first..stills.len());
        }
        let rest = rest::at_rest(&stills, step)?;
        let spread = stills
            .iter()
            .map(|s| direction_covariance(s.still, s.accel, accelerometer))
            .collect();
        let mut motions = motions::Motions::default();
        for (index, range) in ranges.into_iter().enumerate() {
            let recording = parts[index].0;
            let Some(gyro) = &recording.gyro else {
                continue;
            };
            // Files of one placement each, or of two that blank rows part, hold no motions:
            // nothing is missing in them.
            if parts.len() > 1 && !moves(parts[index]) {
                continue;
            }
            if let Some(rate_hz) = recording.timing.rate_hz() {
                let source = motions::Source {
                    recording,
                    gyro,
                    scale,
                    stills: &stills[range.clone()],
                    index,
                    first: range.start,
                    accelerometer,
                    rest: &rest,
                    period_s: rate_hz.recip(),
                };
                motions::gather(&source, &mut motions);
            } else if range.len() > 1 {
                findings.push(
                    Finding::new(
                        FindingKind::GyroRateUnknown,
                        "no time stamps and no --rate: the turns between static intervals cannot be integrated, and the gyroscope gets its bias only",
                    )
                    .in_file(&recording.name),
                );
            }
        }
        findings.append(&mut motions.findings);
        Some(Prepared {
            rest,
            motions,
            spread,
        })
    }
}

/// Covariance of a unit vector along A (u − b), from the standard error of u.
fn direction_covariance(
    still: &Still,
    accel: [f64; 3],
    accelerometer: &Calibration<f64>,
) -> Matrix3<f64> {
    let error = Vector3::from(still.standard_error.unwrap_or([0.0; 3]));
    let a = Vector3::from(accel);
    let direction = a.normalize();
    let across = Matrix3::identity() - direction * direction.transpose();
    // nalgebra's arrays are columns.
    let to_direction = across * Matrix3::from(accelerometer.matrix).transpose() / a.norm();
    to_direction * Matrix3::from_diagonal(&error.component_mul(&error)) * to_direction.transpose()
}
