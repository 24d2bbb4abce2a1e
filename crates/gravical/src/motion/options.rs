//! How motion is computed.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::Deserialize;

use crate::calibration_file::NoiseSection;
use crate::denoise::FilterSpec;
use crate::gravity::Gravity;
use crate::poses::face::AxisMap;
use crate::recording::Meter;
use crate::{Error, Result};

/// Highest angular rate of a walking foot in stance, rad/s.
const STANCE_RATE_RAD_S: f64 = 1.0;

/// Why options do not go together, and what to do, with which option.
const BY_MEAN: [&str; 4] = [
    "the mean of the first rows is subtracted, and nothing else corrects the drift",
    "remove it, or subtract gravity by strapdown",
    "gravity_removal",
    "strapdown",
];
const LATER: [&str; 4] = [
    "filters use what comes later",
    "remove the filters, or compute with all samples",
    "causal",
    "",
];
const BY_PAST: [&str; 4] = [
    "a causal run looks for rests, and takes each for zero velocity",
    "leave it out, or compute with all samples",
    "causal",
    "",
];
const AT_REST: [&str; 4] = [
    "velocity is zero at the rests, and what comes before the first follows from it",
    "leave it out, or switch the updates at rests off",
    "zero_velocity",
    "off",
];

/// How gravity is taken off the specific force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum GravityRemoval {
    /// The attitude is followed with the gyroscope, and levelled at every rest; without a
    /// gyroscope it stays about that of the rests.
    #[default]
    Strapdown,
    /// The same without the gyroscope, even if there is one.
    ConstantTilt,
    /// The mean of the first 500 rows is subtracted, nothing is rotated; the frame is the sensor's
    /// own. There is no zero-velocity update and no band.
    InitialMean,
}

/// A named way to compute a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Procedure {
    /// By the options.
    #[default]
    Default,
    /// That of the student report: [`MotionOptions::report`].
    Report,
}

/// Highest angular rate of a walking foot in stance, rad/s; none where stances are not looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StanceRate(pub Option<f64>);

impl Default for StanceRate {
    fn default() -> Self {
        StanceRate(Some(STANCE_RATE_RAD_S))
    }
}

impl fmt::Display for StanceRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(rate) => write!(f, "{rate}"),
            None => f.write_str("off"),
        }
    }
}

impl FromStr for StanceRate {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "off" {
            return Ok(StanceRate(None));
        }
        let wrong = |_| Error::usage("usage", format!("{text:?} is no rate in rad/s, nor off"));
        text.parse()
            .map(|rate| StanceRate(Some(rate)))
            .map_err(wrong)
    }
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
    let bad = |why: &str| {
        Error::usage("rests-syntax", format!("interval {text:?}: {why}"))
            .with_hint("write seconds as 0-5,7.2-: from 0 to 5 s, and from 7.2 s to the end")
    };
    let (start, end) = text
        .split_once('-')
        .ok_or_else(|| bad("there is no dash between start and end"))?;
    let number = |part: &str, open: f64| match part.trim() {
        "" => Ok(open),
        part => part
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| bad(&format!("{part:?} is no number"))),
    };
    let pair = (number(start, 0.0)?, number(end, f64::INFINITY)?);
    if pair.1 <= pair.0 {
        return Err(bad("it ends before it starts"));
    }
    Ok(pair)
}

impl Intervals {
    /// Start and end of each, s; the end may be infinite.
    #[must_use]
    pub fn as_slice(&self) -> &[(f64, f64)] {
        &self.0
    }

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
                let end = end.min(last_s);
                let text = format!(
                    "there are fewer than two samples in the rest from {start} s to {end} s: \
                     the recording goes from {first_s:.3} s to {last_s:.3} s"
                );
                return Err(Error::usage("rests-outside", text)
                    .with_hint("seconds count from the first row of the recording"));
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
    /// report: that of the student report
    ///
    /// The mean of the first 500 rows off and Savitzky–Golay of window 5 and order 2, to compare with.
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "NAME",
            default_value = "default",
            hide_default_value = true,
            hide_possible_values = true
        )
    )]
    pub procedure: Procedure,
    /// strapdown (default), constant-tilt, initial-mean
    ///
    /// `initial-mean` subtracts the mean of the first 500 rows, in sensor axes, without
    /// zero-velocity updates and bands.
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "HOW",
            default_value = "strapdown",
            hide_default_value = true,
            hide_possible_values = true,
            hide_short_help = true
        )
    )]
    pub gravity_removal: GravityRemoval,
    /// Filter, e.g. butter:4,5Hz; repeatable
    ///
    /// Rests are found without it. It has to keep a constant, and does not make the drift less.
    #[serde(deserialize_with = "crate::option_text::list")]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "FILTER", hide_short_help = true)
    )]
    pub smooth: Vec<FilterSpec>,
    /// Update at rests: on or off [default: on]
    ///
    /// Without it the first rest alone levels, and nothing corrects the drift after it.
    #[cfg_attr(feature = "clap", arg(long, value_name = "ON", value_parser = on_or_off, hide_short_help = true))]
    pub zero_velocity: Option<bool>,
    /// In s, e.g. 0-5,7.2- [default: found]
    #[serde(deserialize_with = "crate::option_text::optional")]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SPANS", allow_hyphen_values = true)
    )]
    pub rests: Option<Intervals>,
    /// Use the past only, as if samples came one by one
    #[cfg_attr(feature = "clap", arg(long))]
    pub causal: bool,
    /// Stance below this rad/s, or off
    ///
    /// The highest angular rate of a walking foot in stance: 0.01 to 5 rad/s.
    #[serde(rename = "stances", deserialize_with = "crate::option_text::one")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long = "stances",
            value_name = "RATE",
            default_value_t,
            hide_short_help = true
        )
    )]
    pub stance_rate: StanceRate,
    /// Velocity at the start, m/s; no updates at rests
    ///
    /// Of a sensor that moves evenly in what is taken for the first rest.
    #[serde(rename = "v0")]
    #[cfg_attr(feature = "clap", arg(long = "v0", value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, hide_short_help = true))]
    pub v0_mps: Option<[f64; 3]>,
    /// Position at the start, m
    #[serde(rename = "p0")]
    #[cfg_attr(feature = "clap", arg(long = "p0", value_name = "X,Y,Z", value_parser = vector, default_value = "0,0,0", allow_hyphen_values = true, hide_short_help = true))]
    pub p0_m: [f64; 3],
    /// Noise of the sensor, for the bands; its N is used in place of what the rests show, where it is
    /// known of all axes. Default: by the rests.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub noise: Option<NoiseSection>,
    /// Local gravity, for judging the magnitude at rest. Default: that of the calibration, else
    /// standard.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub gravity: Option<Gravity>,
    /// Write no error bands: a smaller table
    #[cfg_attr(feature = "clap", arg(long, hide_short_help = true))]
    pub no_bands: bool,
    /// Axes of the sensor that point along x, y and z of the case.
    #[serde(deserialize_with = "crate::option_text::one")]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub axes: AxisMap,
    /// Ends the computation when it is [stopped](Meter::stop), with `io`. Default none.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub meter: Option<Meter>,
}

