//! The fit itself: robustly to find out which motions can be believed, then by
//! generalised least squares on those.
//!
//! Gauss–Newton: one pass over the samples makes all residuals linear, and
//! everything robust happens on the linear problem, where a step costs nothing.

use nalgebra::{Matrix3, SMatrix};

use super::motions::Motions;
use super::problem::{Alone, Chained, Delta, Linear, PARAMETERS, Prior, State};
use crate::estimate::solve::{Factor, Loss, Options, solve};
use crate::stats::median;

/// Covariance of E and β.
pub(super) type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// What the fit needs to know beside the motions; angles in rad, rates in rad/s
/// by the nominal scale.
pub(super) struct Known {
    /// Covariance of the direction of gravity in each still.
    pub spread: Vec<Matrix3<f64>>,
    /// Allan N of the gyroscope, rad/√s.
    pub noise: f64,
    /// What is not known of the bias during a motion, sd.
    pub drift: f64,
    /// Standard error of the bias.
    pub beta_sigma: [f64; 3],
}

/// Parameters, their covariance and how well they fit.
pub(super) struct Fit {
    pub state: State,
    /// None where the rank is not full.
    pub covariance: Option<Covariance>,
    /// Indices of the motions that were used.
    pub kept: Vec<usize>,
    /// … and of those that contradict them.
    pub outliers: Vec<usize>,
    /// Length of every kept residual.
    pub residuals: Vec<f64>,
    /// The same when the motion takes no part.
    pub left_out: Option<Vec<f64>>,
    /// Variance per component that noise does not explain.
    more: f64,
    /// The last step.
    step: Delta,
}

/// No direction and no turn is known better, rad: 0.00006°.
const FLOOR: f64 = 1e-6;

/// A residual this many times the usual one contradicts the others.
const OUTLIER: f64 = 6.0;

/// A motion is an outlier when it misses its prediction by this many standard
/// deviations: one in a thousand does with five degrees of freedom.
const SURPRISE: f64 = 5.0;

/// Median length of two components that are normal with unit variance.
const RAYLEIGH_MEDIAN: f64 = 1.1774;

/// Width of Cauchy's loss, 95 % as efficient as least squares on normal
/// residuals.
const CAUCHY: f64 = 2.385;

/// A pass that moves no residual by more than this share of the usual one is
/// the last.
const SETTLED: f64 = 0.01;

/// Passes over the samples; three are usual.
const MOST_PASSES: usize = 15;

/// The linear problems need no more digits than noise leaves.
const SEARCH: Options = Options {
    most_steps: 30,
    cost_tolerance: 1e-10,
    gradient_tolerance: 1e-8,
    step_tolerance: 1e-6,
    damping: 1e-9,
};

/// A robust solution, linear there.
pub(super) struct Robust {
    pub state: State,
    pub linear: Vec<Linear>,
    /// Median length of the residuals, rad.
    pub typical: f64,
}

/// Motions with what is known of their noise.
pub(super) struct Setup<'a> {
    motions: &'a Motions,
    known: &'a Known,
    /// Standard deviation of a component of every residual.
    sigma: Vec<f64>,
}

impl<'a> Setup<'a> {
    pub(super) fn new(motions: &'a Motions, known: &'a Known) -> Self {
        let sigma = motions
            .list
            .iter()
            .map(|m| {
                let ends =
                    0.5 * (known.spread[m.still].trace() + known.spread[m.still + 1].trace());
                (ends + own_variance(m.seconds, known)).sqrt()
            })
            .collect();
        Setup {
            motions,
            known,
            sigma,
        }
    }

    fn prior(&self, state: &State) -> Prior {
        Prior {
            beta: state.beta,
            sigma: self.known.beta_sigma,
        }
    }

    fn alone<'b>(&'b self, linear: &'b [Linear], state: &State, loss: Loss) -> Alone<'b> {
        Alone {
            linear,
            sigma: &self.sigma,
            prior: self.prior(state),
            loss,
        }
    }

    /// Median of whitened residuals over that of noise, at least 1.
    fn excess(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        let mut whitened: Vec<f64> = residuals.zip(&self.sigma).map(|(r, s)| r / s).collect();
        (median(&mut whitened).unwrap_or(1.0) / RAYLEIGH_MEDIAN).max(1.0)
    }

    /// Covariance by noise alone at `state`: what the motions can determine at
    /// best.
    pub(super) fn expected_covariance(&self, at: &Robust) -> Option<Covariance> {
        let problem = self.alone(&at.linear, &at.state, Loss::Squared);
        dense(&Factor::new(&problem, &Delta::zeros())?)
    }

