//! Unit of the accelerometer: by the user, by what gravity shows, by what the head claims, in this
//! order; and rows in which it changes.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::cells::median;
use crate::finding::{Case, Finding};
use crate::full_scale::range_of_16_bits;
use crate::options::ReadOptions;
use crate::units::{AccelScale, AccelUnit, Origin, Units};

/// Rows of a block whose spread tells rest from motion.
const BLOCK_ROWS: usize = 20;

/// A claim holds unless the magnitude at rest is off by more: no accelerometer with a bias of
/// more than that is used.
const CLAIM_TOLERANCE: f64 = 0.1;

/// Smaller magnitudes at rest cannot be gravity, in any unit or with any wrong full scale.
const MIN_GRAVITY: f64 = 0.1;

/// What a file claims about its accelerometer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AccelClaim {
    /// Unit, from the header or the board's settings line
    pub unit: Option<AccelUnit>,
    /// Counts per g, from the header or the board's settings line
    pub lsb_per_g: Option<f64>,
    /// The column names say that gravity was removed
    pub without_gravity: bool,
}

/// Median magnitude in the quietest third of the blocks of 20 rows: gravity, in the unit of the
/// values. `None` without a complete row. The sensor need not be at rest: gravity dominates the mean of
/// a quiet block.
pub fn quiet_norm(accel: [&[f64]; 3]) -> Option<f64> {
    let blocks = blocks(accel).filter_map(|(_, block)| spread_and_norm(block));
    let mut blocks: Vec<(f64, f64)> = blocks.collect();
    blocks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    blocks.truncate(blocks.len().div_ceil(3));
    median(blocks.iter().map(|b| b.1))
}

/// Blocks of 20 rows with the first row of each; the last one may be shorter.
fn blocks(accel: [&[f64]; 3]) -> impl Iterator<Item = (usize, [&[f64]; 3])> {
    let rows = accel[0].len();
    let starts = (0..rows).step_by(BLOCK_ROWS);
    starts.map(move |start| {
        (
            start,
            accel.map(|c| &c[start..rows.min(start + BLOCK_ROWS)]),
        )
    })
}

/// Blocks of 20 rows; none of them shorter.
fn whole_blocks(accel: [&[f64]; 3]) -> impl Iterator<Item = (usize, [&[f64]; 3])> {
    blocks(accel).filter(|(_, block)| block[0].len() == BLOCK_ROWS)
}

/// Whether the magnitude of quiet rows is gravity in some unit.
pub fn shows_gravity(accel: [&[f64]; 3]) -> bool {
    quiet_norm(accel).is_some_and(|norm| accel_evidence(norm, true) != Evidence::None)
}

