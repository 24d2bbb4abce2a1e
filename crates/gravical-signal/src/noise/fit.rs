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

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{NoiseModel, NoiseTerm};
use crate::allan::AllanVariance;

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
const BEHIND: f64 = 2.0;
/// Points at the short end that have to agree with the model, and fewest points of a fit.
const TESTED: usize = 3;
const MIN_POINTS: usize = 6;
/// Octaves that are left out after those that disagree visibly: what they may hide has decayed then.
const MORE: usize = 1;
/// The part of a low-pass that is seen, in standard deviations.
const SEEN: f64 = 4.0;
/// Behind a low-pass, N is seen where all else is less than this part of the Allan variance: the slope
/// of the deviation is −½ to 0.1 there.
const MAX_ELSE: f64 = 0.2;
/// A random walk leads, with a slope near +½, over a factor of 4: from this part of the longest segment
/// to half of it, where averaging times end.
const WALK_FROM: f64 = 1.0 / 8.0;
/// The longest recording that is proposed, as a multiple.
const MAX_FACTOR: f64 = 1024.0;

/// A term as far as the recording determines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TermEstimate {
    /// The coefficient and its 95 % interval
    Known {
        /// Coefficient: N, B or K
        value: f64,
        /// Lower end
        low: f64,
        /// Upper end
        high: f64,
    },
    /// Not observable
    Unknown {
        /// Upper limit (95 %); `None` if there is none
        at_most: Option<f64>,
        /// Length of a recording that would show a term as large as the limit, s; `None` if a
        /// thousand times the length would not
        record_s: Option<f64>,
    },
}

/// Allan variances of one channel.
#[derive(Debug, Clone)]
pub struct NoisePoints {
    /// Averaging times, s, in octaves
    tau_s: Vec<f64>,
    variance: Vec<f64>,
    /// Degrees of freedom if the noise were that of one term
    freedom: Vec<[f64; 3]>,
    /// Length of the longest segment, s
    longest_s: f64,
    period_s: f64,
    /// Fitted with the ends of a low-pass
    has_edge: bool,
}

impl NoisePoints {
    /// Points of samples `period_s` apart in segments of these `lengths`; octaves where they are fitted.
    pub fn new(points: &[AllanVariance], lengths: &[usize], period_s: f64) -> Self {
        let freedom = |point: &AllanVariance| {
            let m = point.m as f64;
            let fitting = lengths.iter().filter(|n| **n >= 2 * point.m);
            NoiseTerm::ALL.map(|term| {
                let each = fitting
                    .clone()
                    .map(|n| term.degrees_of_freedom(m, *n as f64));
                each.sum::<f64>()
            })
        };
        NoisePoints {
            tau_s: points.iter().map(|p| p.m as f64 * period_s).collect(),
            variance: points.iter().map(|p| p.variance).collect(),
            freedom: points.iter().map(freedom).collect(),
            longest_s: lengths.iter().max().map_or(0.0, |n| *n as f64 * period_s),
            period_s,
            has_edge: false,
        }
    }

    fn after(&self, first: usize, has_edge: bool) -> Self {
        NoisePoints {
            has_edge,
            tau_s: self.tau_s[first..].to_vec(),
            variance: self.variance[first..].to_vec(),
            freedom: self.freedom[first..].to_vec(),
            ..*self
        }
    }

    /// Degrees of freedom of the points under a model.
    pub fn degrees_of_freedom(&self, model: &NoiseModel) -> Vec<f64> {
        let freedom = |i: usize| {
            let deviation: f64 = self.term_deviations(model, i).iter().sum();
            2.0 * (model.variance(self.tau_s[i]) / deviation).powi(2)
        };
        (0..self.tau_s.len()).map(freedom).collect()
    }

    /// What each term adds to the standard deviation of a point.
    fn term_deviations(&self, model: &NoiseModel, i: usize) -> [f64; 3] {
        let parts = model.parts(self.tau_s[i]);
        NoiseTerm::ALL.map(|t| parts[t as usize] * (2.0 / self.freedom[i][t as usize]).sqrt())
    }

    /// Covariance of the points under a model. Each term adds to the second differences by itself, so
    /// that the covariance is a product of sums over the terms.
    fn covariance(&self, model: &NoiseModel) -> DMatrix<f64> {
        let count = self.tau_s.len();
        let deviations: Vec<[f64; 3]> =
            (0..count).map(|i| self.term_deviations(model, i)).collect();
        DMatrix::from_fn(count, count, |i, j| {
            let octaves = (self.tau_s[i] / self.tau_s[j]).log2().abs();
            let roots = NoiseTerm::ALL.map(|term| term.correlation(octaves).sqrt());
            let sum = |i: usize| {
                deviations[i]
                    .iter()
                    .zip(roots)
                    .map(|(d, r)| d * r)
                    .sum::<f64>()
            };
            sum(i) * sum(j)
        })
    }

