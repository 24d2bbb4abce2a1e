//! Noise of a sensor at rest: Allan deviation, and what it says.
//!
//! # Overview
//!
//! [`noise`] reads a recording of a sensor that lies still and returns for each channel the
//! overlapping Allan deviation with its 95 % intervals, the noise density N, the bias instability B
//! and the random walk K with theirs, or why the recording does not determine them.
//!
//! - `allan`: the sums, sample by sample, in constant memory.
//! - `model`, `fit`: the terms, and the covariance of their estimates.
//! - `fold`: rows to samples; the static intervals of [`crate::poses`], gaps, the temperature.
//! - `density`: check of N by the power spectral density.
//! - `parts`: data sheets.
//!
//! Everything is in SI units, converted by the nominal scale: 3 % of scale error are 3 % of N.
//!
//! It fails where noise is not what the model says: vibration of the place and drift with
//! temperature look like noise of the sensor. Both are reported, neither can be removed afterwards.
//!
//! # Example
//!
//! ```
//! use gravical::noise::{NoiseOptions, noise_of_samples};
//! # let mut state = 1_u64;
//! # let mut uniform = move || {
//! #     state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
//! #     (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
//! # };
//!
//! // White noise of standard deviation 0.0289 at 100 Hz: N = 0.00289.
//! let samples: Vec<f64> = (0..50_000).map(|_| 0.1 * uniform()).collect();
//! let channel = noise_of_samples("ax", &samples, 0.01, &NoiseOptions::default());
//! let n = channel.n.unwrap();
//! assert!(n.low < 0.00289 && 0.00289 < n.high);
//! assert!(channel.k.is_none());
//! ```

mod allan;
mod density;
mod file;
mod fit;
mod fold;
mod model;
mod parts;
mod words;

use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::calibration_file::{CHANNELS, InputFile, NoiseParameters, NoiseSection};
use crate::finding::{Finding, FindingKind};
use crate::poses::check_units;
use crate::poses::gyro_unit::{Claims, Evidence, decide};
use crate::poses::rests::{find_quiet, find_rests, why_never_static};
use crate::poses::turns::motions;
use crate::recording::{self, ReadOptions, Recording};
use crate::stats::floors;
use crate::stats::moments;
use crate::{Error, Result};
use gravical_signal::{BLOCK_S, block_len, quantile};

pub use allan::{Allan, AllanSums, Lengths, Spacing, overlapping};
pub use file::{NOISE_FORMAT, read_noise};
pub use fit::{Estimate, NotObservable};
pub use model::Term;
pub use parts::{DataSheet, PARTS, Part};
pub use words::{Unit, duration_text};

use density::Density;
use fit::{Fit, Outcome, Points, chi_square_factors, fit};
use fold::{Channel, Fold, MEAN_S, Plan, Trend};
use model::{Model, Pairs};

/// Shortest static interval whose noise is analysed, s.
const SHORTEST_S: f64 = 10.0;
/// Static intervals of less than this share of the longest one are left out: a hand lets go of the
/// sensor at the start of each.
const LEAST_SHARE: f64 = 0.25;
/// A block whose standard deviation is this multiple of that of the median one is disturbed.
const DISTURBED: f64 = 3.0;
/// A temperature that moves by less than this is constant, °C.
const STEADY_C: f64 = 0.5;
/// Share of slow changes that the temperature explains, and the deviation from no dependence.
const EXPLAINED: f64 = 0.5;
const SIGNIFICANT: f64 = 5.0;
/// The density may differ from that of the model by this share of its power, and by so many
/// standard deviations.
const DENSITY_SHARE: f64 = 0.15;
const DENSITY_SIGMAS: f64 = 4.0;
/// Noise before rounding below this share of the resolution does not average it away
/// ([`gravical_core::rounding`]).
const LEAST_OF_RESOLUTION: f64 = 0.34;
/// Share of samples that are replaced beyond which it is a warning.
const MOST_FILLED_SHARE: f64 = 0.05;

