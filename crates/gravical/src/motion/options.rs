//! How motion is computed.

use std::ops::Range;
use std::str::FromStr;

use serde::Deserialize;

use crate::gravity::Gravity;
use crate::poses::face::AxisMap;
use crate::problem::Problem;
use crate::recording::Meter;
use crate::{Error, Result};

/// A way to compute a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Procedure {
    /// The attitude is followed with the gyroscope, and levelled at every rest; without a
    /// gyroscope it stays about that of the rests.
    #[default]
    Strapdown,
    /// The same without the gyroscope, even if there is one.
    ConstantTilt,
    /// That of the student report: Savitzky–Golay of window 5 and order 2, the mean of the first 500 rows
    /// subtracted, nothing rotated; the frame is the sensor's own. There is no zero-velocity update and no band.
    Report,
}

/// A list of intervals in seconds: `0-5,7.2-`. Without an end an interval goes to
/// the end of the recording, without a start it begins with it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intervals(Vec<(f64, f64)>);

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
    let number = |part: &str, open: f64| match part.trim() {
        "" => Some(open),
        part => part.parse().ok().filter(|v: &f64| v.is_finite()),
    };
    let ends = text.split_once('-').and_then(|(start, end)| {
        let ends = (number(start, 0.0)?, number(end, f64::INFINITY)?);
        (ends.0 < ends.1).then_some(ends)
    });
    ends.ok_or_else(|| {
        let text = text.to_owned();
        Problem::NoInterval { text }.error()
    })
}

impl Intervals {
    /// Spans of samples with these times, in order, joined where they touch.
    ///
    /// # Errors
    ///
    /// `rests-outside` (usage) where one holds fewer than two samples.
    pub(super) fn spans(&self, time_s: &[f64]) -> Result<Vec<Range<usize>>> {
        let mut spans = Vec::with_capacity(self.0.len());
        let first_s = time_s.first().copied().unwrap_or_default();
        let last_s = time_s.last().copied().unwrap_or_default();
        for &(start, end) in &self.0 {
            let from = time_s.partition_point(|t| *t < start);
            let span = from..time_s.partition_point(|t| *t <= end);
            if span.len() < 2 {
                let outside = Problem::RestOutside {
                    rest_s: [start, end.min(last_s)],
                    recorded_s: [first_s, last_s],
                };
                return Err(outside.error());
            }
            spans.push(span);
        }
        spans.sort_by_key(|span| span.start);
        spans.dedup_by(|next, last| {
            let touch = next.start <= last.end;
            if touch {
                last.end = last.end.max(next.end);
            }
            touch
        });
        Ok(spans)
    }
}

/// How motion is computed.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Method"))]
pub struct MotionOptions {
    /// strapdown (default), constant-tilt, report
    ///
    /// `constant-tilt` goes without the gyroscope. `report` is that of the student report, to compare with: the
    /// mean of the first 500 rows off, Savitzky–Golay of window 5 and order 2, no zero-velocity updates, no bands.
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "NAME",
            default_value = "strapdown",
            hide_default_value = true,
            hide_possible_values = true
        )
    )]
    pub procedure: Procedure,
    /// In s, e.g. 0-5,7.2- [default: found]
    #[serde(deserialize_with = "gravical_judge::option_text::optional")]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SPANS", allow_hyphen_values = true)
    )]
    pub rests: Option<Intervals>,
    /// Take no moment between swings for a foot in stance
    #[cfg_attr(feature = "clap", arg(long, hide_short_help = true))]
    pub no_stances: bool,
    /// Local gravity, for judging the magnitude at rest. Default: that of the calibration, else
    /// standard.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub gravity: Option<Gravity>,
    /// Axes of the sensor that point along x, y and z of the case.
    #[serde(deserialize_with = "gravical_judge::option_text::one")]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub axes: AxisMap,
    /// Ends the computation when it is [stopped](Meter::stop), with `io`. Default none.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub meter: Option<Meter>,
}

impl MotionOptions {
    /// The procedure of the student report.
    pub fn report() -> Self {
        MotionOptions {
            procedure: Procedure::Report,
            ..Self::default()
        }
    }

    /// Whether rests and uncertainties are known: the student report has neither.
    pub(super) fn has_bands(&self) -> bool {
        self.procedure != Procedure::Report
    }

    /// Checks that options go together.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        if self.procedure == Procedure::Report && self.rests.is_some() {
            let what =
                "the mean of the first rows is subtracted, and nothing else corrects the drift";
            let error = Error::range("rests", what).with_hint("remove it, or compute by strapdown");
            return Err(error.advise("procedure", "strapdown"));
        }
        Ok(())
    }
}