#[cfg(feature = "clap")]
fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("on or off".to_owned()),
    }
}

#[cfg(feature = "clap")]
fn vector(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|part| part.trim().parse());
    let numbers: Result<Vec<f64>, _> = numbers.collect();
    let three = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    three.ok_or_else(|| "expected three numbers such as 0,0,0".to_owned())
}

impl MotionOptions {
    /// The procedure of the student report: Savitzky–Golay of window 5 and order 2, mean of the first
    /// 500 rows off, trapezoid; no attitude, no zero-velocity update.
    #[must_use]
    pub fn report() -> Self {
        MotionOptions {
            procedure: Procedure::Report,
            ..Self::default()
        }
    }

    /// With the procedure of the student report written out, where it is named; filters and a removal of
    /// gravity that are given stay.
    pub(super) fn resolved(&self) -> Self {
        let mut options = self.clone();
        if self.procedure == Procedure::Report {
            if options.gravity_removal == GravityRemoval::default() {
                options.gravity_removal = GravityRemoval::InitialMean;
            }
            if options.smooth.is_empty() {
                options.smooth.push(FilterSpec::SavitzkyGolay {
                    window: 5,
                    order: 2,
                });
            }
        }
        options
    }

    /// Whether velocity is zero at rests; the mean of the first rows knows no rests.
    pub(super) fn updates_at_rests(&self) -> bool {
        self.zero_velocity
            .unwrap_or(self.gravity_removal != GravityRemoval::InitialMean)
    }

    /// Whether uncertainties are known and wanted.
    pub(super) fn has_bands(&self) -> bool {
        !self.no_bands && self.gravity_removal != GravityRemoval::InitialMean
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        self.resolved().check()
    }

    /// Checks ranges of what [`resolved`](Self::resolved) returns.
    pub(super) fn check(&self) -> Result<()> {
        let by_mean = self.gravity_removal == GravityRemoval::InitialMean;
        let no_updates = self.zero_velocity == Some(false);
        let moves_at_start = self.v0_mps.is_some();
        let refused = [
            (
                by_mean && self.zero_velocity == Some(true),
                "zero_velocity",
                BY_MEAN,
            ),
            (by_mean && self.rests.is_some(), "rests", BY_MEAN),
            (by_mean && self.causal, "causal", BY_MEAN),
            (by_mean && moves_at_start, "v0", BY_MEAN),
            (by_mean && self.noise.is_some(), "noise", BY_MEAN),
            (self.causal && !self.smooth.is_empty(), "smooth", LATER),
            (self.causal && self.rests.is_some(), "rests", BY_PAST),
            (self.causal && no_updates, "zero_velocity", BY_PAST),
            (moves_at_start && self.updates_at_rests(), "v0", AT_REST),
        ];
        if let Some((_, option, [what, hint, other, value])) = refused.into_iter().find(|r| r.0) {
            let error = Error::range(option, what).with_hint(hint);
            return Err(error.advise(other, value));
        }
        for filter in &self.smooth {
            filter.validate()?;
            if !filter.keeps_constants() {
                let what = "does not keep constants: its output is no acceleration";
                return Err(Error::range("smooth", format!("{filter} {what}")));
            }
        }
        if let Some(rate) = self.stance_rate.0
            && !(0.01..=5.0).contains(&rate)
        {
            let what = format!("{rate} is not possible; 0.01 to 5 is");
            return Err(Error::range("stances", what));
        }
        for (option, vector) in [("v0", self.v0_mps.unwrap_or_default()), ("p0", self.p0_m)] {
            if !vector.iter().all(|v| v.is_finite()) {
                return Err(Error::range(option, "three finite numbers are needed"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Intervals;

    #[test]
    fn intervals_are_spans_of_samples_in_order() {
        let time_s: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let spans = |text: &str| text.parse::<Intervals>().unwrap().spans(&time_s);
        assert_eq!(spans("7-,0-1,0.5-2").unwrap(), [0..201, 700..1000]);
        let refused = spans("3-3.001").unwrap_err();
        assert_eq!(refused.code(), "rests-outside");
    }
}
