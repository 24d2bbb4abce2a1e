//! The unit of a gyroscope: one rule, whoever asks.
//!
//! The user's word; else what the turns of gravity between rests show; else the
//! calibration that is there; else the header, which is then said to be unverified;
//! else whole numbers are counts. Turns may refute header and calibration. Where
//! nothing claims a unit, where the header is wrong about the accelerometer and where
//! it contradicts the calibration, the noise at rest chooses between rad/s and °/s:
//! gyroscopes that people can afford have 0.02 to 0.5 °/s of it per sample, which read
//! as rad/s would be 0.0004 to 0.009.

use std::f64::consts::PI;
use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_judge::resolution;
use gravical_signal::stats::{floors, moments};
use nalgebra::{UnitQuaternion, Vector3};

use super::face::angle_deg;
use super::nominal::MAX_NOISE_RAD_S;
use super::rests::{find_rests, with_slow_ends};
use crate::calibration_file::Gyroscope;
use crate::finding::{Case, GyroMismatch, RecordingCase};
use crate::recording::units::{GyroScale, GyroUnit, LSB_PER_DEG_S, MDPS_PER_DEG_S, Origin};
use crate::recording::{Finding, Recording};

/// A scale that the data show.
fn shown(unit: GyroUnit, lsb_per_deg_s: Option<f64>) -> GyroScale {
    GyroScale {
        unit,
        lsb_per_deg_s,
        origin: Origin::Data,
    }
}

/// Scales that a gyroscope can be in.
fn hypotheses() -> Vec<GyroScale> {
    let rates = [GyroUnit::RadianPerSecond, GyroUnit::DegreePerSecond];
    let counts = LSB_PER_DEG_S.into_iter().chain([MDPS_PER_DEG_S]);
    let counts = counts.map(|lsb| shown(GyroUnit::Counts, Some(lsb)));
    let rates = rates.into_iter().map(|unit| shown(unit, None));
    rates.chain(counts).collect()
}

/// Scales within this factor of each other (InvenSense's and ST's) are distinguished by all
/// turns together: a single one of less than half a turn does not part them by 5°.
const ALIKE: f64 = 1.3;

fn alike(a: &GyroScale, b: &GyroScale) -> bool {
    let ratio = a.nominal().zip(b.nominal()).map(|(a, b)| a / b);
    ratio.is_some_and(|r| (1.0 / ALIKE..=ALIKE).contains(&r))
}

/// Turns of gravity under this angle decide nothing.
const MIN_TURN_DEG: f64 = 10.0;
/// So many turns decide against a header or a calibration.
const ENOUGH: usize = 3;
/// A turn that a scale does not fit counts for no more than this, in limits.
const MAX_MISFIT: f64 = 3.0;
/// Rows that noise is looked at over.
const BLOCK: usize = 50;

/// The unit of the gyroscope by the rule of all commands: the user's, that of the turns between `rests`, of
/// the calibration `section`, of the header. What was decided against a claim, or could not be verified, goes
/// to `findings`. None without a gyroscope.
#[doc(hidden)]
pub fn judge(
    recording: &Recording,
    section: Option<&Gyroscope>,
    rests: &[Range<usize>],
    findings: &mut Vec<Finding>,
) -> Option<GyroScale> {
    let mut evidence = Evidence::default();
    evidence.add(recording, rests);
    let scale = evidence.judge(recording, section, findings)?;
    let is_known = |section: &Gyroscope| section.input_unit != GyroUnit::Unknown;
    let unknown = match scale.unit {
        _ if scale.nominal().is_some() || section.is_some_and(is_known) => None,
        GyroUnit::Unknown => Some(("unit", "gyro_unit")),
        _ => Some(("range", "gyro_range")),
    };
    findings.extend(unknown.map(|(what, option)| {
        let unknown = Case::GyroScaleUnread { what }.finding();
        unknown.advise(option, "").in_file(&recording.name)
    }));
    Some(scale)
}