/// Options of [`noise`].
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct NoiseOptions {
    /// octave, dense or decade
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "SPACING",
            default_value = "octave",
            hide_possible_values = true
        )
    )]
    pub spacing: Spacing,
    /// Every sample, for long times too; needs more memory
    #[cfg_attr(feature = "clap", arg(long))]
    pub full: bool,
    /// q (quantisation), r (rate ramp); repeatable
    #[serde(rename = "term")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "term", value_name = "TERM", hide_possible_values = true)
    )]
    pub further_terms: Vec<Term>,
    /// Compare with MPU6050, MPU9250 or ICM42688P
    #[serde(deserialize_with = "parts::optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART", value_parser = parts::part))]
    pub part: Option<&'static Part>,
}

impl NoiseOptions {
    /// Terms of the model: N, B and K, and the further ones.
    fn terms(&self) -> Vec<Term> {
        let mut terms = vec![Term::N, Term::B, Term::K];
        terms.extend(
            Term::ALL
                .into_iter()
                .skip(3)
                .filter(|t| self.further_terms.contains(t)),
        );
        terms
    }
}

/// Noise of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NoiseResult {
    /// `gravical-noise/1`.
    pub format: String,
    /// Program and version.
    pub tool: String,
    /// The recording.
    pub inputs: Vec<InputFile>,
    /// Text format of the recording in words.
    pub description: String,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Duration of the recording, s.
    pub recorded_s: f64,
    /// Duration of the samples that were used, s.
    pub used_s: f64,
    /// Number of static intervals that were used.
    pub static_intervals: usize,
    /// Number of segments between gaps.
    pub segments: u64,
    /// Lowest and highest temperature of the samples that were used, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Every second difference was taken.
    pub full: bool,
    /// One for each of ax, ay, az, gx, gy, gz that was recorded.
    pub channels: Vec<ChannelNoise>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

impl NoiseResult {
    /// The channel with this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&ChannelNoise> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// What a calibration file keeps.
    #[must_use]
    pub fn section(&self) -> NoiseSection {
        NoiseSection {
            rate_hz: self.rate_hz,
            used_s: self.used_s,
            channels: self.channels.iter().map(ChannelNoise::parameters).collect(),
        }
    }
}

/// Noise of one channel, in its [unit](Self::unit), seconds and hertz.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelNoise {
    /// `ax` … `gz`.
    pub channel: String,
    /// `m/s^2` or `rad/s`.
    pub unit: String,
    /// The Allan deviation.
    pub adev: Vec<AllanPoint>,
    /// Noise density (velocity or angle random walk), unit/√Hz; null if it is not observable.
    pub n: Option<Estimate>,
    /// Bias instability, unit.
    pub b: Option<Estimate>,
    /// Random walk (of the acceleration or rate), unit/√s.
    pub k: Option<Estimate>,
    /// Quantisation, unit·s; null unless requested.
    #[serde(default)]
    pub q: Option<Estimate>,
    /// Rate ramp, unit/s; null unless requested.
    #[serde(default)]
    pub r: Option<Estimate>,
    /// Terms that are not observable.
    pub not_observable: Vec<NotObservable>,
    /// The fitted curve; null without one.
    pub fit: Option<FittedCurve>,
    /// N by the power spectral density.
    pub density: Option<DensityCheck>,
    /// N by the data sheet.
    pub data_sheet: Option<DataSheet>,
    /// Dependence on the temperature, where it explains most of the slow changes.
    pub temperature: Option<TemperatureDrift>,
}

impl ChannelNoise {
    /// The estimate of a term.
    #[must_use]
    pub fn estimate(&self, term: Term) -> Option<&Estimate> {
        match term {
            Term::N => self.n.as_ref(),
            Term::B => self.b.as_ref(),
            Term::K => self.k.as_ref(),
            Term::Q => self.q.as_ref(),
            Term::R => self.r.as_ref(),
        }
    }

