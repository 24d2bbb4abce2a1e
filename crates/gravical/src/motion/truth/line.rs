//! Positions over time, and what lies between two of them.

/// Between points further apart than this and than [`GAP_STEPS`] median steps
/// nothing is interpolated, s.
const GAP_S: f64 = 0.25;

/// See [`GAP_S`].
const GAP_STEPS: f64 = 4.5;

/// Positions over time; stamps never fall.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    t_s: &'a [f64],
    position: &'a [[f64; 3]],
}

impl<'a> Line<'a> {
    pub fn new(t_s: &'a [f64], position: &'a [[f64; 3]]) -> Self {
        let n = t_s.len().min(position.len());
        Line {
            t_s: &t_s[..n],
            position: &position[..n],
        }
    }

    /// First and last stamp.
    pub fn range(&self) -> Option<(f64, f64)> {
        Some((*self.t_s.first()?, *self.t_s.last()?))
    }

    /// Median step, s; 0 without any.
    pub fn median_step_s(&self) -> f64 {
        let steps = self.t_s.windows(2).map(|w| w[1] - w[0]);
        let mut steps: Vec<f64> = steps.filter(|s| *s > 0.0).collect();
        crate::stats::median(&mut steps).unwrap_or(0.0)
    }

    /// Interpolates at times that never fall; across gaps up to `gap_s`, or what
    /// is a gap by the line's own rate.
    pub fn walk(&self, gap_s: f64) -> LineCursor<'a> {
        LineCursor {
            line: *self,
            next: 0,
            gap_s: gap_s.max(GAP_S).max(GAP_STEPS * self.median_step_s()),
        }
    }
}

/// A place on a [`Line`] that only moves forwards.
pub(super) struct LineCursor<'a> {
    line: Line<'a>,
    next: usize,
    gap_s: f64,
}

impl LineCursor<'_> {
    /// Position at `t_s`; none outside, across a gap, and where it is not known.
    pub fn at(&mut self, t_s: f64) -> Option<[f64; 3]> {
        let stamps = self.line.t_s;
        while stamps.get(self.next).is_some_and(|t| *t < t_s) {
            self.next += 1;
        }
        let (after, p) = (*stamps.get(self.next)?, self.line.position.get(self.next)?);
        let found = if after == t_s {
            *p
        } else {
            let i = self.next.checked_sub(1)?;
            let (before, from) = (*stamps.get(i)?, self.line.position.get(i)?);
            if after - before > self.gap_s {
                return None;
            }
            let share = (t_s - before) / (after - before);
            std::array::from_fn(|k| from[k] + share * (p[k] - from[k]))
        };
        found.iter().all(|v| v.is_finite()).then_some(found)
    }
}
