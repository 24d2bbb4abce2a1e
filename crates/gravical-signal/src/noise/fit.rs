//! Fit of the model to Allan variances, with intervals.
//!
//! Non-negative least squares on the variance, six times reweighted by the variances of the points
//! under the fitted model: weights from the points themselves would prefer those that happen to be
//! small. Points of overlapping samples are correlated, so the covariance of the squares is A V Aᵀ, A
//! the matrix of the fit. A square x with variance s² is distributed nearly as χ² with 2x²/s² degrees
//! of freedom, which give its 95 % interval.
//!
//! A low-pass leaves the white noise of averaging times beyond its own memory as it is, but for what it
//! takes from the two ends of each mean: N²/τ + e/τ², with e < 0 fitted beside the terms.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::allan::AllanVariance;
use super::model::{NoiseModel, NoiseTerm, chi_square_factors, shapes};
use super::trend::Drift;

/// Real noise follows the model to about this fraction of the variance: without it the first
/// averaging times, known to a thousandth, would decide all terms.
const MODEL_ERROR: f64 = 0.01;
const REWEIGHTINGS: usize = 6;
/// A term with fewer degrees of freedom, a standard deviation of more than 35 %, is not
/// observable.
const MIN_FREEDOM: f64 = 4.0;
/// Deviation of a point that the model does not explain, in standard deviations.
const MAX_DEVIATION: f64 = 4.0;
/// The same behind a low-pass, where a part of it that is left would bias N.
const MAX_DEVIATION_FILTERED: f64 = 2.0;
/// Points at the short end that have to agree with the model, and fewest points of a fit.
const TESTED: usize = 3;
const MIN_POINTS: usize = 6;
/// Octaves that are left out after those that disagree visibly: what they may hide has decayed then.
const MORE: usize = 1;
/// A low-pass is seen where e has more degrees of freedom: it differs from zero by four standard deviations.
const MIN_EDGE_FREEDOM: f64 = 32.0;
/// Behind a low-pass, N is seen where all else is less than this part of the Allan variance: the slope
/// of the deviation is −½ to 0.1 there.
const MAX_ELSE: f64 = 0.2;
/// A random walk leads, with a slope near +½, over a factor of 4: from this part of the longest segment
/// to half of it, where averaging times end.
const WALK_FROM: f64 = 1.0 / 8.0;
/// The longest recording that is proposed is 2 to this power times as long.
const MAX_DOUBLINGS: i32 = 10;
/// Standard normal quantile of a one-sided 95 % limit.
const ONE_SIDED: f64 = 1.645;
/// Column of e, after those of the terms.
const EDGE: usize = 3;

/// A fit of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseFit {
    /// Zero for what is not part of it
    pub model: NoiseModel,
    /// The same as it is written
    pub curve: FittedCurve,
    /// N, B and K, or the limit of a term that is not observable
    pub estimates: [Result<Estimate, NoiseLimit>; 3],
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

/// What a recording says of a term that it does not determine.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NoiseLimit {
    /// Upper limit (95 %), in the unit of the term; null if there is none.
    pub at_most: Option<f64>,
    /// Length of a recording that would show a term as large as the limit, s; null if even a
    /// thousand times the length would not.
    pub record_s: Option<f64>,
}

/// Points and a model of them.
#[derive(Clone, Copy)]
struct Fit<'a> {
    points: &'a [AllanVariance],
    model: NoiseModel,
}

impl<'a> Fit<'a> {
    /// The best model, with the ends of a low-pass or without.
    fn new(points: &'a [AllanVariance], has_edge: bool) -> Option<Self> {
        let model = NoiseModel::WHITE;
        let white = Fit { points, model };
        let relative = points.iter().zip(white.deviations());
        let first = relative.map(|(p, sd)| sd / model.variance(p.tau_s) * p.variance);
        let first = white.non_negative(&first.collect::<Vec<f64>>(), has_edge)?;
        (0..REWEIGHTINGS).try_fold(first, |fit, _| {
            fit.non_negative(&fit.deviations(), has_edge)
        })
    }

