//! Fit of the model to Allan variances, with intervals.
//!
//! Non-negative least squares on the variance. Weights come from the covariance of the estimates
//! under the fitted model ([`Model::covariance`]), six times reweighted: weights from the estimates
//! themselves would prefer those that happen to be small. The covariance of the result is that of
//! the estimator, A V Aᵀ with V the whole covariance matrix, since points of overlapping samples are
//! correlated. A square x with variance s² is distributed nearly as χ² with 2x²/s² degrees of
//! freedom; its 95 % interval is that of χ².

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::allan::Lengths;
use super::model::{Model, Pairs, TERMS, Term};

/// Real noise follows the model to about this share of the variance: without it the first
/// averaging times, known to a thousandth, would decide all terms.
const MODEL_SHARE: f64 = 0.01;
const REWEIGHTINGS: usize = 6;
/// A term with fewer degrees of freedom, a standard deviation of more than 35 %, is not
/// observable.
const LEAST_FREEDOM: f64 = 4.0;
/// Deviation of a point that the model does not explain.
const MOST_DEVIATIONS: f64 = 4.0;
/// Points at the short end that have to agree with the model, and fewest points of a fit.
const TESTED: usize = 3;
const LEAST_POINTS: usize = 6;
/// Octaves that are left out after those that disagree visibly: noise behind a low-pass approaches
/// the model by half of the distance with each.
const MORE: usize = 2;
/// The longest recording that is proposed, as a multiple.
const LONGEST_FACTOR: f64 = 1024.0;

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
    /// `N`, `B`, `K`, `Q` or `R`.
    pub term: String,
    /// Why, and what to do.
    pub reason: String,
    /// Upper limit (95 %), in the unit of the term; null if there is none.
    pub at_most: Option<f64>,
    /// Length of a recording that would show a term as large as the limit, s; null if even a
    /// thousand times the length would not.
    pub record_s: Option<f64>,
}

/// Result for one term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outcome {
    Known(Estimate),
    Unknown {
        at_most: Option<f64>,
        record_s: Option<f64>,
    },
}

/// A fit of one channel.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub model: Model,
    /// The first point that was used.
    pub from: usize,
    /// The point that deviates most from the model, by more than chance, and variance over that of
    /// the model.
    pub misfit: Option<(usize, f64)>,
    /// One for each of the terms that were asked for.
    pub outcomes: Vec<(Term, Outcome)>,
}

/// Points of a fit.
#[derive(Clone, Copy)]
pub(super) struct Points<'a> {
    /// Averaging times, samples.
    pub m: &'a [f64],
    pub variance: &'a [f64],
    pub lengths: &'a [Lengths],
    pub period_s: f64,
    /// What the covariances of the points are made of.
    pub pairs: &'a Pairs,
}

impl Points<'_> {
    fn after(&self, from: usize) -> Self {
        Points {
            m: &self.m[from..],
            variance: &self.variance[from..],
            ..*self
        }
    }

    /// Standard deviations under the model.
    fn deviations(&self, model: &Model) -> Vec<f64> {
        let variances = model.variances(self.m, self.lengths, self.pairs);
        let both = self.m.iter().zip(variances);
        both.map(|(m, v)| (v + (MODEL_SHARE * model.variance(*m)).powi(2)).sqrt())
            .collect()
    }
}

/// Least squares over some terms: squares of the parameters, and the matrix that they are
/// computed with.
struct Solution {
    squares: [f64; TERMS],
    matrix: DMatrix<f64>,
}

