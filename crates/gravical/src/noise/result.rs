//! The noise of a sensor, as it is written and printed.

use std::f64::consts::PI;
use std::path::Path;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{AllanVariance, NoiseFit, NoiseLimit, NoiseModel, chi_square_factors};
use serde::{Deserialize, Serialize};

use super::Term;
use crate::Result;
use crate::calibration_file::{InputFile, InputRole};
use crate::finding::{Case, Finding};
use crate::numfmt::duration_text;
use crate::problem::Problem;

/// Value of `format`.
pub(super) const NOISE_FORMAT: &str = "gravical-noise/1";
/// Why N is not seen, however long the recording.
const HIDDEN_N: &str = "not visible: no averaging time is beyond the low-pass and below the wander of the bias; set a wider low-pass and a faster rate";
/// Why K is not given where a trend explains the recording as well.
const LIKE_A_TREND: &str =
    "a drift of the bias explains it as well; record at constant temperature, and for longer";

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
    /// One for each of ax, ay, az, gx, gy, gz that was recorded.
    pub channels: Vec<ChannelNoise>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

#[cfg(feature = "schema")]
impl NoiseResult {
    /// JSON schema of the file.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(NoiseResult).to_value()
    }
}

/// Reads the result that `gravical noise` wrote.
///
/// # Errors
///
/// `not-noise` for any other file; errors of the file system.
pub fn read_noise(path: impl AsRef<Path>) -> Result<NoiseResult> {
    let path = path.as_ref();
    InputFile::read(path, InputRole::Noise, parse).map(|(result, _)| result)
}

fn parse(bytes: &[u8]) -> Result<NoiseResult> {
    let result: NoiseResult = serde_json::from_slice(bytes)
        .map_err(|e| Problem::NoNoise { why: e.to_string() }.error())?;
    if result.format != NOISE_FORMAT {
        let (format, wanted) = (result.format, NOISE_FORMAT);
        return Err(Problem::OtherFormat { format, wanted }.error());
    }
    let estimates = result.channels.iter().flat_map(|c| [c.n, c.b, c.k]);
    let mut values = estimates.flatten().map(|e| e.value);
    if !values.all(|value| value.is_finite() && value > 0.0) {
        return Err(Problem::NotPositive.error());
    }
    Ok(result)
}

/// Noise of one channel, in its [unit](Self::unit), seconds and hertz.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelNoise {
    /// `ax` … `gz`.
    pub channel: String,
    /// `m/s^2` or `rad/s`.
    pub unit: String,
    /// The Allan deviation, without the noise of rounding and without drift.
    pub adev: Vec<AllanPoint>,
    /// Noise density (velocity or angle random walk), unit/√Hz; null if it is not observable.
    pub n: Option<Estimate>,
    /// Bias instability, unit.
    pub b: Option<Estimate>,
    /// Random walk (of the acceleration or rate), unit/√s.
    pub k: Option<Estimate>,
    /// Terms that are not observable.
    pub not_observable: Vec<NotObservable>,
    /// The fitted curve; null without one.
    pub fit: Option<FittedCurve>,
}

impl ChannelNoise {
    /// The estimate of a term.
    pub fn estimate(&self, term: Term) -> Option<&Estimate> {
        [&self.n, &self.b, &self.k][term as usize].as_ref()
    }

    /// Why a term is not observable.
    pub fn missing(&self, term: Term) -> Option<&NotObservable> {
        self.not_observable.iter().find(|t| t.term == term.symbol())
    }

    /// The estimates of a fit to `longest_s`; N may be off by so much more than its interval, relative.
    pub(super) fn take_estimates(&mut self, fit: &NoiseFit, longest_s: f64, walks: bool, off: f64) {
        let what = format!("not observable in {}", duration_text(longest_s));
        let is_filtered = fit.model.0[3] != 0.0;
        let mut estimates = [None; 3];
        for (i, term) in Term::ALL.into_iter().enumerate() {
            let value = fit.model.0[i].sqrt();
            let off = if term == Term::N { off } else { 0.0 };
            let mut limit = fit.intervals[i].err().unwrap_or_default();
            let reason = match (fit.intervals[i], limit.record_s) {
                (Ok([_, high]), _) if term == Term::K && !walks => {
                    limit.at_most = Some(value * high);
                    format!("{what}: {LIKE_A_TREND}")
                }
                (Ok([low, high]), _) => {
                    let (low, high) = (value * low * (1.0 - off), value * high * (1.0 + off));
                    estimates[i] = Some(Estimate { value, low, high });
                    continue;
                }
                _ if term == Term::N && is_filtered => {
                    limit.record_s = None;
                    HIDDEN_N.to_owned()
                }
                (_, Some(s)) => format!("{what}: record at least {}", duration_text(s)),
                (_, None) => format!("{what}, nor in a thousand times that"),
            };
            self.leave_out(term, reason, limit);
        }
        [self.n, self.b, self.k] = estimates;
    }