    /// The residuals at a state.
    pub(super) fn at(&self, state: State) -> Robust {
        let linear = Linear::all(self.motions, &state);
        let mut lengths: Vec<f64> = linear.iter().map(|l| l.residual.norm()).collect();
        Robust {
            state,
            typical: median(&mut lengths).unwrap_or(f64::NAN),
            linear,
        }
    }

    /// Minimises Cauchy's loss from `start`, its width following the residuals.
    pub(super) fn robust(&self, start: Robust) -> Robust {
        let mut best = start;
        let mut share = 1.0;
        for _ in 0..MOST_PASSES {
            let step = share * self.robust_step(&best);
            let moves = best
                .linear
                .iter()
                .map(|l| (l.jacobian * step).norm())
                .fold(0.0, f64::max);
            let next = self.at(best.state.moved(&step));
            // Far from the answer a linear step may lead astray.
            if next.typical.is_nan() || next.typical > 1.5 * best.typical {
                share *= 0.3;
                if share < 0.01 {
                    break;
                }
                continue;
            }
            share = 1.0;
            best = next;
            if moves < SETTLED * best.typical.max(FLOOR) {
                break;
            }
        }
        best
    }

    fn robust_step(&self, at: &Robust) -> Delta {
        let mut step = Delta::zeros();
        let mut width = self.excess(at.linear.iter().map(|l| l.residual.norm()));
        for _ in 0..6 {
            let problem = self.alone(&at.linear, &at.state, Loss::Cauchy(CAUCHY * width));
            step = solve(&problem, step, &SEARCH).0;
            let now = self.excess(at.linear.iter().map(|l| l.after(&step).norm()));
            let settled = (now / width - 1.0).abs() < 0.1;
            width = now;
            if settled {
                break;
            }
        }
        step
    }

    /// Judges the motions at a robust solution and fits those that agree. Where
    /// the motions are few, a robust fit may follow some of them too closely; so
    /// what it calls an outlier is heard again, against what the others predict
    /// for it and how well.
    pub(super) fn fit(&self, robust: Robust) -> Option<Fit> {
        let lengths: Vec<f64> = robust.linear.iter().map(|l| l.residual.norm()).collect();
        let (mut kept, mut outliers) = self.judge(&lengths);
        let mut at = robust;
        let mut passes = 0;
        loop {
            let (fit, moves) = self.fit_kept(&at, &kept, &outliers)?;
            passes += 1;
            let back: Vec<usize> = match &fit.covariance {
                Some(c) => outliers
                    .iter()
                    .copied()
                    .filter(|&m| self.surprise(&at.linear[m], &fit, c, m) < SURPRISE)
                    .collect(),
                None => Vec::new(),
            };
            let usual = median(&mut fit.residuals.clone())
                .unwrap_or(FLOOR)
                .max(FLOOR);
            if passes == MOST_PASSES || (back.is_empty() && moves < SETTLED * usual) {
                return Some(fit);
            }
            outliers.retain(|m| !back.contains(m));
            kept.extend(back);
            kept.sort_unstable();
            at = self.at(fit.state);
        }
    }

    /// Length of a residual in standard deviations of its prediction by a fit
    /// that it took no part in.
    fn surprise(&self, linear: &Linear, fit: &Fit, covariance: &Covariance, m: usize) -> f64 {
        let own = self.sigma[m].powi(2) + fit.more;
        let predicted = linear.jacobian * covariance * linear.jacobian.transpose()
            + Matrix3::from_diagonal_element(own);
        let residual = linear.after(&fit.step);
        predicted
            .cholesky()
            .map_or(f64::INFINITY, |c| c.solve(&residual).dot(&residual).sqrt())
    }

    /// Generalised least squares on `kept`, and how far its step moves any
    /// residual.
    fn fit_kept(&self, at: &Robust, kept: &[usize], outliers: &[usize]) -> Option<(Fit, f64)> {
        let freedom = 2.0 * kept.len() as f64 - 9.0;
        if freedom < 3.0 {
            return None;
        }
        // What the residuals show must not be that of a start that is off.
        let first = self.chained(at, kept, 0.0)?;
        let (step, _) = solve(&first, Delta::zeros(), &SEARCH);
        let lengths: Vec<f64> = at.linear.iter().map(|l| l.after(&step).norm()).collect();
        let more = self.unexplained(kept, &lengths, freedom);
        let problem = self.chained(at, kept, more)?;
        let (step, summary) = solve(&problem, step, &SEARCH);
        // Where the residuals say how large they are, few of them say it
        // badly: the variance of Student's t.
        let wide = if more > 0.0 {
            freedom / (freedom - 2.0)
        } else {
            1.0
        };
        let covariance = dense(&Factor::new(&problem, &step)?)
            .map(|c| c * (summary.cost / freedom).max(1.0) * wide);
        let moves = kept
            .iter()
            .map(|&m| (at.linear[m].jacobian * step).norm())
            .fold(0.0, f64::max);
        let fit = Fit {
            left_out: self.leave_one_out(at, kept, more),
            state: at.state.moved(&step),
            covariance,
            residuals: kept
                .iter()
                .map(|&m| at.linear[m].after(&step).norm())
                .collect(),
            kept: kept.to_vec(),
            outliers: outliers.to_vec(),
            more,
            step,
        };
        Some((fit, moves))
    }

