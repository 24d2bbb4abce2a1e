//! Results of filtering: numbers and findings.

use std::ops::Range;

use serde::Serialize;

use crate::numfmt::count;
use crate::recording::{Finding, FindingKind, Recording};

use super::engine::{ChannelSigmas, Counts, Done, GAP_STEPS, Setup, Treatment};
use super::filter::Filter;
use super::response::Response;
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
    /// Number of parts between breaks, gaps and steps back; filters restart in each.
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

/// The scales of the channels to m/s² and rad/s, where they are known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    accel: Option<f64>,
    gyro: Option<f64>,
}

impl Sigmas {
    fn of(channels: ChannelSigmas, scales: Scales) -> Self {
        let sensor = |first: usize, nominal: Option<f64>| {
            let scale = nominal.unwrap_or(1.0);
            let [x, y, z] = [0, 1, 2].map(|axis| channels[first + axis].map(|sigma| sigma / scale));
            Some([x?, y?, z?])
        };
        Sigmas {
            accelerometer: sensor(0, scales.accel),
            gyroscope: sensor(3, scales.gyro),
        }
    }
}

impl Scales {
    pub fn of(recording: &Recording) -> Self {
        Scales {
            accel: recording.accel_scale.nominal(),
            gyro: recording.gyro_scale.and_then(|s| s.nominal()),
        }
    }
}

impl DenoiseSummary {
    /// What is known before the filters run; `stills`: the rows of the static intervals.
    pub(super) fn start(recording: &Recording, stills: &[Range<usize>]) -> Self {
        DenoiseSummary {
            input: recording.name.clone(),
            description: recording.description.clone(),
            rows: recording.rows(),
            rate_hz: recording.timing.rate_hz(),
            segments: 0,
            static_intervals: stills.len(),
            static_rows: stills.iter().map(ExactSizeIterator::len).sum(),
            accel_unit: match recording.accel_scale.nominal() {
                Some(_) => "m/s^2",
                None => recording.accel_scale.unit.name(),
            },
            gyro_unit: match recording.gyro_scale {
                Some(scale) if scale.nominal().is_none() => scale.unit.name(),
                _ => "rad/s",
            },
            recorded: Sigmas::default(),
            filters: Vec::new(),
            columns: Vec::new(),
            findings: recording.findings.clone(),
        }
    }

    /// Adds the results of the filters.
    pub(super) fn finish(
        &mut self,
        setup: &Setup,
        done: Done,
        scales: Scales,
        duration_s: Option<f64>,
    ) {
        let mut noise = done.noise.into_iter();
        let mut sigmas = || {
            noise
                .next()
                .map_or_else(Sigmas::default, |n| Sigmas::of(n, scales))
        };
        self.recorded = sigmas();
        self.segments = done.counts.stretches;
        let mut derivative = 0;
        for (filter, treatment) in setup.filters.iter().zip(&done.treatments) {
            let spec = filter.spec();
            derivative += spec.derivative();
            self.filters.push(FilterOutcome {
                filter: spec.to_string(),
                response: filter.response().clone(),
                derivative,
                keeps_constants: spec.keeps_constants(),
                replaced: matches!(spec, FilterSpec::Hampel { .. }).then_some(treatment.replaced),
                sigma: sigmas(),
            });
        }
        self.findings
            .extend(findings(setup, &done.treatments, &done.counts, duration_s));
        if self.static_intervals == 0 {
            self.findings.push(Finding::new(
                FindingKind::NeverStatic,
                "no static interval was found: the effect of the filters on the noise of this recording is unknown",
            ));
        }
        for finding in &mut self.findings {
            finding.file = Some(self.input.clone());
        }
    }
}

/// Findings of all filters, and about rows.
pub(super) fn findings(
    setup: &Setup,
    treatments: &[Treatment],
    counts: &Counts,
    duration_s: Option<f64>,
) -> Vec<Finding> {
    let filters = setup.filters.iter().zip(treatments);
    let of_filters = filters.flat_map(|(f, treatment)| filter_findings(f, treatment, duration_s));
    let mut all: Vec<Finding> = of_filters.collect();
    all.extend(parted(counts, GAP_STEPS * setup.step_s));
    all
}

/// Findings about samples that needed special treatment.
fn filter_findings(
    filter: &Filter,
    treatment: &Treatment,
    duration_s: Option<f64>,
) -> Vec<Finding> {
    let mut out = Vec::new();
    let spec = filter.spec();
    let share = |n: usize| 100.0 * n as f64 / treatment.samples.max(1) as f64;
    if treatment.filled > 0 {
        out.push(
            Finding::new(
                FindingKind::LostSamplesFilled,
                format!(
                    "{spec}: {} lost samples ({:.2} %) were interpolated for the filter; they are not written",
                    treatment.filled,
                    share(treatment.filled)
                ),
            )
            .counting(treatment.filled as u64),
        );
    }
    if treatment.resampled > 0 {
        out.push(
            Finding::new(
                FindingKind::Resampled,
                format!(
                    "{spec}: {:.2} % of the samples are unevenly spaced; they were interpolated to {:.6} Hz and back, which also smooths (white noise to 0.6 at worst)",
                    share(treatment.resampled),
                    1.0 / filter.step_s()
                ),
            )
            .counting(treatment.resampled as u64),
        );
    }
    if treatment.too_short > 0 {
        out.push(
            Finding::new(
                FindingKind::NotFiltered,
                format!(
                    "{spec}: {} parts of channels are shorter than the {} samples it needs; their {} samples are left unchanged",
                    treatment.short_stretches,
                    filter.shortest(),
                    treatment.too_short
                ),
            )
            .counting(treatment.too_short as u64),
        );
    }
    if let FilterSpec::Butterworth { band, .. } = spec
        && let Some(duration_s) = duration_s
        && let Some(slowest_hz) = band.edges_hz().first()
        && duration_s * slowest_hz < 1.0
    {
        out.push(Finding::new(
            FindingKind::ShortForCutoff,
            format!("{spec}: {slowest_hz} Hz has a period of {:.3} s and the recording lasts {duration_s:.3} s: the result depends mainly on the treatment of the ends", 1.0 / slowest_hz),
        ));
    }
    out
}

/// Where filters restart.
fn parted(counts: &Counts, gap_s: f64) -> Option<Finding> {
    let mut why = Vec::new();
    if counts.gaps > 0 {
        let steps = count(counts.gaps, "step");
        why.push(format!("{steps} of more than {gap_s:.3} s"));
    }
    if counts.backward > 0 {
        let runs = if counts.backward == 1 { "runs" } else { "run" };
        let stamps = count(counts.backward, "stamp");
        why.push(format!("{stamps} that {runs} backwards"));
    }
    let text = format!("the filters restart at {}", why.join(" and "));
    let finding = Finding::new(FindingKind::Parted, text);
    (!why.is_empty()).then(|| finding.counting((counts.gaps + counts.backward) as u64))
}
