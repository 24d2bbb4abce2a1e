//! Where the rests of a stepper come from.

use gravical_signal::{RestDetector, RestEvent};

use crate::options::MotionOptions;
use crate::samples::Samples;

/// Where rests come from.
#[derive(Debug, Clone)]
pub(crate) enum RestSource {
    Detected(Box<RestDetector>),
    /// Spans of times in order, s, and where the first of them has begun.
    Given(Vec<(f64, f64)>, Option<usize>),
}

impl RestSource {
    pub fn new(options: &MotionOptions, period_s: f64, resolution: [f64; 6]) -> RestSource {
        let Some(given) = &options.rests_s else {
            return RestSource::Detected(Box::new(RestDetector::new(period_s, resolution)));
        };
        let mut spans: Vec<(f64, f64)> = given
            .iter()
            .copied()
            .filter(|(from_s, to_s)| from_s.is_finite() && to_s.is_finite() && from_s <= to_s)
            .collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        spans.dedup_by(|next, last| {
            let touches = next.0 <= last.1 + period_s;
            if touches {
                last.1 = last.1.max(next.1);
            }
            touches
        });
        // The next one is the last.
        spans.reverse();
        RestSource::Given(spans, None)
    }

    pub fn is_given(&self) -> bool {
        matches!(self, RestSource::Given(..))
    }

    pub fn update(&mut self, samples: &Samples) -> Option<RestEvent> {
        let (spans, begun) = match self {
            RestSource::Detected(detector) => return detector.update(&samples.channels()),
            RestSource::Given(spans, begun) => (spans, begun),
        };
        let now_s = *samples.time_s.last()?;
        while let Some((from_s, to_s)) = spans.last().copied() {
            let start = samples.time_s.partition_point(|t| *t < from_s);
            let end = samples.time_s.partition_point(|t| *t <= to_s);
            let over = now_s > to_s;
            if begun.is_some() && over {
                spans.pop();
                *begun = None;
                return Some(RestEvent::End(end));
            }
            let closes = now_s >= from_s + 1.0 && start + 1 < end;
            if begun.is_none() && (closes || over && start + 1 < end) {
                *begun = Some(start);
                return Some(RestEvent::Begin(start));
            }
            if !over {
                return None;
            }
            spans.pop();
        }
        None
    }

    pub fn finish(&mut self, samples: &Samples) -> Option<RestEvent> {
        match self {
            RestSource::Detected(detector) => detector.finish(&samples.channels()),
            RestSource::Given(spans, begun) => {
                let (from_s, _) = *spans.last().filter(|_| begun.is_none())?;
                let start = samples.time_s.partition_point(|t| *t < from_s);
                *begun = (start + 1 < samples.len()).then_some(start);
                begun.map(RestEvent::Begin)
            }
        }
    }

    pub fn forget(&mut self, count: usize) {
        match self {
            RestSource::Detected(detector) => detector.forget(count),
            RestSource::Given(_, begun) => {
                *begun = begun.map(|start| start.saturating_sub(count));
            }
        }
    }
}
