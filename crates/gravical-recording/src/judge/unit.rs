//! Unit of the accelerometer, by what the head claims and what gravity shows.

use super::cells::median;
use crate::units::AccelUnit;

/// Rows of a block whose spread tells rest from motion.
const BLOCK_ROWS: usize = 20;

/// A claim holds unless the magnitude at rest is off by more: no accelerometer with a bias of
/// more than that is used.
const CLAIM_TOLERANCE: f64 = 0.1;

/// Counts per g of common parts, and whether only whole numbers can be counts of it: 64 Empatica
/// E4, 256 ADXL345 and BMA, 1024 to 16384 MPU and LSM at their ranges.
const COUNTS_PER_G: [(f64, bool); 7] = [
    (64.0, true),
    (256.0, true),
    (1024.0, true),
    (2048.0, false),
    (4096.0, false),
    (8192.0, false),
    (16384.0, false),
];

/// Unit of an accelerometer.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AccelScale {
    /// The unit; `None` if neither head nor gravity show it
    pub unit: Option<AccelUnit>,
    /// Nominal counts per g, where the unit is counts
    pub counts_per_g: Option<f64>,
}

impl AccelScale {
    /// Nominal m/s² of one unit of the file.
    #[must_use]
    pub fn mps2(&self) -> Option<f64> {
        let per_g = self.unit?.gravity().or(self.counts_per_g)?;
        Some(9.80665 / per_g)
    }
}

/// The unit in which rows at rest show gravity.
///
/// What the head claims holds unless gravity is off by more than 10 %.
#[must_use]
pub fn accel_scale(accel: [&[f64]; 3], claim: Option<AccelUnit>) -> AccelScale {
    let named = |unit| AccelScale {
        unit: Some(unit),
        counts_per_g: None,
    };
    let Some(norm) = median(quiet_norms(accel)) else {
        return AccelScale {
            unit: claim,
            counts_per_g: None,
        };
    };
    if let Some(unit) = claim
        && let Some(gravity) = unit.gravity()
        && (norm / gravity - 1.0).abs() <= CLAIM_TOLERANCE
    {
        return named(unit);
    }
    let is_whole = accel
        .iter()
        .all(|c| c.iter().all(|v| v.is_nan() || v.fract() == 0.0));
    match norm {
        0.8..=1.25 => return named(AccelUnit::G),
        8.0..=12.0 => return named(AccelUnit::Mps2),
        800.0..=1250.0 if !is_whole => return named(AccelUnit::MilliG),
        _ => {}
    }
    let ratio = |per_g: f64| (norm / per_g).ln().abs();
    let fit = COUNTS_PER_G
        .iter()
        .filter(|(per_g, only_whole)| (norm / per_g - 1.0).abs() < 0.2 && (is_whole || !only_whole))
        .min_by(|a, b| ratio(a.0).total_cmp(&ratio(b.0)));
    match fit {
        Some((per_g, _)) => AccelScale {
            unit: Some(AccelUnit::Counts),
            counts_per_g: Some(*per_g),
        },
        None => AccelScale {
            unit: None,
            counts_per_g: None,
        },
    }
}

/// Mean magnitudes of the quietest third of the blocks.
pub(crate) fn quiet_norms(accel: [&[f64]; 3]) -> Vec<f64> {
    let rows = accel[0].len();
    let ranges = (0..rows)
        .step_by(BLOCK_ROWS)
        .map(|from| from..(from + BLOCK_ROWS).min(rows));
    let mut blocks: Vec<(f64, f64)> = ranges
        .filter_map(|r| spread_and_norm(accel.map(|c| &c[r.clone()])))
        .collect();
    blocks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    blocks.truncate(blocks.len().div_ceil(3));
    blocks.into_iter().map(|b| b.1).collect()
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
