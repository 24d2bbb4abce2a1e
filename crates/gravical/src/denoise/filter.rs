//! Filters as text (`savgol:5,2`, `butter:4,5Hz` …), and designed for a sampling rate.
//!
//! **Savitzky–Golay** (Analytical Chemistry 36, 1964): a polynomial is fitted to the samples around each
//! one. Powers of the points lose all but three digits (window 101, order 8); Chebyshev polynomials on
//! −1 … 1 lose none.
//!
//! **Butterworth**, forwards and backwards. Two passes square the response, so that the filter is designed for
//! another cutoff, at which |H|⁴ = 1/2: x²ⁿ = √2 − 1. With Ω = tan(πf/f_s) and q = (√2 − 1)^(1/2n) a
//! low-pass is designed for Ω_c/q, a high-pass for Ω_c·q. The ends are treated as in scipy's
//! `sosfiltfilt`: 3(n + 1) samples are added at each by odd reflection about the end point, and each pass
//! starts in the steady state of its first sample (the method of F. Gustafsson, IEEE Transactions on
//! Signal Processing 44, 1996, is better but needs a fit).
//!
//! **Hampel** (JASA 69, 1974; as a filter R. K. Pearson, IEEE Transactions on Control Systems Technology
//! 10, 2002): a sample that deviates from the median of its window by more than a number of robust
//! standard deviations is replaced by that median. The standard deviation is 1.4826 times the median
//! deviation from the median. If that is zero (more than half of the window has one value, as with a
//! coarse resolution), it is 1.2533 times the mean deviation (Iglewicz and Hoaglin 1993): otherwise every
//! other value would be an outlier.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};
use std::fmt;
use std::str::FromStr;

use gravical_core::filter::biquad::Biquad;
use gravical_core::filter::butterworth::{MAX_ORDER, Pass, design, sections_of};
use gravical_signal::stats::median;
use nalgebra::{DMatrix, DVector};

use crate::problem::Problem;
use crate::{Error, Result};

/// The longest window, samples; of Hampel, which sorts the window of each sample.
const MAX_WINDOW: usize = 10_001;
const MAX_HAMPEL: usize = 1001;
/// The highest order of a polynomial, tested to 1e-12.
const MAX_POLYNOMIAL: usize = 12;
/// Least distance of a cutoff from 0 and from half the rate, as a share of the rate; below it too many
/// digits are lost: the gain at zero frequency is off by 1e-7 there.
const MIN_SHARE: f64 = 1e-5;
/// 1/Φ⁻¹(3/4).
const FROM_MEDIAN: f64 = 1.482_602_218_505_602;
/// √(π/2).
const FROM_MEAN: f64 = 1.253_314_137_315_500_1;
/// Samples summed at once, so that they stay in the first-level cache.
const BLOCK: usize = 1024;

/// Specification of a filter; [`Filter::design`] designs it for a sampling rate.
///
/// ```
/// use gravical::denoise::FilterSpec;
///
/// let spec: FilterSpec = "butter:4,5Hz".parse()?;
/// assert_eq!(spec.to_string(), "butter:4,5Hz");
/// assert!("butter:4".parse::<FilterSpec>().is_err());
/// # Ok::<(), gravical::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilterSpec {
    /// `savgol:WINDOW,ORDER`: a polynomial fitted to the samples around each one.
    SavitzkyGolay {
        /// Samples, odd, 1 to 10,001.
        window: usize,
        /// Degree of the polynomial, 0 to 12 and below the window.
        order: usize,
    },
    /// `butter:ORDER,CUTOFFHz`, `highpass:ORDER,CUTOFFHz`: forwards and backwards, without a delay.
    Butterworth {
        /// 1 to 8.
        order: usize,
        /// The frequency at which the gain of both passes together is −3 dB, Hz, above 0 and below half
        /// the rate.
        cutoff_hz: f64,
        /// Frequencies above the cutoff pass, not those below.
        is_high_pass: bool,
    },
    /// `hampel:WINDOW,SIGMAS`: a value too far from the median of its neighbours is replaced by
    /// that median.
    Hampel {
        /// Samples, odd, 3 to 1001.
        window: usize,
        /// Largest accepted deviation in robust standard deviations, 0 to 1e6; 0 gives a running
        /// median.
        sigmas: f64,
    },
}