/// The unit in which rows at rest show gravity. What the head claims holds unless gravity is off
/// by more than 10 %; what the user says always does. `is_unsigned`: counts of unknown range, whose
/// middle was subtracted. Sets `units.contradicts_given` and
/// `units.is_without_gravity`. That the unit is unknown is the last of the findings.
pub fn accel_unit(
    accel: [&[f64]; 3],
    is_unsigned: bool,
    claim: AccelClaim,
    options: &ReadOptions,
    units: &mut Units,
    findings: &mut Vec<Finding>,
) -> AccelScale {
    let is_whole = |c: &&[f64]| c.iter().all(|v| v.is_nan() || v.fract() == 0.0);
    let integers = accel.iter().all(is_whole);
    let norm = quiet_norm(accel);
    let given_lsb = options.accel_range_g.map(|range| 32768.0 / range);
    // A range given by the user overrides the data, one claimed by the board does not.
    let range_lsb = given_lsb.or(claim.lsb_per_g);
    if let Some(unit) = options.accel_unit {
        let from_data = match norm.map(|norm| accel_evidence(norm, true)) {
            Some(Evidence::Unit(AccelUnit::Counts, lsb)) if !is_unsigned => lsb,
            _ => None,
        };
        let lsb = given_lsb.or(from_data).or(range_lsb);
        let lsb = lsb.filter(|_| unit == AccelUnit::Counts);
        let scale = AccelScale::new(unit, lsb, Origin::Given);
        let contradiction = norm.and_then(|norm| given_disagrees(&scale, norm));
        units.contradicts_given = contradiction.is_some();
        findings.extend(contradiction);
        return scale;
    }
    if is_unsigned {
        return AccelScale::new(AccelUnit::Counts, range_lsb, Origin::Data);
    }
    let Some(norm) = norm else {
        return match claim.unit {
            Some(unit) => AccelScale::new(unit, range_lsb, Origin::Header),
            None => AccelScale::new(AccelUnit::Unknown, range_lsb, Origin::Assumed),
        };
    };
    let mut rest = AtRest {
        norm,
        claim,
        given_lsb,
        findings,
    };
    let evidence = match find_evidence(norm, integers, claim) {
        // In a motion any magnitude may be near that of some counts, and that of what lacks gravity near any.
        Evidence::Unit(unit, _)
            if (unit == AccelUnit::Counts || claim.without_gravity) && !has_rest(accel) =>
        {
            Evidence::None
        }
        evidence => evidence,
    };
    let unknown = match evidence {
        Evidence::Unit(unit, lsb) => return rest.read_as(unit, lsb),
        _ if claim.without_gravity || norm < MIN_GRAVITY => {
            units.is_without_gravity = true;
            if norm < MIN_GRAVITY || has_rest(accel) {
                Case::WithoutGravity { norm }.finding()
            } else {
                Case::NamedLinear.finding()
            }
        }
        // A given range, or a claim for one of the matching units decides.
        Evidence::Ambiguous => match claim.unit {
            _ if given_lsb.is_some() => return rest.read_as(AccelUnit::Counts, given_lsb),
            Some(unit @ AccelUnit::MilliGravity) => return rest.read_as(unit, None),
            Some(unit @ AccelUnit::Counts) => return rest.read_as(unit, Some(1024.0)),
            None if !integers => {
                // cm/s² is rare, and a calibration of one serves for the other.
                let assumed = Case::UnitAssumed { norm }.finding();
                rest.findings.push(assumed.advise("accel_unit", ""));
                return rest.read_as(AccelUnit::MilliGravity, None);
            }
            _ => {
                let unknown = Case::UnitAmbiguous { norm }.finding();
                let unknown = unknown.advise("accel_unit", "mg");
                unknown.advise("accel_unit", "counts")
            }
        },
        Evidence::None if claim.unit == Some(AccelUnit::Counts) || range_lsb.is_some() => {
            let is_claimed = claim.unit == Some(AccelUnit::Counts);
            let origin = if is_claimed {
                Origin::Header
            } else {
                Origin::Given
            };
            return AccelScale::new(AccelUnit::Counts, range_lsb, origin);
        }
        Evidence::None if !has_rest(accel) => {
            let likely = match norm {
                ..=3.0 => "g",
                ..=30.0 => "m/s^2",
                ..=3000.0 => "mg",
                _ => "counts",
            };
            let unknown = Case::NeverAtRest { norm }.finding();
            unknown.advise("accel_unit", likely)
        }
        Evidence::None => {
            let unknown = wrong_full_scale(norm).unwrap_or(Case::UnitUnknown { norm });
            unknown.finding().advise("accel_unit", "counts")
        }
    };
    findings.push(unknown);
    AccelScale::default()
}

