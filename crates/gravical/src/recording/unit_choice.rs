//! The unit of a recording: what was given, what gravity shows, what the
//! header claims, in this order.

use super::ReadOptions;
use super::units::{AccelScale, AccelUnit, Evidence, MOST_OFF, Origin, accel_evidence};
use crate::finding::{Finding, FindingKind};

/// What a file says of its accelerometer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AccelClaim {
    /// The unit, by the header or by the board's own line.
    pub unit: Option<AccelUnit>,
    /// Counts per g, by the board's own line.
    pub lsb_per_g: Option<f64>,
    /// The names say that gravity was taken out.
    pub without_gravity: bool,
}

impl From<AccelUnit> for AccelClaim {
    fn from(unit: AccelUnit) -> Self {
        AccelClaim {
            unit: Some(unit),
            ..AccelClaim::default()
        }
    }
}

/// Why a unit is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitDoubt {
    /// Gravity was taken out of the acceleration.
    WithoutGravity,
    /// Gravity is a power of two too large or too small.
    WrongFullScale,
    /// Gravity has that size in no unit, or in several.
    NoUnit,
}

/// Decides the unit from the magnitude of quiet readings, the header's claim
/// and the user's word; contradictions become findings. Where the unit stays unknown
/// against gravity, it says why.
#[must_use]
pub fn decide_accel(
    quiet: Option<(f64, bool)>,
    unsigned: bool,
    claim: AccelClaim,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
) -> (AccelScale, Option<UnitDoubt>) {
    let mut doubt = None;
    let scale = decide(quiet, unsigned, claim, options, findings, &mut doubt);
    (scale, doubt)
}

fn decide(
    quiet: Option<(f64, bool)>,
    unsigned: bool,
    claim: AccelClaim,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
    doubt: &mut Option<UnitDoubt>,
) -> AccelScale {
    let given_lsb = options.accel_range_g.map(|range| 32768.0 / range);
    // A range that was given beats the data, one that the board claims does not.
    let range_lsb = given_lsb.or(claim.lsb_per_g);
    let claimed = claim.unit;
    if let Some(unit) = options.accel_unit {
        let counts = unit == AccelUnit::Counts;
        let from_data = quiet.and_then(|(norm, _)| match accel_evidence(norm, true) {
            Evidence::Unit(AccelUnit::Counts, lsb) if counts && !unsigned => lsb,
            _ => None,
        });
        let scale = AccelScale {
            unit,
            lsb_per_g: if counts {
                given_lsb.or(from_data).or(range_lsb)
            } else {
                None
            },
            origin: Origin::Given,
        };
        warn_if_gravity_disagrees(&scale, quiet, findings);
        return scale;
    }
    if unsigned {
        return AccelScale {
            unit: AccelUnit::Counts,
            lsb_per_g: range_lsb,
            origin: Origin::Data,
        };
    }
    let Some((norm, integers)) = quiet else {
        return by_claim(claimed, range_lsb);
    };
    // A sensitivity that is claimed, where gravity does not contradict it.
    let claimed_lsb = claim
        .lsb_per_g
        .filter(|lsb| (norm / lsb - 1.0).abs() <= MOST_OFF);
    let evidence = match claimed_lsb {
        Some(lsb) => Evidence::Unit(AccelUnit::Counts, Some(lsb)),
        None => accel_evidence(norm, integers),
    };
    let gravity_shows = matches!(evidence, Evidence::Unit(..));
    let whole_zero = integers && norm >= 1.0;
    if !gravity_shows && (claim.without_gravity || (norm < LEAST_GRAVITY && !whole_zero)) {
        findings.push(without_gravity(norm));
        *doubt = Some(UnitDoubt::WithoutGravity);
        return AccelScale {
            unit: AccelUnit::Unknown,
            lsb_per_g: None,
            origin: Origin::Assumed,
        };
    }
    let by_data = |unit: AccelUnit, lsb: Option<f64>, findings: &mut Vec<Finding>| {
        if let Some(claim) = claimed
            && claim != unit
        {
            findings.push(Finding::new(
                FindingKind::UnitMismatch,
                format!(
                    "the header says {}, but at rest the magnitude is {}: the values are in {}; taken so",
                    claim.name(),
                    short(norm),
                    unit.name()
                ),
            ));
        }
        let lsb = match unit {
            AccelUnit::Counts => {
                warn_if_range_disagrees(given_lsb, claim.lsb_per_g, lsb, findings);
                given_lsb.or(lsb)
            }
            _ => None,
        };
        AccelScale {
            unit,
            lsb_per_g: lsb,
            origin: Origin::Data,
        }
    };
    match evidence {
        Evidence::Unit(unit, lsb) => by_data(unit, lsb, findings),
        Evidence::Ambiguous if given_lsb.is_some() => {
            by_data(AccelUnit::Counts, given_lsb, findings)
        }
        // Whichever of the three it is, a claim that fits settles it.
        Evidence::Ambiguous => match claimed {
            Some(AccelUnit::MilliGravity) => by_data(AccelUnit::MilliGravity, None, findings),
            Some(AccelUnit::Counts) => by_data(AccelUnit::Counts, Some(1024.0), findings),
            _ => unknown(
                norm,
                "mg, cm/s² or counts at 1024 per g; --accel-unit mg or --accel-unit counts says it",
                findings,
                doubt,
            ),
        },
        Evidence::None if claimed == Some(AccelUnit::Counts) || range_lsb.is_some() => AccelScale {
            unit: AccelUnit::Counts,
            lsb_per_g: range_lsb,
            origin: if claimed.is_some() {
                Origin::Header
            } else {
                Origin::Given
            },
        },
        Evidence::None => unknown(
            norm,
            "no unit in which gravity has that size; --accel-unit counts takes it as it is",
            findings,
            doubt,
        ),
    }
}

