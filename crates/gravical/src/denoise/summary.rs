//! Results of filtering: numbers and findings.

use std::ops::Range;

use serde::Serialize;

use crate::finding::finding;
use crate::numfmt::count;
use crate::recording::{Finding, Recording};

use super::filter::{Filter, Response};
use super::rows::{ChannelSigmas, Done};
use super::spec::FilterSpec;

/// Result of [`denoise`](super::denoise).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DenoiseSummary {
    /// Path of the recording as given, `-` for standard input.
    pub input: String,
    /// Text format in words.
    pub description: String,
    /// Number of rows.
    pub rows: usize,
    /// The rate that the filters were designed for, Hz; null if unknown.
    pub rate_hz: Option<f64>,
    /// Number of parts between breaks, gaps, uneven steps and steps back; filters restart in each.
    pub segments: usize,
    /// Number of static intervals in which the noise was measured.
    pub static_intervals: usize,
    /// Number of rows of these intervals.
    pub static_rows: usize,
    /// Unit of the accelerometer's standard deviations: `m/s^2` if the unit of the file is known,
    /// otherwise that of the file.
    pub accel_unit: &'static str,
    /// Unit of the gyroscope's standard deviations: `rad/s` if that of the file is known.
    pub gyro_unit: &'static str,
    /// Noise before filtering.
    pub recorded: Sigmas,
    /// The filters in the order in which they ran.
    pub filters: Vec<FilterOutcome>,
    /// Names of the columns that were written; empty before writing.
    pub columns: Vec<String>,
    /// All findings, including those of reading.
    pub findings: Vec<Finding>,
}

/// Result of one filter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterOutcome {
    /// As text: `savgol:5,2`.
    pub filter: String,
    /// Its effect on white noise, and its −3 dB frequencies.
    #[serde(flatten)]
    pub response: Response,
    /// Order of the derivative of the channels after this filter: their units must be divided by
    /// s to this power.
    pub derivative: usize,
    /// False if it removes constants, as a high-pass or a derivative does.
    pub keeps_constants: bool,
    /// Number of samples replaced as outliers; null for filters that do not replace any.
    pub replaced: Option<usize>,
    /// Noise at rest after it.
    pub sigma: Sigmas,
}

/// Standard deviation of each axis at rest: the deviations from the mean of each static interval,
/// pooled. After a filter, without the ends of each interval, into which it spreads motion. Null
/// if the sensor was not filtered, does not exist or was not static for long enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Default)]
pub struct Sigmas {
    /// In the summary's `accel_unit`.
    pub accelerometer: Option<[f64; 3]>,
    /// In the summary's `gyro_unit`.
    pub gyroscope: Option<[f64; 3]>,
}

impl Sigmas {
    /// `nominal`: units of the file per m/s² and rad/s, where they are known.
    fn new(channels: &ChannelSigmas, nominal: [Option<f64>; 2]) -> Self {
        let [accelerometer, gyroscope] = [0, 1].map(|sensor| {
            let scale = nominal[sensor].unwrap_or(1.0);
            let axis = |axis: usize| channels[3 * sensor + axis].map(|sigma| sigma / scale);
            Some([axis(0)?, axis(1)?, axis(2)?])
        });
        Sigmas {
            accelerometer,
            gyroscope,
        }
    }
}

impl DenoiseSummary {
    /// Of a recording that was filtered; `rests`: the rows of its static intervals.
    pub(super) fn new(
        recording: &Recording,
        rests: &[Range<usize>],
        filters: &[Filter],
        done: &Done,
    ) -> Self {
        let (accel, gyro) = (recording.accel_scale, recording.gyro_scale);
        let nominal = [accel.nominal(), gyro.and_then(|s| s.nominal())];
        let mut sigmas = done.noise.iter().map(|n| Sigmas::new(n, nominal));
        let recorded = sigmas.next().unwrap_or_default();
        let mut derivative = 0;
        let outcomes = filters.iter().zip(&done.treatments).zip(sigmas);
        let outcomes = outcomes.map(|((filter, treatment), sigma)| {
            let spec = filter.spec;
            derivative += spec.derivative();
            FilterOutcome {
                filter: spec.to_string(),
                response: filter.response().clone(),
                derivative,
                keeps_constants: spec.keeps_constants(),
                replaced: matches!(spec, FilterSpec::Hampel { .. }).then_some(treatment.replaced),
                sigma,
            }
        });
        let filtered = outcomes.collect();
        let mut all = recording.findings.clone();
        all.extend(findings(filters, done, recording.timing.duration_s));
        if rests.is_empty() {
            all.push(finding!(
                NeverStatic,
                "no static interval was found: the effect of the filters on the noise of this recording is unknown"
            ));
        }
        DenoiseSummary {
            input: recording.name.clone(),
            description: recording.description.clone(),
            rows: recording.rows(),
            rate_hz: recording.timing.rate_hz(),
            segments: done.parts,
            static_intervals: rests.len(),
            static_rows: rests.iter().map(ExactSizeIterator::len).sum(),
            accel_unit: nominal[0].map_or(accel.unit.name(), |_| "m/s^2"),
            gyro_unit: match gyro {
                Some(scale) if nominal[1].is_none() => scale.unit.name(),
                _ => "rad/s",
            },
            recorded,
            filters: filtered,
            columns: Vec::new(),
            findings: all
                .into_iter()
                .map(|f| f.in_file(&recording.name))
                .collect(),
        }
    }
}

/// Findings of all filters, and about rows.
pub(super) fn findings(filters: &[Filter], done: &Done, duration_s: Option<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (filter, treatment) in filters.iter().zip(&done.treatments) {
        let spec = filter.spec;
        if treatment.too_short > 0 {
            let finding = finding!(
                NotFiltered,
                "{spec}: {} parts of channels are shorter than the {} samples it needs; their {} samples are left unchanged",
                treatment.short_stretches,
                filter.shortest(),
                treatment.too_short
            );
            findings.push(finding.counting(treatment.too_short as u64));
        }
        if let FilterSpec::Butterworth { band, .. } = spec
            && let Some(duration_s) = duration_s
            && let Some(slowest_hz) = band.edges_hz().first()
            && duration_s * slowest_hz < 1.0
        {
            findings.push(finding!(
                ShortForCutoff,
                "{spec}: {slowest_hz} Hz has a period of {:.3} s and the recording lasts {duration_s:.3} s: the result depends mainly on the treatment of the ends",
                1.0 / slowest_hz
            ));
        }
    }
    if done.restarts > 0 {
        let times = count(done.restarts, "time");
        let finding = finding!(
            Parted,
            "the filters restart {times}, where a time step is negative, longer than ten usual ones or no whole number of them"
        );
        findings.push(finding.counting(done.restarts as u64));
    }
    findings
}
