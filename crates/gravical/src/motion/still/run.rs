//! From where a rest is certain to its end, in one direction.

use gravical_core::still::{Plan, Statistic, onset};

use super::levels::{Coarse, Levels};
use super::view::{Six, View};

/// An onset is looked for over so many blocks: 3 s. A slow move is noticed 1 to 2 s
/// after it began.
const ONSET_BLOCKS: usize = 15;

/// A rest as one direction sees it, in places of the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    /// Where it was certain to rest: the first of five blocks that agree.
    pub seed: usize,
    /// First place that is not at rest; the end of the view when `alarm` is none.
    pub end: usize,
    /// Place at which the motion was noticed.
    pub alarm: Option<usize>,
}

/// All rests of a view.
pub(super) fn runs(view: &View<'_>, plan: &Plan, levels: &Levels) -> Vec<Run> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some((seed, coarse)) = find_seed(view, plan, levels, at) {
        let run = follow(view, plan, coarse, seed);
        out.push(run);
        let Some(alarm) = run.alarm else { break };
        // Up to there it was moving, or it would not have been noticed.
        at = alarm;
    }
    out
}

/// The first five blocks from `from` on that agree, in the middle of a coarse rest.
fn find_seed<'a>(
    view: &View<'_>,
    plan: &Plan,
    levels: &'a Levels,
    from: usize,
) -> Option<(usize, &'a Coarse)> {
    let length = plan.block;
    let whole = length * Plan::SEED_BLOCKS;
    let step = (length / 4).max(1);
    let mut at = from;
    while at + whole <= view.len() {
        let middle = view.sample(at + whole / 2);
        if let Some(coarse) = levels.at(middle) {
            let means: [Six; Plan::SEED_BLOCKS] =
                std::array::from_fn(|k| view.mean(at + k * length..at + (k + 1) * length));
            if coarse.noise.agree(&means, length) {
                return Some((at, coarse));
            }
        }
        at += step;
    }
    None
}

fn follow(view: &View<'_>, plan: &Plan, coarse: &Coarse, seed: usize) -> Run {
    let origin = view.mean(seed..seed + plan.block);
    let mut statistic = Statistic::new(*plan, coarse.noise, origin);
    for at in seed..view.len() {
        let leaving = plan.windows.map(|w| {
            if at >= seed + w {
                view.at(at - w)
            } else {
                origin
            }
        });
        if statistic.update(view.at(at), leaving).is_none() {
            continue;
        }
        let rest = statistic.reference().unwrap_or(origin);
        let length = (ONSET_BLOCKS * plan.block).min(at - seed);
        let variance = &coarse.noise.mean_variance[0];
        let tau = onset(at, length, &rest, variance, |i| view.at(i));
        let end = (tau + 1).saturating_sub(plan.margin).max(seed + 1);
        return Run {
            seed,
            end,
            alarm: Some(at),
        };
    }
    Run {
        seed,
        end: view.len(),
        alarm: None,
    }
}