    /// The best of all models without a negative square.
    fn non_negative(&self, deviations: &[f64], has_edge: bool) -> Option<Self> {
        let variances = self.points.iter().map(|p| p.variance);
        let variances = DVector::from_iterator(self.points.len(), variances);
        let fits = (1..8_usize).filter_map(|terms| {
            let is_fitted = |c: &usize| (terms | usize::from(has_edge) << EDGE) >> c & 1 == 1;
            let columns: Vec<usize> = (0..=EDGE).filter(is_fitted).collect();
            let solved = self.solver(deviations, &columns)? * &variances;
            let mut model = NoiseModel::default();
            columns
                .iter()
                .zip(&solved)
                .for_each(|(c, x)| model.0[*c] = *x);
            let fit = Fit { model, ..*self };
            let misfit: f64 = fit.residuals(deviations).iter().map(|x| x * x).sum();
            let is_possible = model.0[..EDGE].iter().all(|square| *square >= 0.0);
            is_possible.then_some((misfit, fit))
        });
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }

    /// The matrix that makes these coefficients of the variances, by least squares.
    fn solver(&self, deviations: &[f64], columns: &[usize]) -> Option<DMatrix<f64>> {
        let count = self.points.len();
        let mut design = DMatrix::from_fn(count, columns.len(), |i, j| {
            shapes(self.points[i].tau_s)[columns[j]] / deviations[i]
        });
        let norms: Vec<f64> = design.column_iter().map(|c| c.norm()).collect();
        for (mut column, norm) in design.column_iter_mut().zip(&norms) {
            column /= *norm;
        }
        let inverse = design.pseudo_inverse(1e-12).ok()?;
        let scale = |j: usize, i: usize| inverse[(j, i)] / (norms[j] * deviations[i]);
        let scaled = DMatrix::from_fn(columns.len(), count, scale);
        scaled.iter().all(|x| x.is_finite()).then_some(scaled)
    }

    /// Standard deviations of the points, the error of the model included.
    fn deviations(&self) -> Vec<f64> {
        let deviation = |p: &AllanVariance| {
            let by_chance = p.deviation(&self.model, 0.0);
            by_chance.hypot(MODEL_ERROR * self.model.variance(p.tau_s))
        };
        self.points.iter().map(deviation).collect()
    }

    /// Deviations of the points from the model, in standard deviations.
    fn residuals(&self, deviations: &[f64]) -> Vec<f64> {
        let points = self.points.iter().zip(deviations);
        let residuals = points.map(|(p, sd)| (p.variance - self.model.variance(p.tau_s)) / sd);
        residuals.collect()
    }

    /// True if the points at the short end agree with the model.
    fn agrees(&self, within: f64) -> bool {
        let residuals = self.residuals(&self.deviations());
        residuals.iter().take(TESTED).all(|x| x.abs() < within)
    }

    /// Variance of a coefficient in a fit of it and all that are part of the model.
    fn coefficient_variance(&self, column: usize) -> Option<f64> {
        let is_fitted = |c: &usize| *c == column || self.model.0[*c] != 0.0;
        let columns: Vec<usize> = (0..=EDGE).filter(is_fitted).collect();
        let solver = self.solver(&self.deviations(), &columns)?;
        let row = solver.row(columns.iter().position(|c| *c == column)?);
        let covariance = DMatrix::from_fn(row.len(), row.len(), |i, j| {
            let (a, b) = (&self.points[i], &self.points[j]);
            let octaves = (a.tau_s / b.tau_s).log2().abs();
            a.deviation(&self.model, octaves) * b.deviation(&self.model, octaves)
        });
        Some((row * covariance * row.transpose())[(0, 0)])
    }

    /// Degrees of freedom of a coefficient that is observable.
    fn freedom(&self, column: usize) -> Option<f64> {
        let variance = self.coefficient_variance(column)?;
        Some(2.0 * self.model.0[column].powi(2) / variance).filter(|n| *n >= MIN_FREEDOM)
    }

    /// True where the slope of the Allan deviation shows the term.
    fn shows(&self, term: NoiseTerm, longest_s: f64) -> bool {
        let is_white = |p: &AllanVariance| {
            let [white, b, k, edge] = self.model.parts(p.tau_s);
            (b + k + edge).abs().max(edge.abs()) < MAX_ELSE * white
        };
        let [n, b, k, _] = self.model.parts(WALK_FROM * longest_s);
        match term {
            NoiseTerm::N => self.model.0[EDGE] == 0.0 || self.points.iter().any(is_white),
            NoiseTerm::B => true,
            NoiseTerm::K => k > n + b,
        }
    }