fn solve(points: &Points<'_>, deviations: &[f64], terms: &[Term]) -> Option<Solution> {
    let mut design = DMatrix::from_fn(points.m.len(), terms.len(), |i, j| {
        terms[j].shape(points.m[i] * points.period_s) / deviations[i]
    });
    let norms: Vec<f64> = design.column_iter().map(|c| c.norm()).collect();
    for (mut column, norm) in design.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let normal = (design.transpose() * &design).try_inverse()?;
    let mut matrix = normal * design.transpose();
    for ((j, i), value) in indices(&matrix).zip(matrix.iter_mut()) {
        *value /= norms[j] * deviations[i];
    }
    let values = &matrix * DVector::from_column_slice(points.variance);
    let mut squares = [0.0; TERMS];
    for (term, value) in terms.iter().zip(values.iter()) {
        squares[*term as usize] = *value;
    }
    squares
        .iter()
        .all(|x| x.is_finite())
        .then_some(Solution { squares, matrix })
}

/// Row and column of the elements in the order of memory.
fn indices(matrix: &DMatrix<f64>) -> impl Iterator<Item = (usize, usize)> + use<> {
    let rows = matrix.nrows();
    (0..matrix.len()).map(move |at| (at % rows, at / rows))
}

/// The best of all solutions without negative squares, and its terms.
fn non_negative(
    points: &Points<'_>,
    deviations: &[f64],
    terms: &[Term],
) -> Option<(Model, Vec<Term>)> {
    let subsets = (1..1_u32 << terms.len()).map(|bits| {
        let chosen = terms.iter().enumerate().filter(|(i, _)| bits >> i & 1 == 1);
        chosen.map(|(_, term)| *term).collect::<Vec<Term>>()
    });
    let candidates = subsets.filter(|subset| subset.len() <= points.m.len());
    let solved = candidates.filter_map(|subset| {
        let squares = solve(points, deviations, &subset)?.squares;
        let model = Model {
            squares,
            period_s: points.period_s,
        };
        let deviates =
            |i: usize| (points.variance[i] - model.variance(points.m[i])) / deviations[i];
        let misfit: f64 = (0..points.m.len()).map(|i| deviates(i).powi(2)).sum();
        let positive = subset.iter().all(|term| squares[*term as usize] > 0.0);
        positive.then_some((misfit, model, subset))
    });
    let best = solved.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((best.1, best.2))
}

/// Model, its terms, and the standard deviations of the points.
type Found = (Model, Vec<Term>, Vec<f64>);

/// The fit with weights by the fitted model.
fn reweighted(points: &Points<'_>, terms: &[Term]) -> Option<Found> {
    // As if the noise were white.
    let first = Model {
        squares: [1.0, 0.0, 0.0, 0.0, 0.0],
        period_s: points.period_s,
    };
    let mut deviations: Vec<f64> = (first.deviations_of(points).iter())
        .zip(points.variance)
        .map(|(share, variance)| share * variance)
        .collect();
    let mut found = non_negative(points, &deviations, terms)?;
    for _ in 0..REWEIGHTINGS {
        deviations = points.deviations(&found.0);
        found = non_negative(points, &deviations, terms)?;
    }
    Some((found.0, found.1, deviations))
}

impl Model {
    /// Relative standard deviations of the points.
    fn deviations_of(&self, points: &Points<'_>) -> Vec<f64> {
        let all = points.deviations(self).into_iter().zip(points.m);
        all.map(|(deviation, m)| deviation / self.variance(*m))
            .collect()
    }
}

