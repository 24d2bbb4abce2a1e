//! A filter designed for a sampling rate.

use super::butterworth::Butterworth;
use super::hampel::hampel;
use super::response::{Response, minus_3db};
use super::savgol::Savgol;
use super::spec::FilterSpec;
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
    spec: FilterSpec,
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
            } => Kind::Savgol(Savgol::new(window, order, derivative, step_s)),
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

    /// The specification.
    #[must_use]
    pub fn spec(&self) -> &FilterSpec {
        &self.spec
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

    /// Time between even samples, s; 1 if the rate is unknown.
    pub(super) fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Its result depends on the time between samples.
    pub(super) fn needs_even_steps(&self) -> bool {
        matches!(
            self.spec,
            FilterSpec::SavitzkyGolay { .. } | FilterSpec::Butterworth { .. }
        )
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
