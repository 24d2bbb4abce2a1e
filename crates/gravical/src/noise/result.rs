//! The noise of a sensor, as it is written and printed.

use gravical_judge::numfmt::duration_text;
use gravical_recording::source::Named;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{AllanPoint, Estimate, FittedCurve, NoiseFit, NoiseLimit};
use serde::{Deserialize, Serialize};

use super::Term;
use crate::Result;
use crate::calibration_file::{InputFile, InputRole};
use crate::finding::{Case, Finding};
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

/// Reads the result that `gravical noise` wrote, on the disk or in memory.
///
/// # Errors
///
/// `not-noise` for any other file; errors of the file system.
#[doc(hidden)]
pub fn read_noise<'a>(file: impl Into<Named<'a>>) -> Result<NoiseResult> {
    InputFile::read(file, InputRole::Noise, parse).map(|(result, _)| result)
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

    /// The estimates of a fit to `longest_s`.
    pub(super) fn take_estimates(&mut self, fit: &NoiseFit, longest_s: f64, walks: bool) {
        let what = format!("not observable in {}", duration_text(longest_s));
        let [.., edge] = fit.model.0;
        let places = [&mut self.n, &mut self.b, &mut self.k];
        for ((term, place), estimate) in Term::ALL.into_iter().zip(places).zip(fit.estimates) {
            let mut limit = estimate.err().unwrap_or_default();
            let reason = match (estimate, limit.record_s) {
                (Ok(estimate), _) if term == Term::K && !walks => {
                    limit.at_most = Some(estimate.high);
                    format!("{what}: {LIKE_A_TREND}")
                }
                (Ok(estimate), _) => {
                    *place = Some(estimate);
                    continue;
                }
                _ if term == Term::N && edge != 0.0 => {
                    limit.record_s = None;
                    HIDDEN_N.to_owned()
                }
                (_, Some(s)) => format!("{what}: record at least {}", duration_text(s)),
                (_, None) => format!("{what}, nor in a thousand times that"),
            };
            self.not_observable
                .push(NotObservable::new(term, reason, limit));
        }
    }

    /// What is odd about the fit.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let misfit = self.fit.and_then(|fit| fit.misfit);
        let misfit = misfit.map(|misfit| Case::NoiseMisfit {
            channel: self.channel.clone(),
            tau_s: misfit.tau_s,
            ratio: misfit.ratio,
        });
        let (unit, factor) = printed_unit(Term::B, self.is_gyroscope());
        let drift = self.fit.and_then(|fit| fit.drift);
        let drift = drift.map(|drift| Case::NoiseDrift {
            channel: self.channel.clone(),
            change: factor * drift.change,
            unit,
            during_s: drift.during_s,
            constant_s: drift.time_constant_s,
        });
        let cases = misfit.into_iter().chain(drift);
        cases.map(|case| case.finding()).collect()
    }

    /// True for an axis of the gyroscope.
    pub fn is_gyroscope(&self) -> bool {
        self.channel.starts_with('g')
    }
}

/// A term that this recording does not determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotObservable {
    /// `N`, `B` or `K`.
    pub term: String,
    /// Why, and what to do.
    pub reason: String,
    /// What is known of it.
    #[serde(flatten)]
    pub limit: NoiseLimit,
}

impl NotObservable {
    pub(super) fn new(term: Term, reason: String, limit: NoiseLimit) -> Self {
        let term = term.symbol().to_owned();
        NotObservable {
            term,
            reason,
            limit,
        }
    }
}

/// The unit in which a parameter of the gyroscope or of the accelerometer is printed, and printed values per
/// value in SI units.
#[doc(hidden)]
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