    /// Upper limit of a term that is not observable, and how long a recording would show it.
    fn limit(&self, term: usize, period_s: f64, longest: usize) -> Option<NoiseLimit> {
        let mut limit = *self;
        // The term itself adds to its own uncertainty.
        for _ in 0..10 {
            let deviation = Some(limit.coefficient_variance(term)?.sqrt());
            let deviation = deviation.filter(|sd| sd.is_finite())?;
            limit.model.0[term] = self.model.0[term] + ONE_SIDED * deviation;
        }
        let shows = |length: &usize| {
            let first = (self.points[0].tau_s / period_s).round() as usize;
            let octaves = (0..).map(|k| first << k);
            let octaves = octaves.take_while(|m| (*m as f64) < 0.4 * *length as f64);
            // Only their number counts: values are those of the model, as if without a low-pass.
            let planned = octaves.map(|m| AllanVariance::new(m, period_s, f64::NAN, &[*length]));
            let points = &planned.collect::<Vec<_>>();
            let mut longer = Fit { points, ..limit };
            longer.model.0[EDGE] = 0.0;
            longer.freedom(term).is_some()
        };
        let mut lengths = (1..=MAX_DOUBLINGS).map(|k| longest << k);
        Some(NoiseLimit {
            at_most: Some(limit.model.0[term].sqrt()),
            record_s: lengths.find(shows).map(|n| n as f64 * period_s),
        })
    }
}

/// Fits N, B and K to Allan variances in octaves; the longest segment has `longest` samples, `period_s`
/// apart. `None` with fewer than two points, or if a variance is zero.
///
/// A low-pass is seen if the first points contradict the model, or if e is not zero. The points that
/// the model with e does not explain are then left out.
pub fn fit_noise(points: &[AllanVariance], longest: usize, period_s: f64) -> Option<NoiseFit> {
    let is_usable = |p: &AllanVariance| p.variance.is_finite() && p.variance > 0.0;
    if points.len() < 2 || !points.iter().all(is_usable) {
        return None;
    }
    let edge_freedom = Fit::new(points, true).and_then(|fit| fit.freedom(EDGE));
    let is_filtered = edge_freedom.is_some_and(|n| n > MIN_EDGE_FREEDOM);
    let plain = Fit::new(points, false).filter(|fit| !is_filtered && fit.agrees(MAX_DEVIATION));
    let fit = plain.or_else(|| {
        let last = points.len().saturating_sub(MIN_POINTS);
        let filtered = |first: usize| Fit::new(&points[first..], true);
        let agrees =
            |first: &usize| filtered(*first).is_some_and(|fit| fit.agrees(MAX_DEVIATION_FILTERED));
        let first = (0..=last).find(agrees);
        filtered(first.map_or(last, |first| (first + MORE).min(last)))
    })?;
    let residuals = fit.points.iter().zip(fit.residuals(&fit.deviations()));
    let (worst, misfit) = residuals.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let misfit = (misfit.abs() > MAX_DEVIATION).then(|| Misfit {
        tau_s: worst.tau_s,
        ratio: worst.variance / fit.model.variance(worst.tau_s),
    });
    let estimate = |term: NoiseTerm| {
        let shown = Some(term as usize).filter(|_| fit.shows(term, longest as f64 * period_s));
        let factors = shown.and_then(|term| chi_square_factors(fit.freedom(term)?));
        let value = fit.model.0[term as usize].sqrt();
        let ends = factors.map(|factors| factors.map(|factor| value * factor));
        let estimate = ends.map(|[low, high]| Estimate { value, low, high });
        let limit = || fit.limit(term as usize, period_s, longest);
        estimate.ok_or_else(|| limit().unwrap_or_default())
    };
    let [n, b, k, edge] = fit.model.0;
    let is_seen = edge < 0.0 && fit.freedom(EDGE).is_some_and(|n| n > MIN_EDGE_FREEDOM);
    Some(NoiseFit {
        model: fit.model,
        curve: FittedCurve {
            from_s: fit.points[0].tau_s,
            parameters: [n, b, k].map(f64::sqrt),
            // One pole of time constant T takes ends of 3/2 T: e = −3/2 N² T.
            low_pass_hz: (is_seen && n > 0.0).then(|| 1.5 * n / (-2.0 * PI * edge)),
            drift: None,
            misfit,
        },
        estimates: NoiseTerm::ALL.map(estimate),
    })
}
