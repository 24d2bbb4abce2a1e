//! One filter over the samples of a stretch, block after block.

use super::filter::{Filter, Treatment};
use super::grid::Grid;
use super::samples::{Samples, keep};

/// One filter and the samples of a stretch that it still needs.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    /// Number of samples that were returned.
    pub returned: usize,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    Window {
        samples: Samples,
        /// Number of these that were returned; they are in the windows of others.
        returned: usize,
    },
    Grid(Box<Grid>),
}

impl Stage {
    /// A stretch without samples yet; `off_grid`: not all of its steps will be whole multiples of
    /// the usual one.
    pub fn new(filter: &Filter, channels: usize, off_grid: bool) -> Self {
        let kind = match filter.butterworth() {
            Some(butterworth) => {
                let grid = Grid::new(butterworth, filter.step_s(), channels, off_grid);
                Kind::Grid(Box::new(grid))
            }
            None => Kind::Window {
                samples: Samples::new(channels),
                returned: 0,
            },
        };
        Stage { returned: 0, kind }
    }

    /// Keeps the channels that are marked.
    pub fn keep(&mut self, marked: &[bool]) {
        match &mut self.kind {
            Kind::Window { samples, .. } => keep(&mut samples.channels, marked),
            Kind::Grid(grid) => grid.keep(marked),
        }
    }

    /// Adds `input`, the next samples, and returns those that are filtered; at the `end` of the
    /// stretch all of them. `least` avoids small steps: smallest number of samples of a step.
    pub fn run(
        &mut self,
        filter: &Filter,
        input: Samples,
        end: bool,
        least: usize,
        treatment: &mut Treatment,
    ) -> Samples {
        let out = match &mut self.kind {
            Kind::Window { samples, returned } => {
                samples.append(input);
                over_window(filter, samples, returned, end, treatment)
            }
            Kind::Grid(grid) => match filter.butterworth() {
                Some(butterworth) => grid.run(butterworth, input, end, least, treatment),
                None => input,
            },
        };
        treatment.samples += out.channels.len() * out.len();
        self.returned += out.len();
        out
    }
}

fn over_window(
    filter: &Filter,
    samples: &mut Samples,
    returned: &mut usize,
    end: bool,
    treatment: &mut Treatment,
) -> Samples {
    let (count, window) = (samples.len(), filter.window());
    if end && count < filter.shortest() {
        let channels = samples.channels.len();
        treatment.too_short += channels * count;
        treatment.short_stretches += channels;
        return std::mem::take(samples);
    }
    // The ends depend on the last full window.
    let ready = match end {
        true => count,
        false => count.saturating_sub(window),
    };
    if ready <= *returned {
        return Samples::new(samples.channels.len());
    }
    let out = filter.over_window(samples, *returned..ready, treatment);
    let passed = ready.saturating_sub(window);
    samples.remove_first(passed);
    *returned = ready - passed;
    out
}