/// Fits `terms` to the points. `None` if there are too few points, or they are all zero.
///
/// The first points are left out if the model does not explain them: behind a low-pass, noise is
/// white only for longer averaging times.
pub(super) fn fit(points: &Points<'_>, terms: &[Term]) -> Option<Fit> {
    if points.variance.iter().any(|v| !(v.is_finite() && *v > 0.0)) {
        return None;
    }
    let last = points
        .m
        .len()
        .checked_sub(LEAST_POINTS.min(points.m.len()))?;
    let worst = |from: usize, found: &Found, count: usize| {
        let used = points.after(from);
        let deviates = |i: usize| {
            let expected = found.0.variance(used.m[i]);
            let by = (used.variance[i] - expected) / found.2[i];
            (from + i, by.abs(), used.variance[i] / expected)
        };
        let all = (0..count.min(used.m.len())).map(deviates);
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let mut chosen: Option<(usize, Found)> = None;
    for from in 0..=last {
        let found = reweighted(&points.after(from), terms)?;
        let agrees = worst(from, &found, TESTED).is_some_and(|w| w.1 < MOST_DEVIATIONS);
        if agrees && from > 0 {
            let from = (from + MORE).min(last);
            chosen = Some((from, reweighted(&points.after(from), terms)?));
        } else if chosen.is_none() {
            chosen = Some((from, found));
        }
        if agrees {
            break;
        }
    }
    let (from, found) = chosen?;
    let misfit = worst(from, &found, usize::MAX)
        .filter(|w| w.1 > MOST_DEVIATIONS)
        .map(|(at, _, ratio)| (at, ratio));
    let used = points.after(from);
    let (model, active, deviations) = found;
    let spread = spread(&used, &model, &active, &deviations);
    let outcome = |term: &Term| {
        let square = model.squares[*term as usize];
        let known = active.iter().position(|t| t == term).and_then(|at| {
            let variance = spread.as_ref()?[(at, at)];
            interval(square, variance)
        });
        let outcome = match known {
            Some(estimate) => Outcome::Known(estimate),
            None => unknown(&used, &model, *term, &active, &deviations),
        };
        (*term, outcome)
    };
    Some(Fit {
        outcomes: terms.iter().map(outcome).collect(),
        model,
        from,
        misfit,
    })
}

/// Covariance of the squares of `terms`.
fn spread(
    points: &Points<'_>,
    model: &Model,
    terms: &[Term],
    deviations: &[f64],
) -> Option<DMatrix<f64>> {
    let matrix = solve(points, deviations, terms)?.matrix;
    let covariance = model.covariance(points.m, points.lengths, points.pairs);
    Some(&matrix * covariance * matrix.transpose())
}

/// The 95 % interval of the root of a square with this variance; `None` if it is not observable.
fn interval(square: f64, variance: f64) -> Option<Estimate> {
    let freedom = 2.0 * square * square / variance;
    if !(freedom >= LEAST_FREEDOM && freedom.is_finite()) {
        return None;
    }
    let [low, high] = chi_square_factors(freedom)?;
    Some(Estimate {
        value: square.sqrt(),
        low: square.sqrt() * low,
        high: square.sqrt() * high,
    })
}

/// Ends of the 95 % interval of a standard deviation with these degrees of freedom, over its
/// estimate.
pub(super) fn chi_square_factors(freedom: f64) -> Option<[f64; 2]> {
    // Beyond that the quantile is the normal one to six digits, and its iteration slow.
    if freedom > 1e5 {
        let half = 1.959_964 / (2.0 * freedom).sqrt();
        return Some([1.0 - half, 1.0 + half]);
    }
    let chi2 = ChiSquared::new(freedom).ok()?;
    let factor = |p: f64| (freedom / chi2.inverse_cdf(p)).sqrt();
    Some([factor(0.975), factor(0.025)])
}

/// Upper limit of a term that is not observable, and how long a recording would show it.
fn unknown(
    points: &Points<'_>,
    model: &Model,
    term: Term,
    active: &[Term],
    deviations: &[f64],
) -> Outcome {
    const ONE_SIDED: f64 = 1.645;
    let mut terms = active.to_vec();
    if !terms.contains(&term) {
        terms.push(term);
    }
    let at = terms.iter().position(|t| *t == term).unwrap_or(0);
    let estimate = model.squares[term as usize];
    let mut limit = *model;
    // The term itself adds to its own uncertainty.
    for _ in 0..4 {
        let variance = spread(points, &limit, &terms, deviations).map(|s| s[(at, at)]);
        let Some(variance) = variance.filter(|v| v.is_finite() && *v >= 0.0) else {
            return Outcome::Unknown {
                at_most: None,
                record_s: None,
            };
        };
        limit.squares[term as usize] = estimate + ONE_SIDED * variance.sqrt();
    }
    let longest = points.lengths.iter().map(|l| l.samples).fold(0.0, f64::max);
    let mut record_s = None;
    let mut factor = 2.0;
    while record_s.is_none() && factor <= LONGEST_FACTOR {
        let samples = longest * factor;
        // Two octaves apart: fast, and no less can be seen.
        let octaves = (0..).map(|k| points.m[0] * 4_f64.powi(k));
        let m: Vec<f64> = octaves.take_while(|m| *m < 0.4 * samples).collect();
        let more = Points {
            m: &m,
            variance: &vec![1.0; m.len()],
            lengths: &[Lengths {
                samples,
                count: 1.0,
            }],
            period_s: points.period_s,
            pairs: points.pairs,
        };
        let deviations = more.deviations(&limit);
        let variance = spread(&more, &limit, &terms, &deviations).map(|s| s[(at, at)]);
        let square = limit.squares[term as usize];
        let shows = variance.is_some_and(|v| 2.0 * square * square / v >= LEAST_FREEDOM);
        if shows {
            record_s = Some(samples * points.period_s);
        }
        factor *= 2.0;
    }
    Outcome::Unknown {
        at_most: Some(limit.squares[term as usize].sqrt()),
        record_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: [Term; 3] = [Term::N, Term::B, Term::K];

    fn exact(squares: [f64; TERMS], samples: f64) -> (Vec<f64>, Vec<f64>, Vec<Lengths>) {
        let model = Model {
            squares,
            period_s: 0.01,
        };
        let m: Vec<f64> = (0..)
            .map(|k| 2_f64.powi(k))
            .take_while(|m| *m < 0.5 * samples)
            .collect();
        let variance = m.iter().map(|m| model.variance(*m)).collect();
        let lengths = vec![Lengths {
            samples,
            count: 1.0,
        }];
        (m, variance, lengths)
    }

    fn fitted(squares: [f64; TERMS], samples: f64, terms: &[Term]) -> Fit {
        let (m, variance, lengths) = exact(squares, samples);
        let points = Points {
            m: &m,
            variance: &variance,
            lengths: &lengths,
            period_s: 0.01,
            pairs: &Pairs::default(),
        };
        fit(&points, terms).unwrap()
    }

    #[test]
    fn points_of_the_model_give_its_parameters_back() {
        let squares = [1.09e-5, 6.4e-7, 3.6e-9, 0.0, 0.0];
        let found = fitted(squares, 2e6, &THREE);
        for (is, was) in found.model.squares.iter().zip(squares) {
            assert!((is - was).abs() <= 1e-6 * was, "{is} {was}");
        }
        assert!(found.misfit.is_none() && found.from == 0);
        for (term, outcome) in found.outcomes {
            let Outcome::Known(e) = outcome else {
                panic!("{term:?} {outcome:?}");
            };
            assert!(e.low < e.value && e.value < e.high);
        }
        let squares = [1.09e-5, 6.4e-7, 3.6e-9, 1e-8, 1e-12];
        let found = fitted(squares, 2e6, &Term::ALL);
        for (is, was) in found.model.squares.iter().zip(squares) {
            assert!((is - was).abs() <= 1e-4 * was, "{is} {was}");
        }
    }

    #[test]
    fn what_a_short_recording_does_not_show_has_a_limit_and_a_time() {
        let found = fitted([1.09e-5, 0.0, 0.0, 0.0, 0.0], 1.2e4, &THREE);
        for (term, outcome) in found.outcomes {
            match outcome {
                Outcome::Known(_) => assert_eq!(term, Term::N),
                Outcome::Unknown { at_most, record_s } => {
                    assert!(at_most.unwrap() > 0.0, "{term:?}");
                    assert!(record_s.unwrap() >= 240.0, "{term:?}");
                }
            }
        }
    }
}
