//! A filter designed for a sampling rate.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use serde::Serialize;

use super::butterworth::Butterworth;
use super::hampel::hampel;
use super::savgol::Savgol;
use super::spec::{EXAMPLES, FilterSpec};
use crate::{Error, Result};

/// A [`FilterSpec`] designed for a sampling rate.
///
/// ```
/// use gravical::denoise::Filter;
///
/// let filter = Filter::design(&"savgol:5,2".parse()?, Some(100.0))?;
/// let mut x = [0.0, 1.0, 4.0, 9.0, 16.0, 25.0];
/// filter.apply(&mut x);
/// assert!((x[3] - 9.0).abs() < 1e-12, "a parabola is unchanged");
/// assert!((filter.response().noise_gain.unwrap() - 0.697).abs() < 5e-4);
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct Filter {
    pub(super) spec: FilterSpec,
    /// Time between even samples, s; 1 if the rate is unknown.
    step_s: f64,
    kind: Kind,
    response: Response,
}

enum Kind {
    /// Also the moving average: a polynomial of order 0.
    Savgol(Savgol),
    Butterworth(Butterworth),
    Hampel {
        window: usize,
        sigmas: f64,
    },
}

impl Filter {
    /// Designs a filter for samples at `rate_hz`.
    ///
    /// At the ends polynomials go on from the last full window (scipy's `interp`), Butterworth
    /// filters reflect about the last sample, Hampel filters truncate their window.
    ///
    /// # Errors
    ///
    /// `rate-unknown` (usage) for a filter in Hz or a derivative without a rate; `filter-range`
    /// (usage) for impossible parameters, for example a cutoff above half the rate.
    pub fn design(spec: &FilterSpec, rate_hz: Option<f64>) -> Result<Filter> {
        spec.validate()?;
        if rate_hz.is_none() && spec.needs_rate() {
            return Err(Error::usage(
                "rate-unknown",
                format!("{spec} needs the sampling rate, and the recording has no time stamps"),
            )
            .of_option("rate")
            .with_hint("give the rate in Hz"));
        }
        let step_s = rate_hz.map_or(1.0, f64::recip);
        let kind = match *spec {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => {
                let savgol = Savgol::new(window, order, derivative, step_s).ok_or_else(|| {
                    let what = format!("{spec}: the window does not determine the polynomial");
                    Error::usage("filter-range", what).with_hint(EXAMPLES)
                })?;
                Kind::Savgol(savgol)
            }
            FilterSpec::Butterworth {
                order,
                band,
                passes,
            } => Kind::Butterworth(Butterworth::new(order, band, passes, 1.0 / step_s)?),
            FilterSpec::Hampel { window, sigmas } => Kind::Hampel { window, sigmas },
        };
        let minus_3db_of_rate: Vec<f64> = match (&kind, spec) {
            (Kind::Savgol(savgol), _) => {
                let per_sample = step_s.powi(spec.derivative() as i32);
                let weights: Vec<f64> = savgol.weights().iter().map(|w| w * per_sample).collect();
                minus_3db(&weights, spec.derivative())
            }
            (_, FilterSpec::Butterworth { band, .. }) => {
                band.edges_hz().iter().map(|f| f * step_s).collect()
            }
            _ => Vec::new(),
        };
        let response = Response {
            noise_gain: kind.noise_gain(),
            minus_3db_hz: rate_hz.map(|rate| match spec {
                // Exactly as requested.
                FilterSpec::Butterworth { band, .. } => band.edges_hz(),
                _ => minus_3db_of_rate.iter().map(|share| share * rate).collect(),
            }),
            minus_3db_of_rate,
        };
        Ok(Filter {
            spec: *spec,
            step_s,
            kind,
            response,
        })
    }

    /// Its effect on white noise and its −3 dB frequencies.
    #[must_use]
    pub fn response(&self) -> &Response {
        &self.response
    }

    /// Fewer samples than this are left unchanged.
    #[must_use]
    pub fn shortest(&self) -> usize {
        match &self.kind {
            Kind::Savgol(savgol) => savgol.window(),
            Kind::Butterworth(butterworth) => butterworth.shortest(),
            Kind::Hampel { .. } => 1,
        }
    }

