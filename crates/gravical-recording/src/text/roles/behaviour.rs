//! What the rows of the head show of three columns: gravity at rest, angular rate, or neither.

use std::ops::Range;

use gravical_core::matrix3::{dot, norm, sub, unit};
use gravical_judge::median;

/// Rows of a block that is at rest or in motion.
const BLOCK_ROWS: usize = 10;
/// Directions of gravity that differ by more are of two poses: cos 25°.
const ONE_POSE: f64 = 0.906;
/// The magnitude at rest deviates by less from pose to pose: by bias and scale of a cheap sensor.
const MAX_OFF: f64 = 0.05;
/// Poses among which a bias is the same and a direction is not.
const MIN_POSES: usize = 3;
/// Means of a gyroscope at rest differ from pose to pose by less than so many deviations within a block,
/// or than this share of the largest rate: by its drift, and the hand that holds it.
const MAX_DEVIATIONS: f64 = 5.0;
const MAX_SHARE: f64 = 0.2;

/// Three columns of the head.
pub(super) type Axes<'a> = [&'a [f64]; 3];

/// Whether the sensor answers at all.
pub(super) fn answers(axes: Axes<'_>) -> bool {
    let is_value = |v: &f64| *v != 0.0 && !v.is_nan();
    axes.iter().any(|axis| axis.iter().any(is_value))
}

/// Whether three columns may be the angular rate of the sensor whose specific force others are: at rest
/// it is the same in every pose. Angles and the magnetic field at rest differ from pose to pose.
pub(super) fn may_be_rate(axes: Axes<'_>, accel: Axes<'_>) -> bool {
    let poses = poses(accel);
    let pose_means = |blocks: &Vec<Range<usize>>| {
        let means = |axis: &[f64]| median(blocks.iter().map(|rows| mean(&axis[rows.clone()])));
        let [x, y, z] = axes.map(means);
        Some([x?, y?, z?])
    };
    let means: Vec<[f64; 3]> = poses.iter().filter_map(pose_means).collect();
    if means.len() < MIN_POSES {
        return true;
    }
    let noise = median(poses.iter().flatten().map(|rows| deviation(axes, rows))).unwrap_or(0.0);
    let values = axes.into_iter().flatten().filter(|v| v.is_finite());
    let largest = values.fold(0.0, |m: f64, v| m.max(v.abs()));
    let is_far = |mean: &&[f64; 3]| {
        let apart = norm(&sub(mean, &means[0]));
        apart > MAX_DEVIATIONS * noise && apart > MAX_SHARE * largest
    };
    // One other pose may be a turn.
    means.iter().filter(is_far).count() + 1 < MIN_POSES
}

/// Blocks at rest by the specific force, of each pose; none where its magnitude is not the same in all:
/// then the sensor was in motion throughout.
fn poses(accel: Axes<'_>) -> Vec<Vec<Range<usize>>> {
    let blocks = (0..accel[0].len() / BLOCK_ROWS).map(|b| BLOCK_ROWS * b..BLOCK_ROWS * (b + 1));
    let means = |rows: &Range<usize>| accel.map(|axis| mean(&axis[rows.clone()]));
    let described = blocks.map(|rows| (deviation(accel, &rows), means(&rows), rows));
    let mut blocks: Vec<(f64, [f64; 3], Range<usize>)> = described.collect();
    blocks.retain(|block| block.0.is_finite());
    blocks.sort_by(|a, b| a.0.total_cmp(&b.0));
    // In half of the rows at least a session is at rest.
    blocks.truncate(blocks.len().div_ceil(2));
    let gravity = median(blocks.iter().map(|block| norm(&block.1))).unwrap_or(f64::NAN);
    let off = |block: &(f64, [f64; 3], _)| (norm(&block.1) / gravity - 1.0).abs();
    if median(blocks.iter().map(off)).is_none_or(|off| off > MAX_OFF) {
        return Vec::new();
    }
    let mut poses: Vec<([f64; 3], Vec<Range<usize>>)> = Vec::new();
    for (_, mean, rows) in blocks {
        let direction = unit(&mean);
        let mut others = poses.iter_mut();
        match others.find(|pose| dot(&pose.0, &direction) > ONE_POSE) {
            Some(pose) => pose.1.push(rows),
            None => poses.push((direction, vec![rows])),
        }
    }
    let poses = poses.into_iter().map(|pose| pose.1);
    poses.filter(|blocks| blocks.len() > 1).collect()
}

/// Standard deviation in some rows, over all axes.
fn deviation(axes: Axes<'_>, rows: &Range<usize>) -> f64 {
    norm(&axes.map(|axis| variance(&axis[rows.clone()]).sqrt()))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64
}