/// The same between all rests, which are returned, set in the recording with its findings.
#[doc(hidden)]
pub fn decide_unit(recording: &mut Recording) -> Vec<Range<usize>> {
    let (rests, mut findings) = (find_rests(recording), Vec::new());
    if let Some(scale) = judge(recording, None, &rests, &mut findings) {
        recording.units.gyro = Some(scale);
        recording.findings.extend(findings);
    }
    rests
}

/// What the data of a session show of the unit.
#[derive(Debug, Default)]
pub(super) struct Evidence {
    turns: Vec<TurnTest>,
    /// Standard deviation of a sample at rest, unit of the file.
    noise: Option<f64>,
    /// Not all values are whole numbers.
    fractions: bool,
}

/// How far a turn is off in each of the [`hypotheses`], and how far it may be, degrees.
#[derive(Debug)]
struct TurnTest {
    residuals_deg: Vec<f64>,
    limit_deg: f64,
}

impl Evidence {
    /// The rests of a recording and the motions between them. Whole numbers (counts) have no noise to tell a
    /// unit by.
    pub fn add(&mut self, recording: &Recording, rests: &[Range<usize>]) {
        let Some(gyro) = &recording.gyro else { return };
        let mut rows = rests.iter().flat_map(Clone::clone).take(2000);
        let fractions = rows.any(|row| gyro.iter().any(|c| c[row].fract().abs() > 0.0));
        self.fractions |= fractions;
        if fractions && self.noise.is_none() {
            self.noise = noise(gyro, rests);
        }
        for pair in rests.windows(2) {
            // Of the rests rows may be left out, of the move none.
            let is_broken = recording.is_broken(&(pair[0].start..pair[1].end));
            let gravity = [0, 1].map(|i: usize| moments(&recording.accel, pair[i].clone()).0);
            let delta_deg = angle_deg(gravity[0], gravity[1]);
            if is_broken || pair[0].end >= pair[1].start || delta_deg < MIN_TURN_DEG {
                continue;
            }
            let Some(steps) = steps(recording, gyro, pair) else {
                return;
            };
            let residual_deg = |scale: GyroScale| residual_deg(&steps, gravity, scale);
            self.turns.push(TurnTest {
                residuals_deg: hypotheses().into_iter().map(residual_deg).collect(),
                limit_deg: (0.15 * delta_deg).max(3.0),
            });
        }
    }

    /// The scale that the turns agree with best, and how many show that it is no other: those that fit it,
    /// and that every unlike one misses by over three times as much and 5°. A scale that is none of these
    /// fits a turn now and then, five times round being as good as once; the right one fits most of them.
    fn by_turns(&self) -> Option<(GyroScale, usize)> {
        let scales = hypotheses();
        let misfit = |i: &usize| -> f64 {
            let ratios = self.turns.iter().map(|t| t.residuals_deg[*i] / t.limit_deg);
            ratios.map(|r| r.min(MAX_MISFIT).powi(2)).sum()
        };
        let best = (0..scales.len()).min_by(|i, j| misfit(i).total_cmp(&misfit(j)))?;
        let shows = |turn: &&TurnTest| {
            let least = (3.0 * turn.residuals_deg[best]).max(5.0);
            let mut others = scales.iter().zip(&turn.residuals_deg);
            others.all(|(scale, residual)| alike(scale, &scales[best]) || *residual > least)
        };
        let fits = |turn: &&TurnTest| turn.residuals_deg[best] < turn.limit_deg;
        let fitting = self.turns.iter().filter(fits);
        let is_most = 2 * fitting.clone().count() > self.turns.len();
        let votes = fitting.filter(shows).count();
        (is_most && votes > 0).then_some((scales[best], votes))
    }