    /// Its result depends on the time between samples.
    pub(super) fn needs_even_steps(&self) -> bool {
        !matches!(self.kind, Kind::Hampel { .. })
    }

    /// Number of samples on each side that affect a value: half a window, or a period of the
    /// lowest cutoff.
    pub(super) fn reach(&self) -> usize {
        match self.spec {
            FilterSpec::SavitzkyGolay { window, .. } | FilterSpec::Hampel { window, .. } => {
                window / 2
            }
            FilterSpec::Butterworth { band, .. } => {
                let slowest_hz = band.edges_hz().first().copied().unwrap_or(1.0);
                (1.0 / (slowest_hz * self.step_s)).ceil() as usize
            }
        }
    }

    /// Filters one channel of equally spaced samples without gaps, in place; fewer than
    /// [`shortest`](Self::shortest) are left unchanged. Returns the number of outliers that were
    /// replaced (Hampel; otherwise 0).
    ///
    /// The samples are not checked: a sample that is not finite spoils all results whose window
    /// contains it, and all results of a Butterworth filter. [`denoise`](super::denoise) handles
    /// such samples.
    pub fn apply(&self, samples: &mut [f64]) -> usize {
        if samples.len() < self.shortest() {
            return 0;
        }
        let (filtered, replaced) = self.kind.filter(samples);
        samples.copy_from_slice(&filtered);
        replaced
    }
}

impl Kind {
    /// The filtered samples, and the number of outliers that were replaced.
    fn filter(&self, x: &[f64]) -> (Vec<f64>, usize) {
        match self {
            Kind::Savgol(savgol) => (savgol.filter(x), 0),
            Kind::Butterworth(butterworth) => (butterworth.filter(x), 0),
            Kind::Hampel { window, sigmas } => hampel(x, *window, *sigmas),
        }
    }

    /// Root of the sum of squares of the impulse response; none for a filter that has none.
    fn noise_gain(&self) -> Option<f64> {
        let reach = match self {
            Kind::Savgol(savgol) => savgol.window(),
            Kind::Butterworth(butterworth) => butterworth.memory(),
            Kind::Hampel { .. } => return None,
        };
        let mut impulse = vec![0.0; 2 * reach + 1];
        impulse[reach] = 1.0;
        let (response, _) = self.filter(&impulse);
        Some(response.iter().map(|h| h * h).sum::<f64>().sqrt())
    }
}

/// Properties of a filter that do not depend on the recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// Standard deviation of white noise after the filter over that before it: the root of the
    /// sum of squares of its impulse response. For a derivative of order d in 1/sᵈ. Null for
    /// Hampel, which has no impulse response.
    pub noise_gain: Option<f64>,
    /// Frequencies with a gain of 1/√2 (−3 dB), as a share of the sampling rate: none if the gain
    /// never falls so far, two for a band-pass. For a derivative: where it is 1/√2 of the true
    /// one.
    pub minus_3db_of_rate: Vec<f64>,
    /// The same in Hz; null without a sampling rate.
    pub minus_3db_hz: Option<Vec<f64>>,
}

/// The frequency as a share of the rate, if there is one, at which the gain of weights falls to −3 dB; for a
/// derivative of order `derivative` with respect to the sample index, relative to the true one.
fn minus_3db(weights: &[f64], derivative: usize) -> Vec<f64> {
    let relative = |share: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, w) in weights.iter().enumerate() {
            let (sin, cos) = (TAU * share * k as f64).sin_cos();
            re += w * cos;
            im += w * sin;
        }
        f64::hypot(re, im) / (TAU * share).powi(derivative as i32)
    };
    // Fine enough to find every dip: lobes are about 1/window wide.
    let step = 1.0 / (32.0 * weights.len().max(4) as f64);
    let down = |share: f64| relative(share) < FRAC_1_SQRT_2;
    let steps = (0.5 / step) as usize;
    let crossing = (1..=steps)
        .map(|i| i as f64 * step)
        .find(|share| down(*share))
        .map(|at| {
            let (mut low, mut high) = (at - step, at);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if middle > 0.0 && down(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            0.5 * (low + high)
        });
    crossing.into_iter().collect()
}
