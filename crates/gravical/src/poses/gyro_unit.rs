//! The unit of a gyroscope: one rule, whoever asks.
//!
//! The user's word; else what the turns of gravity between rests show, or turns
//! by a known angle; else the calibration that is there; else the header, which
//! is then said to be unverified; else whole numbers are counts. Turns may refute
//! header and calibration. Where nothing claims a unit, where the header is wrong
//! about the accelerometer and where it contradicts the calibration, the noise at
//! rest chooses between rad/s and °/s: gyroscopes that people can afford have 0.02
//! to 0.5 °/s of it per sample, which read as rad/s would be 0.0004 to 0.009.

use std::ops::Range;

use gravical_recording::judge::resolution;

use super::face::angle_deg;
use super::turns::{Motion, motions, residual_deg, steps};
use crate::calibration_file::GyroscopeSection;
use crate::recording::units::{GyroScale, GyroUnit, LSB_PER_DEG_S, MDPS_PER_DEG_S, Origin};
use crate::recording::{Finding, FindingKind, Recording};
use crate::stats::floors;
use crate::stats::moments;

/// Units that a gyroscope can be in.
fn hypotheses() -> Vec<GyroScale> {
    let scale = |unit, lsb_per_deg_s| GyroScale {
        unit,
        lsb_per_deg_s,
        origin: Origin::Data,
    };
    let mut all = vec![
        scale(GyroUnit::RadianPerSecond, None),
        scale(GyroUnit::DegreePerSecond, None),
    ];
    let counts = LSB_PER_DEG_S.into_iter().chain([MDPS_PER_DEG_S]);
    all.extend(counts.map(|lsb| scale(GyroUnit::Counts, Some(lsb))));
    all
}

/// Scales within this factor of each other (InvenSense's and ST's) are distinguished by all
/// turns together: a single one of less than half a turn does not part them by 5°.
const ALIKE: f64 = 1.3;

fn alike(a: &GyroScale, b: &GyroScale) -> bool {
    let ratio = a.nominal().zip(b.nominal()).map(|(a, b)| a / b);
    ratio.is_some_and(|r| (1.0 / ALIKE..=ALIKE).contains(&r))
}

/// What is said about the unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Claims<'a> {
    /// The recording.
    pub file: &'a str,
    /// By option, header or whole numbers.
    pub scale: GyroScale,
    /// The gyroscope of the calibration that is applied or checked.
    pub calibration: Option<&'a GyroscopeSection>,
    /// The header is wrong about the accelerometer.
    pub header_is_wrong: bool,
}

impl<'a> Claims<'a> {
    /// Of a recording that is read as a whole; none without a gyroscope.
    pub fn of(recording: &'a Recording, calibration: Option<&'a GyroscopeSection>) -> Option<Self> {
        Some(Claims {
            file: &recording.name,
            scale: recording.gyro.as_ref().and(recording.gyro_scale)?,
            calibration,
            header_is_wrong: recording.contradicts_header(),
        })
    }
}

/// What the data show of the unit.
#[derive(Debug, Clone, Default)]
pub(crate) struct Evidence {
    /// Turns that could decide.
    turns: usize,
    /// Of each hypothesis: the turns that speak for it alone, and those that it
    /// fits.
    votes: Vec<usize>,
    fits: Vec<usize>,
    /// … and the sum of its squared residuals over the turns that speak for any, deg².
    misfit: Vec<f64>,
    /// Standard deviation of a sample at rest, unit of the file.
    noise: Option<f64>,
    /// Not all values are whole numbers.
    fractions: bool,
}

/// The unit of the gyroscope by the rule of all commands, with its findings, set in the
/// recording.
pub(crate) fn settle(recording: &mut Recording, rests: &[Range<usize>]) {
    let mut findings = Vec::new();
    let scale = Claims::of(recording, None).map(|claims| {
        let moves = motions(recording, rests);
        decide(
            claims,
            &Evidence::of(recording, rests, &moves),
            &mut findings,
        )
    });
    if scale.is_some() {
        recording.gyro_scale = scale;
        recording.findings.extend(findings);
    }
}

/// Turns of gravity under this angle decide nothing.
const MIN_TURN_DEG: f64 = 10.0;

/// So many turns decide against a header or a calibration; a known turn counts
/// as many, since its angle is not gravity's alone.
const ENOUGH: usize = 3;

/// A known turn comes out right within this factor.
const KNOWN_TURN: f64 = 1.25;

