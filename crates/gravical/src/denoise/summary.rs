//! What filtering did, with numbers and findings.

use std::ops::Range;

use serde::Serialize;

use crate::recording::{Finding, FindingKind, Recording};

use super::clock::Parted;
use super::filter::Filter;
use super::response::Response;
use super::run::{Outcome, Runner};
use super::spec::{FilterSpec, Passes};
use super::{Channels, DenoiseOptions, Edge};

/// What was done to a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DenoiseSummary {
    /// The recording as it was given, `-` for standard input.
    pub input: String,
    /// How it is written, for people.
    pub description: String,
    /// Its rows.
    pub rows: usize,
    /// The rate that the filters were made for, Hz; null when nothing tells it.
    pub rate_hz: Option<f64>,
    /// Stretches between breaks, gaps and backward stamps: filters begin anew in each.
    pub stretches: usize,
    /// What stood beyond the ends, for filters with a window.
    pub edge: Edge,
    /// Spans at rest that the noise was measured in, and their rows together.
    pub still_spans: usize,
    /// Rows of these spans.
    pub still_rows: usize,
    /// Unit of the accelerometer's standard deviations: `m/s^2` where the unit of the
    /// file is known, else that of the file.
    pub accel_unit: &'static str,
    /// Unit of the gyroscope's: `rad/s` where that of the file is known.
    pub gyro_unit: &'static str,
    /// Noise as it was recorded.
    pub recorded: Sigmas,
    /// The filters in the order in which they ran.
    pub filters: Vec<FilterOutcome>,
    /// Names of the columns that were written; empty before.
    pub columns: Vec<String>,
    /// What is odd, with the findings of reading.
    pub findings: Vec<Finding>,
}

/// One filter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterOutcome {
    /// As it is written: `savgol:5,2`.
    pub filter: String,
    /// What it does to any noise and frequency.
    #[serde(flatten)]
    pub response: Response,
    /// How often the channels are differentiated by time up to here: units are to be
    /// divided by s so many times.
    pub derivative: usize,
    /// False when it takes constants away, as a high-pass or a derivative does.
    pub keeps_constants: bool,
    /// Samples that were replaced as outliers; null for filters that replace none.
    pub replaced: Option<usize>,
    /// Noise at rest behind it.
    pub sigma: Sigmas,
}

/// Standard deviation at rest of each axis: the deviations from the mean of each
/// still, pooled. Behind a filter without the ends of each still, into which it spreads
/// the motion around. Null for what was not filtered, is not there or never still for
/// long enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Default)]
pub struct Sigmas {
    /// In the summary's `accel_unit`.
    pub accelerometer: Option<[f64; 3]>,
    /// In the summary's `gyro_unit`.
    pub gyroscope: Option<[f64; 3]>,
}

impl Sigmas {
    pub(super) fn of(recording: &Recording, channels: Channels, stills: &[Range<usize>]) -> Self {
        let of = |sensor: &[Vec<f64>; 3], nominal: Option<f64>| {
            let mut sigmas = [0.0; 3];
            for (sigma, channel) in sigmas.iter_mut().zip(sensor) {
                *sigma = pooled(channel, stills)? / nominal.unwrap_or(1.0);
            }
            Some(sigmas)
        };
        let gyro = recording.gyro.as_ref();
        Sigmas {
            accelerometer: (channels != Channels::Gyro)
                .then(|| of(&recording.accel, recording.accel_scale.nominal()))
                .flatten(),
            gyroscope: gyro
                .filter(|_| channels != Channels::Accel)
                .and_then(|g| of(g, recording.gyro_scale.and_then(|s| s.nominal()))),
        }
    }
}

/// √(Σ(x − mean of its still)²/Σ(n − 1)).
fn pooled(channel: &[f64], stills: &[Range<usize>]) -> Option<f64> {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for rows in stills {
        let there = || channel[rows.clone()].iter().filter(|v| v.is_finite());
        let n = there().count() as f64;
        if n < 2.0 {
            continue;
        }
        let mean = there().sum::<f64>() / n;
        squares += there().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        freedom += n - 1.0;
    }
    (freedom > 0.0).then(|| (squares / freedom).sqrt())
}

impl DenoiseSummary {
    pub(super) fn start(
        recording: &Recording,
        options: &DenoiseOptions,
        stills: &[Range<usize>],
    ) -> Self {
        DenoiseSummary {
            input: recording.name.clone(),
            description: recording.description.clone(),
            rows: recording.rows(),
            rate_hz: recording.timing.rate_hz(),
            stretches: 0,
            edge: options.edge,
            still_spans: stills.len(),
            still_rows: stills.iter().map(ExactSizeIterator::len).sum(),
            accel_unit: match recording.accel_scale.nominal() {
                Some(_) => "m/s^2",
                None => recording.accel_scale.unit.name(),
            },
            gyro_unit: match recording.gyro_scale {
                Some(scale) if scale.nominal().is_none() => scale.unit.name(),
                _ => "rad/s",
            },
            recorded: Sigmas::of(recording, options.channels, stills),
            filters: Vec::new(),
            columns: Vec::new(),
            findings: recording.findings.clone(),
        }
    }

    pub(super) fn add(
        &mut self,
        filter: &Filter,
        outcome: &Outcome,
        sigma: Sigmas,
        derivative: usize,
        recording: &Recording,
    ) {
        let spec = filter.spec();
        self.filters.push(FilterOutcome {
            filter: spec.to_string(),
            response: filter.response().clone(),
            derivative,
            keeps_constants: spec.keeps_constants(),
            replaced: matches!(spec, FilterSpec::Hampel { .. }).then_some(outcome.treated.replaced),
            sigma,
        });
        let told = told_of_filter(filter, outcome, self.rate_hz, recording.timing.duration_s);
        self.findings.extend(told);
    }

