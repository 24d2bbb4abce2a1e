//! Elimination block by block against one dense matrix.

use gravical::estimate::solve::{Factor, Jacobian, Options, Problem, Shape, solve};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Linear residuals S x + L z − y in blocks.
#[derive(Debug)]
struct Blocks {
    shared: usize,
    blocks: Vec<Block>,
}

#[derive(Debug)]
struct Block {
    s: DMatrix<f64>,
    l: DMatrix<f64>,
    y: DVector<f64>,
}

impl Blocks {
    /// Blocks of the given (residuals, local parameters), numbers by `seed`.
    fn random(shared: usize, shapes: &[(usize, usize)], seed: u64) -> Blocks {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut number = move || 2.0 * rng.random::<f64>() - 1.0;
        let blocks = shapes
            .iter()
            .map(|&(m, q)| Block {
                s: DMatrix::from_fn(m, shared, |_, _| number()),
                l: DMatrix::from_fn(m, q, |_, _| number()),
                y: DVector::from_fn(m, |_, _| number()),
            })
            .collect();
        Blocks { shared, blocks }
    }

    fn locals(&self) -> usize {
        self.blocks.iter().map(|b| b.l.ncols()).sum()
    }

    fn start(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; self.shared], vec![0.0; self.locals()])
    }

    /// All unknowns, shared ones first, in one matrix.
    fn dense(&self) -> (DMatrix<f64>, DVector<f64>) {
        let rows = self.blocks.iter().map(|b| b.y.len()).sum();
        let mut a = DMatrix::zeros(rows, self.shared + self.locals());
        let mut y = DVector::zeros(rows);
        let (mut at, mut column) = (0, self.shared);
        for block in &self.blocks {
            let (m, q) = block.l.shape();
            a.view_mut((at, 0), (m, self.shared)).copy_from(&block.s);
            a.view_mut((at, column), (m, q)).copy_from(&block.l);
            y.rows_mut(at, m).copy_from(&block.y);
            at += m;
            column += q;
        }
        (a, y)
    }
}

impl Problem for Blocks {
    type State = (Vec<f64>, Vec<f64>);

    fn shared(&self) -> usize {
        self.shared
    }

    fn blocks(&self) -> usize {
        self.blocks.len()
    }

    fn shape(&self, k: usize) -> Shape {
        let (residuals, local) = self.blocks[k].l.shape();
        Shape { residuals, local }
    }

    fn evaluate(&self, state: &Self::State, k: usize, r: &mut [f64], j: Option<Jacobian<'_>>) {
        let block = &self.blocks[k];
        let (m, q) = block.l.shape();
        let before: usize = self.blocks[..k].iter().map(|b| b.l.ncols()).sum();
        for i in 0..m {
            let shared: f64 = (0..self.shared).map(|c| block.s[(i, c)] * state.0[c]).sum();
            let local: f64 = (0..q).map(|c| block.l[(i, c)] * state.1[before + c]).sum();
            r[i] = shared + local - block.y[i];
        }
        if let Some(j) = j {
            for i in 0..m {
                (0..self.shared).for_each(|c| j.shared[i * self.shared + c] = block.s[(i, c)]);
                (0..q).for_each(|c| j.local[i * q + c] = block.l[(i, c)]);
            }
        }
    }

    fn moved(&self, state: &Self::State, shared: &[f64], local: &[f64]) -> Self::State {
        let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x + y).collect();
        (add(&state.0, shared), add(&state.1, local))
    }
}

/// Shapes of blocks: 0 to 3 local parameters, 1 to 4 residuals more.
fn shapes() -> impl Strategy<Value = Vec<(usize, usize)>> {
    prop::collection::vec(
        (1..5_usize, 0..4_usize).prop_map(|(m, q)| (m + q, q)),
        4..12,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn elimination_equals_dense_algebra(shared in 1..5_usize, shapes in shapes(), seed: u64) {
        let problem = Blocks::random(shared, &shapes, seed);
        let (a, y) = problem.dense();
        let svd = a.clone().svd(true, true);
        let condition = svd.singular_values.max() / svd.singular_values.min();
        // More unknowns than residuals, or nearly so, has no one answer.
        prop_assume!(condition < 1e4 && a.nrows() >= a.ncols());
        // By normal equations: nalgebra's singular value decomposition is off by
        // 1e-3 for one such matrix in some thousands.
        let x = a.tr_mul(&a).try_inverse().unwrap() * a.tr_mul(&y);
        let cost = (&a * &x - &y).norm_squared();

        let (state, summary) = solve(&problem, problem.start(), &Options::default());
        prop_assert!(summary.converged(), "{summary:?}");
        let tolerance = 1e-13 * condition * condition * (1.0 + x.norm());
        for (got, want) in state.0.iter().chain(&state.1).zip(x.iter()) {
            prop_assert!((got - want).abs() < tolerance, "{got} {want} {condition} {summary:?}");
        }
        prop_assert!((summary.cost - cost).abs() < 1e-10 * (cost + 1e-6));

        // Covariance: blocks of the dense inverse.
        let inverse = (a.tr_mul(&a)).try_inverse().unwrap();
        let close = |got: f64, want: f64| {
            (got - want).abs() < 1e-13 * condition.powi(2) * inverse.amax()
        };
        let factor = Factor::new(&problem, &state).unwrap();
        let covariance = factor.covariance().values.unwrap();
        for i in 0..shared {
            for j in 0..shared {
                prop_assert!(close(covariance[i][j], inverse[(i, j)]));
            }
        }
        let mut at = shared;
        for nth in 0.. {
            let Some(local) = factor.local_covariance(nth, &covariance) else { break };
            for i in 0..local.len() {
                for j in 0..local.len() {
                    prop_assert!(close(local[i][j], inverse[(at + i, at + j)]));
                }
            }
            at += local.len();
        }
        prop_assert_eq!(at, a.ncols());
    }

    #[test]
    fn a_prior_that_is_a_block_is_a_ridge(shared in 1..6_usize, rows in 1..9_usize, seed: u64, ridge in 0.01..10.0_f64) {
        let mut problem = Blocks::random(shared, &vec![(1, 0); rows], seed);
        let (a, y) = problem.dense();
        problem.blocks.push(Block {
            s: DMatrix::identity(shared, shared) * ridge.sqrt(),
            l: DMatrix::zeros(shared, 0),
            y: DVector::zeros(shared),
        });
        // Fewer rows than unknowns are enough with it.
        let inverse = (a.tr_mul(&a) + DMatrix::identity(shared, shared) * ridge)
            .try_inverse()
            .unwrap();
        let x = &inverse * a.tr_mul(&y);
        let (state, summary) = solve(&problem, problem.start(), &Options::default());
        prop_assert!(summary.converged(), "{summary:?}");
        let covariance = Factor::new(&problem, &state).unwrap().covariance().values.unwrap();
        for i in 0..shared {
            prop_assert!((state.0[i] - x[i]).abs() < 1e-11 * (1.0 + x.norm()));
            for j in 0..shared {
                prop_assert!((covariance[i][j] - inverse[(i, j)]).abs() < 1e-11 * inverse.amax());
            }
        }
    }
}
