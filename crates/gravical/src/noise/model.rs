//! The model of the Allan variance, and the covariance of its estimates.
//!
//! ```text
//! σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π) B² + K²τ/3 + R²τ²/2
//! ```
//!
//! (IEEE Std 952, annex C). Estimates for different τ, from the same samples and overlapping, are
//! correlated. For Gaussian noise Cov(σ̂²_a, σ̂²_b) = 2/(n_a n_b) Σ_u w(u) C_ab(u)², where C_ab(u) is the
//! covariance of the second differences over a samples and, u later, over b samples, and w(u) the
//! number of pairs at that distance. C_ab follows from the generalised covariance of the phase: of
//! order |h| for white noise, h² ln|h| for flicker noise, |h|³ for the random walk. For single
//! noises the degrees of freedom agree with the approximations of NIST SP 1065 (tables 5 and 6).

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::{LN_2, PI};

use nalgebra::DMatrix;

use super::allan::Lengths;

/// A term of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Term {
    /// White noise, N.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", value(skip))]
    N,
    /// Bias instability (flicker noise), B.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", value(skip))]
    B,
    /// Random walk, K.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", value(skip))]
    K,
    /// Quantisation, Q.
    Q,
    /// Rate ramp, R.
    R,
}

/// Number of terms.
pub(super) const TERMS: usize = 5;

impl Term {
    /// All terms, in the order of arrays.
    pub const ALL: [Term; TERMS] = [Term::N, Term::B, Term::K, Term::Q, Term::R];

    /// Its letter.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        ["N", "B", "K", "Q", "R"][self as usize]
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        [
            "noise density",
            "bias instability",
            "random walk",
            "quantisation",
            "rate ramp",
        ][self as usize]
    }

    /// Its Allan variance at τ for a coefficient of 1.
    #[must_use]
    pub fn shape(self, tau_s: f64) -> f64 {
        match self {
            Term::N => 1.0 / tau_s,
            Term::B => 2.0 * LN_2 / PI,
            Term::K => tau_s / 3.0,
            Term::Q => 3.0 / (tau_s * tau_s),
            Term::R => 0.5 * tau_s * tau_s,
        }
    }
}

/// Squares of N, B, K, Q and R.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Model {
    pub squares: [f64; TERMS],
    /// Sampling period, s.
    pub period_s: f64,
}

impl Model {
    /// Allan variance over m samples.
    pub fn variance(&self, m: f64) -> f64 {
        let shapes = Term::ALL.map(|term| term.shape(m * self.period_s));
        shapes.iter().zip(self.squares).map(|(s, x)| s * x).sum()
    }

    /// Power spectral density, one-sided.
    pub fn density(&self, hz: f64) -> f64 {
        let [n, b, k, q, _] = self.squares;
        let rounding = 8.0 * q * (PI * hz * self.period_s).sin().powi(2) / self.period_s;
        2.0 * n + b / (PI * hz) + k / (2.0 * (PI * hz).powi(2)) + rounding
    }

    /// Parts of the Allan variance over one sample of the terms that are random.
    fn parts(&self) -> [f64; RANDOM] {
        let part = |term: Term| self.squares[term as usize] * term.shape(self.period_s);
        [part(Term::N), part(Term::B), part(Term::K), part(Term::Q)]
    }

    /// Variances of the Allan variances over `m` samples.
    pub fn variances(&self, m: &[f64], lengths: &[Lengths], pairs: &Pairs) -> Vec<f64> {
        let parts = self.parts();
        let variance = |m: &f64| pairs.covariance(*m, *m, lengths, &parts);
        m.iter().map(variance).collect()
    }

    /// Their covariance matrix.
    pub fn covariance(&self, m: &[f64], lengths: &[Lengths], pairs: &Pairs) -> DMatrix<f64> {
        let parts = self.parts();
        let mut all = DMatrix::zeros(m.len(), m.len());
        for i in 0..m.len() {
            for j in 0..=i {
                all[(i, j)] = pairs.covariance(m[i], m[j], lengths, &parts);
                all[(j, i)] = all[(i, j)];
            }
        }
        all
    }
}

