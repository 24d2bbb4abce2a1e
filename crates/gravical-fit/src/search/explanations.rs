//! What explains that poses contradict each other: one bad pose, a step of the bias, a drift of it, or nothing but a
//! nonlinear response.
//!
//! Each is the same model with at most three more columns, and they are weighed by their evidence, the likelihood of
//! the session integrated over all parameters (MacKay, Neural Computation 4, 1992): more columns fit better, and are
//! less likely to have had just these values.

use super::{Found, Search};
use crate::model::Parameters;

/// What is wrong with a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Explanation {
    /// Nothing: noise, tilts, a model error and a nonlinear response.
    Nothing,
    /// The pose of this number is off.
    BadPose(usize),
    /// The bias moved once, between this pose and the one before it in time.
    Step(usize),
    /// The bias moved steadily.
    Drift,
}

/// An explanation that cannot be ruled out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explained {
    /// What it is.
    pub explanation: Explanation,
    /// Its probability among all of them.
    pub probability: f64,
    /// Largest difference of ‖a‖ over the sphere between its result and the one that is given, m/s².
    pub difference_mps2: f64,
}

/// Probability that a pose is off by some 50 mg …
const BAD_POSE: f64 = 0.02;
const BAD_POSE_MPS2: f64 = 0.5;
/// … that the bias of a session moves once, and that it drifts, each by some 20 mg.
const STEP: f64 = 0.03;
const DRIFT: f64 = 0.03;
const MOVED_MPS2: f64 = 0.2;

/// An explanation, the parameters by it, and the logarithm of its evidence times its prior probability.
pub(crate) struct Hypothesis {
    pub explanation: Explanation,
    pub x: Parameters,
    pub log_weight: f64,
}

impl Search {
    /// All explanations, of poses in the order of time `order` (their numbers as given); without an order the bias did
    /// not move.
    pub fn hypotheses(&self, order: Option<&[usize]>) -> Vec<Hypothesis> {
        let count = self.place_of.len();
        let mut fresh = self.clone();
        fresh.poses.iter_mut().for_each(|p| p.bad = None);
        let mut all = Vec::new();
        let mut weigh = |mut search: Search, explanation, prior: f64| {
            let Some(found) = search.settle() else { return };
            all.push(Hypothesis {
                explanation,
                x: found.linear.x,
                log_weight: search.evidence(&found) + prior.ln(),
            });
        };
        weigh(fresh.clone(), Explanation::Nothing, 1.0);
        for place in 0..fresh.poses.len() {
            let mut search = fresh.clone();
            search.poses[place].outlier_sd = BAD_POSE_MPS2;
            let pose = self.place_of.iter().position(|p| *p == place);
            weigh(search, Explanation::BadPose(pose.unwrap_or(0)), BAD_POSE);
        }
        let Some(order) = order.filter(|_| !self.held.drift && count > 2) else {
            return all;
        };
        for rank in 1..count {
            let step = |k: usize| if k < rank { -0.5 } else { 0.5 };
            let search = fresh.moved(order, step);
            weigh(search, Explanation::Step(order[rank]), STEP / (count - 1) as f64);
        }
        let drift = |k: usize| k as f64 / (count - 1) as f64 - 0.5;
        weigh(fresh.moved(order, drift), Explanation::Drift, DRIFT);
        all
    }

    /// The search with a bias that moves as `by` says of each rank in time.
    fn moved(&self, order: &[usize], by: impl Fn(usize) -> f64) -> Search {
        let mut search = self.clone();
        let mut sums = vec![(0.0, 0.0); search.poses.len()];
        for (rank, pose) in order.iter().enumerate() {
            let sum = &mut sums[self.place_of[*pose]];
            *sum = (sum.0 + by(rank), sum.1 + 1.0);
        }
        for (pose, (sum, times)) in search.poses.iter_mut().zip(sums) {
            pose.warmer_c = sum / f64::max(times, 1.0);
        }
        let mean = search.poses.iter().map(|p| p.warmer_c).sum::<f64>() / search.poses.len() as f64;
        search.poses.iter_mut().for_each(|p| p.warmer_c -= mean);
        search.held.drift = true;
        search.held.drift_sd = MOVED_MPS2;
        search
    }
}