    /// The unit in which the noise at rest is that of a usual gyroscope.
    fn by_noise(&self) -> Option<GyroUnit> {
        self.noise.map(|noise| {
            if noise < MAX_NOISE_RAD_S {
                GyroUnit::RadianPerSecond
            } else {
                GyroUnit::DegreePerSecond
            }
        })
    }

    /// Decides, for the gyroscope of `recording`; motions that are fitted, or turns, may answer what stays unknown.
    pub fn judge(
        &self,
        recording: &Recording,
        section: Option<&Gyroscope>,
        findings: &mut Vec<Finding>,
    ) -> Option<GyroScale> {
        let claimed = recording.gyro.as_ref().and(recording.units.gyro)?;
        let is_given = claimed.origin == Origin::Given;
        if is_given && claimed.nominal().is_some() {
            return Some(claimed);
        }
        let header = (claimed.origin == Origin::Header).then_some(claimed.unit);
        let section = section.filter(|c| c.input_unit != GyroUnit::Unknown);
        let mut tell = |finding: Finding| findings.push(finding.in_file(&recording.name));

        if let Some((found, votes)) = self.by_turns() {
            let is_as_claimed = found.unit == claimed.unit;
            let agrees = section.is_some_and(|c| c.input_unit == found.unit)
                || is_as_claimed
                    && (claimed.lsb_per_deg_s.is_none()
                        || found.lsb_per_deg_s == claimed.lsb_per_deg_s);
            let is_doubted = header.is_some() || section.is_some();
            if (!is_given || is_as_claimed) && (agrees || !is_doubted || votes >= ENOUGH) {
                if let Some(stated) = header.filter(|_| !is_as_claimed) {
                    let unit = found.unit;
                    tell(RecordingCase::GyroUnitOfHeader { stated, unit }.finding());
                }
                return Some(found);
            }
        }

        let by_noise = self.by_noise();
        let header_is_wrong = recording.units.contradicts_header;
        if let Some(section) = section {
            let wanted = section.input_unit;
            let is_other = claimed.unit != wanted;
            let stays = match header {
                Some(_) => !header_is_wrong && by_noise != Some(wanted),
                // Fractions are no counts, and counts are not rounded rates.
                None => {
                    is_given
                        || claimed.unit == GyroUnit::Counts
                        || wanted == GyroUnit::Counts && self.fractions
                }
            };
            if is_other && stays {
                return Some(claimed);
            }
            if is_other {
                tell(match header {
                    Some(stated) => {
                        let unit = wanted;
                        let mismatch = RecordingCase::GyroUnitOfCalibration { unit, stated };
                        mismatch.finding().advise("gyro_unit", "")
                    }
                    None => Case::GyroUnitOfCalibration { unit: wanted }.finding(),
                });
            }
            let lsb = claimed.lsb_per_deg_s.unwrap_or(section.mean_per_deg_s());
            return Some(GyroScale {
                unit: wanted,
                lsb_per_deg_s: (wanted == GyroUnit::Counts).then_some(lsb),
                origin: Origin::Assumed,
            });
        }

        let is_open = claimed.unit == GyroUnit::Unknown
            || header.is_some() && header_is_wrong && claimed.unit != GyroUnit::Counts;
        if let Some(unit) = by_noise.filter(|unit| is_open && *unit != claimed.unit) {
            let noise = self.noise.unwrap_or(f64::NAN);
            let by_noise = Case::GyroUnitByNoise { unit, noise }.finding();
            tell(by_noise.advise("gyro_unit", ""));
            return Some(shown(unit, None));
        }
        if claimed.nominal().is_some() {
            let unit = claimed.unit;
            tell(Case::GyroUnitUnverified { unit }.finding());
        }
        Some(claimed)
    }
}

