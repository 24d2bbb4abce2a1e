//! Choice of the accelerometer's unit: by option, by the magnitude at rest, by the header, in
//! this order.

use gravical_recording::UnitDoubt;
pub use gravical_recording::judge::AccelClaim;

use super::ReadOptions;
use super::units::{AccelScale, AccelUnit, Evidence, MOST_OFF, Origin, accel_evidence};
use crate::finding::{Finding, FindingKind};

/// Determines the unit from the magnitude of quiet readings, the header's claim and the options;
/// contradictions become findings. If the unit stays unknown, the second value is the reason.
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
    // A range given by the user overrides the data, one claimed by the board does not.
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
    // A claimed sensitivity is used if gravity does not contradict it.
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
                    "the header gives {}, but the magnitude at rest is {}: the values are read as {}",
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
        // A claim for one of the matching units decides.
        Evidence::Ambiguous => match claimed {
            Some(AccelUnit::MilliGravity) => by_data(AccelUnit::MilliGravity, None, findings),
            Some(AccelUnit::Counts) => by_data(AccelUnit::Counts, Some(1024.0), findings),
            _ => unknown(
                norm,
                "mg, cm/s² or counts at 1024 per g; give --accel-unit mg or --accel-unit counts",
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
            "gravity in no known unit; check the factor in the program that wrote the file, or give --accel-unit counts, which uses the values as they are",
            findings,
            doubt,
        ),
    }
}

/// Smaller magnitudes at rest cannot be gravity, in any unit or with any wrong full scale.
const LEAST_GRAVITY: f64 = 0.1;

/// Finding for acceleration without gravity, as some apps record it.
fn without_gravity(norm: f64) -> Finding {
    Finding::new(
        FindingKind::WithoutGravity,
        format!(
            "the magnitude at rest is {}: gravity was removed from this acceleration, but a calibration needs it; use the raw data (phyphox: \"Acceleration (with g)\"; Sensor Logger: TotalAcceleration.csv; Android: TYPE_ACCELEROMETER)",
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

/// Reports a given or claimed range that does not match the magnitude at rest.
fn warn_if_range_disagrees(
    given: Option<f64>,
    claimed: Option<f64>,
    measured: Option<f64>,
    findings: &mut Vec<Finding>,
) {
    let differ = |a: f64, b: f64| (a / b - 1.0).abs() > 0.2;
    let (Some(stated), Some(measured)) = (given.or(claimed), measured) else {
        return;
    };
    if !differ(stated, measured) {
        return;
    }
    let message = match given {
        Some(_) => format!(
            "±{} g was given, but the magnitude at rest corresponds to ±{} g; the given range is used",
            short(32768.0 / stated),
            short(32768.0 / measured)
        ),
        None => format!(
            "the file claims {} counts per g, the magnitude at rest is that of {}; that of gravity is used",
            short(stated),
            short(measured)
        ),
    };
    findings.push(Finding::new(FindingKind::RangeMismatch, message));
}

/// Explanation of a magnitude that differs from gravity by a power of two: the converter ran at
/// another range than its counts were converted with.
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
                "read as {} as given, but then the magnitude at rest is {g:.2} g, and should be 1",
                scale.unit.name()
            ),
        ));
    }
}

fn short(value: f64) -> String {
    let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// True for a whole number in the range of a converter. (`fract` is a library call on most
/// processors and too slow for every value.)
pub(crate) fn is_whole_number(v: f64) -> bool {
    v == f64::from(v as i32)
}