    /// Standard deviations under a model, its own error included.
    fn deviations(&self, model: &NoiseModel) -> Vec<f64> {
        let deviation = |i: usize| {
            let by_chance: f64 = self.term_deviations(model, i).iter().sum();
            by_chance.hypot(MODEL_ERROR * model.variance(self.tau_s[i]))
        };
        (0..self.tau_s.len()).map(deviation).collect()
    }

    /// The matrix that makes the squares of `terms` of the variances, and e where it is fitted, by
    /// least squares.
    fn solver(&self, deviations: &[f64], terms: &[NoiseTerm]) -> Option<DMatrix<f64>> {
        let columns = terms.len() + usize::from(self.has_edge);
        let mut design = DMatrix::from_fn(self.tau_s.len(), columns, |i, j| {
            let tau_s = self.tau_s[i];
            let shape = terms
                .get(j)
                .map_or(tau_s.powi(-2), |term| term.shape(tau_s));
            shape / deviations[i]
        });
        let norms: Vec<f64> = design.column_iter().map(|c| c.norm()).collect();
        for (mut column, norm) in design.column_iter_mut().zip(&norms) {
            column /= *norm;
        }
        let inverse = design.pseudo_inverse(1e-12).ok()?;
        let scaled = DMatrix::from_fn(columns, self.tau_s.len(), |j, i| {
            inverse[(j, i)] / (norms[j] * deviations[i])
        });
        scaled.iter().all(|x| x.is_finite()).then_some(scaled)
    }

    /// The best of all models without a negative square.
    fn non_negative(&self, deviations: &[f64]) -> Option<NoiseModel> {
        let variances = DVector::from_column_slice(&self.variance);
        let solved = (1..8_u32).filter_map(|bits| {
            let terms: Vec<NoiseTerm> = NoiseTerm::ALL
                .into_iter()
                .filter(|term| bits >> *term as u32 & 1 == 1)
                .collect();
            let squares = self.solver(deviations, &terms)? * &variances;
            let mut model = NoiseModel::default();
            for (term, square) in terms.iter().zip(&squares) {
                model.squares[*term as usize] = *square;
            }
            if self.has_edge {
                model.edge = squares[terms.len()];
            }
            let misfit: f64 = self.misfits(&model, deviations).map(|d| d * d).sum();
            let mut squares = squares.iter().take(terms.len());
            squares.all(|x| *x > 0.0).then_some((misfit, model))
        });
        solved.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }

    /// Deviations of the points from a model, in standard deviations.
    fn misfits(&self, model: &NoiseModel, deviations: &[f64]) -> impl Iterator<Item = f64> {
        let points = self.tau_s.iter().zip(&self.variance).zip(deviations);
        points.map(|((tau_s, variance), sd)| (variance - model.variance(*tau_s)) / sd)
    }

    fn reweighted(&self) -> Option<NoiseModel> {
        let white = NoiseModel::WHITE;
        let relative = self.deviations(&white).into_iter().zip(&self.tau_s);
        let relative = relative.map(|(sd, tau_s)| sd / white.variance(*tau_s));
        let first: Vec<f64> = relative.zip(&self.variance).map(|(sd, v)| sd * v).collect();
        let mut model = self.non_negative(&first)?;
        for _ in 0..REWEIGHTINGS {
            model = self.non_negative(&self.deviations(&model))?;
        }
        Some(model)
    }

    /// Variance of the square of `term`, or of e, in a fit of it and all terms of the model.
    fn square_variance(&self, model: &NoiseModel, term: Option<NoiseTerm>) -> Option<f64> {
        let is_fitted = |t: &NoiseTerm| Some(*t) == term || model.squares[*t as usize] > 0.0;
        let terms: Vec<NoiseTerm> = NoiseTerm::ALL.into_iter().filter(is_fitted).collect();
        let of_term = |term| terms.iter().position(|t| *t == term);
        let row = term.map_or(Some(terms.len()), of_term)?;
        let solver = self.solver(&self.deviations(model), &terms)?;
        let row = solver.row(row);
        Some((row * self.covariance(model) * row.transpose())[(0, 0)])
    }

    /// True where the slope of the Allan deviation shows the term.
    fn shows(&self, model: &NoiseModel, term: NoiseTerm) -> bool {
        let is_white = |tau_s: &f64| {
            let white = model.parts(*tau_s)[0];
            let others = (model.variance(*tau_s) - white).abs();
            others.max((model.edge / tau_s.powi(2)).abs()) < MAX_ELSE * white
        };
        match term {
            NoiseTerm::N => !self.has_edge || self.tau_s.iter().any(is_white),
            NoiseTerm::B => true,
            NoiseTerm::K => {
                let [n, b, k] = model.parts(WALK_FROM * self.longest_s);
                k > n + b
            }
        }
    }

    fn estimate(&self, model: &NoiseModel, term: NoiseTerm) -> TermEstimate {
        let square = model.squares[term as usize];
        let variance = self.square_variance(model, Some(term));
        let variance = variance.filter(|_| self.shows(model, term));
        let factors = variance.and_then(|variance| {
            let freedom = 2.0 * square * square / variance;
            chi_square_factors(freedom).filter(|_| freedom >= MIN_FREEDOM)
        });
        match factors {
            Some([low, high]) => TermEstimate::Known {
                value: square.sqrt(),
                low: square.sqrt() * low,
                high: square.sqrt() * high,
            },
            None => self.limit(model, term),
        }
    }