    pub(super) fn leave_out(&mut self, term: Term, reason: String, limit: NoiseLimit) {
        self.not_observable.push(NotObservable {
            term: term.symbol().to_owned(),
            reason,
            at_most: limit.at_most,
            record_s: limit.record_s,
        });
    }

    /// True for an axis of the gyroscope.
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

impl AllanPoint {
    /// Distributed as under a model; `None` without any degrees of freedom.
    pub(super) fn new(point: &AllanVariance, model: &NoiseModel) -> Option<Self> {
        let sigma = point.variance.sqrt();
        let edf = point.degrees_of_freedom(model);
        let [low, high] = chi_square_factors(edf).filter(|_| sigma.is_finite())?;
        Some(AllanPoint {
            tau_s: point.tau_s,
            sigma,
            low: sigma * low,
            high: sigma * high,
            edf,
        })
    }
}

/// Parameters of the fitted curve; zero for a term that is not part of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FittedCurve {
    /// Shortest averaging time that was used, s.
    pub from_s: f64,
    /// N, B, K.
    pub parameters: [f64; 3],
    /// Cut-off frequency (−3 dB) of the low-pass that was seen, if it has one pole, Hz; null without one. Two
    /// poles (Butterworth) are at 0.71 of it.
    pub low_pass_hz: Option<f64>,
    /// Drift of the bias that is not random, and not part of it; null where there is none.
    pub drift: Option<Drift>,
    /// Where the recording deviates most from the curve, by more than chance; null if nowhere.
    pub misfit: Option<Misfit>,
}

/// A drift of the bias along a line or an exponential.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Drift {
    /// Change of the bias, unit.
    pub change: f64,
    /// Time in which it changes so, that of the longest segment, s.
    pub during_s: f64,
    /// Time constant of warming up, s; null for a line.
    pub time_constant_s: Option<f64>,
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
    pub(super) fn new(fit: &NoiseFit, drift: Option<Drift>) -> Self {
        let [n, b, k, edge] = fit.model.0;
        // One pole of time constant T takes ends of 3/2 T: e = −3/2 N² T.
        let low_pass_hz = 1.5 * n / (-2.0 * PI * edge);
        FittedCurve {
            from_s: fit.from_s,
            parameters: [n, b, k].map(f64::sqrt),
            low_pass_hz: Some(low_pass_hz).filter(|hz| hz.is_finite() && *hz > 0.0),
            drift,
            misfit: fit.misfit.map(|(tau_s, ratio)| Misfit { tau_s, ratio }),
        }
    }

    /// What is odd about it.
    pub(super) fn findings(&self, channel: &str) -> Vec<Finding> {
        let misfit = self.misfit.map(|misfit| Case::NoiseMisfit {
            channel: channel.to_owned(),
            tau_s: misfit.tau_s,
            ratio: misfit.ratio,
        });
        let (unit, factor) = printed_unit(Term::B, channel.starts_with('g'));
        let drift = self.drift.map(|drift| Case::NoiseDrift {
            channel: channel.to_owned(),
            change: factor * drift.change,
            unit,
            during_s: drift.during_s,
            constant_s: drift.time_constant_s,
        });
        let cases = misfit.into_iter().chain(drift);
        cases.map(|case| case.finding()).collect()
    }

    /// Allan deviation at an averaging time.
    pub fn deviation(&self, tau_s: f64) -> f64 {
        let [n, b, k] = self.parameters.map(|x| x * x);
        NoiseModel([n, b, k, 0.0]).variance(tau_s).sqrt()
    }
}

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A term that this recording does not determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotObservable {
    /// `N`, `B` or `K`.
    pub term: String,
    /// Why, and what to do.
    pub reason: String,
    /// Upper limit (95 %), in the unit of the term; null if there is none.
    pub at_most: Option<f64>,
    /// Length of a recording that would show a term as large as the limit, s; null if even a
    /// thousand times the length would not.
    pub record_s: Option<f64>,
}

/// The unit in which a parameter of the gyroscope or of the accelerometer is printed, and printed values per
/// value in SI units.
pub fn printed_unit(term: Term, gyroscope: bool) -> (&'static str, f64) {
    let g = STANDARD_GRAVITY_MPS2;
    let degrees = 1_f64.to_degrees();
    match (gyroscope, term) {
        (false, Term::N) => ("µg/√Hz", 1e6 / g),
        (false, Term::B) => ("mg", 1e3 / g),
        (false, Term::K) => ("mg/√h", 1e3 / g * 60.0),
        (true, Term::N) => ("°/√h", degrees * 60.0),
        (true, Term::B) => ("°/h", degrees * 3600.0),
        (true, Term::K) => ("°/h/√h", degrees * 3600.0 * 60.0),
    }
}
