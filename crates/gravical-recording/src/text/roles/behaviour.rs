//! What the rows of the head show of three columns: gravity at rest, angular rate, or neither.

use std::ops::Range;

use crate::judge::{median, shows_gravity};

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

/// How good an accelerometer three columns are: the sensor answers, and shows gravity at rest.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct Gravity {
    pub answers: bool,
    pub is_shown: bool,
}

impl Gravity {
    pub(super) fn of(axes: Axes<'_>) -> Self {
        let answers = axes
            .iter()
            .any(|c| c.iter().any(|v| *v != 0.0 && !v.is_nan()));
        Gravity {
            answers,
            is_shown: answers && shows_gravity(axes),
        }
    }
}

/// Whether three columns may be the angular rate of the sensor whose specific force others are: at rest
/// it is the same in every pose. Angles and the magnetic field at rest differ from pose to pose.
pub(super) fn may_be_rate(axes: Axes<'_>, accel: Axes<'_>) -> bool {
    let poses = poses(accel);
    let means = |blocks: &Vec<Range<usize>>| {
        let mean = |axis: &[f64]| median(blocks.iter().map(|rows| mean(&axis[rows.clone()])));
        Some([mean(axes[0])?, mean(axes[1])?, mean(axes[2])?])
    };
    let means: Vec<[f64; 3]> = poses.iter().filter_map(means).collect();
    if means.len() < MIN_POSES {
        return true;
    }
    let blocks = poses.iter().flatten();
    let deviation = |rows: &Range<usize>| {
        let axes = axes.iter().map(|axis| variance(&axis[rows.clone()]));
        axes.sum::<f64>().sqrt()
    };
    let noise = median(blocks.map(deviation)).unwrap_or(0.0);
    let largest = axes.iter().flat_map(|axis| axis.iter());
    let largest = largest
        .filter(|v| v.is_finite())
        .fold(0.0, |m: f64, v| m.max(v.abs()));
    let first = means[0];
    let far = means.iter().filter(|mean| {
        let apart = distance(mean, &first);
        apart > MAX_DEVIATIONS * noise && apart > MAX_SHARE * largest
    });
    // One other pose may be a turn.
    far.count() + 1 < MIN_POSES
}

/// Blocks at rest by the specific force, of each pose; none where its magnitude is not the same in all:
/// then the sensor was in motion throughout.
fn poses(accel: Axes<'_>) -> Vec<Vec<Range<usize>>> {
    let rows = accel[0].len();
    let blocks = (0..rows / BLOCK_ROWS).map(|b| BLOCK_ROWS * b..BLOCK_ROWS * (b + 1));
    let variance = |rows: &Range<usize>| -> f64 {
        accel.iter().map(|axis| variance(&axis[rows.clone()])).sum()
    };
    let mut blocks: Vec<(f64, Range<usize>)> = blocks.map(|rows| (variance(&rows), rows)).collect();
    blocks.retain(|block| block.0.is_finite());
    blocks.sort_by(|a, b| a.0.total_cmp(&b.0));
    // In half of the rows at least a session is at rest.
    blocks.truncate(blocks.len().div_ceil(2));
    let norm = |rows: &Range<usize>| {
        let means = accel.map(|axis| mean(&axis[rows.clone()]));
        means.iter().map(|v| v * v).sum::<f64>().sqrt()
    };
    let gravity = median(blocks.iter().map(|block| norm(&block.1))).unwrap_or(f64::NAN);
    let off = blocks
        .iter()
        .map(|block| (norm(&block.1) / gravity - 1.0).abs());
    if median(off).is_none_or(|off| off > MAX_OFF) {
        return Vec::new();
    }
    let mut poses: Vec<([f64; 3], Vec<Range<usize>>)> = Vec::new();
    for (_, rows) in blocks {
        let direction = accel.map(|axis| mean(&axis[rows.clone()]));
        let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
        let direction = direction.map(|v| v / norm);
        let is_same = |pose: &&mut ([f64; 3], Vec<Range<usize>>)| {
            let cosine: f64 = pose.0.iter().zip(&direction).map(|(a, b)| a * b).sum();
            cosine > ONE_POSE
        };
        match poses.iter_mut().find(is_same) {
            Some(pose) => pose.1.push(rows),
            None => poses.push((direction, vec![rows])),
        }
    }
    let poses = poses.into_iter().map(|pose| pose.1);
    poses.filter(|blocks| blocks.len() > 1).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}
