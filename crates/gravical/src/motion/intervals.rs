//! Rests that the user names.

use std::str::FromStr;

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
pub(super) fn check_intervals(intervals: &[(f64, f64)]) -> Result<()> {
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

/// Refuses intervals in which a recording with these times has fewer than two samples.
///
/// # Errors
///
/// `rests-outside` (usage).
pub(super) fn check_inside(time_s: &[f64], intervals: &[(f64, f64)]) -> Result<()> {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else {
        return Ok(());
    };
    for &(start, end) in intervals {
        if time_s.partition_point(|t| *t <= end) < time_s.partition_point(|t| *t < start) + 2 {
            let text = format!(
                "there are fewer than two samples in the rest from {start} s to {}: \
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
