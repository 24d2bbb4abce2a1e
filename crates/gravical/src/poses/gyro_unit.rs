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
use super::turns::{Motion, motions, residual_deg};
use crate::calibration_file::GyroscopeSection;
use crate::finding::finding;
use crate::recording::units::{GyroScale, GyroUnit, LSB_PER_DEG_S, MDPS_PER_DEG_S, Origin};
use crate::recording::{Finding, Recording};
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
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    /// Turns that could decide.
    turns: usize,
    tallies: Vec<Tally>,
    /// Standard deviation of a sample at rest, unit of the file.
    noise: Option<f64>,
    /// Not all values are whole numbers.
    fractions: bool,
}

/// What the turns say of a hypothesis.
#[derive(Debug, Clone)]
struct Tally {
    scale: GyroScale,
    /// Turns that speak for it alone, and those that it fits.
    votes: usize,
    fits: usize,
    /// Sum of its squared residuals over the turns that speak for any, deg².
    misfit: f64,
}

impl Default for Evidence {
    fn default() -> Self {
        let tally = |scale| Tally {
            scale,
            votes: 0,
            fits: 0,
            misfit: 0.0,
        };
        Evidence {
            turns: 0,
            tallies: hypotheses().into_iter().map(tally).collect(),
            noise: None,
            fractions: false,
        }
    }
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
        motions.iter().for_each(|motion| self.add_turn(motion));
    }

    /// Noise and fractions of the rows at rest. Whole numbers (counts) have no noise to tell a unit by.
    pub fn add_rest(&mut self, gyro: &[Vec<f64>; 3], rests: &[Range<usize>]) {
        let mut rows = rests.iter().flat_map(Clone::clone).take(2000);
        let fractions = rows.any(|row| gyro.iter().any(|c| c[row].fract().abs() > 0.0));
        self.fractions |= fractions;
        if fractions && self.noise.is_none() {
            self.noise = noise(gyro, rests);
        }
    }

    /// One turn of gravity: the best hypothesis counts when its residual is under
    /// max(3°, 0.15·Δ) and the next one is over three times that and over 5°.
    fn add_turn(&mut self, motion: &Motion) {
        let delta = angle_deg(motion.gravity[0], motion.gravity[1]);
        if delta < MIN_TURN_DEG {
            return;
        }
        let fits = |residual: f64| residual < (0.15 * delta).max(3.0);
        let residuals = self.residuals(|nominal| residual_deg(motion, nominal));
        let best = smallest(&residuals);
        let others = self.tallies.iter().zip(&residuals);
        let next = others
            .filter(|(tally, _)| !alike(&self.tallies[best].scale, &tally.scale))
            .map(|(_, residual)| *residual)
            .fold(f64::INFINITY, f64::min);
        self.turns += 1;
        for (tally, residual) in self.tallies.iter_mut().zip(&residuals) {
            tally.fits += usize::from(fits(*residual));
        }
        if fits(residuals[best]) && next > 3.0 * residuals[best] && next > 5.0 {
            self.vote(best, 1, &residuals);
        }
    }

    /// A turn by `angle_rad` whose angular rate less the bias sums up to
    /// `integral`, unit of the file · s.
    pub fn add_known_turn(&mut self, integral: [f64; 3], angle_rad: f64) {
        let angle_rad = angle_rad.abs();
        let size = gravical_core::matrix3::norm(&integral) / angle_rad;
        let off = |nominal: f64| (size / nominal).ln().abs() * angle_rad.to_degrees();
        let residuals = self.residuals(off);
        let best = smallest(&residuals);
        self.turns += ENOUGH;
        if residuals[best] < KNOWN_TURN.ln() * angle_rad.to_degrees() {
            self.tallies[best].fits += ENOUGH;
            self.vote(best, ENOUGH, &residuals);
        }
    }

    fn residuals(&self, of_nominal: impl Fn(f64) -> f64) -> Vec<f64> {
        let nominal = |tally: &Tally| tally.scale.nominal().unwrap_or(f64::NAN);
        self.tallies
            .iter()
            .map(|t| of_nominal(nominal(t)))
            .collect()
    }

    fn vote(&mut self, best: usize, weight: usize, residuals: &[f64]) {
        self.tallies[best].votes += weight;
        for (tally, residual) in self.tallies.iter_mut().zip(residuals) {
            tally.misfit += residual * residual;
        }
    }

    /// The hypothesis that the turns speak for, with the number that do; of scales that are
    /// alike the one that fits all turns best. A scale that is none of these fits a turn now
    /// and then, five times round being as good as once; the right one fits most of them.
    fn shown(&self) -> Option<(GyroScale, usize)> {
        let votes = |tally: &Tally| -> usize {
            let near = self
                .tallies
                .iter()
                .filter(|o| alike(&tally.scale, &o.scale));
            near.map(|o| o.votes).sum()
        };
        let most = self.tallies.iter().map(votes).max()?;
        let best = self
            .tallies
            .iter()
            .filter(|tally| votes(tally) == most)
            .min_by(|a, b| a.misfit.total_cmp(&b.misfit))?;
        let cast: usize = self.tallies.iter().map(|tally| tally.votes).sum();
        (most > 0 && most * 4 > cast * 3 && best.fits * 2 > self.turns)
            .then_some((best.scale, most))
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

fn smallest(values: &[f64]) -> usize {
    let order = |&i: &usize, &j: &usize| values[i].total_cmp(&values[j]);
    (0..values.len()).min_by(order).unwrap_or(0)
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
                tell(finding!(
                    UnitMismatch,
                    "the header says {said} for the gyroscope, but its rotations agree with gravity only in {}, which is used",
                    found.unit
                ));
            }
            return found;
        }
    }

    let by_noise = evidence.by_noise();
    let noise = || format!("{:.2e}", evidence.noise.unwrap_or(f64::NAN));
    if let Some(section) = section {
        let wanted = section.input_unit;
        let lsb = claimed.lsb_per_deg_s.unwrap_or(section.mean_per_deg_s());
        let taken = GyroScale {
            unit: wanted,
            lsb_per_deg_s: (wanted == GyroUnit::Counts).then_some(lsb),
            origin: Origin::Assumed,
        };
        if header == Some(wanted) {
            let origin = Origin::Header;
            return GyroScale { origin, ..taken };
        }
        if let Some(said) = header {
            let why = if claims.header_is_wrong {
                "the same header is wrong about the accelerometer".to_owned()
            } else if by_noise == Some(wanted) {
                let noise = noise();
                format!("the noise at rest, {noise}, is that of a gyroscope in {wanted}")
            } else {
                return claimed;
            };
            let other = finding!(
                UnitMismatch,
                "the gyroscope is read in {wanted}, the unit of the calibration, although the header says {said}: {why}; give the unit if it is another"
            );
            tell(other.advise("gyro_unit", ""));
            return taken;
        }
        // Fractions are no counts, and counts are not rounded rates.
        let is_another = given
            || claimed.unit == GyroUnit::Counts
            || wanted == GyroUnit::Counts && evidence.fractions;
        if claimed.unit != wanted && is_another {
            return claimed;
        }
        if claimed.unit != wanted {
            tell(finding!(
                GyroUnitUnverified,
                "the gyroscope is read in {wanted}, the unit of the calibration: the recording does not name one, and it is not verified by a rotation between static intervals"
            ));
        }
        return taken;
    }

    if let Some(unit) = by_noise.filter(|u| *u != claimed.unit)
        && (claimed.unit == GyroUnit::Unknown || header.is_some() && claims.header_is_wrong)
        && claimed.unit != GyroUnit::Counts
    {
        let why = match header {
            None => "nothing states the unit of the gyroscope".to_owned(),
            Some(said) => format!(
                "the header says {said} for the gyroscope, and is wrong about the accelerometer"
            ),
        };
        let by_noise = finding!(
            GyroUnitByNoise,
            "{why}; its noise at rest, {}, is that of a gyroscope in {unit}, which is used; give the unit if it is another",
            noise()
        );
        tell(by_noise.advise("gyro_unit", ""));
        return GyroScale {
            unit,
            lsb_per_deg_s: None,
            origin: Origin::Data,
        };
    }
    let unverified = match claimed.unit {
        GyroUnit::Unknown => {
            finding!(
                GyroUnitUnverified,
                "the unit of the gyroscope is unknown: neither the file nor a rotation between static intervals tells it; give it"
            )
            .advise("gyro_unit", "")
        }
        GyroUnit::Counts if claimed.nominal().is_none() => {
            let sheet = if evidence.turns > 0 {
                " (none that a data sheet names fits the turns)"
            } else {
                ""
            };
            finding!(
                GyroUnitUnverified,
                "the gyroscope is in counts of unknown scale{sheet}; give the range, or record turns between static intervals"
            )
            .advise("gyro_range", "")
        }
        unit => {
            let by = if header.is_some() { ", as the header says" } else { "" };
            // One wrong unit in a header makes the other doubtful.
            let doubt = if header.is_some() && claims.header_is_wrong {
                ", and the same header is wrong about the accelerometer"
            } else {
                ""
            };
            finding!(
                GyroUnitUnverified,
                "the gyroscope is read in {unit}{by}, not verified by a rotation between static intervals{doubt}"
            )
        }
    };
    tell(unverified);
    claimed
}

/// Why a calibration is not for a gyroscope of this scale; none where it is.
pub(crate) fn mismatch(section: &GyroscopeSection, scale: &GyroScale) -> Option<String> {
    /// Beyond what any sensor is off, below the next range.
    const ANOTHER_RANGE: f64 = 1.25;
    let (unit, wanted) = (scale.unit, section.input_unit);
    let how = match scale.origin {
        Origin::Given => " as given",
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