/// Angle that each row of the motion between two rests turns by, less the bias that both show, unit of the
/// file · s. Where the gyroscope was not read its last reading holds. None without stamps and a rate.
fn steps(
    recording: &Recording,
    gyro: &[Vec<f64>; 3],
    rests: &[Range<usize>],
) -> Option<Vec<[f64; 3]>> {
    let [before, after] = [0, 1].map(|i: usize| moments(gyro, rests[i].clone()).0);
    let usual_s = recording.clock.rate_hz().map(f64::recip);
    let mut rate = [0.0; 3];
    let step = |row: usize| {
        let reading: [f64; 3] =
            std::array::from_fn(|i| gyro[i][row] - 0.5 * (before[i] + after[i]));
        if reading.iter().all(|v| v.is_finite()) {
            rate = reading;
        }
        let stamps = recording.time_s.as_ref();
        let period_s = stamps.and_then(|t| Some(t.get(row + 1)? - t[row]));
        // Across a gap, a repeat or a step back the usual period stands.
        let is_usual = |s: &f64| *s > 0.0 && usual_s.is_none_or(|usual_s| *s < 4.0 * usual_s);
        let period_s = period_s.filter(is_usual).or(usual_s)?;
        Some(rate.map(|v| v * period_s))
    };
    with_slow_ends(recording, &rests[0], &rests[1])
        .map(step)
        .collect()
}

/// Angle between gravity turned by the steps of a motion and gravity as it was found in the rest after.
/// 180 where a row turns by more than half a turn, as no recording can tell.
fn residual_deg(steps: &[[f64; 3]], gravity: [[f64; 3]; 2], scale: GyroScale) -> f64 {
    let nominal = scale.nominal().unwrap_or(f64::NAN);
    if steps.iter().any(|step| norm(step) > PI * nominal) {
        return 180.0;
    }
    // A direction fixed in space turns the other way.
    let back = |v: Vector3<f64>, step: &[f64; 3]| {
        UnitQuaternion::from_scaled_axis(-Vector3::from(*step) / nominal) * v
    };
    let turned: Vector3<f64> = steps.iter().fold(Vector3::from(gravity[0]), back);
    angle_deg(turned.into(), gravity[1])
}

/// Standard deviation of a sample in the quietest quarter of short blocks at
/// rest, mean of the axes, unit of the file; none without noise, and where rounding may hide the noise of
/// either unit.
fn noise(gyro: &[Vec<f64>; 3], rests: &[Range<usize>]) -> Option<f64> {
    let mut levels: Vec<f64> = rests
        .iter()
        .flat_map(|s| s.clone().step_by(BLOCK).map(|i| i..(i + BLOCK).min(s.end)))
        .filter(|b| b.len() >= 10)
        .map(|b| (moments(gyro, b).1 / 3.0).sqrt())
        .collect();
    levels.sort_by(f64::total_cmp);
    let rounding = (floors(&resolution(gyro)) / 3.0).sqrt();
    let level = levels.get(levels.len() / 4).copied()?.max(rounding);
    (level > 0.0 && (level > rounding || rounding < MAX_NOISE_RAD_S)).then_some(level)
}

/// Why a calibration is not for a gyroscope of this scale; none where it is.
#[doc(hidden)]
pub fn mismatch(section: &Gyroscope, scale: &GyroScale) -> Option<GyroMismatch> {
    /// Beyond what any sensor is off, below the next range.
    const ANOTHER_RANGE: f64 = 1.25;
    match (scale.unit, section.input_unit) {
        (_, GyroUnit::Unknown) => None,
        (GyroUnit::Unknown, wanted) => {
            (wanted == GyroUnit::Counts).then_some(GyroMismatch::Fractions)
        }
        (unit, wanted) if unit != wanted => Some(GyroMismatch::Unit(unit, wanted)),
        (unit, _) => {
            let lsb = scale.lsb_per_deg_s.filter(|_| unit == GyroUnit::Counts)?;
            let expected = section.mean_per_deg_s();
            let is_other = (lsb / expected).ln().abs() > ANOTHER_RANGE.ln();
            is_other.then_some(GyroMismatch::Range(lsb, expected))
        }
    }
}
