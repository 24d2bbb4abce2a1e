//! What a fit and its grade are worth: simulated sessions whose truth is known.
//!
//! ```console
//! $ cargo run --release -p gravical-fit --example study -- 300
//! ```
//!
//! With `estimators` in place of the number: errors of the parameters, for the first table of
//! `docs/accuracy.md`. Else every line is a kind of session under one disturbance: shares of the
//! grades, good and fair results that are off by more than 20 mg or twice what is claimed, how often the error claimed for the worst direction holds, and how many of the
//! 95 % intervals of M and b hold the truth. The number is that of sensors; a word selects lines.

#[path = "../tests/it/sessions.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod sessions;

use gravical_core::matrix3;
use gravical_core::six_position::{SixPositionMeans, ferraris_accelerometer};
use gravical_fit::{Fit, Grade};
use nalgebra::Matrix3;

use sessions::{
    DISTURBANCES, Disturbance, G, MG, Model, PLANS, Plan, Session, V, parameter_errors,
};

/// How six faces or more become M and b.
#[derive(Debug, Clone, Copy)]
enum Estimator {
    /// Nothing measured.
    Nominal,
    /// The closed form.
    Ferraris,
    Fit(Plan),
}

impl Estimator {
    fn estimate(self, session: &mut Session) -> Option<Model> {
        match self {
            Estimator::Nominal => Some((matrix3::identity(), [0.0; 3])),
            Estimator::Ferraris => {
                let directions = session.directions(Plan::Proposed(0));
                let poses = directions.iter().map(|n| session.pose(n, V::zeros()).mean);
                let means: Vec<[f64; 3]> = poses.collect();
                let of = |up: usize| std::array::from_fn(|axis| means[2 * axis + up]);
                let (plus, minus) = (of(0), of(1));
                let found = ferraris_accelerometer(&SixPositionMeans { plus, minus }, G).ok()?;
                Some((found.model(), found.bias))
            }
            Estimator::Fit(plan) => {
                let (found, _) = session.run(plan, Disturbance::Nothing)?;
                Some((found.model(), found.bias()))
            }
        }
    }
}

/// Errors of ‖a‖ (mg) / bias (mg) / direction of the axes (°), rms over sensors.
fn estimators(count: u64) {
    println!("| session | tilt 0.1° | 1° | 2° | 3° |");
    println!("| --- | --- | --- | --- | --- |");
    let plans = [
        Plan::Proposed(0),
        Plan::Proposed(3),
        Plan::Proposed(6),
        Plan::Spread(6),
        Plan::Spread(12),
        Plan::Spread(18),
        Plan::Again(4),
    ];
    let closed = [Estimator::Nominal, Estimator::Ferraris];
    for estimator in closed.into_iter().chain(plans.map(Estimator::Fit)) {
        let cells = [0.1, 1.0, 2.0, 3.0].map(|tilt_deg| {
            let (mut squares, mut done) = ([0.0; 3], 0.0);
            for seed in 0..count {
                let mut session = Session::new(seed);
                session.noise = 1.24e-3;
                session.tilt = f64::to_radians(tilt_deg);
                session.options.tilt = Some(session.tilt);
                let Some(found) = estimator.estimate(&mut session) else {
                    continue;
                };
                done += 1.0;
                let errors = parameter_errors(&found, &session.sensor);
                for (sum, error) in squares.iter_mut().zip(errors) {
                    *sum += error * error;
                }
            }
            let [norm, bias, axes] = squares.map(|s| f64::sqrt(s / done));
            format!("{norm:.2} / {bias:.2} / {axes:.2}")
        });
        println!("| {estimator:?} | {} |", cells.join(" | "));
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|a| a == "estimators") {
        return estimators(500);
    }
    let count: u64 = arguments
        .first()
        .and_then(|a| a.parse().ok())
        .unwrap_or(100);
    let only = arguments.get(1).cloned().unwrap_or_default();
    println!(
        "| session | disturbed by | good | fair | not verifiable | poor | refused | wrong good | wrong fair | error, mg | claimed, mg | holds | undetected, mg | intervals of b | of M |"
    );
    println!("|{}", " --- |".repeat(15));
    for plan in PLANS {
        for disturbance in DISTURBANCES {
            if format!("{plan:?} {disturbance:?}").contains(&only) {
                line(plan, disturbance, count);
            }
        }
    }
}