/// Between the noise of a usual gyroscope in rad/s and in °/s: 0.09 °/s is
/// 0.0016 rad/s, and this is their geometric mean.
pub(super) const MAX_NOISE_RAD_S: f64 = 0.012;

/// Rows that noise is looked at over.
const BLOCK: usize = 50;

impl Evidence {
    /// What the rests and the motions between them show, in the unit of the file.
    pub fn of(recording: &Recording, rests: &[Range<usize>], motions: &[Motion]) -> Self {
        let mut evidence = Evidence::default();
        evidence.add(recording, rests, motions);
        evidence
    }

    /// The same of one more recording of the session.
    pub fn add(&mut self, recording: &Recording, rests: &[Range<usize>], motions: &[Motion]) {
        let Some(gyro) = &recording.gyro else { return };
        self.add_rest(gyro, rests);
        for motion in motions {
            self.add_turn(recording, motion);
        }
    }

    /// Noise and fractions of the rows at rest.
    pub fn add_rest(&mut self, gyro: &[Vec<f64>; 3], rests: &[Range<usize>]) {
        let mut rows = rests.iter().flat_map(Clone::clone).take(2000);
        self.fractions |= rows.any(|row| gyro.iter().any(|c| c[row].fract().abs() > 0.0));
        self.noise = self.noise.or_else(|| noise(gyro, rests));
    }

    /// One turn of gravity: the best hypothesis counts when its residual is under
    /// max(3°, 0.15·Δ) and the next one is over three times that and over 5°.
    fn add_turn(&mut self, recording: &Recording, motion: &Motion) {
        let delta = angle_deg(motion.gravity[0], motion.gravity[1]);
        if delta < MIN_TURN_DEG {
            return;
        }
        let Some(steps) = steps(recording, motion) else {
            return;
        };
        let fits = |residual: f64| residual < (0.15 * delta).max(3.0);
        let all = hypotheses();
        let residuals: Vec<f64> = all
            .iter()
            .map(|h| match h.nominal() {
                Some(nominal) => residual_deg(&steps, motion, nominal),
                None => f64::NAN,
            })
            .collect();
        let fitting: Vec<usize> = (0..all.len()).filter(|&i| fits(residuals[i])).collect();
        let mut order: Vec<usize> = (0..all.len())
            .filter(|&i| residuals[i].is_finite())
            .collect();
        order.sort_by(|&i, &o| residuals[i].total_cmp(&residuals[o]));
        let clear = order.first().copied().filter(|&best| {
            let next = order.iter().find(|o| !alike(&all[best], &all[**o]));
            let next = next.map_or(0.0, |o| residuals[*o]);
            fits(residuals[best]) && next > 3.0 * residuals[best] && next > 5.0
        });
        self.count(1, &fitting, clear, &residuals);
    }

    /// A turn by `angle_rad` whose angular rate less the bias sums up to
    /// `integral`, unit of the file · s.
    pub fn add_known_turn(&mut self, integral: [f64; 3], angle_rad: f64) {
        let residuals = residuals_of_known_turn(integral, angle_rad);
        let best = (0..residuals.len()).min_by(|&i, &o| residuals[i].total_cmp(&residuals[o]));
        let most = KNOWN_TURN.ln() * angle_rad.abs().to_degrees();
        let shown = best.filter(|i| residuals[*i] < most);
        self.count(ENOUGH, shown.as_slice(), shown, &residuals);
    }

    fn count(&mut self, weight: usize, fitting: &[usize], clear: Option<usize>, residuals: &[f64]) {
        self.votes.resize(residuals.len(), 0);
        self.fits.resize(residuals.len(), 0);
        self.misfit.resize(residuals.len(), 0.0);
        self.turns += weight;
        fitting.iter().for_each(|i| self.fits[*i] += weight);
        if let Some(i) = clear {
            self.votes[i] += weight;
            for (sum, residual) in self.misfit.iter_mut().zip(residuals) {
                *sum += residual * residual;
            }
        }
    }

    /// The hypothesis that the turns speak for, with the number that do; of scales that are
    /// alike the one that fits all turns best. A scale that is none of these fits a turn now
    /// and then, five times round being as good as once; the right one fits most of them.
    fn shown(&self) -> Option<(GyroScale, usize)> {
        let all = hypotheses();
        if self.votes.is_empty() {
            return None;
        }
        let votes = |i: usize| -> usize {
            let near = (0..all.len()).filter(|&o| o == i || alike(&all[i], &all[o]));
            near.map(|o| self.votes[o]).sum()
        };
        let most = (0..all.len()).map(votes).max()?;
        let best = (0..all.len())
            .filter(|&i| votes(i) == most)
            .min_by(|&i, &o| self.misfit[i].total_cmp(&self.misfit[o]))?;
        let cast = self.votes.iter().sum::<usize>();
        (most > 0 && most * 4 > cast * 3 && self.fits[best] * 2 > self.turns)
            .then(|| (all[best], most))
    }

