//! What explains that poses contradict each other: one bad pose, a step of the bias, a drift of it, or nothing but a
//! nonlinear response.
//!
//! Each is the same model with at most three more columns. They are weighed by their evidence, the likelihood of the
//! session integrated over all parameters (MacKay, Neural Computation 4, 1992): with more columns any session fits
//! better, and any one session is less likely.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::state::Search;
use crate::model::{Parameters, bias, inverse, matrix, sphere};

/// What is wrong with a session; poses by their number, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "what", content = "pose")]
pub enum Explanation {
    /// Nothing: noise, tilts, a model error and a nonlinear response.
    Nothing,
    /// This pose is off.
    BadPose(usize),
    /// The poses that were left out are off.
    BadPoses,
    /// The bias moved once, before this pose.
    Step(usize),
    /// The bias moved steadily.
    Drift,
}

/// An explanation that cannot be ruled out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explained {
    /// What it is.
    #[serde(flatten)]
    pub explanation: Explanation,
    /// Its probability among all of them.
    pub probability: f64,
    /// Largest difference of ‖a‖ over the sphere between its result and the one that is given, m/s².
    pub difference_mps2: f64,
    /// Where it is that large: unit vector of specific force.
    pub direction: [f64; 3],
}

/// Before any reading: the probability that a pose is off, by some 50 mg …
pub(super) const BAD_POSE: f64 = 0.02;
pub(super) const BAD_POSE_MPS2: f64 = 0.5;
/// … that the bias moves once in a session, and that it drifts, each by some 20 mg.
const STEP: f64 = 0.03;
const DRIFT: f64 = 0.03;
const MOVED_MPS2: f64 = 0.2;
/// Explanations that are less likely are ruled out.
const LIKELY: f64 = 0.003;
/// Directions in which results are compared.
const DIRECTIONS: usize = 200;

impl Search {
    /// The explanations that cannot be ruled out, the likeliest first, beside the result `x`. `order` has the numbers of
    /// the poses in the order of time, if it is known.
    pub fn explanations(&self, x: &Parameters, order: Option<&[usize]>) -> Vec<Explained> {
        let mut fresh = self.clone();
        fresh.poses.iter_mut().for_each(|pose| pose.bad = None);
        let mut all = vec![weighed(fresh.clone(), Explanation::Nothing, 1.0)];
        for place in 0..fresh.poses.len() {
            let mut search = fresh.clone();
            search.poses[place].outlier_sd = BAD_POSE_MPS2;
            let pose = self.place_of.iter().position(|p| *p == place);
            all.extend(pose.map(|k| weighed(search, Explanation::BadPose(k), BAD_POSE)));
        }
        let count = self.poses.iter().filter(|pose| pose.bad.is_some()).count();
        if count > 1 {
            let mut search = fresh.clone();
            for (pose, found) in search.poses.iter_mut().zip(&self.poses) {
                pose.outlier_sd = found.bad.map_or(0.0, |_| BAD_POSE_MPS2);
            }
            let prior = BAD_POSE.powi(count as i32);
            all.push(weighed(search, Explanation::BadPoses, prior));
        }
        // A drift with temperature has the columns already.
        if let Some(order) = order.filter(|order| order.len() > 1 && !self.held.drift) {
            let last = (order.len() - 1) as f64;
            for rank in 1..order.len() {
                let moved = fresh.moved(order, |k| f64::from(u8::from(k >= rank)));
                all.push(weighed(moved, Explanation::Step(order[rank]), STEP / last));
            }
            let moved = fresh.moved(order, |k| k as f64 / last);
            all.push(weighed(moved, Explanation::Drift, DRIFT));
        }
        let all: Vec<_> = all.into_iter().flatten().collect();
        let best = all
            .iter()
            .map(|(_, _, log)| *log)
            .fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = all.iter().map(|(_, _, log)| (log - best).exp()).sum();
        let explained = |(explanation, other, log): &(Explanation, Parameters, f64)| {
            let (direction, difference_mps2) = self.largest_difference(x, other);
            Explained {
                explanation: *explanation,
                probability: (log - best).exp() / sum,
                difference_mps2,
                direction: direction.into(),
            }
        };
        let mut likely: Vec<Explained> = all.iter().map(explained).collect();
        likely.retain(|e| e.probability > LIKELY);
        likely.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        likely
    }

    /// The search with a bias that moves by `by` of each rank in time, about its mean.
    fn moved(&self, order: &[usize], by: impl Fn(usize) -> f64) -> Search {
        let mut search = self.clone();
        let mean = (0..order.len()).map(&by).sum::<f64>() / order.len() as f64;
        search.poses.iter_mut().for_each(|pose| pose.warmer_c = 0.0);
        for (rank, pose) in order.iter().enumerate() {
            let place = self.place_of[*pose];
            let times = self.place_of.iter().filter(|p| **p == place).count();
            search.poses[place].warmer_c += (by(rank) - mean) / times as f64;
        }
        search.held.drift = true;
        search.held.drift_sd = MOVED_MPS2;
        search
    }

    /// The direction in which ‖a‖ by two results differs most, and by how much, m/s².
    fn largest_difference(&self, x: &Parameters, other: &Parameters) -> (Vector3<f64>, f64) {
        let (inverse, gravity) = (inverse(x), self.held.gravity);
        let shift = bias(other, 0.0) - bias(x, 0.0);
        let length = |n: Vector3<f64>| (inverse * (matrix(other) * n * gravity + shift)).norm();
        let each = sphere(DIRECTIONS).map(|n| (n, (length(n) - gravity).abs()));
        each.fold(
            (Vector3::z(), 0.0),
            |most, one| if one.1 > most.1 { one } else { most },
        )
    }
}

/// An explanation, its result, and the logarithm of its evidence times its probability before any reading.
fn weighed(
    mut search: Search,
    what: Explanation,
    prior: f64,
) -> Option<(Explanation, Parameters, f64)> {
    let found = search.converge()?;
    Some((what, found.linear.x, search.evidence(&found) + prior.ln()))
}