impl FilterSpec {
    /// Checks the ranges that do not depend on the rate.
    ///
    /// # Errors
    ///
    /// `filter-range` (usage), with the range.
    pub fn validate(&self) -> Result<()> {
        let is_odd = |window: usize| !window.is_multiple_of(2);
        let is_within = match *self {
            FilterSpec::SavitzkyGolay { window, order } => {
                is_odd(window) && window <= MAX_WINDOW && order < window.min(MAX_POLYNOMIAL + 1)
            }
            FilterSpec::Butterworth {
                order, cutoff_hz, ..
            } => (1..=MAX_ORDER).contains(&order) && cutoff_hz > 0.0 && cutoff_hz.is_finite(),
            FilterSpec::Hampel { window, sigmas } => {
                is_odd(window)
                    && (3..=MAX_HAMPEL).contains(&window)
                    && (0.0..=1e6).contains(&sigmas)
            }
        };
        if is_within {
            return Ok(());
        }
        let problem = Problem::FilterRange {
            filter: self.to_string(),
            window: MAX_WINDOW,
            hampel: MAX_HAMPEL,
            polynomial: MAX_POLYNOMIAL,
        };
        Err(problem.error())
    }

    /// True if a constant is unchanged.
    pub fn keeps_constants(&self) -> bool {
        match self {
            FilterSpec::Butterworth { is_high_pass, .. } => !is_high_pass,
            _ => true,
        }
    }

    /// Its result depends on the time between samples.
    pub(super) fn needs_even_steps(&self) -> bool {
        !matches!(self, FilterSpec::Hampel { .. })
    }
}

impl fmt::Display for FilterSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            FilterSpec::SavitzkyGolay { window, order } => write!(f, "savgol:{window},{order}"),
            FilterSpec::Butterworth {
                order,
                cutoff_hz,
                is_high_pass,
            } => {
                let name = if is_high_pass { "highpass" } else { "butter" };
                write!(f, "{name}:{order},{cutoff_hz}Hz")
            }
            FilterSpec::Hampel { window, sigmas } => write!(f, "hampel:{window},{sigmas}"),
        }
    }
}

impl FromStr for FilterSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let spec = parse(&text.to_ascii_lowercase()).ok_or_else(|| {
            let text = text.to_owned();
            Problem::NoFilter { text }.error()
        })?;
        spec.validate()?;
        Ok(spec)
    }
}

fn parse(text: &str) -> Option<FilterSpec> {
    let (name, arguments) = text.split_once(':')?;
    let (first, second) = arguments.split_once(',')?;
    let (first, second) = (first.trim().parse().ok()?, second.trim());
    Some(match name.trim() {
        "savgol" => FilterSpec::SavitzkyGolay {
            window: first,
            order: second.parse().ok()?,
        },
        "hampel" => FilterSpec::Hampel {
            window: first,
            sigmas: second.parse().ok()?,
        },
        name @ ("butter" | "highpass") => FilterSpec::Butterworth {
            order: first,
            cutoff_hz: second.trim_end_matches("hz").trim_end().parse().ok()?,
            is_high_pass: name == "highpass",
        },
        _ => return None,
    })
}

