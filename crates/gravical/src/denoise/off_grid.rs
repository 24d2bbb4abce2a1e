//! Which stretches are off an even grid: known before they are filtered.

use super::clock::{Clock, Step};
use super::grid::is_on_grid;
use crate::recording::sample::Sample;

/// The stretches with steps that are no whole multiples of the usual one, of each channel, by their
/// first rows.
#[derive(Debug, Clone, Default)]
pub(super) struct OffGrid([Vec<usize>; 6]);

impl OffGrid {
    /// True if the stretch of a channel that begins in this row is off the grid.
    pub fn contains(&self, channel: usize, row: usize) -> bool {
        self.0[channel].binary_search(&row).is_ok()
    }
}

/// Determines [`OffGrid`] from all rows.
pub(super) struct GridScout {
    clock: Clock,
    rows: usize,
    stretches: [Option<Stretch>; 6],
    found: OffGrid,
}

#[derive(Debug, Clone, Copy)]
struct Stretch {
    first: usize,
    last_s: f64,
    has_uneven: bool,
    on_grid: bool,
}

impl GridScout {
    pub fn new(clock: Clock) -> Self {
        GridScout {
            clock,
            rows: 0,
            stretches: [None; 6],
            found: OffGrid::default(),
        }
    }

    /// Adds a row, whose time is known.
    pub fn push(&mut self, row: Sample) {
        for (channel, stretch) in self.stretches.iter_mut().enumerate() {
            let found = &mut self.found.0[channel];
            if row.is_break {
                end(stretch, found);
            }
            let step = stretch.map(|s| self.clock.step(s.last_s, row.time_s));
            let is_empty = !row.values[channel].is_finite();
            if step.is_some_and(Step::parts) && (!is_empty || step == Some(Step::Gap)) {
                end(stretch, found);
            }
            if is_empty {
                continue;
            }
            match stretch {
                Some(stretch) => {
                    stretch.has_uneven |= step == Some(Step::Uneven);
                    stretch.on_grid &= is_on_grid(row.time_s - stretch.last_s, self.clock.step_s);
                    stretch.last_s = row.time_s;
                }
                None => {
                    *stretch = Some(Stretch {
                        first: self.rows,
                        last_s: row.time_s,
                        has_uneven: false,
                        on_grid: true,
                    });
                }
            }
        }
        self.rows += 1;
    }

    pub fn finish(mut self) -> OffGrid {
        for (stretch, found) in self.stretches.iter_mut().zip(&mut self.found.0) {
            end(stretch, found);
        }
        self.found
    }
}

fn end(stretch: &mut Option<Stretch>, found: &mut Vec<usize>) {
    if let Some(stretch) = stretch.take()
        && stretch.has_uneven
        && !stretch.on_grid
    {
        found.push(stretch.first);
    }
}
