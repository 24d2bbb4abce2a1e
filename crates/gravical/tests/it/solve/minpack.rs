//! Against the crate `levenberg-marquardt`, a translation of MINPACK.
//!
//! MINPACK stops where the sum of squares changes by rounding, 1e-16, and a
//! parameter by the root of that over its condition, about 1e-8. What it leaves
//! is its own: the certified digits of `nist` are reached.

use gravical::estimate::solve::{Jacobian, Options, Problem, Shape, solve};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_034::{DMatrix, DVector, Dyn, Owned};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::dual::{Dual, dual};
use super::problems::Nist;

/// Residuals with derivatives, for both solvers.
trait Model {
    fn rows(&self) -> usize;
    fn residual(&self, b: &[f64], i: usize) -> Dual;
}

impl Model for Nist {
    fn rows(&self) -> usize {
        Nist::rows(self)
    }

    fn residual(&self, b: &[f64], i: usize) -> Dual {
        Nist::residual(self, b, i)
    }
}

struct Theirs<'a, M> {
    model: &'a M,
    at: DVector<f64>,
}

impl<M: Model> LeastSquaresProblem<f64, Dyn, Dyn> for Theirs<'_, M> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let of = |i, _| self.model.residual(self.at.as_slice(), i).value;
        Some(DVector::from_fn(self.model.rows(), of))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let of = |i, j: usize| self.model.residual(self.at.as_slice(), i).by[j];
        Some(DMatrix::from_fn(self.model.rows(), self.at.len(), of))
    }
}

/// Where MINPACK ends, and the sum of squares there.
fn theirs<M: Model>(model: &M, start: &[f64]) -> (Vec<f64>, f64) {
    let problem = Theirs {
        model,
        at: DVector::from_column_slice(start),
    };
    let solver = LevenbergMarquardt::new()
        .with_ftol(f64::EPSILON)
        .with_xtol(f64::EPSILON)
        .with_gtol(f64::EPSILON)
        .with_patience(500);
    let (problem, report) = solver.minimize(problem);
    (
        problem.at.as_slice().to_vec(),
        2.0 * report.objective_function,
    )
}

/// Greatest difference, relative.
fn difference(ours: &[f64], theirs: &[f64]) -> f64 {
    ours.iter()
        .zip(theirs)
        .map(|(a, b)| (a - b).abs() / b.abs().max(1e-3))
        .fold(0.0, f64::max)
}

#[test]
fn the_same_minimum_of_nists_problems() {
    for name in [
        "Chwirut2", "DanWood", "Gauss1", "Gauss2", "Gauss3", "Hahn1", "Kirby2", "MGH09", "Misra1a",
        "Misra1c", "Rat42", "Rat43", "Roszman1", "Thurber",
    ] {
        let problem = Nist::read(name);
        let start = &problem.starts[1];
        let (ours, summary) = solve(&problem, start.clone(), &Options::default());
        assert!(summary.converged(), "{name}: {summary:?}");
        let (theirs, cost) = theirs(&problem, start);
        let (off, cost) = (difference(&ours, &theirs), summary.cost / cost - 1.0);
        println!("{name}: parameters {off:.1e}, cost {cost:.1e}");
        assert!(off < 1e-7 && cost.abs() < 1e-12, "{name}: {off} {cost}");
    }
}

/// y = b₀ e^(−b₁x) + b₂ sin(b₃x + b₄) with noise.
struct Wave {
    y: Vec<f64>,
}

impl Wave {
    fn value(b: &[Dual], i: usize) -> Dual {
        let x = 0.2 * i as f64;
        b[0] * (-b[1] * x).exp() + b[2] * (b[3] * x + b[4]).sin()
    }
}

impl Model for Wave {
    fn rows(&self) -> usize {
        self.y.len()
    }

    fn residual(&self, b: &[f64], i: usize) -> Dual {
        let b: Vec<Dual> = (0..b.len()).map(|j| Dual::parameter(b[j], j)).collect();
        Wave::value(&b, i) - self.y[i]
    }
}

impl Problem for Wave {
    type State = Vec<f64>;

    fn shared(&self) -> usize {
        5
    }

    fn blocks(&self) -> usize {
        self.y.len()
    }

    fn shape(&self, _: usize) -> Shape {
        Shape {
            residuals: 1,
            local: 0,
        }
    }

    fn evaluate(&self, b: &Vec<f64>, i: usize, r: &mut [f64], jacobian: Option<Jacobian<'_>>) {
        let residual = self.residual(b, i);
        r[0] = residual.value;
        if let Some(j) = jacobian {
            j.shared.copy_from_slice(&residual.by[..5]);
        }
    }

    fn moved(&self, b: &Vec<f64>, step: &[f64], _: &[f64]) -> Vec<f64> {
        b.iter().zip(step).map(|(b, s)| b + s).collect()
    }
}

#[test]
fn the_same_minimum_of_random_problems() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        let mut within = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let truth = [
            within(1.0, 5.0),
            within(0.2, 1.0),
            within(0.5, 3.0),
            within(0.8, 2.5),
            within(-1.0, 1.0),
        ];
        let start: Vec<f64> = truth.iter().map(|t| t + 0.1 * within(-1.0, 1.0)).collect();
        let y = (0..60)
            .map(|i| {
                Wave::value(&truth.map(dual), i).value + 0.1 * rng.sample::<f64, _>(StandardNormal)
            })
            .collect();
        let problem = Wave { y };
        let (ours, summary) = solve(&problem, start.clone(), &Options::default());
        assert!(summary.converged(), "{summary:?}");
        let (theirs, cost) = theirs(&problem, &start);
        let off = difference(&ours, &theirs);
        let lost = summary.cost / cost - 1.0;
        assert!(off < 1e-7 && lost.abs() < 1e-12, "{off} {lost} {summary:?}");
        worst = worst.max(off);
    }
    println!("parameters differ by {worst:.1e} at the most");
}