    /// Why a term is not observable.
    #[must_use]
    pub fn missing(&self, term: Term) -> Option<&NotObservable> {
        self.not_observable.iter().find(|t| t.term == term.symbol())
    }

    /// What a calibration file keeps.
    fn parameters(&self) -> NoiseParameters {
        let value = |term: Term| self.estimate(term).map(|e| e.value);
        let most = |term: Term| self.missing(term)?.at_most;
        NoiseParameters {
            channel: self.channel.clone(),
            n: value(Term::N),
            b: value(Term::B),
            k: value(Term::K),
            n_at_most: most(Term::N),
            b_at_most: most(Term::B),
            k_at_most: most(Term::K),
        }
    }

    /// True for an axis of the gyroscope.
    #[must_use]
    pub fn is_gyroscope(&self) -> bool {
        self.channel.starts_with('g')
    }
}

/// A point of the Allan deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AllanPoint {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Allan deviation.
    pub sigma: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Equivalent degrees of freedom of its square.
    pub edf: f64,
}

/// Parameters of the fitted curve; zero for a term that is not part of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FittedCurve {
    /// Shortest averaging time that was used, s.
    pub from_s: f64,
    /// N, B, K, Q, R.
    pub parameters: [f64; 5],
    /// Where the recording deviates most from the curve, by more than chance; null if nowhere.
    pub misfit: Option<Misfit>,
}

/// A deviation from the fitted curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Allan variance over that of the curve.
    pub ratio: f64,
}

impl FittedCurve {
    /// Allan deviation at an averaging time.
    #[must_use]
    pub fn deviation(&self, tau_s: f64) -> f64 {
        let terms = Term::ALL.iter().zip(self.parameters);
        let variance: f64 = terms.map(|(term, x)| x * x * term.shape(tau_s)).sum();
        variance.sqrt()
    }
}

/// N by the power spectral density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DensityCheck {
    /// N.
    pub n: f64,
    /// Band, Hz.
    pub band_hz: [f64; 2],
    /// Power in the band over that of the fitted curve.
    pub ratio: f64,
    /// Standard deviation of the ratio by chance.
    pub ratio_sd: f64,
}

/// Dependence of the slow changes on the temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TemperatureDrift {
    /// Change for each °C.
    pub slope_per_c: f64,
    /// Share of the variance of slow changes that it explains, 0 to 1.
    pub explained: f64,
}

/// Analyses the noise of the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// As [`read_samples`](crate::recording::read_samples); `unit-unknown`; `rate-unknown` (usage) without
/// time stamps and rate; `not-at-rest` without a static interval of ten seconds.
pub fn noise(path: &Path, read: &ReadOptions, options: &NoiseOptions) -> Result<NoiseResult> {
    noise_of(&recording::read_samples(path, read)?, options)
}

/// The same of a recording in memory.
///
/// # Errors
///
/// As [`noise`]; `averaged` (usage) if its rows are means of samples.
pub fn noise_of(recording: &Recording, options: &NoiseOptions) -> Result<NoiseResult> {
    recording.refuse_averaged("use `noise`, which reads the file")?;
    let mut fold = Fold::new(plan(recording)?, options);
    fold.take_recording(recording);
    finish(recording, fold, options)
}

/// Noise of one channel from samples in memory, `period_s` apart, which have to be finite; its
/// first letter is `g` for a gyroscope.
#[must_use]
pub fn noise_of_samples(
    channel: &str,
    samples: &[f64],
    period_s: f64,
    options: &NoiseOptions,
) -> ChannelNoise {
    // Without what only samples with gaps need: nothing is copied.
    let mut sums = Channel::new(period_s, options);
    sums.allan.push(samples);
    sums.density.push(samples);
    channel_noise(channel, sums, [period_s, 1.0], options, &Pairs::default())
}

