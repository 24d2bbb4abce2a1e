//! The second order of the fit: where the mean of the posterior lies beside its
//! maximum, and what spread the linearised covariance does not know of.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::solve::Problem;

use super::fit::Fit;
use super::model::Rows;

/// The quantities that are corrected: lengths of the rows of M, then b.
const QUANTITIES: usize = 6;

/// Second-order terms of the scales k (row norms of M) and biases b.
pub(super) struct SecondOrder {
    /// Posterior mean less maximum, input unit (per m/s² of k).
    shift: [f64; QUANTITIES],
    /// Covariance beyond the linearised one.
    covariance: [[f64; QUANTITIES]; QUANTITIES],
}

/// A block of the problem in coordinates in which its local parameters are
/// independent of the shared ones: x_local = A x_shared + w.
struct Block {
    /// Derivatives of the rows by the shared parameters in these coordinates.
    shared: DMatrix<f64>,
    /// Second derivatives of every row by (shared, w).
    second: Vec<DMatrix<f64>>,
    /// Covariance of w.
    own: DMatrix<f64>,
}

/// Second-order terms at the minimum `found`; none without a covariance.
///
/// A tilt of δ shortens what its axis reads by δ²/2 whatever its sign, and six
/// faces do not tell half of the tilts from misalignment: the most likely
/// tilts are too small, always, and with them the scales.
///
/// With residuals r + Jz + ½H(z, z) the step x = z + ½Γ(z, z), Γ = −C JᵀH,
/// makes the residuals linear along everything that parameters can follow
/// (Bates and Watts, J. R. Stat. Soc. B 42 (1980) 1: the parameter-effects
/// curvature), so that z is normal with covariance C but for the density of the
/// map, which moves its mean by C g, g_c = −Σ (C J_i)_a H_i,ac. A quantity q(x)
/// with gradient ∇q and second derivatives D is ∇q z + ½ zᵀQz,
/// Q = Σ λ_i H_i + D, λ = −J C ∇q: its mean moves by ∇q C g + ½ tr(Q C), its
/// variance gains ½ tr(Q C Q C).
pub(super) fn second_order(found: &Fit) -> Option<SecondOrder> {
    let values = found.covariance.values.as_ref()?;
    let model = &found.model;
    let p = model.shared();
    let c = DMatrix::from_fn(p, p, |i, j| values[i][j]);
    let blocks: Option<Vec<(Block, DVector<f64>)>> = (0..model.blocks())
        .map(|block| Block::at(found, block, &c))
        .collect();
    let (blocks, density): (Vec<Block>, Vec<DVector<f64>>) = blocks?.into_iter().unzip();
    let moved: DVector<f64> = &c * density.iter().sum::<DVector<f64>>();
    let quantities = quantities(found);
    let curved: Vec<Curved> = quantities
        .iter()
        .map(|(gradient, second)| Curved::of(&blocks, &c, gradient, second))
        .collect();
    let out = SecondOrder {
        shift: std::array::from_fn(|a| {
            quantities[a].0.dot(&moved) + 0.5 * curved[a].trace(&c, &blocks)
        }),
        covariance: std::array::from_fn(|a| {
            std::array::from_fn(|b| 0.5 * curved[a].product(&curved[b], &c, &blocks))
        }),
    };
    let finite = |v: &f64| v.is_finite();
    (out.shift.iter().all(finite) && out.covariance.iter().flatten().all(finite)).then_some(out)
}

/// Gradient and second derivatives of every quantity by the shared parameters.
fn quantities(found: &Fit) -> Vec<(DVector<f64>, DMatrix<f64>)> {
    let elements = found.model.list();
    let p = elements.len();
    (0..QUANTITIES)
        .map(|a| {
            if a >= 3 {
                let gradient = DVector::from_fn(p, |i, _| f64::from(elements[i] == 6 + a));
                return (gradient, DMatrix::zeros(p, p));
            }
            let row = found.state.m[a];
            let k = matrix3::norm(&row);
            // Of element i when it stands in this row.
            let unit = |i: usize| {
                let e = elements[i];
                if e < 9 && e / 3 == a {
                    row[e % 3] / k
                } else {
                    0.0
                }
            };
            let own = |i: usize| elements[i] < 9 && elements[i] / 3 == a;
            let gradient = DVector::from_fn(p, |i, _| unit(i));
            let second = DMatrix::from_fn(p, p, |i, j| {
                (f64::from(i == j && own(i)) - unit(i) * unit(j)) / k
            });
            (gradient, second)
        })
        .collect()
}