/// Magnitudes at rest below this are gravity in no unit, at no wrong full scale.
const LEAST_GRAVITY: f64 = 0.1;

/// Acceleration that a phone has taken gravity out of.
fn without_gravity(norm: f64) -> Finding {
    Finding::new(
        FindingKind::WithoutGravity,
        format!(
            "the magnitude at rest is {}: gravity was taken out of this acceleration, and a calibration needs it; use the raw one (phyphox: \"Acceleration (with g)\"; Sensor Logger: TotalAcceleration.csv; Android: TYPE_ACCELEROMETER)",
            short(norm)
        ),
    )
}

fn by_claim(claim: Option<AccelUnit>, range_lsb: Option<f64>) -> AccelScale {
    AccelScale {
        unit: claim.unwrap_or(AccelUnit::Unknown),
        lsb_per_g: range_lsb,
        origin: if claim.is_some() {
            Origin::Header
        } else {
            Origin::Assumed
        },
    }
}

/// A range that was given, or that the board claims, and a magnitude at rest that belongs
/// to another.
fn warn_if_range_disagrees(
    given: Option<f64>,
    claimed: Option<f64>,
    shown: Option<f64>,
    findings: &mut Vec<Finding>,
) {
    let differ = |a: f64, b: f64| (a / b - 1.0).abs() > 0.2;
    let (Some(said), Some(shown)) = (given.or(claimed), shown) else {
        return;
    };
    if !differ(said, shown) {
        return;
    }
    let (who, taken) = match given {
        Some(_) => ("was given", "taken as given"),
        None => ("is what the board says", "taken as gravity shows"),
    };
    findings.push(Finding::new(
        FindingKind::RangeMismatch,
        format!(
            "±{} g {who}, but gravity at rest is that of ±{} g; {taken}",
            short(32768.0 / said),
            short(32768.0 / shown)
        ),
    ));
}

/// Gravity that is a power of two too large or too small: the converter ran at
/// another range than the one its counts were converted with.
fn wrong_full_scale(norm: f64) -> Option<String> {
    for (unit, gravity) in [("m/s^2", 9.80665), ("g", 1.0)] {
        for factor in [0.125, 0.25, 0.5, 2.0, 4.0, 8.0] {
            if (norm / gravity / factor - 1.0).abs() < 0.1 {
                return Some(format!(
                    "; it would be gravity in {unit} with the full-scale setting wrong by a factor of {factor}: was the sensor set to another range than the program assumed?"
                ));
            }
        }
    }
    None
}

