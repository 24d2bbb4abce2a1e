//! The fit so far: poses, what is held, and the parameters by Gauss–Newton.

use nalgebra::Matrix3;

use crate::model::{NONLINEARITY, Parameters, matrix};
use crate::rows::{Hyperparameters, Linear, PoseState, Solution, free_parameters};

/// Steps of the search for the parameters.
const MAX_STEPS: usize = 40;
/// Rounds in which roles and variances settle.
pub(super) const MAX_ROUNDS: usize = 8;

/// The fit so far.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    pub poses: Vec<PoseState>,
    /// Place among them of every pose that was given: repeats are merged.
    pub place_of: Vec<usize>,
    /// Input unit per working unit.
    pub scale: f64,
    /// Mean temperature of the poses, °C.
    pub reference_c: f64,
    pub held: Hyperparameters,
    /// Geometric mean of the likely spreads of the nonlinearity; `held` has their root mean square.
    pub typical_nonlinearity: f64,
    /// Without nonlinearity.
    pub is_linear: bool,
    /// Tilt that was given, rad.
    pub tilt: Option<f64>,
    /// The channel along each axis of the case.
    pub channel_of: [usize; 3],
    pub x: Parameters,
}

/// Parameters at which the search came to rest, the problem linearised there, and its solution.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub linear: Linear,
    pub solution: Solution,
}

impl Search {
    /// What parameters are estimated with. What is claimed of them has to allow for all nonlinearity that is
    /// likely, and `held` has their mean square; with that the parameters would trust directions across
    /// an axis, which no nonlinearity changes, more than is usually right.
    pub fn estimating(&self) -> Hyperparameters {
        Hyperparameters {
            nonlinearity_sd: self.typical_nonlinearity,
            ..self.held
        }
    }

    /// The same without nonlinearity.
    pub fn without_nonlinearity(&self) -> Search {
        let mut search = self.clone();
        (
            search.is_linear,
            search.typical_nonlinearity,
            search.held.nonlinearity_sd,
        ) = (true, 0.0, 0.0);
        search
    }

    pub fn is_oriented(&self) -> bool {
        let counted = self.poses.iter().filter(|p| p.bad.is_none());
        let mut faces = counted.filter_map(|p| p.face);
        let first = faces.next();
        first.is_some_and(|first| faces.any(|face| face.axis != first.axis))
    }

    /// Gauss–Newton with the weights of the present parameters; steps are halved until they help.
    pub fn fit(&self, held: &Hyperparameters) -> Option<Found> {
        let oriented = self.is_oriented();
        let free = free_parameters(oriented, self.channel_of, held);
        let mut x = self.x;
        if held.nonlinearity_sd == 0.0 {
            x.fixed_rows_mut::<6>(NONLINEARITY).fill(0.0);
        }
        if !oriented {
            upper_triangular(&mut x, self.channel_of)?;
        }
        let mut found: Option<Found> = None;
        for _ in 0..MAX_STEPS {
            let linear = Linear::new(&self.poses, &x, (oriented, &free), held)?;
            let solution = linear.solve_poses(held, |_| true)?;
            let now = linear.cost_at(&self.poses, &x, held)?;
            let no_worse = |x: &Parameters| {
                let cost = linear.cost_at(&self.poses, x, held);
                cost.is_some_and(|cost| cost <= now * (1.0 + 1e-9))
            };
            let shares = (0..14).map(|i| 0.5_f64.powi(i));
            let next = shares.map(|share| x + share * solution.step).find(no_worse);
            let converged = solution.decrement < 1e-3 || next.is_none();
            found = Some(Found { linear, solution });
            match next {
                Some(next) if !converged => x = next,
                _ => break,
            }
        }
        found
    }
}

/// M = U Q with U upper triangular in the axes of the channels, by a Cholesky decomposition of M Mᵀ = U Uᵀ
/// from its last row up: turns the frame of the case, which no length tells.
fn upper_triangular(x: &mut Parameters, channel_of: [usize; 3]) -> Option<()> {
    let m = matrix(x);
    let flip = |m: Matrix3<f64>| Matrix3::from_fn(|r, c| m[(2 - r, 2 - c)]);
    let upper = flip(flip(m * m.transpose()).cholesky()?.l());
    for (axis, channel) in channel_of.into_iter().enumerate() {
        let sign = m[(channel, axis)].signum();
        for r in 0..3 {
            x[3 * r + axis] = sign * upper[(r, channel)];
        }
    }
    x.iter().all(|v| v.is_finite()).then_some(())
}
