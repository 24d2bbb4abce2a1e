//! A filter designed for a sampling rate.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::butterworth::Butterworth;
use super::hampel::hampel;
use super::response::{Response, of_butterworth, of_weights};
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
/// assert!((filter.response().noise_gain - 0.697).abs() < 5e-4);
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

/// Number of normal random numbers for measuring the gain of a Hampel filter.
const TRIAL: usize = 20_000;

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
        let step_s = rate_hz.map_or(1.0, |rate| 1.0 / rate);
        let (kind, noise_gain, of_rate) = match *spec {
            FilterSpec::SavitzkyGolay {
                window,
                order,
                derivative,
            } => {
                let savgol = Savgol::new(window, order, derivative, step_s)?;
                let per_sample = step_s.powi(derivative as i32);
                let weights: Vec<f64> = savgol.weights().iter().map(|w| w * per_sample).collect();
                let (gain, of_rate) = of_weights(&weights, derivative);
                (Kind::Savgol(savgol), gain / per_sample, of_rate)
            }
            FilterSpec::Mean { window } => {
                let savgol = Savgol::new(window, 0, 0, step_s)?;
                let (gain, of_rate) = of_weights(savgol.weights(), 0);
                (Kind::Savgol(savgol), gain, of_rate)
            }
            FilterSpec::Butterworth {
                order,
                band,
                passes,
            } => {
                let rate = 1.0 / step_s;
                let butterworth = Butterworth::new(order, band, passes, rate)?;
                let of_rate = band.edges_hz().iter().map(|f| f / rate).collect();
                let gain = of_butterworth(order, band, passes, rate);
                (Kind::Butterworth(butterworth), gain, of_rate)
            }
            FilterSpec::Hampel { window, sigmas } => (
                Kind::Hampel { window, sigmas },
                gain_of_hampel(window, sigmas),
                Vec::new(),
            ),
        };
        Ok(Filter {
            spec: *spec,
            step_s,
            kind,
            response: Response {
                noise_gain,
                minus_3db_hz: rate_hz.map(|rate| match spec {
                    // Exactly as requested.
                    FilterSpec::Butterworth { band, .. } => band.edges_hz(),
                    _ => of_rate.iter().map(|share| share * rate).collect(),
                }),
                minus_3db_of_rate: of_rate,
            },
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
            FilterSpec::SavitzkyGolay { window, .. }
            | FilterSpec::Hampel { window, .. }
            | FilterSpec::Mean { window } => window / 2,
            FilterSpec::Butterworth { band, .. } => {
                let slowest_hz = band.edges_hz().first().copied().unwrap_or(1.0);
                (1.0 / (slowest_hz * self.step_s)).ceil() as usize
            }
        }
    }

    /// b₀, b₁, b₂, a₁, a₂ of the sections of a Butterworth filter, for one pass; empty for other
    /// filters.
    #[must_use]
    pub fn sections(&self) -> Vec<[f64; 5]> {
        let Kind::Butterworth(butterworth) = &self.kind else {
            return Vec::new();
        };
        let all = butterworth.sections().iter();
        all.map(|s| {
            let ([b0, b1, b2], [a1, a2]) = (s.forward(), s.back());
            [b0, b1, b2, a1, a2]
        })
        .collect()
    }

    /// Filters one channel of equally spaced samples without gaps, in place; fewer than
    /// [`shortest`](Self::shortest) are left unchanged. Returns the number of outliers that were
    /// replaced (Hampel; otherwise 0).
    ///
    /// The samples are not checked: a sample that is not finite spoils all results whose window
    /// contains it, and all results of a Butterworth filter. [`denoise`](super::denoise) handles
    /// such samples.
    pub fn apply(&self, samples: &mut [f64]) -> usize {
        let (filtered, replaced) = match &self.kind {
            Kind::Butterworth(butterworth) => {
                butterworth.apply(samples);
                return 0;
            }
            Kind::Savgol(savgol) => (savgol.filter(samples), 0),
            Kind::Hampel { window, sigmas } => hampel(samples, *window, *sigmas),
        };
        samples.copy_from_slice(&filtered);
        replaced
    }
}

/// A Hampel filter has no impulse response: its gain is measured on normal noise.
fn gain_of_hampel(window: usize, sigmas: f64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let noise: Vec<f64> = (0..TRIAL)
        .map(|_| StandardNormal.sample(&mut random))
        .collect();
    let square = |x: &[f64]| x.iter().map(|v: &f64| v * v).sum::<f64>();
    let (filtered, _) = hampel(&noise, window, sigmas);
    (square(&filtered) / square(&noise)).sqrt()
}