/// How many 95 % intervals hold, of how many: the elements of M, or without faces what a rotation of
/// the frame leaves alone, the lengths of its rows and the products of them.
fn element_intervals(found: &Fit, truth: &Matrix3<f64>) -> (usize, usize) {
    let (m, c) = (found.model(), found.covariance());
    let m = Matrix3::from_fn(|r, k| m[r][k]);
    let c = nalgebra::DMatrix::from_fn(9, 9, |i, k| c[i][k]);
    let holds = |difference: f64, variance: f64| difference.abs() < 1.96 * variance.sqrt();
    if found.quality.oriented {
        let each = (0..9).map(|i| holds(m[(i / 3, i % 3)] - truth[(i / 3, i % 3)], c[(i, i)]));
        return (each.filter(|h| *h).count(), 9);
    }
    let products = |m: &Matrix3<f64>| m * m.transpose();
    let difference = products(&m) - products(truth);
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
    let each = pairs.map(|(p, q)| {
        let mut h = nalgebra::DVector::zeros(9);
        for k in 0..3 {
            h[3 * p + k] += m[(q, k)];
            h[3 * q + k] += m[(p, k)];
        }
        holds(difference[(p, q)], (h.transpose() * &c * &h)[0])
    });
    (each.iter().filter(|h| **h).count(), 6)
}

fn line(plan: Plan, disturbance: Disturbance, count: u64) {
    let (mut grades, mut wrong, mut refused) = ([0; 4], [0; 2], 0);
    let (mut errors, mut claims, mut hidden) = (vec![], vec![], vec![]);
    let (mut holds, mut bias, mut model, mut elements) = (0, 0, 0, 0);
    for seed in 0..count {
        let mut session = Session::new(seed);
        let Some((found, worst)) = session.run(plan, disturbance) else {
            refused += 1;
            continue;
        };
        let trust = found.trust(Some(&(0..found.poses().len()).collect::<Vec<_>>()));
        let grade = trust.grade();
        let at = [Grade::Good, Grade::Fair, Grade::NotVerifiable, Grade::Poor];
        let column = at.iter().position(|g| *g == grade);
        grades[column.unwrap_or(3)] += 1;
        let is_wrong = worst > 20.0 * MG || worst > 2.0 * trust.worst.error_mps2;
        wrong[0] += usize::from(grade == Grade::Good && is_wrong);
        wrong[1] += usize::from(grade == Grade::Fair && is_wrong);
        errors.push(worst / MG);
        claims.push(trust.worst.error_mps2 / MG);
        hidden.push(trust.undetected.map_or(f64::INFINITY, |u| u.effect_mps2) / MG);
        holds += usize::from(worst <= trust.worst.error_mps2);
        let (b, c) = (found.bias(), found.covariance());
        for i in 0..3 {
            bias += usize::from((b[i] - session.sensor.b[i]).abs() < 1.96 * c[9 + i][9 + i].sqrt());
        }
        let within = element_intervals(&found, &session.sensor.m);
        model += within.0;
        elements += within.1;
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let done = (count - refused) as f64;
    println!(
        "| {plan:?} | {disturbance:?} | {} | {} | {} | {} | {refused} | {} | {} | {:.2} | {:.2} | {:.2} | {:.1} | {:.3} | {:.3} |",
        grades[0],
        grades[1],
        grades[2],
        grades[3],
        wrong[0],
        wrong[1],
        median(&mut errors),
        median(&mut claims),
        holds as f64 / done,
        median(&mut hidden),
        bias as f64 / done / 3.0,
        model as f64 / f64::from(elements as u32),
    );
}