impl Block {
    /// The block at the minimum, and its part of g by the shared parameters.
    fn at(found: &Fit, block: usize, c: &DMatrix<f64>) -> Option<(Block, DVector<f64>)> {
        let model = &found.model;
        let p = model.shared();
        let Rows { shared, local, .. } = model.rows(&found.state, block);
        let q = local.ncols();
        let own = local.tr_mul(&local).try_inverse()?;
        let follows = -&own * local.tr_mul(&shared);
        let shared = shared + &local * &follows;
        let mut turn = DMatrix::identity(p + q, p + q);
        turn.view_mut((p, 0), (q, p)).copy_from(&follows);
        let second: Vec<DMatrix<f64>> = model
            .second_derivatives(&found.state, block)
            .into_iter()
            .map(|h| turn.tr_mul(&h) * &turn)
            .collect();
        let mut density = DVector::zeros(p);
        for (row, h) in second.iter().enumerate() {
            let along = c * shared.row(row).transpose();
            let aside = &own * local.row(row).transpose();
            density -= h.view((0, 0), (p, p)) * along + h.view((0, p), (p, q)) * aside;
        }
        let block = Block {
            shared,
            second,
            own,
        };
        Some((block, density))
    }
}

/// The quadratic form Q of one quantity: over the shared parameters, and for each
/// block what has to do with its w.
struct Curved {
    shared: DMatrix<f64>,
    /// Over (shared, w) of a block; its shared part is in `shared`.
    blocks: Vec<DMatrix<f64>>,
}

impl Curved {
    fn of(
        blocks: &[Block],
        c: &DMatrix<f64>,
        gradient: &DVector<f64>,
        second: &DMatrix<f64>,
    ) -> Curved {
        let p = c.nrows();
        let follows = c * gradient;
        let mut shared = second.clone();
        let blocks = blocks
            .iter()
            .map(|block| {
                let size = p + block.own.nrows();
                let mut sum = DMatrix::zeros(size, size);
                for (row, h) in block.second.iter().enumerate() {
                    sum -= h * block.shared.row(row).transpose().dot(&follows);
                }
                shared += sum.view((0, 0), (p, p));
                sum
            })
            .collect();
        Curved { shared, blocks }
    }

    /// tr(Q C).
    fn trace(&self, c: &DMatrix<f64>, blocks: &[Block]) -> f64 {
        let p = c.nrows();
        let own = |(q, block): (&DMatrix<f64>, &Block)| {
            let size = block.own.nrows();
            q.view((p, p), (size, size)).component_mul(&block.own).sum()
        };
        self.shared.component_mul(c).sum() + self.blocks.iter().zip(blocks).map(own).sum::<f64>()
    }

    /// tr(Q C Q′ C).
    fn product(&self, other: &Curved, c: &DMatrix<f64>, blocks: &[Block]) -> f64 {
        let p = c.nrows();
        let mut sum = (&self.shared * c)
            .component_mul(&(&other.shared * c).transpose())
            .sum();
        for ((a, b), block) in self.blocks.iter().zip(&other.blocks).zip(blocks) {
            let q = block.own.nrows();
            let (mixed_a, mixed_b) = (a.view((0, p), (p, q)), b.view((0, p), (p, q)));
            sum += 2.0 * (c * mixed_a * &block.own).component_mul(&mixed_b).sum();
            sum += (a.view((p, p), (q, q)) * &block.own)
                .component_mul(&(b.view((p, p), (q, q)) * &block.own).transpose())
                .sum();
        }
        sum
    }
}

impl SecondOrder {
    /// M and b at the posterior mean. Angles between the rows stay: what they
    /// gain is nothing beside their own uncertainty.
    pub fn mean(&self, m: &[[f64; 3]; 3], b: &[f64; 3]) -> ([[f64; 3]; 3], [f64; 3]) {
        let scaled =
            std::array::from_fn(|i| m[i].map(|v| v * (1.0 + self.shift[i] / matrix3::norm(&m[i]))));
        (scaled, std::array::from_fn(|i| b[i] + self.shift[3 + i]))
    }

    /// Its part of the covariance of (M, b).
    pub fn covariance(&self, m: &[[f64; 3]; 3]) -> [[f64; 12]; 12] {
        // An element follows its row's length by its share of it, a bias itself.
        let follows = |element: usize| match element {
            0..9 => (
                element / 3,
                m[element / 3][element % 3] / matrix3::norm(&m[element / 3]),
            ),
            _ => (element - 6, 1.0),
        };
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let ((a, x), (b, y)) = (follows(i), follows(j));
                x * y * self.covariance[a][b]
            })
        })
    }
}