fn unknown(
    norm: f64,
    what: &str,
    findings: &mut Vec<Finding>,
    doubt: &mut Option<UnitDoubt>,
) -> AccelScale {
    *doubt = Some(UnitDoubt::NoUnit);
    if let Some(guess) = wrong_full_scale(norm) {
        *doubt = Some(UnitDoubt::WrongFullScale);
        findings.push(Finding::new(
            FindingKind::WrongFullScale,
            format!("the magnitude at rest is {}{guess}", short(norm)),
        ));
    }
    findings.push(Finding::new(
        FindingKind::UnitUnknown,
        format!("the magnitude at rest is {}: {what}", short(norm)),
    ));
    AccelScale {
        unit: AccelUnit::Unknown,
        lsb_per_g: None,
        origin: Origin::Assumed,
    }
}

fn warn_if_gravity_disagrees(
    scale: &AccelScale,
    quiet: Option<(f64, bool)>,
    findings: &mut Vec<Finding>,
) {
    let (Some(nominal), Some((norm, _))) = (scale.nominal(), quiet) else {
        return;
    };
    let g = norm / nominal / gravical_core::unit::STANDARD_GRAVITY_MPS2;
    if !(0.75..=1.25).contains(&g) {
        findings.push(Finding::new(
            FindingKind::UnitMismatch,
            format!(
                "taken as {} as told, but then the quietest parts measure {g:.2} g",
                scale.unit.name()
            ),
        ));
    }
}

fn short(value: f64) -> String {
    let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// True for a whole number that a converter can give. (`fract` is a call into the
/// mathematical library on most processors, and this is asked of every value.)
pub(crate) fn whole(v: f64) -> bool {
    v == f64::from(v as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decide(norm: f64, unit: Option<AccelUnit>) -> (AccelScale, Vec<Finding>) {
        let mut findings = Vec::new();
        let (scale, _) = decide_accel(
            Some((norm, false)),
            false,
            unit.map_or_else(AccelClaim::default, AccelClaim::from),
            &ReadOptions::default(),
            &mut findings,
        );
        (scale, findings)
    }

    #[test]
    fn a_header_that_gravity_refutes_loses() {
        let (scale, findings) = decide(9.79, Some(AccelUnit::StandardGravity));
        assert_eq!(scale.unit, AccelUnit::MetrePerSecondSquared);
        assert_eq!(findings[0].kind, "unit-mismatch");
        let (scale, findings) = decide(9.79, Some(AccelUnit::MetrePerSecondSquared));
        assert!(findings.is_empty() && scale.origin == Origin::Data);
    }

    #[test]
    fn what_cannot_be_told_is_asked() {
        let (scale, findings) = decide(985.0, None);
        assert_eq!(
            (scale.unit, findings[0].kind.name()),
            (AccelUnit::Unknown, "unit-unknown")
        );
        assert_eq!(
            decide(985.0, Some(AccelUnit::MilliGravity)).0.unit,
            AccelUnit::MilliGravity
        );
    }

    #[test]
    fn a_wrong_full_scale_is_named() {
        for norm in [4.9, 19.6, 0.5] {
            let (scale, findings) = decide(norm, Some(AccelUnit::MetrePerSecondSquared));
            assert_eq!(scale.unit, AccelUnit::Unknown, "{norm}");
            assert_eq!(findings[0].kind, "wrong-full-scale", "{norm}");
        }
        let mut findings = Vec::new();
        let options = ReadOptions {
            accel_range_g: Some(2.0),
            ..ReadOptions::default()
        };
        let _ = decide_accel(
            Some((8200.0, true)),
            false,
            AccelClaim::default(),
            &options,
            &mut findings,
        );
        assert_eq!(findings[0].kind, "range-mismatch");
    }
}