/// A [`FilterSpec`] designed for a sampling rate.
///
/// ```
/// use gravical::denoise::Filter;
///
/// let filter = Filter::design(&"savgol:5,2".parse()?, Some(100.0))?;
/// let mut x = [0.0, 1.0, 4.0, 9.0, 16.0, 25.0];
/// filter.apply(&mut x);
/// assert!((x[3] - 9.0).abs() < 1e-12, "a parabola is unchanged");
/// assert!((filter.noise_gain().unwrap() - 0.697).abs() < 5e-4);
/// # Ok::<(), gravical::Error>(())
/// ```
pub struct Filter {
    pub(super) spec: FilterSpec,
    /// Fewer samples are left unchanged.
    pub(super) shortest: usize,
    /// Samples on each side that affect a value: half a window, or a period of the cutoff.
    pub(super) reach: usize,
    /// Samples until its response to an impulse ends; `None` without one.
    memory: Option<usize>,
    run: Run,
}

/// From evenly spaced samples, as many as the filter needs or more, to as many.
type Run = Box<dyn Fn(&[f64]) -> Vec<f64>>;

impl Filter {
    /// Designs a filter for samples at `rate_hz`.
    ///
    /// At the ends polynomials go on from the last full window (scipy's `interp`), Butterworth
    /// filters reflect about the last sample, Hampel filters truncate their window.
    ///
    /// # Errors
    ///
    /// `rate-unknown` (usage) for a filter in Hz without a rate; `filter-range` (usage) for impossible
    /// parameters, for example a cutoff above half the rate.
    pub fn design(spec: &FilterSpec, rate_hz: Option<f64>) -> Result<Filter> {
        spec.validate()?;
        let run: Run;
        let (shortest, reach, memory) = match *spec {
            FilterSpec::SavitzkyGolay { window, order } => {
                let smooth = savitzky_golay(window, order).ok_or_else(|| {
                    let filter = spec.to_string();
                    Problem::PolynomialOpen { filter }.error()
                })?;
                run = Box::new(smooth);
                (window, window / 2, Some(window))
            }
            FilterSpec::Butterworth {
                order,
                cutoff_hz,
                is_high_pass,
            } => {
                let rate_hz = rate_hz.ok_or_else(|| {
                    let filter = spec.to_string();
                    let error = Problem::FilterWithoutRate { filter }.error();
                    error.advise("rate", "")
                })?;
                let (sections, decay) = butterworth(order, cutoff_hz, is_high_pass, rate_hz)?;
                let padding = 3 * (order + 1);
                run = Box::new(move |x: &[f64]| run_sections(&sections, padding, x));
                let period = (rate_hz / cutoff_hz).ceil() as usize;
                (padding + 1, period, Some(decay + padding + 1))
            }
            FilterSpec::Hampel { window, sigmas } => {
                run = Box::new(move |x: &[f64]| hampel(x, window, sigmas));
                (1, window / 2, None)
            }
        };
        Ok(Filter {
            spec: *spec,
            shortest,
            reach,
            memory,
            run,
        })
    }

    /// Standard deviation of white noise after the filter over that before it: the root of the sum of
    /// squares of its impulse response. `None` for Hampel, which has no impulse response.
    pub fn noise_gain(&self) -> Option<f64> {
        let memory = self.memory?;
        let mut response = vec![0.0; 2 * memory + 1];
        response[memory] = 1.0;
        self.apply(&mut response);
        Some(response.iter().map(|h| h * h).sum::<f64>().sqrt())
    }

    /// Filters one channel of equally spaced samples without gaps, in place; too few for the filter are
    /// left unchanged. Returns the number of samples that changed.
    ///
    /// The samples are not checked: a sample that is not finite spoils all results whose window
    /// contains it, and all results of a Butterworth filter. [`denoise`](super::denoise) handles
    /// such samples.
    pub fn apply(&self, samples: &mut [f64]) -> usize {
        if samples.len() < self.shortest {
            return 0;
        }
        let filtered = (self.run)(samples);
        let mut changed = 0;
        for (sample, filtered) in samples.iter_mut().zip(filtered) {
            changed += usize::from(*sample != filtered);
            *sample = filtered;
        }
        changed
    }
}