    fn by_noise(&self) -> Option<GyroUnit> {
        self.noise.map(|noise| {
            if noise < MAX_NOISE_RAD_S {
                GyroUnit::RadianPerSecond
            } else {
                GyroUnit::DegreePerSecond
            }
        })
    }
}

/// How far off a turn by a known angle comes out in each hypothesis, deg.
fn residuals_of_known_turn(integral: [f64; 3], angle_rad: f64) -> Vec<f64> {
    let size = gravical_core::matrix3::norm(&integral) / angle_rad.abs();
    let off = |h: &GyroScale| {
        h.nominal().map_or(f64::INFINITY, |n| {
            (size / n).ln().abs() * angle_rad.abs().to_degrees()
        })
    };
    hypotheses().iter().map(off).collect()
}

/// Standard deviation of a sample in the quietest quarter of short blocks at
/// rest, mean of the axes, unit of the file; none for whole numbers (counts),
/// without noise, and where rounding may hide the noise of either unit.
fn noise(gyro: &[Vec<f64>; 3], rests: &[Range<usize>]) -> Option<f64> {
    let mut levels: Vec<f64> = rests
        .iter()
        .flat_map(|s| s.clone().step_by(BLOCK).map(|i| i..(i + BLOCK).min(s.end)))
        .filter(|b| b.len() >= 10)
        .map(|b| (moments(gyro, b).1 / 3.0).sqrt())
        .collect();
    let whole = rests.iter().flat_map(Clone::clone).take(2000).all(|row| {
        gyro.iter()
            .all(|c| c[row].fract() == 0.0 || c[row].is_nan())
    });
    if whole || levels.is_empty() {
        return None;
    }
    levels.sort_by(f64::total_cmp);
    let rounding = (floors(&resolution(gyro)) / 3.0).sqrt();
    let level = levels.get(levels.len() / 4).copied()?.max(rounding);
    (level > 0.0 && (level > rounding || rounding < MAX_NOISE_RAD_S)).then_some(level)
}