/// Terms that are random: N, B, K, Q.
const RANDOM: usize = 4;
/// Products of two of them.
const PRODUCTS: usize = RANDOM * (RANDOM + 1) / 2;

/// What the covariance of two Allan variances is for any model: it is quadratic in the squares of
/// the parameters, and its coefficients depend on the averaging times and the length of the segment
/// alone. They are computed once and kept, for all steps of a fit and all channels.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// By the bits of both averaging times and the length, all in samples.
    known: RefCell<HashMap<[u64; 3], [f64; PRODUCTS]>>,
}

impl Pairs {
    /// Covariance of the Allan variances over `a` and `b` samples, pooled over segments.
    fn covariance(&self, a: f64, b: f64, lengths: &[Lengths], parts: &[f64; RANDOM]) -> f64 {
        let (mut sum, mut of_a, mut of_b) = (0.0, 0.0, 0.0);
        for l in lengths {
            let (na, nb) = (terms(a, l.samples), terms(b, l.samples));
            of_a += l.count * na;
            of_b += l.count * nb;
            if na > 0.0 && nb > 0.0 {
                let key = [a, b, l.samples].map(f64::to_bits);
                let mut known = self.known.borrow_mut();
                let products = known.entry(key).or_insert_with(|| segment(a, b, l.samples));
                sum += l.count * na * nb * quadratic(products, parts);
            }
        }
        sum / (of_a * of_b)
    }
}

/// Σ of all products of two parts, each times its coefficient.
fn quadratic(products: &[f64; PRODUCTS], parts: &[f64; RANDOM]) -> f64 {
    let mut at = products.iter();
    let mut sum = 0.0;
    for i in 0..RANDOM {
        for j in 0..=i {
            let twice = if i == j { 1.0 } else { 2.0 };
            sum += twice * parts[i] * parts[j] * at.next().copied().unwrap_or(0.0);
        }
    }
    sum
}

/// Generalised covariance of the phase at a distance of h samples, for each random term with an
/// Allan variance of 1 over one sample.
#[inline]
fn of_phase(h: f64) -> [f64; RANDOM] {
    let h = h.abs();
    if h == 0.0 {
        return [0.0, 0.0, 0.0, 1.0 / 3.0];
    }
    let square = h * h;
    [
        -0.5 * h,
        square * h.ln() / (4.0 * LN_2),
        0.25 * square * h,
        0.0,
    ]
}

/// Covariance of the second difference over a samples with that over b samples, u later.
#[inline]
fn of_differences(a: f64, b: f64, u: f64) -> [f64; RANDOM] {
    const WEIGHTS: [(f64, f64); 3] = [(0.0, 1.0), (1.0, -2.0), (2.0, 1.0)];
    let mut sum = [0.0; RANDOM];
    for (i, wi) in WEIGHTS {
        for (j, wj) in WEIGHTS {
            let phase = of_phase(u + j * b - i * a);
            for (sum, of_term) in sum.iter_mut().zip(phase) {
                *sum += wi * wj * of_term;
            }
        }
    }
    sum
}

/// The coefficients for one segment.
fn segment(a: f64, b: f64, samples: f64) -> [f64; PRODUCTS] {
    let (na, nb) = (terms(a, samples), terms(b, samples));
    let longest = a.max(b);
    // Flicker noise has tails beyond the reach of both.
    let low = (-na).max(-8.0 * longest);
    let high = nb.min(8.0 * longest);
    // C is smooth between the places where two phases coincide, w between these.
    let mut places = vec![low, high, 0.0, nb - na];
    for i in 0..3 {
        places.extend((0..3).map(|j| f64::from(i) * a - f64::from(j) * b));
    }
    places.extend([-4.0, -3.0, 3.0, 4.0].map(|k| k * longest));
    places.retain(|u| (low..=high).contains(u));
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut products = [0.0; PRODUCTS];
    let mut add = |u: f64, weight: f64| {
        let pairs = (na.min(nb - u) - 0_f64.max(-u)).max(0.0);
        let c = of_differences(a, b, u);
        let mut at = products.iter_mut();
        for i in 0..RANDOM {
            for (j, product) in (0..=i).zip(&mut at) {
                *product += weight * pairs * c[i] * c[j];
            }
        }
    };
    for w in places.windows(2) {
        weigh_between(w[0], w[1], &mut add);
    }
    products.map(|sum| 2.0 * sum / (na * nb * 4.0 * (a * b).powi(2)))
}