/// What is used, and how.
fn plan(recording: &Recording) -> Result<Plan> {
    check_units(std::slice::from_ref(recording))?;
    let here = Path::new(&recording.name);
    let Some(rate_hz) = recording.timing.rate_hz() else {
        return Err(Error::usage(
            "rate-unknown",
            "there are no time stamps and no sampling rate: averaging times are unknown",
        )
        .at(here, None)
        .with_hint("give the rate: --rate 100"));
    };
    let ranges = find_quiet(recording);
    let longest = ranges.iter().map(Range::len).max().unwrap_or(0);
    let longest_s = longest as f64 / rate_hz;
    if longest_s < SHORTEST_S {
        let what = match longest {
            0 => format!(
                "the sensor is never at rest: {}",
                why_never_static(recording)
            ),
            _ => format!("the longest static interval takes {longest_s:.1} s"),
        };
        return Err(Error::input(
            "not-at-rest",
            format!("{what}: noise is what a sensor shows while nothing moves"),
        )
        .at(here, None)
        .with_hint("record the sensor while it lies still, away from fans and footsteps, for two hours or more; ten seconds are the least"));
    }
    let width = block_len(1.0 / rate_hz, BLOCK_S);
    let used = |range: &Range<usize>| range.len() as f64 >= LEAST_SHARE * longest as f64;
    let most_variance = DISTURBED.powi(2) * quiet_variance(recording, &ranges, width);
    Ok(Plan {
        ranges: ranges.into_iter().filter(used).collect(),
        period_s: 1.0 / rate_hz,
        channels: if recording.gyro.is_some() { 6 } else { 3 },
        most_variance,
        width,
    })
}

/// Variance of the accelerometer in the median block of `width` rows at rest, three axes together.
fn quiet_variance(recording: &Recording, rests: &[Range<usize>], width: usize) -> f64 {
    let starts = rests
        .iter()
        .flat_map(|rest| rest.clone().step_by(width).take(rest.len() / width));
    let variances = starts.map(|row| moments(&recording.accel, row..row + width).1);
    let rounding = floors(&recording.accel_resolution());
    quantile(variances.filter(|v| v.is_finite()).collect(), 0.5).max(rounding)
}

fn finish(recording: &Recording, fold: Fold, options: &NoiseOptions) -> Result<NoiseResult> {
    let mut findings = recording.findings.clone();
    let period_s = fold.period_s();
    let accel_per_si = recording.accel_scale.nominal().ok_or_else(|| {
        Error::input(
            "unit-unknown",
            "counts of unknown scale: the noise has no unit",
        )
        .at(Path::new(&recording.name), None)
        .with_hint("give the range: --accel-range 2")
    })?;
    let gyro_per_si = gyro_scale(recording, &mut findings);
    let mut counts = fold.counts.clone();
    counts.gaps += fold.channels.iter().map(|c| c.gaps).max().unwrap_or(0);
    let ranges = fold.ranges().to_vec();
    let mut channels = Vec::new();
    let mut filled = 0;
    let mut segments = 0;
    // The channels have the same segments, but where cells are empty.
    let pairs = Pairs::default();
    for (i, sums) in fold.channels.into_iter().enumerate() {
        let per_si = if i < 3 {
            Some(accel_per_si)
        } else {
            gyro_per_si
        };
        let Some(per_si) = per_si else { continue };
        filled = filled.max(sums.filled);
        let step = recording.resolution[i] / per_si;
        let deviation = sums.scatter.variance().sqrt() / per_si;
        segments = segments.max(sums.allan.segments());
        let mut channel = channel_noise(CHANNELS[i], sums, [period_s, per_si], options, &pairs);
        if channel.adev.is_empty() {
            findings.push(words::without_values(&channel));
            continue;
        }
        findings.extend(words::judge(&mut channel, step, deviation, period_s));
        channel.data_sheet = data_sheet(&channel, options.part);
        channels.push(channel);
    }
    let recorded_s = recording
        .timing
        .duration_s
        .unwrap_or(recording.rows() as f64 * period_s);
    let used_s = counts.rows.saturating_sub(counts.disturbed) as f64 * period_s;
    findings.extend(words::of_recording(
        recording, &ranges, &counts, filled, period_s,
    ));
    findings.extend(words::of_temperature(&channels, counts.temperature_c));
    Ok(NoiseResult {
        format: NOISE_FORMAT.to_owned(),
        tool: crate::TOOL.to_owned(),
        inputs: InputFile::of(std::slice::from_ref(recording)),
        description: recording.description.clone(),
        rate_hz: 1.0 / period_s,
        recorded_s,
        used_s,
        static_intervals: ranges.len(),
        segments,
        temperature_c: counts.temperature_c,
        full: options.full,
        channels,
        findings: findings
            .into_iter()
            .map(|finding| finding.in_file(&recording.name))
            .collect(),
    })
}