    fn chained(&self, at: &Robust, kept: &[usize], more: f64) -> Option<Chained> {
        let own: Vec<f64> = self
            .motions
            .list
            .iter()
            .map(|m| own_variance(m.seconds, self.known) + more)
            .collect();
        let spread = &self.known.spread;
        let prior = self.prior(&at.state);
        Chained::new(self.motions, &at.linear, kept, spread, &own, prior)
    }

    /// Motions that agree, and motions that do not.
    fn judge(&self, lengths: &[f64]) -> (Vec<usize>, Vec<usize>) {
        let all = lengths.len();
        // Nine parameters swallow part of few residuals.
        let swallowed = (2.0 * all as f64 / (2.0 * all as f64 - 9.0).max(1.0)).sqrt();
        let limit = OUTLIER * swallowed * self.excess(lengths.iter().copied());
        let (kept, outliers): (Vec<usize>, Vec<usize>) =
            (0..all).partition(|&m| lengths[m] <= limit * self.sigma[m]);
        if 2 * kept.len() < 9 + 6 || outliers.len() * 5 > all {
            // Too few, or too many, to call any of them wrong.
            return ((0..all).collect(), Vec::new());
        }
        (kept, outliers)
    }

    /// Variance per component that noise does not explain, the same for every
    /// motion (a hand that trembles, a gyroscope that is not linear): so that
    /// the weighted squares are what their number lets expect (Paule and
    /// Mandel).
    fn unexplained(&self, kept: &[usize], lengths: &[f64], freedom: f64) -> f64 {
        let squares = |more: f64| -> f64 {
            kept.iter()
                .map(|&m| lengths[m].powi(2) / (self.sigma[m].powi(2) + more))
                .sum()
        };
        if squares(0.0) <= freedom {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, kept.iter().map(|&m| lengths[m].powi(2)).sum::<f64>());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if squares(middle) > freedom {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Length of each residual after one step without it: the parameters move
    /// by so little that the linear answer is the answer.
    fn leave_one_out(&self, at: &Robust, kept: &[usize], more: f64) -> Option<Vec<f64>> {
        if 2 * kept.len() < 9 + 4 {
            return None;
        }
        let weight = |m: usize| 1.0 / (self.sigma[m].powi(2) + more);
        let mut normal = Covariance::zeros();
        let mut pull = Delta::zeros();
        for i in 0..3 {
            let w = self.known.beta_sigma[i].powi(-2);
            normal[(9 + i, 9 + i)] += w;
            pull[9 + i] += w * at.state.beta[i];
        }
        for &m in kept {
            let l = &at.linear[m];
            normal += weight(m) * l.jacobian.tr_mul(&l.jacobian);
            pull += weight(m) * l.jacobian.tr_mul(&l.residual);
        }
        kept.iter()
            .map(|&m| {
                let l = &at.linear[m];
                let rest = normal - weight(m) * l.jacobian.tr_mul(&l.jacobian);
                let pull = pull - weight(m) * l.jacobian.tr_mul(&l.residual);
                // Columns of very different length: scaled before they are
                // solved.
                let scale = Delta::from_fn(|i, _| rest[(i, i)].sqrt().recip());
                let scaled = rest.component_mul(&(scale * scale.transpose()));
                let step = scaled
                    .cholesky()?
                    .solve(&pull.component_mul(&scale))
                    .component_mul(&scale);
                Some(l.after(&-step).norm())
            })
            .collect()
    }
}

/// Variance of a turn through noise and drift over `seconds`.
fn own_variance(seconds: f64, known: &Known) -> f64 {
    known.noise.powi(2) * seconds + (known.drift * seconds).powi(2) + FLOOR * FLOOR
}

fn dense(factor: &Factor) -> Option<Covariance> {
    let values = factor.covariance().values?;
    Some(Covariance::from_fn(|i, j| values[i][j]))
}
