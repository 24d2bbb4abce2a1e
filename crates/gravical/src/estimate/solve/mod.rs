//! Nonlinear least squares: Levenberg–Marquardt in square-root form.
//!
//! # Overview
//!
//! A [`Problem`] has p *shared* parameters and residuals in *blocks*. A block
//! may have a few *local* parameters that no other block knows: the tilt of one
//! placement, the direction of one free pose. They are eliminated block by block
//! with an orthogonal transformation before the shared parameters are solved
//! for, so that a hundred poses cost a hundred small factorisations and one of
//! size p. The normal equations are never formed: squaring the Jacobian would
//! square its condition number.
//!
//! Priors are residuals like any other: a block without data. A [`Loss`] acts on
//! the length of a whole block, which is then kept or distrusted as one.
//!
//! [`solve`] returns the state and a [`Summary`]; [`Factor`] of the solution
//! answers what follows from it: rank, condition, covariance.
//!
//! Sources: Marquardt, SIAM J. Appl. Math. 11 (1963) 431; Nielsen, Damping
//! parameter in Marquardt's method, IMM-REP-1999-05; Demmel et al., Square root
//! bundle adjustment, CVPR 2021, for the elimination.
//!
//! # Example
//!
//! ```
//! use gravical::estimate::solve::{Jacobian, Options, Problem, Shape, solve};
//!
//! /// y = a·exp(b·x).
//! struct Decay { x: Vec<f64>, y: Vec<f64> }
//!
//! impl Problem for Decay {
//!     type State = [f64; 2];
//!     fn shared(&self) -> usize { 2 }
//!     fn blocks(&self) -> usize { self.x.len() }
//!     fn shape(&self, _block: usize) -> Shape { Shape { residuals: 1, local: 0 } }
//!     fn evaluate(&self, s: &[f64; 2], i: usize, r: &mut [f64], j: Option<Jacobian<'_>>) {
//!         let e = (s[1] * self.x[i]).exp();
//!         r[0] = s[0] * e - self.y[i];
//!         if let Some(j) = j {
//!             j.shared.copy_from_slice(&[e, s[0] * self.x[i] * e]);
//!         }
//!     }
//!     fn moved(&self, s: &[f64; 2], shared: &[f64], _local: &[f64]) -> [f64; 2] {
//!         [s[0] + shared[0], s[1] + shared[1]]
//!     }
//! }
//!
//! let x: Vec<f64> = (0..10).map(f64::from).collect();
//! let y = x.iter().map(|x| 5.0 * (-0.3 * x).exp()).collect();
//! let (found, summary) = solve(&Decay { x, y }, [1.0, -1.0], &Options::default());
//! assert!(summary.converged() && (found[1] + 0.3).abs() < 1e-9);
//! ```

mod factor;
mod levenberg;
mod loss;

pub use factor::{Covariance, Factor};
pub use levenberg::solve;
pub use loss::Loss;

/// How many residuals and local parameters a block has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Residuals m.
    pub residuals: usize,
    /// Local parameters q ≤ m. The residuals have to determine them when the
    /// shared parameters are held.
    pub local: usize,
}

/// Derivatives of a block's residuals, row-major, zero on entry.
#[derive(Debug)]
pub struct Jacobian<'a> {
    /// m × p, after the shared parameters.
    pub shared: &'a mut [f64],
    /// m × q, after the block's local ones.
    pub local: &'a mut [f64],
}

/// A sum of squares to be made small.
///
/// Residuals are whitened: divided by their standard deviation where that is
/// known. A residual or derivative that is not finite makes a trial step fail,
/// and a start fail for good.
pub trait Problem {
    /// Where the parameters are. It may be curved (a direction on the sphere);
    /// steps are taken by [`moved`](Self::moved).
    type State: Clone;

    /// Number p of shared parameters.
    fn shared(&self) -> usize;

    /// Number of blocks.
    fn blocks(&self) -> usize;

    /// Shape of a block, the same at every state.
    fn shape(&self, block: usize) -> Shape;

    /// Residuals of a block, and their derivatives by a step from `state`.
    fn evaluate(
        &self,
        state: &Self::State,
        block: usize,
        residuals: &mut [f64],
        jacobian: Option<Jacobian<'_>>,
    );

    /// The state after a step; `local` holds the steps of all blocks one after
    /// the other.
    fn moved(&self, state: &Self::State, shared: &[f64], local: &[f64]) -> Self::State;

    /// What is done to the length of a block's residuals. Default: squared.
    fn loss(&self, _block: usize) -> Loss {
        Loss::Squared
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Steps tried at the most, those that failed included. Default 200.
    pub most_steps: usize,
    /// Converged when a step would change the cost by less than this share of
    /// it. Default 1e-20: near a minimum the cost hardly changes while the
    /// parameters still do.
    pub cost_tolerance: f64,
    /// Converged when no column of the Jacobian has a cosine above this with
    /// the residuals. Default 1e-12.
    pub gradient_tolerance: f64,
    /// Converged when the scaled step is shorter than this share of the
    /// parameters moved so far. Default 1e-13.
    pub step_tolerance: f64,
    /// Damping at the start, relative to the scaled Jacobian. Default 1e-4. Up
    /// to 100 and more for a start whose linearisation is worth little (steps
    /// begin short), down to 1e-8 to begin with Gauss and Newton.
    pub damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            most_steps: 200,
            cost_tolerance: 1e-20,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-13,
            damping: 1e-4,
        }
    }
}

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The residuals are orthogonal to every column of the Jacobian.
    Gradient,
    /// No step promises a smaller cost.
    Cost,
    /// Steps have become too short to matter.
    Step,
    /// [`Options::most_steps`] were tried.
    MostSteps,
    /// Residuals or derivatives of the start are not finite, or a block does not
    /// determine its local parameters.
    NotFinite,
}

/// How a search went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Why it ended.
    pub ending: Ending,
    /// Steps that were taken.
    pub accepted: usize,
    /// Steps that were tried.
    pub tried: usize,
    /// Sum of squared residuals at the start, losses applied.
    pub first_cost: f64,
    /// … and at the end.
    pub cost: f64,
}

impl Summary {
    /// True when the search ended at a minimum (or saddle) rather than for want
    /// of steps or of numbers.
    #[must_use]
    pub fn converged(&self) -> bool {
        matches!(self.ending, Ending::Gradient | Ending::Cost | Ending::Step)
    }
}