/// The sections of one pass, and the samples in which they decay to e⁻²⁵.
fn butterworth(
    order: usize,
    cutoff_hz: f64,
    is_high_pass: bool,
    rate_hz: f64,
) -> Result<(Vec<Biquad<f64>>, usize)> {
    let share = cutoff_hz / rate_hz;
    if !(share > MIN_SHARE && share < 0.5 - MIN_SHARE) {
        let margin_hz = MIN_SHARE * rate_hz;
        return Err(Problem::Cutoff { rate_hz, margin_hz }.error());
    }
    let q = (SQRT_2 - 1.0).powf(0.5 / order as f64);
    let omega = (PI * share).tan();
    let omega = if is_high_pass { omega * q } else { omega / q };
    let designed_hz = rate_hz / PI * omega.atan();
    let mut sections = vec![Biquad::default(); sections_of(order)];
    let pass = if is_high_pass { Pass::High } else { Pass::Low };
    design(pass, order, designed_hz, rate_hz, &mut sections)
        .map_err(|why| Problem::NoDesign { why }.error())?;
    // The pole nearest to the unit circle, (1 + s)/(1 − s) of s = Ω exp(±i(π/2 + π/2n)).
    let near = 2.0 * omega * (FRAC_PI_2 / order as f64).sin();
    let squared_radius = (1.0 + omega * omega - near) / (1.0 + omega * omega + near);
    Ok((sections, (-50.0 / squared_radius.ln()).ceil() as usize))
}

/// Forwards and backwards, with `padding` samples added at each end.
fn run_sections(sections: &[Biquad<f64>], padding: usize, x: &[f64]) -> Vec<f64> {
    // Odd reflection about the end points: value and slope are continuous.
    let n = x.len();
    let before = (1..=padding).rev().map(|i| 2.0 * x[0] - x[i]);
    let after = (1..=padding).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]);
    let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        // From the steady state of the first sample. One section after the other: its state stays in
        // registers, and the numbers are those of the sections run together.
        let mut steady = y[0];
        for mut section in sections.iter().copied() {
            steady = section.settle(steady);
            y.iter_mut().for_each(|v| *v = section.update(*v));
        }
        y.reverse();
    }
    y[padding..padding + n].to_vec()
}

/// The filter; `window` is odd and above `order`. `None` if the window does not determine the polynomial.
/// Samples are equally spaced, so that one set of weights is used for all.
fn savitzky_golay(window: usize, order: usize) -> Option<impl Fn(&[f64]) -> Vec<f64>> {
    let points = (0..window).flat_map(|i| chebyshev(order, position(i, window)));
    let qr = DMatrix::from_row_iterator(window, order + 1, points).qr();
    // Chebyshev coefficients of the fit by the samples of a window: R⁻¹Qᵀ.
    let fit = qr.r().solve_upper_triangular(&qr.q().transpose())?;
    // For the middle of a window.
    let weights = fit.tr_mul(&DVector::from_vec(chebyshev(order, 0.0)));
    Some(move |x: &[f64]| {
        let (n, ends) = (x.len(), window / 2);
        let mut y = vec![0.0; n];
        for (block, y) in y[ends..n - ends].chunks_mut(BLOCK).enumerate() {
            for (k, weight) in weights.iter().enumerate() {
                y.iter_mut()
                    .zip(&x[BLOCK * block + k..])
                    .for_each(|(y, x)| *y += weight * x);
            }
        }
        // At the ends the fit to the last full window goes on (scipy's `interp`).
        for (start, rows) in [(0, 0..ends), (n - window, n - ends..n)] {
            let fit = &fit * DVector::from_column_slice(&x[start..start + window]);
            for row in rows {
                let basis = chebyshev(order, position(row - start, window));
                y[row] = basis.iter().zip(&fit).map(|(b, c)| b * c).sum();
            }
        }
        y
    })
}

