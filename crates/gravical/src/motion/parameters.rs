//! How far the parameters of a calibration may be off, as directions: each is a
//! change of all parameters together by one standard deviation, independent of
//! the others, so that variances of results add.
//!
//! With u = M a + b and A = M⁻¹ the specific force f = A (u − b) changes by
//! δf = −A (δM f + δb), the angular rate alike.

use gravical_core::matrix3::{mul, mul_vec, transpose};
use nalgebra::DMatrix;

use crate::calibration_file::{AccelerometerSection, CalibrationFile, Covariance};
use crate::segment::face::AxisMap;

/// Step of the parameters for their effect, in standard deviations.
pub(super) const STEP: f64 = 1e-3;

/// What a direction changes, for the budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Bias of the accelerometer, and what the covariance ties to it.
    Bias,
    /// Its scale and cross-axis terms.
    Scale,
    /// Scale and cross-axis terms of the gyroscope.
    Gyro,
}

/// A change of the parameters: δf = F f + c, δω = W ω.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    pub kind: Kind,
    force: [[f64; 3]; 3],
    offset: [f64; 3],
    rate: [[f64; 3]; 3],
}

impl Direction {
    /// No change.
    pub const NONE: Direction = Direction {
        kind: Kind::Bias,
        force: [[0.0; 3]; 3],
        offset: [0.0; 3],
        rate: [[0.0; 3]; 3],
    };

    /// What it adds to a specific force.
    #[inline]
    pub fn force(&self, f: &[f64; 3]) -> [f64; 3] {
        let turned = mul_vec(&self.force, f);
        std::array::from_fn(|i| turned[i] + self.offset[i])
    }

    /// F of δf = F f + c.
    pub fn matrix(&self) -> &[[f64; 3]; 3] {
        &self.force
    }

    /// What it adds to an angular rate.
    #[inline]
    pub fn rate(&self, w: &[f64; 3]) -> [f64; 3] {
        mul_vec(&self.rate, w)
    }

    /// The same change, `factor` times as large.
    pub fn times(&self, factor: f64) -> Self {
        Direction {
            kind: self.kind,
            force: self.force.map(|row| row.map(|v| v * factor)),
            offset: self.offset.map(|v| v * factor),
            rate: self.rate.map(|row| row.map(|v| v * factor)),
        }
    }
}

/// Standard deviations where nothing was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Assumed {
    /// Relative scale.
    pub scale: f64,
    /// Off-diagonal elements of M.
    pub cross: f64,
    /// Bias, m/s².
    pub bias_mps2: f64,
}

/// Data sheet of the MPU6050, which is that of most cheap parts.
pub(super) const DATA_SHEET: Assumed = Assumed {
    scale: 0.03,
    cross: 0.02,
    bias_mps2: 0.6,
};

/// A calibration that says nothing of its uncertainty: what six careful
/// placements reach.
pub(super) const UNSTATED: Assumed = Assumed {
    scale: 0.005,
    cross: 0.01,
    bias_mps2: 0.02,
};

/// A gyroscope whose turns were fitted, without a covariance.
pub(super) const TURNED: Assumed = Assumed {
    scale: 0.005,
    cross: 0.01,
    bias_mps2: 0.0,
};

/// Directions of the accelerometer by a covariance of its parameters; none where that is no
/// covariance.
pub(super) fn by_covariance(
    section: &AccelerometerSection,
    covariance: &gravical_fit::model::Covariance,
    axes: &AxisMap,
) -> Option<Vec<Direction>> {
    // Bias first: the first three columns of the factor are then the bias, and
    // what goes along with it.
    let order: Vec<usize> = (9..12).chain(0..9).collect();
    let c = DMatrix::from_fn(12, 12, |i, j| covariance[(order[i], order[j])]);
    let factor = factor(&c)?;
    let a = &section.matrix;
    let case = Case::new(axes);
    Some(
        (0..12)
            .map(|k| {
                let bias: [f64; 3] = std::array::from_fn(|i| factor[(i, k)]);
                let model: [[f64; 3]; 3] =
                    std::array::from_fn(|i| std::array::from_fn(|j| factor[(3 + 3 * i + j, k)]));
                Direction {
                    kind: if k < 3 { Kind::Bias } else { Kind::Scale },
                    force: case.matrix(&negated(&mul(a, &model))),
                    offset: case.vector(&mul_vec(a, &bias).map(|v| -v)),
                    rate: [[0.0; 3]; 3],
                }
            })
            .collect(),
    )
}