/// Units of the gyroscope per rad/s, by the rule of all commands; `None` without a gyroscope or if
/// its unit is unknown, which is a finding then.
fn gyro_scale(recording: &Recording, findings: &mut Vec<Finding>) -> Option<f64> {
    let claims = Claims::of(recording, None)?;
    let stills = find_rests(recording).spans;
    let moves = motions(recording, &stills);
    let evidence = Evidence::of(recording, &stills, &moves);
    let nominal = decide(claims, &evidence, findings).nominal();
    if nominal.is_none() {
        findings.push(Finding::warning(
            FindingKind::GyroUnitUnknown,
            "the scale of the gyroscope is unknown: its noise is left out (--gyro-unit, --gyro-range)",
        ));
    }
    nominal
}

/// The result of one channel; `per_si`: units of its values per unit of the result; `pairs` are
/// shared by channels.
fn channel_noise(
    name: &str,
    sums: Channel,
    [period_s, per_si]: [f64; 2],
    options: &NoiseOptions,
    pairs: &Pairs,
) -> ChannelNoise {
    let Channel {
        allan,
        density,
        trend,
        ..
    } = sums;
    let (sums, lengths) = allan.finish();
    let per_si2 = per_si * per_si;
    let m: Vec<f64> = sums.iter().map(|s| s.m as f64).collect();
    let variance: Vec<f64> = sums.iter().map(|s| s.variance() / per_si2).collect();
    // The fit is the same with any spacing.
    let is_octave = |i: &usize| sums[*i].m.is_power_of_two();
    let octaves: Vec<usize> = (0..sums.len()).filter(is_octave).collect();
    let of_octaves = |all: &[f64]| octaves.iter().map(|i| all[*i]).collect::<Vec<f64>>();
    let (fit_m, fit_variance) = (of_octaves(&m), of_octaves(&variance));
    let points = Points {
        m: &fit_m,
        variance: &fit_variance,
        lengths: &lengths,
        period_s,
        pairs,
    };
    let fitted = fit(&points, &options.terms());
    let model = fitted.as_ref().map_or(
        // White noise: the distribution of the points has to be that of some noise.
        Model {
            squares: [
                variance.first().copied().unwrap_or(0.0) * period_s,
                0.0,
                0.0,
                0.0,
                0.0,
            ],
            period_s,
        },
        |fit| fit.model,
    );
    let mut channel = ChannelNoise {
        channel: name.to_owned(),
        unit: if name.starts_with('g') {
            "rad/s"
        } else {
            "m/s^2"
        }
        .to_owned(),
        adev: allan_points(&m, &variance, &model, &points),
        n: None,
        b: None,
        k: None,
        q: None,
        r: None,
        not_observable: Vec::new(),
        fit: None,
        density: None,
        data_sheet: None,
        temperature: None,
    };
    let longest_s = lengths.iter().map(|l| l.samples).fold(0.0, f64::max) * period_s;
    if let Some(fit) = &fitted {
        take_fit(&mut channel, fit, &points, longest_s);
        channel.density = density_check(&density, fit, per_si2);
        channel.temperature = temperature_drift(&trend, per_si, &channel);
    } else {
        words::nothing_fitted(&mut channel, &options.terms(), &variance);
    }
    channel.data_sheet = data_sheet(&channel, options.part);
    channel
}