    pub(super) fn finish(&mut self, runner: &Runner, recording: &Recording) {
        self.stretches = runner.stretches();
        self.findings.extend(told_of_rows(
            runner.parted,
            runner.clock.gap_s,
            runner.stamps_filled,
            runner.empty,
        ));
        if self.still_spans == 0 {
            self.findings.push(Finding::new(
                FindingKind::NeverStill,
                "no span at rest was found: what the filters did to the noise of this recording is not known",
            ));
        }
        for finding in &mut self.findings {
            finding.file = Some(recording.name.clone());
        }
    }
}

/// What was done about samples that a filter could not take as they are.
pub(super) fn told_of_filter(
    filter: &Filter,
    outcome: &Outcome,
    rate_hz: Option<f64>,
    duration_s: Option<f64>,
) -> Vec<Finding> {
    let mut out = Vec::new();
    let (spec, treated) = (filter.spec(), &outcome.treated);
    let share = |n: usize| 100.0 * n as f64 / outcome.samples.max(1) as f64;
    if treated.fitted > 0 {
        out.push(
            Finding::new(
                FindingKind::FittedOverStamps,
                format!(
                    "{spec}: {:.2} % of the windows hold uneven steps; there the polynomial is fitted over the stamps, at the ends too",
                    share(treated.fitted)
                ),
            )
            .counting(treated.fitted as u64),
        );
    }
    if treated.too_few > 0 {
        out.push(
            Finding::new(
                FindingKind::TooFewStamps,
                format!(
                    "{spec}: in {:.2} % of the windows too many stamps are the same for this order; they are filtered as if even",
                    share(treated.too_few)
                ),
            )
            .counting(treated.too_few as u64),
        );
    }
    if treated.filled > 0 {
        out.push(
            Finding::new(
                FindingKind::LostSamplesFilled,
                format!(
                    "{spec}: {} lost samples ({:.2} %) were interpolated for the filter; they are not written",
                    treated.filled,
                    share(treated.filled)
                ),
            )
            .counting(treated.filled as u64),
        );
    }
    if treated.resampled > 0 {
        out.push(
            Finding::new(
                FindingKind::Resampled,
                format!(
                    "{spec}: {:.2} % of the samples came at uneven times; they were interpolated to {:.6} Hz and back, which smooths by itself (white noise to 0.6 at worst)",
                    share(treated.resampled),
                    rate_hz.unwrap_or(f64::NAN)
                ),
            )
            .counting(treated.resampled as u64),
        );
    }
    if treated.too_short > 0 {
        out.push(
            Finding::new(
                FindingKind::NotFiltered,
                format!(
                    "{spec}: {} stretches of channels are shorter than the {} samples it takes; their {} samples stay as they are",
                    outcome.short_stretches,
                    filter.shortest(),
                    treated.too_short
                ),
            )
            .counting(treated.too_short as u64),
        );
    }
    if let FilterSpec::Butterworth {
        passes: Passes::Causal,
        ..
    } = spec
    {
        out.push(Finding::new(
            FindingKind::Delayed,
            format!("{spec} runs forwards only: what it writes lags behind"),
        ));
    }
    if let FilterSpec::SavitzkyGolay { window, .. } = spec
        && window % 2 == 0
    {
        out.push(Finding::new(
            FindingKind::EvenWindow,
            format!("{spec}: an even window has its middle between two samples: the values belong half a step later; take {} or {}", window - 1, window + 1),
        ));
    }
    if let FilterSpec::Butterworth { band, .. } = spec
        && let Some(duration_s) = duration_s
        && let Some(slowest_hz) = band.edges_hz().first()
        && duration_s * slowest_hz < 1.0
    {
        out.push(Finding::new(
            FindingKind::ShortForCutoff,
            format!("{spec}: {slowest_hz} Hz takes {:.3} s a period and the recording lasts {duration_s:.3} s: the ends decide the result", 1.0 / slowest_hz),
        ));
    }
    out
}

/// What was done about rows: where filters begin anew, stamps that were filled in,
/// cells that are empty.
pub(super) fn told_of_rows(
    parted: Parted,
    gap_s: f64,
    stamps_filled: usize,
    empty: usize,
) -> Vec<Finding> {
    let mut out = Vec::new();
    if parted.gaps + parted.backward > 0 {
        let mut why = Vec::new();
        if parted.gaps > 0 {
            let steps = if parted.gaps == 1 { "step" } else { "steps" };
            why.push(format!(
                "{} {steps} of more than {:.3} s",
                parted.gaps, gap_s
            ));
        }
        if parted.backward > 0 {
            why.push(match parted.backward {
                1 => "1 stamp that runs backwards".to_owned(),
                n => format!("{n} stamps that run backwards"),
            });
        }
        out.push(
            Finding::new(
                FindingKind::Parted,
                format!("the filters begin anew at {}", why.join(" and ")),
            )
            .counting((parted.gaps + parted.backward) as u64),
        );
    }
    if stamps_filled > 0 {
        out.push(
            Finding::new(
                FindingKind::StampsFilled,
                format!(
                    "{} rows have no time stamp; they are taken to lie evenly between their neighbours",
                    stamps_filled
                ),
            )
            .counting(stamps_filled as u64),
        );
    }
    if empty > 0 {
        out.push(
            Finding::new(
                FindingKind::EmptyKept,
                format!(
                    "{} empty cells stay empty; the samples around them are filtered as if one were lost",
                    empty
                ),
            )
            .counting(empty as u64),
        );
    }
    out
}
