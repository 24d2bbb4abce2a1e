//! A filter that follows a move as it goes on.

use crate::filter::{Action, Filter};
use crate::moves::rectified;
use crate::result::PathNode;
use crate::samples::Samples;
use crate::transition::Model;

/// The move has the roughness of its last seconds, s.
const RECENT_S: f64 = 2.0;
/// Nodes, s: what turns less than a swing within it.
const NODE_S: f64 = 0.04;

/// A filter that goes on through a move.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub filter: Filter,
    /// First sample of the move.
    pub start: usize,
    /// Σ ω² and the number of samples in it, and by how much it has widened the bias.
    squares: f64,
    count: usize,
    inflated: f64,
}

impl Track {
    pub fn new(model: &Model<'_>, mut filter: Filter) -> Track {
        filter.run(model, &Action::StartMove(0), None);
        Track {
            start: filter.at,
            filter,
            squares: 0.0,
            count: 0,
            inflated: 0.0,
        }
    }

    /// Goes on to a sample, from node to node, which are added to `path`.
    pub fn advance(&mut self, model: &Model<'_>, to: usize, mut path: Option<&mut Vec<PathNode>>) {
        let node = node_len(model.samples);
        let recent = model.samples.count_in(RECENT_S);
        while self.filter.at < to {
            let span = self.filter.at..to.min(self.filter.at + node);
            let mean_square = self.filter.mean_square_rate(model, span.clone());
            self.squares += mean_square * span.len() as f64;
            self.count += span.len();
            let rate_sd = model.directions.rate_sd;
            let variance = rectified(self.squares / self.count as f64, rate_sd);
            if variance > self.inflated {
                let more = Action::InflateRateBias(variance - self.inflated);
                self.filter.run(model, &more, None);
                self.inflated = variance;
            }
            if let Some(path) = &mut path {
                path.push(PathNode::forward(&self.filter.node()));
            }
            let since = self.start.max(span.end.saturating_sub(recent));
            let propagate = Action::Propagate {
                to: span.end,
                node,
                excess: model.noise.excess(since, span.end),
            };
            self.filter.run(model, &propagate, None);
        }
    }
}

pub(crate) fn node_len(samples: &Samples) -> usize {
    samples.count_in(NODE_S).max(1)
}