/// Decides. What was decided against a claim, or could not be verified, goes to
/// `findings`.
pub(crate) fn decide(
    claims: Claims<'_>,
    evidence: &Evidence,
    findings: &mut Vec<Finding>,
) -> GyroScale {
    let claimed = claims.scale;
    let given = claimed.origin == Origin::Given;
    if given && claimed.nominal().is_some() {
        return claimed;
    }
    let header = (claimed.origin == Origin::Header).then_some(claimed.unit);
    let section = claims
        .calibration
        .filter(|c| c.input_unit != GyroUnit::Unknown);
    let calibrated = section.map(|c| c.input_unit);
    let mut tell = |finding: Finding| findings.push(finding.in_file(claims.file));

    if let Some((found, votes)) = evidence.shown() {
        let agrees = calibrated == Some(found.unit)
            || found.unit == claimed.unit
                && (claimed.lsb_per_deg_s.is_none()
                    || found.lsb_per_deg_s == claimed.lsb_per_deg_s);
        let doubted = header.is_some() || calibrated.is_some();
        let allowed = !given || found.unit == claimed.unit;
        if allowed && (agrees || votes >= if doubted { ENOUGH } else { 1 }) {
            if let Some(said) = header.filter(|said| *said != found.unit) {
                tell(Finding::new(
                    FindingKind::UnitMismatch,
                    format!(
                        "the header says {} for the gyroscope, but its rotations agree with gravity only in {}, which is used",
                        said, found.unit
                    ),
                ));
            }
            return found;
        }
    }

    let by_noise = evidence.by_noise();
    let noise = || format!("{:.2e}", evidence.noise.unwrap_or(f64::NAN));
    if let Some(section) = section {
        let wanted = section.input_unit;
        let lsb = section.mean_per_deg_s();
        let taken = GyroScale {
            unit: wanted,
            lsb_per_deg_s: (wanted == GyroUnit::Counts)
                .then(|| claimed.lsb_per_deg_s.unwrap_or(lsb)),
            origin: Origin::Assumed,
        };
        match header {
            Some(said) if said == wanted => {
                return GyroScale {
                    origin: Origin::Header,
                    ..taken
                };
            }
            Some(said) if claims.header_is_wrong || by_noise == Some(wanted) => {
                let why = if claims.header_is_wrong {
                    "the same header is wrong about the accelerometer".to_owned()
                } else {
                    format!(
                        "the noise at rest, {}, is that of a gyroscope in {}",
                        noise(),
                        wanted
                    )
                };
                tell(Finding::new(
                    FindingKind::UnitMismatch,
                    format!(
                        "the gyroscope is read in {used}, the unit of the calibration, although the header says {}: {why} (--gyro-unit overrides it)",
                        said,
                        used = wanted,
                    ),
                ));
                return taken;
            }
            _ if given && claimed.unit != wanted => return claimed,
            Some(_) => return claimed,
            None if claimed.unit == wanted => return taken,
            // Fractions are no counts, and counts are not rounded rates.
            None if claimed.unit == GyroUnit::Counts
                || wanted == GyroUnit::Counts && evidence.fractions =>
            {
                return claimed;
            }
            None => {
                tell(Finding::new(
                    FindingKind::GyroUnitUnverified,
                    format!(
                        "the gyroscope is read in {}, the unit of the calibration: the recording does not name one, and it is not verified by a rotation between static intervals",
                        wanted
                    ),
                ));
                return taken;
            }
        }
    }

    if let Some(unit) = by_noise.filter(|u| *u != claimed.unit)
        && (claimed.unit == GyroUnit::Unknown || header.is_some() && claims.header_is_wrong)
        && claimed.unit != GyroUnit::Counts
    {
        let why = match header {
            None => "nothing states the unit of the gyroscope".to_owned(),
            Some(said) => format!(
                "the header says {} for the gyroscope, and is wrong about the accelerometer",
                said
            ),
        };
        tell(Finding::new(
            FindingKind::GyroUnitByNoise,
            format!(
                "{why}; its noise at rest, {}, is that of a gyroscope in {}, which is used (--gyro-unit overrides it)",
                noise(),
                unit
            ),
        ));
        return GyroScale {
            unit,
            lsb_per_deg_s: None,
            origin: Origin::Data,
        };
    }
    let what = match claimed.unit {
        GyroUnit::Unknown => {
            "the unit of the gyroscope is unknown: neither the file nor a rotation between static intervals tells it; give --gyro-unit".to_owned()
        }
        GyroUnit::Counts if claimed.nominal().is_none() => {
            let sheet = if evidence.turns > 0 {
                " (none that a data sheet names fits the turns)"
            } else {
                ""
            };
            format!("the gyroscope is in counts of unknown scale{sheet}; give --gyro-range, or record turns between static intervals")
        }
        unit => format!(
            "the gyroscope is read in {}{}, not verified by a rotation between static intervals{}",
            unit,
            if header.is_some() { ", as the header says" } else { "" },
            // One wrong unit in a header makes the other doubtful.
            if header.is_some() && claims.header_is_wrong {
                ", and the same header is wrong about the accelerometer"
            } else {
                ""
            }
        ),
    };
    tell(Finding::new(FindingKind::GyroUnitUnverified, what));
    claimed
}

/// Why a calibration is not for a gyroscope of this scale; none where it is.
pub(crate) fn mismatch(section: &GyroscopeSection, scale: &GyroScale) -> Option<String> {
    /// Beyond what any sensor is off, below the next range.
    const ANOTHER_RANGE: f64 = 1.25;
    let (unit, wanted) = (scale.unit, section.input_unit);
    let how = match scale.origin {
        Origin::Given => " as --gyro-unit says",
        Origin::Header => " as its header says",
        Origin::Data => " as its values show",
        Origin::Assumed => "",
    };
    if wanted == GyroUnit::Unknown || unit == GyroUnit::Unknown && wanted != GyroUnit::Counts {
        return None;
    }
    if unit == GyroUnit::Unknown {
        return Some(
            "the gyroscope has values with fractions, the calibration is for counts".to_owned(),
        );
    }
    if unit != wanted {
        return Some(format!(
            "the gyroscope is in {}{how}, the calibration is for {}",
            unit, wanted
        ));
    }
    let lsb = scale.lsb_per_deg_s.filter(|_| unit == GyroUnit::Counts)?;
    let expected = section.mean_per_deg_s();
    ((lsb / expected).ln().abs() > ANOTHER_RANGE.ln()).then(|| {
        format!(
            "the gyroscope has {lsb:.1} counts per °/s, the calibration is for {expected:.1}: another range"
        )
    })
}