/// What gravity shows; claims hold unless it contradicts them.
fn find_evidence(norm: f64, integers: bool, claim: AccelClaim) -> Evidence {
    let is_near = |gravity: f64, tolerance: f64| (norm / gravity - 1.0).abs() <= tolerance;
    let claimed_lsb = claim.lsb_per_g.filter(|lsb| is_near(*lsb, MAX_OFF));
    let holds = |unit: &AccelUnit| {
        let nominal = AccelScale::new(*unit, None, Origin::Header).nominal();
        nominal.is_some_and(|n| is_near(n * STANDARD_GRAVITY_MPS2, CLAIM_TOLERANCE))
    };
    match claim.unit.filter(holds) {
        _ if claimed_lsb.is_some() => Evidence::Unit(AccelUnit::Counts, claimed_lsb),
        Some(unit) => Evidence::Unit(unit, None),
        None => accel_evidence(norm, integers),
    }
}

/// Unit that matches the magnitude of readings at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Evidence {
    /// This unit; for counts with counts per g.
    Unit(AccelUnit, Option<f64>),
    /// Between 800 and 1250: mg, cm/s² or counts at 1024 per g.
    Ambiguous,
    /// No unit in which gravity has that magnitude.
    None,
}

/// Determines the unit from `norm`, the median magnitude of readings at rest; `integers`: all
/// values are whole numbers.
fn accel_evidence(norm: f64, integers: bool) -> Evidence {
    let off = |lsb: f64| (norm / lsb).ln().abs();
    let fits = |(lsb, only_whole): &(f64, bool)| {
        (norm / lsb - 1.0).abs() <= MAX_OFF && (integers || !only_whole)
    };
    let near = LSB_PER_G.into_iter().filter(fits);
    let nearest = near.min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    match (norm, nearest) {
        (0.8..=1.25, _) => Evidence::Unit(AccelUnit::StandardGravity, None),
        (8.0..=12.0, _) => Evidence::Unit(AccelUnit::MetrePerSecondSquared, None),
        // mg, cm/s² (980.665) and 1024 counts per g cannot be distinguished within the scale error and
        // the bias of a sensor.
        (800.0..=1250.0, _) => Evidence::Ambiguous,
        (_, Some((lsb, _))) => Evidence::Unit(AccelUnit::Counts, Some(lsb)),
        (_, None) => Evidence::None,
    }
}

/// Largest relative deviation of gravity from the value of a scale.
const MAX_OFF: f64 = 0.2;

/// Counts per g of converters in use, and whether values must be whole numbers: Empatica E4,
/// ADXL345 and BMA, then 16 bits at ±16 to ±2 g; mm/s² are treated as counts. 1000 and 1024 per g
/// coincide with mg, see [`accel_evidence`].
const LSB_PER_G: [(f64, bool); 7] = [
    (64.0, true),
    (256.0, true),
    (2048.0, false),
    (4096.0, false),
    (8192.0, false),
    (9806.65, false),
    (16384.0, false),
];

/// The magnitude of readings at rest, what is said of their unit, and what is found of it.
struct AtRest<'a> {
    norm: f64,
    claim: AccelClaim,
    given_lsb: Option<f64>,
    findings: &'a mut Vec<Finding>,
}

impl AtRest<'_> {
    /// The unit and, of counts, counts per g that gravity shows; contradictions of the header and
    /// of ranges are reported.
    fn read_as(&mut self, unit: AccelUnit, measured_lsb: Option<f64>) -> AccelScale {
        let is_counts = unit == AccelUnit::Counts;
        let lsb = self.given_lsb.or(measured_lsb).filter(|_| is_counts);
        let norm = self.norm;
        if let Some(stated) = self.claim.unit.filter(|stated| *stated != unit) {
            let mismatch = Case::UnitOfHeader { stated, norm, unit };
            self.findings.push(mismatch.finding());
        }
        let stated = self.given_lsb.or(self.claim.lsb_per_g);
        if let (true, Some(stated), Some(measured)) = (is_counts, stated, measured_lsb)
            && (stated / measured - 1.0).abs() > MAX_OFF
        {
            let given_g = 32_768.0 / stated;
            let mismatch = match range_of_16_bits(measured) {
                _ if self.given_lsb.is_none() => Case::RangeOfHeader {
                    stated_lsb_per_g: stated,
                    lsb_per_g: measured,
                },
                Some(shown_g) => Case::RangeGiven { given_g, shown_g },
                None => Case::RangeGivenForCounts {
                    given_g,
                    lsb_per_g: measured,
                },
            };
            self.findings.push(mismatch.finding());
        }
        AccelScale::new(unit, lsb, Origin::Data)
    }
}

