//! Small problems with answers on paper; NIST's are in `tests/it`.

use super::*;

/// y = a + b·x with an own offset for every pair of rows: shared (a, b), local
/// offset with a prior of sd 1.
struct Line {
    y: Vec<[f64; 2]>,
}

impl Problem for Line {
    type State = (Vec<f64>, Vec<f64>);
    fn shared(&self) -> usize {
        2
    }
    fn blocks(&self) -> usize {
        self.y.len()
    }
    fn shape(&self, _: usize) -> Shape {
        Shape {
            residuals: 3,
            local: 1,
        }
    }
    fn evaluate(&self, s: &Self::State, i: usize, r: &mut [f64], j: Option<Jacobian<'_>>) {
        for k in 0..2 {
            let x = (2 * i + k) as f64;
            r[k] = s.0[0] + s.0[1] * x + s.1[i] - self.y[i][k];
        }
        r[2] = s.1[i];
        if let Some(j) = j {
            for k in 0..2 {
                let x = (2 * i + k) as f64;
                j.shared[2 * k..2 * k + 2].copy_from_slice(&[1.0, x]);
                j.local[k] = 1.0;
            }
            j.local[2] = 1.0;
        }
    }
    fn moved(&self, s: &Self::State, shared: &[f64], local: &[f64]) -> Self::State {
        let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x + y).collect();
        (add(&s.0, shared), add(&s.1, local))
    }
}

/// Distances to points on a line: the position across it has two answers, and
/// along a third axis none.
struct Constant {
    values: Vec<f64>,
    loss: Loss,
    parameters: usize,
}

impl Problem for Constant {
    type State = Vec<f64>;
    fn shared(&self) -> usize {
        self.parameters
    }
    fn blocks(&self) -> usize {
        self.values.len()
    }
    fn shape(&self, _: usize) -> Shape {
        Shape {
            residuals: 1,
            local: 0,
        }
    }
    fn evaluate(&self, s: &Vec<f64>, i: usize, r: &mut [f64], j: Option<Jacobian<'_>>) {
        r[0] = s.iter().sum::<f64>() - self.values[i];
        if let Some(j) = j {
            j.shared.fill(1.0);
        }
    }
    fn moved(&self, s: &Vec<f64>, shared: &[f64], _: &[f64]) -> Vec<f64> {
        s.iter().zip(shared).map(|(a, b)| a + b).collect()
    }
    fn loss(&self, _: usize) -> Loss {
        self.loss
    }
}

#[test]
fn what_is_not_determined_has_no_covariance() {
    let problem = Constant {
        values: vec![1.0, 2.0, 3.0],
        loss: Loss::Squared,
        parameters: 2,
    };
    let (state, summary) = solve(&problem, vec![0.0; 2], &Options::default());
    assert!(summary.converged(), "{summary:?}");
    assert!((state[0] + state[1] - 2.0).abs() < 1e-9);
    let covariance = Factor::new(&problem, &state).unwrap().covariance();
    assert_eq!((covariance.rank, covariance.values), (1, None));
}

#[test]
fn losses_end_where_their_equations_say() {
    let fit = |loss| {
        let values = vec![-0.1, 0.0, 0.1, 10.0];
        let problem = Constant {
            values,
            loss,
            parameters: 1,
        };
        let (state, summary) = solve(&problem, vec![1.0], &Options::default());
        assert!(summary.converged(), "{summary:?}");
        state[0]
    };
    assert!((fit(Loss::Squared) - 2.5).abs() < 1e-9);
    // Σ r/(1 + r²/c²) = 0 holds nearer to the three.
    let x = fit(Loss::Cauchy(0.5));
    let pull = |v: f64| (x - v) / (1.0 + ((x - v) / 0.5).powi(2));
    let sum: f64 = [-0.1, 0.0, 0.1, 10.0].into_iter().map(pull).sum();
    assert!(x.abs() < 0.02 && sum.abs() < 1e-5, "{x} {sum}");
}

#[test]
fn a_start_that_is_no_number_is_said() {
    let problem = Constant {
        values: vec![f64::NAN],
        loss: Loss::Squared,
        parameters: 1,
    };
    let (_, summary) = solve(&problem, vec![0.0], &Options::default());
    assert_eq!(summary.ending, Ending::NotFinite);
    assert!(!summary.converged());
}

/// q = 2 and q·p = 10⁶ in units that make p's column 10⁻⁹ long, and empty at
/// q = 0; with `local`, a local parameter that no residual knows.
struct Hidden {
    local: usize,
}

impl Problem for Hidden {
    type State = [f64; 2];
    fn shared(&self) -> usize {
        2
    }
    fn blocks(&self) -> usize {
        1
    }
    fn shape(&self, _: usize) -> Shape {
        Shape {
            residuals: 3,
            local: self.local,
        }
    }
    fn evaluate(&self, [q, p]: &[f64; 2], _: usize, r: &mut [f64], j: Option<Jacobian<'_>>) {
        r.copy_from_slice(&[q - 2.0, 1e-9 * (q * p - 1e6), 0.0]);
        if let Some(j) = j {
            j.shared
                .copy_from_slice(&[1.0, 0.0, 1e-9 * p, 1e-9 * q, 0.0, 0.0]);
        }
    }
    fn moved(&self, s: &[f64; 2], shared: &[f64], _: &[f64]) -> [f64; 2] {
        [s[0] + shared[0], s[1] + shared[1]]
    }
}

#[test]
fn a_column_that_is_empty_at_the_start_comes_into_play() {
    let (state, summary) = solve(&Hidden { local: 0 }, [0.0, 0.0], &Options::default());
    assert!(summary.converged() && summary.tried < 20, "{summary:?}");
    assert!((state[0] - 2.0).abs() < 1e-9, "{state:?}");
    assert!((state[1] / 5e5 - 1.0).abs() < 1e-6, "{state:?}");
}

#[test]
fn a_local_parameter_that_nothing_determines_is_no_minimum() {
    let (_, summary) = solve(&Hidden { local: 1 }, [0.0, 0.0], &Options::default());
    assert_eq!(summary.ending, Ending::NotFinite);
}

#[test]
fn a_search_that_starts_at_its_end_ends() {
    // Everything fits exactly, to rounding: no gradient, cost or step is small
    // against anything.
    let y = (0..4).map(|i| {
        [
            0.1 + 0.3 * f64::from(2 * i),
            0.1 + 0.3 * f64::from(2 * i + 1),
        ]
    });
    let problem = Line { y: y.collect() };
    let start = (vec![0.0; 2], vec![0.0; 4]);
    let (found, _) = solve(&problem, start, &Options::default());
    for nudge in [0.0, 1e-16, -3e-16] {
        let start = (vec![found.0[0] + nudge, found.0[1]], found.1.clone());
        let (again, summary) = solve(&problem, start, &Options::default());
        assert!(summary.converged(), "{summary:?}");
        assert!((again.0[1] - 0.3).abs() < 1e-12);
    }
}

#[test]
fn numbers_whose_squares_overflow_are_refused() {
    let problem = Line {
        y: vec![[1e300, -1e300]; 4],
    };
    let start = (vec![0.0; 2], vec![0.0; 4]);
    let (_, summary) = solve(&problem, start, &Options::default());
    assert!(!summary.converged(), "{summary:?}");
    assert!(singular_values(nalgebra::DMatrix::from_element(3, 3, f64::NAN)).is_none());
}