    /// Upper limit of a term that is not observable, and how long a recording would show it.
    fn limit(&self, model: &NoiseModel, term: NoiseTerm) -> TermEstimate {
        const ONE_SIDED: f64 = 1.645;
        let mut limit = *model;
        // The term itself adds to its own uncertainty.
        for _ in 0..10 {
            let Some(variance) = self
                .square_variance(&limit, Some(term))
                .filter(|v| v.is_finite() && *v >= 0.0)
            else {
                return TermEstimate::Unknown {
                    at_most: None,
                    record_s: None,
                };
            };
            limit.squares[term as usize] =
                model.squares[term as usize] + ONE_SIDED * variance.sqrt();
        }
        let square = limit.squares[term as usize];
        let shows = |duration_s: &f64| {
            let length = duration_s / self.period_s;
            let first = (self.tau_s[0] / self.period_s).round() as usize;
            let octaves = (0..).map(|k| first << k);
            // Only their number counts: values are those of the model.
            let planned = octaves.take_while(|m| (*m as f64) < 0.4 * length);
            let variance = f64::NAN;
            let planned = planned.map(|m| AllanVariance { m, variance });
            let planned: Vec<AllanVariance> = planned.collect();
            let longer = NoisePoints::new(&planned, &[length as usize], self.period_s);
            let variance = longer.square_variance(&limit, Some(term));
            variance.is_some_and(|v| 2.0 * square * square / v >= MIN_FREEDOM)
        };
        let factors = (1..)
            .map(|k| 2_f64.powi(k))
            .take_while(|f| *f <= MAX_FACTOR);
        TermEstimate::Unknown {
            at_most: Some(square.sqrt()),
            record_s: factors.map(|f| f * self.longest_s).find(shows),
        }
    }
}

/// A fit of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseFit {
    /// Squares of the terms; zero for those that are not part of it
    pub model: NoiseModel,
    /// Shortest averaging time that was used, s
    pub from_s: f64,
    /// Averaging time at which the variance deviates most from the model, by more than chance, s, and
    /// the variance over that of the model
    pub misfit: Option<(f64, f64)>,
    /// N, B, K
    pub estimates: [TermEstimate; 3],
}

/// Fits N, B and K. `None` with fewer than two points, or if a variance is zero.
///
/// A low-pass is seen if the first points contradict the model, or if e is not zero. The points that
/// the model with e does not explain are then left out.
pub fn fit_noise(points: &NoisePoints) -> Option<NoiseFit> {
    let is_usable = |v: &f64| v.is_finite() && *v > 0.0;
    if points.variance.len() < 2 || !points.variance.iter().all(is_usable) {
        return None;
    }
    let last = points.variance.len().saturating_sub(MIN_POINTS);
    let agrees = |used: &NoisePoints, within: f64| {
        used.reweighted().is_some_and(|model| {
            let deviations = used.deviations(&model);
            let mut tested = used.misfits(&model, &deviations).take(TESTED);
            tested.all(|misfit| misfit.abs() < within)
        })
    };
    let filtered = points.after(0, true);
    let is_filtered = filtered.reweighted().is_some_and(|model| {
        let variance = filtered.square_variance(&model, None);
        variance.is_some_and(|v| model.edge.abs() > SEEN * v.sqrt())
    });
    let used = if agrees(points, MAX_DEVIATION) && !is_filtered {
        points.clone()
    } else {
        let first = (0..=last).find(|first| agrees(&points.after(*first, true), BEHIND));
        points.after(first.map_or(last, |first| (first + MORE).min(last)), true)
    };
    let model = used.reweighted()?;
    let deviations = used.deviations(&model);
    let misfits = used.misfits(&model, &deviations).map(f64::abs).enumerate();
    let worst = misfits.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let tau_s = used.tau_s[worst.0];
    Some(NoiseFit {
        from_s: used.tau_s[0],
        misfit: (worst.1 > MAX_DEVIATION)
            .then(|| (tau_s, used.variance[worst.0] / model.variance(tau_s))),
        estimates: NoiseTerm::ALL.map(|term| used.estimate(&model, term)),
        model,
    })
}

/// Ends of the 95 % interval of a standard deviation with these degrees of freedom, over its
/// estimate; `None` without any freedom.
pub fn chi_square_factors(freedom: f64) -> Option<[f64; 2]> {
    // Beyond that the quantile is the normal one to six digits, and its iteration slow.
    if freedom > 1e5 {
        let half = 1.959_964 / (2.0 * freedom).sqrt();
        return Some([1.0 - half, 1.0 + half]);
    }
    let chi2 = ChiSquared::new(freedom).ok()?;
    let factor = |p: f64| (freedom / chi2.inverse_cdf(p)).sqrt();
    Some([factor(0.975), factor(0.025)])
}
