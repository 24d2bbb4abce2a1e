//! Findings about the time stamps of a recording.

use crate::finding::{Finding, FindingKind, LineSpans};

/// Lines of each kind of fault, and durations.
#[derive(Debug, Clone, Default)]
pub(super) struct Faults {
    pub wrapped: LineSpans,
    pub restarted: LineSpans,
    pub backward: LineSpans,
    pub duplicate: LineSpans,
    pub absent: LineSpans,
    pub gaps: LineSpans,
    pub longest_gap_s: f64,
    pub pauses: LineSpans,
    pub paused_s: f64,
}

impl Faults {
    pub fn report(&self, findings: &mut Vec<Finding>, rows: u64) {
        let share = |spans: &LineSpans| 100.0 * spans.count() as f64 / rows.max(1) as f64;
        let mut add = |spans: &LineSpans, finding: Finding| {
            if !spans.is_empty() {
                findings.push(finding.at_lines(spans));
            }
        };
        add(
            &self.restarted,
            Finding::new(
                FindingKind::RestartedTime,
                "the time stamps restart (the board was reset); a break",
            ),
        );
        add(
            &self.backward,
            Finding::new(
                FindingKind::BadStamps,
                format!(
                    "{} time stamps run backwards; kept as recorded",
                    self.backward.count()
                ),
            ),
        );
        add(
            &self.duplicate,
            Finding::new(
                FindingKind::DuplicateTime,
                format!(
                    "{} time stamps repeat the one before ({:.1} % of the rows); the rows are kept",
                    self.duplicate.count(),
                    share(&self.duplicate)
                ),
            ),
        );
        add(
            &self.absent,
            Finding::new(
                FindingKind::AbsentTime,
                format!("{} rows have no time stamp", self.absent.count()),
            ),
        );
        let plural = |spans: &LineSpans, word: &str| match spans.count() {
            1 => format!("1 {word}"),
            n => format!("{n} {word}s"),
        };
        add(
            &self.gaps,
            Finding::new(
                FindingKind::Gap,
                format!(
                    "{} of more than four samples, the longest {:.3} s",
                    plural(&self.gaps, "gap"),
                    self.longest_gap_s
                ),
            ),
        );
    }
}