fn given_disagrees(scale: &AccelScale, norm: f64) -> Option<Finding> {
    let norm_g = norm / scale.nominal()? / STANDARD_GRAVITY_MPS2;
    let unit = scale.unit;
    (!(0.75..=1.25).contains(&norm_g)).then(|| Case::UnitGiven { unit, norm_g }.finding())
}

/// Explanation of a magnitude that differs from gravity by a power of two: the converter ran at
/// another range than its counts were converted with.
fn wrong_full_scale(norm: f64) -> Option<Case> {
    let units = [AccelUnit::MetrePerSecondSquared, AccelUnit::StandardGravity];
    units
        .into_iter()
        .zip([9.80665, 1.0])
        .find_map(|(unit, gravity)| {
            let is_it = |factor: &f64| (norm / gravity / factor - 1.0).abs() < 0.1;
            let factor = [0.125, 0.25, 0.5, 2.0, 4.0, 8.0].into_iter().find(is_it)?;
            Some(Case::OtherFullScale { norm, unit, factor })
        })
}

/// Variance over all axes and mean magnitude of the complete rows of a block.
fn spread_and_norm(block: [&[f64]; 3]) -> Option<(f64, f64)> {
    let (mut sum, mut squares, mut norms, mut count) = ([0.0; 3], 0.0, 0.0, 0.0);
    // Sums about the first row lose no digits to a large mean.
    let mut origin = None;
    for i in 0..block[0].len() {
        let row = block.map(|axis| axis[i]);
        let square: f64 = row.iter().map(|v| v * v).sum();
        if !square.is_finite() {
            continue;
        }
        let origin = origin.get_or_insert(row);
        for k in 0..3 {
            let d = row[k] - origin[k];
            sum[k] += d;
            squares += d * d;
        }
        norms += square.sqrt();
        count += 1.0;
    }
    let of_means: f64 = sum.iter().map(|s| s * s / count).sum();
    (count > 0.0).then(|| ((squares - of_means) / count, norms / count))
}

/// Largest standard deviation of a block at rest, as a share of gravity.
const MAX_RESTLESS: f64 = 0.05;

/// Mean magnitude of a block of complete rows, if the sensor may lie still in it. `gravity`: the magnitude
/// of other blocks at rest, 0 if it is unknown.
fn rest_norm(block: [&[f64]; 3], gravity: f64) -> Option<f64> {
    let (variance, norm) = spread_and_norm(block)?;
    (variance.sqrt() <= MAX_RESTLESS * norm.max(gravity) && norm > 0.0).then_some(norm)
}

/// Whether the sensor may lie still in some block.
fn has_rest(accel: [&[f64]; 3]) -> bool {
    let mut blocks = whole_blocks(accel);
    accel[0].len() < BLOCK_ROWS || blocks.any(|(_, block)| rest_norm(block, 0.0).is_some())
}

/// Blocks at rest in a row that establish a magnitude.
const SETTLED: usize = 5;
/// Magnitudes at rest in one unit differ by no more than this share …
const ONE_UNIT: f64 = 0.25;
/// … and the ratio of two units, or ranges, is matched within this share.
const RATIO: f64 = 0.08;
/// Ratios of 1 g in g, m/s² and mg, and of 1 g in counts at ±16 g to ±2 g to these, from 8.5 on.
const UNIT_RATIOS: [f64; 12] = [
    9.80665, 16.384, 101.972, 208.838, 417.676, 835.351, 1000.0, 1670.70, 2048.0, 4096.0, 8192.0,
    16384.0,
];
/// Ratios of two ranges.
const RANGE_RATIOS: [f64; 3] = [2.0, 4.0, 8.0];
/// Counts at or near the end of the range of a 16-bit converter.
const FULL: f64 = 32_700.0;

