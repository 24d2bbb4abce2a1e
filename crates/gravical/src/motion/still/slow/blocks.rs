//! Means of 0.2 s over a piece, and whether it rested all through each.

use std::ops::Range;

use gravical_core::still::Plan;

use crate::motion::samples::Samples;
use crate::motion::still::view::mean_of;

/// A piece in blocks.
pub(super) struct Blocks {
    /// First sample of each block; one more at the end.
    pub edges: Vec<usize>,
    /// Middle of each block, s.
    pub t_s: Vec<f64>,
    /// Length of a block with the step after it, s.
    pub step_s: Vec<f64>,
    pub force: Vec<[f64; 3]>,
    pub rate: Vec<[f64; 3]>,
    /// Wholly in a rest.
    pub rest: Vec<bool>,
}

impl Blocks {
    /// `rests` are those of the piece, in order.
    pub fn new(
        samples: &Samples,
        piece: &Range<usize>,
        rests: &[Range<usize>],
        plan: &Plan,
    ) -> Self {
        let count = piece.len() / plan.block;
        let t = &samples.t_s;
        let mut out = Blocks {
            edges: (0..=count).map(|j| piece.start + j * plan.block).collect(),
            t_s: Vec::with_capacity(count),
            step_s: Vec::with_capacity(count),
            force: Vec::with_capacity(count),
            rate: Vec::with_capacity(count),
            rest: Vec::with_capacity(count),
        };
        let usual = Plan::BLOCK_S / plan.block as f64;
        let mut rests = rests.iter().peekable();
        for pair in out.edges.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let after = if to < piece.end {
                t[to]
            } else {
                t[to - 1] + usual
            };
            let [a, b, c, d, e, f] = mean_of(samples, from..to);
            out.t_s.push(0.5 * (t[from] + t[to - 1]));
            out.step_s.push(after - t[from]);
            out.force.push([a, b, c]);
            out.rate.push([d, e, f]);
            while rests.next_if(|r| r.end <= from).is_some() {}
            let covered = rests.peek().is_some_and(|r| r.start <= from && to <= r.end);
            out.rest.push(covered);
        }
        out
    }

    pub fn len(&self) -> usize {
        self.t_s.len()
    }
}
