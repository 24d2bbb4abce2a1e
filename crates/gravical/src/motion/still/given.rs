//! Rests that the user names.

use std::ops::Range;
use std::str::FromStr;

use crate::motion::samples::Samples;
use crate::{Error, Result};

/// A list of intervals in seconds: `0-5,7.2-`. Without an end an interval goes to
/// the end of the recording, without a start it begins with it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intervals(pub Vec<(f64, f64)>);

impl FromStr for Intervals {
    type Err = Error;

    /// # Errors
    ///
    /// `rests-syntax` (usage) for anything that is no list of intervals, or an
    /// interval that ends before it starts.
    fn from_str(text: &str) -> Result<Self> {
        let intervals = text.split(',').map(interval).collect::<Result<Vec<_>>>()?;
        Ok(Intervals(intervals))
    }
}

fn interval(text: &str) -> Result<(f64, f64)> {
    let bad = |why: &str| {
        Error::usage("rests-syntax", format!("interval {text:?}: {why}"))
            .with_hint("write seconds as 0-5,7.2-: from 0 to 5 s, and from 7.2 s to the end")
    };
    // The dash of an exponent (1e-3) parts nothing.
    let dash = text
        .char_indices()
        .find(|&(i, c)| c == '-' && !text[..i].ends_with(['e', 'E']));
    let Some((dash, _)) = dash else {
        return Err(bad("there is no dash between start and end"));
    };
    let number = |part: &str, open: f64| -> Result<f64> {
        let part = part.trim();
        if part.is_empty() {
            return Ok(open);
        }
        match part.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(bad(&format!("{part:?} is no number"))),
        }
    };
    let (start, end) = (&text[..dash], &text[dash + 1..]);
    if start.trim().is_empty() && end.trim().is_empty() {
        return Err(bad("neither a start nor an end"));
    }
    let pair = (number(start, 0.0)?, number(end, f64::INFINITY)?);
    if pair.1 <= pair.0 {
        return Err(bad("it ends before it starts"));
    }
    Ok(pair)
}

/// Refuses intervals that cannot be meant.
///
/// # Errors
///
/// `rests-syntax` (usage) for one that is no number or ends before it starts.
pub(in crate::motion) fn check_intervals(intervals: &[(f64, f64)]) -> Result<()> {
    for &(start, end) in intervals {
        if start.is_nan() || end.is_nan() || end <= start {
            return Err(Error::usage(
                "rests-syntax",
                format!(
                    "the rest from {start} s to {} ends before it starts",
                    until(end)
                ),
            )
            .with_hint("give start and end of each rest in seconds, as 0-5,7.2-"));
        }
    }
    Ok(())
}

/// Refuses intervals in which the recording has no sample.
///
/// # Errors
///
/// `rests-outside` (usage).
pub(in crate::motion) fn check_inside(samples: &Samples, intervals: &[(f64, f64)]) -> Result<()> {
    let (Some(first), Some(last)) = (samples.t_s.first(), samples.t_s.last()) else {
        return Ok(());
    };
    for &(start, end) in intervals {
        if range(samples, start, end).is_empty() {
            let text = format!(
                "there is no sample in the rest from {start} s to {}: \
                 the recording goes from {first:.3} s to {last:.3} s",
                until(end)
            );
            return Err(Error::usage("rests-outside", text)
                .with_hint("seconds count from the first row of the recording"));
        }
    }
    Ok(())
}

fn until(end_s: f64) -> String {
    match end_s.is_finite() {
        true => format!("{end_s} s"),
        false => "the end".to_owned(),
    }
}

/// Samples of an interval, both ends included.
fn range(samples: &Samples, start: f64, end: f64) -> Range<usize> {
    let t = &samples.t_s;
    t.partition_point(|v| *v < start)..t.partition_point(|v| *v <= end)
}

/// The samples in `intervals`: clipped to the recording, sorted, merged where they
/// touch or overlap, cut at the breaks. An interval without any sample is left
/// out.
pub(super) fn spans(samples: &Samples, intervals: &[(f64, f64)]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = intervals
        .iter()
        .map(|&(start, end)| range(samples, start, end))
        .filter(|r| r.start < r.end)
        .collect();
    found.sort_by_key(|r| (r.start, r.end));
    let mut merged: Vec<Range<usize>> = Vec::new();
    for range in found {
        match merged.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
        .iter()
        .flat_map(|range| {
            samples.pieces().into_iter().filter_map(move |piece| {
                let cut = range.start.max(piece.start)..range.end.min(piece.end);
                (cut.start < cut.end).then_some(cut)
            })
        })
        .collect()
}