/// N beside that of the data sheet.
fn data_sheet(channel: &ChannelNoise, part: Option<&Part>) -> Option<DataSheet> {
    let part = part?;
    let n = match channel.is_gyroscope() {
        true => part.gyro_n(),
        false => part.accel_n(),
    };
    Some(DataSheet {
        part: part.name.to_owned(),
        n,
        ratio: channel.n.map(|e| e.value / n),
    })
}

fn allan_points(
    m: &[f64],
    variance: &[f64],
    model: &Model,
    fitted: &Points<'_>,
) -> Vec<AllanPoint> {
    let of_model = model.variances(m, fitted.lengths, fitted.pairs);
    let mut points = Vec::with_capacity(m.len());
    for ((m, variance), of_model) in m.iter().zip(variance).zip(of_model) {
        let edf = 2.0 * model.variance(*m).powi(2) / of_model;
        let sigma = variance.sqrt();
        if let Some([low, high]) = chi_square_factors(edf)
            && sigma.is_finite()
        {
            points.push(AllanPoint {
                tau_s: m * model.period_s,
                sigma,
                low: sigma * low,
                high: sigma * high,
                edf,
            });
        }
    }
    points
}

fn take_fit(channel: &mut ChannelNoise, fit: &Fit, points: &Points<'_>, longest_s: f64) {
    for (term, outcome) in &fit.outcomes {
        match outcome {
            Outcome::Known(estimate) => {
                let place = match term {
                    Term::N => &mut channel.n,
                    Term::B => &mut channel.b,
                    Term::K => &mut channel.k,
                    Term::Q => &mut channel.q,
                    Term::R => &mut channel.r,
                };
                *place = Some(*estimate);
            }
            Outcome::Unknown { at_most, record_s } => {
                let reason = words::not_observable(*term, longest_s, *record_s);
                channel.not_observable.push(NotObservable {
                    term: term.symbol().to_owned(),
                    reason,
                    at_most: *at_most,
                    record_s: *record_s,
                });
            }
        }
    }
    channel.fit = Some(FittedCurve {
        from_s: points.m[fit.from] * points.period_s,
        parameters: fit.model.squares.map(f64::sqrt),
        misfit: fit.misfit.map(|(at, ratio)| Misfit {
            tau_s: points.m[at] * points.period_s,
            ratio,
        }),
    });
}

fn density_check(density: &Density, fit: &Fit, per_si2: f64) -> Option<DensityCheck> {
    let (ratio, ratio_sd, band_hz) = density.ratio(|hz| fit.model.density(hz) * per_si2)?;
    let n = fit.model.squares[Term::N as usize].sqrt();
    Some(DensityCheck {
        n: n * ratio.sqrt(),
        band_hz,
        ratio,
        ratio_sd,
    })
}

/// The dependence on the temperature, if it explains the slow changes.
fn temperature_drift(
    trend: &Trend,
    per_si: f64,
    channel: &ChannelNoise,
) -> Option<TemperatureDrift> {
    if trend.count < 10.0 {
        return None;
    }
    // White noise of the means is no slow change; its sum of squares is known up to chance.
    let white = channel.n.map_or(0.0, |n| n.value.powi(2)) / MEAN_S;
    let squares = trend.squares / (per_si * per_si);
    let slow = (squares - white * trend.count).max(white * (2.0 * trend.count).sqrt());
    let slope = trend.slope() / per_si;
    let by_temperature = slope * slope * trend.squares_c;
    let significant = by_temperature.sqrt() > SIGNIFICANT * white.sqrt();
    let explained = (by_temperature / slow).min(1.0);
    (slope.is_finite() && significant && explained > EXPLAINED).then_some(TemperatureDrift {
        slope_per_c: slope,
        explained,
    })
}

#[cfg(test)]
mod tests;
