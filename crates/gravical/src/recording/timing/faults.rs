//! Stamps followed one by one: where they wrap, restart, repeat, run backwards
//! or leave a gap.

use crate::recording::finding::{Finding, LineSpans};

/// Stamps in seconds, and what went wrong in them.
pub(super) struct Followed {
    /// Seconds from the first stamp, unwrapped.
    pub time_s: Vec<f64>,
    /// Rows at which the clock started anew.
    pub restarts: Vec<usize>,
    /// The latest time, s.
    pub duration_s: f64,
    pub faults: Faults,
}

/// Follows the stamps; `median` is their usual step, both in units of `per_s`
/// seconds.
pub(super) fn follow(
    raw: &[f64],
    median: f64,
    per_s: f64,
    line: impl Fn(usize) -> u64,
) -> Followed {
    let mut time_s = Vec::with_capacity(raw.len());
    let mut faults = Faults::default();
    let mut offset = -raw.iter().copied().find(|t| t.is_finite()).unwrap_or(0.0);
    let mut restarts = Vec::new();
    let mut before = f64::NAN;
    let mut latest = f64::NEG_INFINITY;
    for (row, &stamp) in raw.iter().enumerate() {
        if !stamp.is_finite() {
            faults.absent.push(line(row));
            time_s.push(f64::NAN);
            continue;
        }
        let step = stamp - before;
        if step < 0.0 {
            if let Some(period) = wrap_period(before, stamp) {
                offset += period;
                faults.wrapped.push(line(row));
            } else if stamp < 0.5 * before
                && -step > 20.0 * median
                && stamp < 100.0 * median.max(1.0 / per_s)
            {
                // The board began to count anew: it was reset.
                restarts.push(row);
                offset += before + median - stamp;
                faults.restarted.push(line(row));
            } else {
                faults.backward.push(line(row));
            }
        } else if step == 0.0 {
            faults.duplicate.push(line(row));
        } else if step > 4.5 * median {
            // Below that, single lost samples: they are in the missing share.
            faults.gaps.push(line(row));
            faults.longest_gap_s = faults.longest_gap_s.max(step * per_s);
        }
        before = stamp;
        let t = stamp + offset;
        latest = latest.max(t);
        time_s.push(t * per_s);
    }
    Followed {
        time_s,
        restarts,
        duration_s: latest * per_s,
        faults,
    }
}

#[derive(Default)]
pub(super) struct Faults {
    wrapped: LineSpans,
    restarted: LineSpans,
    backward: LineSpans,
    duplicate: LineSpans,
    absent: LineSpans,
    gaps: LineSpans,
    longest_gap_s: f64,
}

impl Faults {
    /// What is to be said about them.
    pub(super) fn report(&self, findings: &mut Vec<Finding>, rows: usize) {
        let share = |spans: &LineSpans| 100.0 * spans.count() as f64 / rows.max(1) as f64;
        let mut add = |spans: &LineSpans, finding: Finding| {
            if !spans.is_empty() {
                findings.push(finding.at_lines(spans));
            }
        };
        add(
            &self.wrapped,
            Finding::note(
                "wrapped-time",
                "the 32-bit counter of the time stamps wrapped; unwrapped",
            ),
        );
        add(
            &self.restarted,
            Finding::warning(
                "restarted-time",
                "the time stamps start anew (the board was reset); taken as a break, the clock goes on from the row before",
            ),
        );
        add(
            &self.backward,
            Finding::warning(
                "backward-time",
                format!(
                    "{} time stamps run backwards; kept as recorded",
                    self.backward.count()
                ),
            ),
        );
        add(
            &self.duplicate,
            Finding::warning(
                "duplicate-time",
                format!(
                    "{} time stamps repeat the one before ({:.1} % of the rows); the rows are kept",
                    self.duplicate.count(),
                    share(&self.duplicate)
                ),
            ),
        );
        add(
            &self.absent,
            Finding::warning(
                "absent-time",
                format!("{} rows have no time stamp", self.absent.count()),
            ),
        );
        add(
            &self.gaps,
            Finding::warning(
                "gap",
                format!(
                    "{} gaps of more than four samples, the longest {:.3} s",
                    self.gaps.count(),
                    self.longest_gap_s
                ),
            ),
        );
    }
}

/// A 32-bit counter that fell from near its end to near its start.
fn wrap_period(before: f64, now: f64) -> Option<f64> {
    let period = 4_294_967_296.0; // 2³²
    (before > 0.95 * period && before < period && now < 0.05 * period && now >= 0.0)
        .then_some(period)
}