/// The magnitude at rest jumps from gravity to another value, and stays there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// Magnitude at rest before and after it
    pub norms: [f64; 2],
    /// The first row after it
    pub row: usize,
    /// Both may be gravity, under two units or ranges; otherwise the values stand in other columns, because the bus
    /// lost a byte
    pub is_of_unit: bool,
}

/// The first jump of the magnitude at rest. No motion can cause one, since a sensor at rest measures 1 g.
pub fn find_jump(accel: &[Vec<f64>; 3], gyro: Option<&[Vec<f64>; 3]>) -> Option<Jump> {
    let norm = |row: usize| accel.iter().map(|c| c[row] * c[row]).sum::<f64>().sqrt();
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() <= ONE_UNIT;
    let is_full = |block: &[&[f64]; 3]| block.iter().any(|c| c.iter().any(|v| v.abs() >= FULL));
    let mut established: Option<f64> = None;
    // Blocks that agree with each other and not with that: their number, magnitude, first row.
    let (mut count, mut other, mut from) = (0, 0.0, 0);
    for (start, block) in whole_blocks(accel.each_ref().map(Vec::as_slice)) {
        let is_known = |magnitude: f64| established.is_some_and(|n| is_near(magnitude, n));
        let magnitude = rest_norm(block, established.unwrap_or(0.0))
            .filter(|m| !is_full(&block) && !is_known(*m));
        let Some(magnitude) = magnitude else {
            count = 0;
            continue;
        };
        if count > 0 && is_near(magnitude, other) {
            count += 1;
        } else {
            (count, other, from) = (1, magnitude, start);
        }
        if count < SETTLED {
            continue;
        }
        let Some(before) = established else {
            established = Some(other);
            continue;
        };
        let is_shifted = || gyro.is_some_and(|gyro| is_shifted(block, gyro, start, before));
        let is_of_unit = is_other_unit(before, other, block);
        if !is_of_unit && !is_shifted() {
            continue;
        }
        let between = (before * other).sqrt();
        let is_new = |row: &usize| (norm(*row) > between) == (other > between);
        let near = from.saturating_sub(BLOCK_ROWS)..from + BLOCK_ROWS;
        return Some(Jump {
            norms: [before, other],
            row: near.rev().take_while(is_new).last().unwrap_or(from),
            is_of_unit,
        });
    }
    None
}

/// Whether the six channels are shifted by some places in a block at rest: three others, one after the
/// other, have the magnitude `gravity` in it.
fn is_shifted(block: [&[f64]; 3], gyro: &[Vec<f64>; 3], start: usize, gravity: f64) -> bool {
    let rates = gyro.each_ref().map(|c| &c[start..start + BLOCK_ROWS]);
    let channels = [block, rates].concat();
    (1..6).any(|places| {
        let block = [0, 1, 2].map(|i| channels[(places + i) % 6]);
        rest_norm(block, gravity).is_some_and(|norm| (norm / gravity - 1.0).abs() <= RATIO)
    })
}

/// True if both magnitudes can be 1 g, in two units or at two ranges. A change of range is only
/// possible between counts (whole numbers): for other values a factor of two may be a force.
fn is_other_unit(before: f64, after: f64, block: [&[f64]; 3]) -> bool {
    let ratio = after / before;
    let is = |expected: f64| (ratio / expected - 1.0).abs() <= RATIO;
    let is_one_of = |ratios: &[f64]| ratios.iter().any(|r| is(*r) || is(1.0 / r));
    let integers = block.iter().all(|c| c.iter().all(|v| v.fract() == 0.0));
    is_one_of(&UNIT_RATIOS) || integers && is_one_of(&RANGE_RATIOS)
}