/// `x` with its outliers replaced. A window that reaches beyond `x` is truncated.
fn hampel(x: &[f64], window: usize, sigmas: f64) -> Vec<f64> {
    let half = window / 2;
    let mut values = Vec::with_capacity(window);
    let filtered = x.iter().enumerate().map(|(i, &value)| {
        values.clear();
        values.extend_from_slice(&x[i.saturating_sub(half)..(i + half + 1).min(x.len())]);
        let middle = median(&mut values).unwrap_or(value);
        let off = (value - middle).abs();
        values.iter_mut().for_each(|v| *v = (*v - middle).abs());
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let typical = median(&mut values).unwrap_or(0.0);
        let deviation = if typical > 0.0 {
            FROM_MEDIAN * typical
        } else {
            FROM_MEAN * mean
        };
        if off > sigmas * deviation {
            middle
        } else {
            value
        }
    });
    filtered.collect()
}

/// Place of a sample in its window, from −1 to 1.
fn position(i: usize, window: usize) -> f64 {
    let half_width = 0.5 * (window as f64 - 1.0);
    (i as f64 - half_width) / half_width.max(1.0)
}

/// The Chebyshev polynomials T₀ … T_order: T_(m+1) = 2x T_m − T_(m−1).
fn chebyshev(order: usize, x: f64) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for m in 1..order {
        values.push(2.0 * x * values[m] - values[m - 1]);
    }
    values.truncate(order + 1);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_are_replaced_by_the_median() {
        let mut x: Vec<f64> = (0..40).map(|i| f64::from(i * 7 % 5)).collect();
        let clean = x.clone();
        (x[0], x[20], x[39]) = (50.0, -30.0, 50.0);
        let filtered = hampel(&x, 7, 3.0);
        assert_eq!((filtered[0], filtered[20], filtered[39]), (3.0, 2.0, 3.0));
        assert_eq!(filtered[1..20], clean[1..20]);
        assert_eq!(filtered[21..39], clean[21..39]);
        // More than half of a window is one value: steps of a coarse resolution stay.
        let coarse: Vec<f64> = (0..42).map(|i| f64::from(i % 3 / 2)).collect();
        assert_eq!(hampel(&coarse, 7, 3.0), coarse);
        assert_eq!(hampel(&coarse, 3, 0.0)[5], 0.0);
    }

    #[test]
    fn text_round_trips() {
        let texts = "savgol:5,2 savgol:5,0 butter:2,44.5Hz highpass:1,0.05Hz hampel:7,3 hampel:7,0";
        for text in texts.split(' ') {
            let spec: FilterSpec = text.parse().unwrap();
            assert_eq!(spec.to_string(), text);
        }
        for text in [" Butter: 4 , 5 hz", "butter:4,5", "butter:4,5e0Hz"] {
            let spec: FilterSpec = text.parse().unwrap();
            assert_eq!(spec.to_string(), "butter:4,5Hz");
        }
    }

    #[test]
    fn invalid_filters_are_refused() {
        let syntax = "savgol savgol: savgol:5 savgol:5,2,1 savgol1:5,2 savgol:-5,2 savgol:5.5,2 \
                      butter:4 butter:4, butter:4,x butter:four,5Hz kalman:1,2 butter:4,1-2Hz \
                      hampel:5 mean:5 butter1:4,5Hz butter:4,5-Hz 5,2 savgol:99999999999999999999,2";
        let range = "savgol:5,5 savgol:0,0 savgol:6,2 savgol:99,13 savgol:99999,2 butter:0,5Hz \
                     butter:9,5Hz butter:4,0Hz butter:4,-5Hz butter:4,nan \
                     butter:4,infHz hampel:4,3 hampel:1,3 hampel:1003,3 hampel:5,-1 hampel:5,nan";
        for (texts, code) in [
            ("", "filter-syntax"),
            (syntax, "filter-syntax"),
            (range, "filter-range"),
        ] {
            for text in texts.split(' ') {
                let error = text.parse::<FilterSpec>().unwrap_err();
                assert_eq!(error.code(), code, "{text}");
            }
        }
    }
}