/// Number of second differences over m samples.
fn terms(m: f64, samples: f64) -> f64 {
    (samples + 1.0 - 2.0 * m).max(0.0)
}

/// Nodes and weights of Gauss–Legendre quadrature with eight points.
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Places and weights of a sum over the whole numbers between two of them, the ends with half their
/// weight; of the integral where they are many.
fn weigh_between(from: f64, to: f64, add: &mut impl FnMut(f64, f64)) {
    const MANY: f64 = 64.0;
    let length = to - from;
    if length <= MANY {
        add(from, 0.5);
        (1..length as u32).for_each(|k| add(from + f64::from(k), 1.0));
        add(to, 0.5);
        return;
    }
    let (centre, half) = (0.5 * (from + to), 0.5 * length);
    for (x, weight) in NODES {
        add(centre - half * x, half * weight);
        add(centre + half * x, half * weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_of_freedom_are_those_of_the_handbook() {
        let samples = 20_000.0;
        let n = samples + 1.0;
        let lengths = [Lengths {
            samples,
            count: 1.0,
        }];
        let edf = |term: Term, m: f64| {
            let mut model = Model {
                period_s: 0.01,
                ..Model::default()
            };
            model.squares[term as usize] = 1.0;
            2.0 * model.variance(m).powi(2) / model.variances(&[m], &lengths, &Pairs::default())[0]
        };
        for m in [1.0, 2.0, 8.0, 64.0, 256.0, 1024.0, 2048.0] {
            let white = (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m * m
                / (4.0 * m * m + 5.0);
            assert!((edf(Term::N, m) / white - 1.0).abs() < 0.02, "{m}");
            // These two are known to be approximations, by some per cent.
            let flicker = 5.0 * n * n / (4.0 * m * (n + 3.0 * m));
            if m > 1.0 {
                assert!((edf(Term::B, m) / flicker - 1.0).abs() < 0.1, "{m}");
            }
            let walk = (n - 2.0) / m * ((n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m)
                / (n - 3.0).powi(2);
            assert!((edf(Term::K, m) / walk - 1.0).abs() < 0.13, "{m}");
        }
    }

    #[test]
    fn equal_segments_share_the_variance() {
        let model = Model {
            squares: [1.0, 0.1, 0.01, 0.0, 0.0],
            period_s: 0.01,
        };
        let lengths = |count| Lengths {
            samples: 5000.0,
            count,
        };
        let of = |count| model.covariance(&[4.0, 512.0], &[lengths(count)], &Pairs::default());
        let (one, ten) = (of(1.0), of(10.0));
        assert!((&one / 10.0 - ten).abs().max() < 1e-12 * one.abs().max());
    }

    #[test]
    fn variance_and_density_belong_together() {
        // σ²(τ) = ∫ S(f) 2 sin⁴(πτf)/(πτf)² df, one-sided S (NIST SP 1065, equation 65).
        let model = Model {
            squares: [0.9, 0.4, 0.3, 0.0, 0.0],
            period_s: 0.5,
        };
        let tau_s = 8.0;
        let steps = 400_000;
        let integral: f64 = (0..steps)
            .map(|k| {
                let hz = 1e-6 * (1e8_f64).powf((f64::from(k) + 0.5) / f64::from(steps));
                let x = PI * tau_s * hz;
                let d = hz * 1e8_f64.ln() / f64::from(steps);
                model.density(hz) * 2.0 * x.sin().powi(4) / (x * x) * d
            })
            .sum();
        let variance = model.variance(tau_s / model.period_s);
        assert!(
            (integral / variance - 1.0).abs() < 1e-3,
            "{integral} {variance}"
        );
    }
}