/// What the calibration changes in samples of `nominal` counts per m/s²: by so much samples are
/// off that were calibrated already when they came.
pub(super) fn applied_twice(file: &CalibrationFile, nominal: f64, axes: &AxisMap) -> Direction {
    let a = &file.accelerometer.matrix;
    let case = Case::new(axes);
    let mut change = a.map(|row| row.map(|v| v * nominal));
    for (i, row) in change.iter_mut().enumerate() {
        row[i] -= 1.0;
    }
    Direction {
        force: case.matrix(&change),
        offset: case.vector(&mul_vec(a, &file.accelerometer.bias).map(|v| -v)),
        ..Direction::NONE
    }
}

/// Directions of an accelerometer of which only a class is known.
pub(super) fn by_class(assumed: &Assumed) -> Vec<Direction> {
    let mut out = Vec::new();
    for i in 0..3 {
        let mut offset = [0.0; 3];
        offset[i] = assumed.bias_mps2;
        out.push(Direction {
            offset,
            ..Direction::NONE
        });
    }
    out.extend(elements(assumed).map(|force| Direction {
        kind: Kind::Scale,
        force,
        ..Direction::NONE
    }));
    out
}

/// Directions of the gyroscope: by its covariance where it has one of M, else
/// by class.
pub(super) fn of_gyroscope(
    file: Option<&CalibrationFile>,
    assumed: &Assumed,
    axes: &AxisMap,
) -> Vec<Direction> {
    let known = file.and_then(|f| f.gyroscope.as_ref()).and_then(|g| {
        let covariance = g.covariance.as_ref().filter(|c| c.parameters.len() >= 9)?;
        let all = square(covariance, covariance.parameters.len())?;
        let factor = factor(&all.view((0, 0), (9, 9)).into_owned())?;
        let case = Case::new(&axes.of_rates());
        Some(
            (0..9)
                .map(|k| {
                    let model: [[f64; 3]; 3] =
                        std::array::from_fn(|i| std::array::from_fn(|j| factor[(3 * i + j, k)]));
                    case.matrix(&negated(&mul(&g.matrix, &model)))
                })
                .collect::<Vec<_>>(),
        )
    });
    known
        .unwrap_or_else(|| elements(assumed).collect())
        .into_iter()
        .map(|rate| Direction {
            kind: Kind::Gyro,
            rate,
            ..Direction::NONE
        })
        .collect()
}

/// One matrix per element of M.
fn elements(assumed: &Assumed) -> impl Iterator<Item = [[f64; 3]; 3]> + use<> {
    let (scale, cross) = (assumed.scale, assumed.cross);
    (0..9).map(move |k| {
        let mut m = [[0.0; 3]; 3];
        m[k / 3][k % 3] = if k / 3 == k % 3 { scale } else { cross };
        m
    })
}

fn negated(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    m.map(|row| row.map(|v| -v))
}

/// A covariance as a matrix, when it is one.
fn square(covariance: &Covariance, size: usize) -> Option<DMatrix<f64>> {
    let rows = &covariance.values;
    let fits = rows.len() == size
        && rows
            .iter()
            .all(|r| r.len() == size && r.iter().all(|v| v.is_finite()));
    fits.then(|| DMatrix::from_fn(size, size, |i, j| rows[i][j]))
}

/// L of C = L Lᵀ. A covariance may be singular: a millionth of each standard
/// deviation is added as independent noise.
fn factor(c: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = c.nrows();
    let sd: Vec<f64> = (0..n).map(|i| c[(i, i)].max(0.0).sqrt()).collect();
    let unit = |s: f64| if s > 0.0 { s } else { 1.0 };
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        let r = 0.5 * (c[(i, j)] + c[(j, i)]) / unit(sd[i]) / unit(sd[j]);
        if i == j { r + 1e-12 } else { r }
    });
    let lower = scaled.cholesky()?.unpack();
    Some(DMatrix::from_fn(n, n, |i, j| {
        if sd[i] > 0.0 {
            sd[i] * lower[(i, j)]
        } else {
            0.0
        }
    }))
}

/// From the board's axes to the case's.
struct Case {
    x: [[f64; 3]; 3],
}

impl Case {
    fn new(axes: &AxisMap) -> Self {
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| axes.to_case(e));
        Case {
            x: transpose(&columns),
        }
    }

    fn vector(&self, v: &[f64; 3]) -> [f64; 3] {
        mul_vec(&self.x, v)
    }

    fn matrix(&self, m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        mul(&mul(&self.x, m), &transpose(&self.x))
    }
}
