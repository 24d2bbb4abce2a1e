//! The search itself.

use super::{Ending, Factor, Options, Problem, Summary};

/// Least damping: below it a step is Gauss–Newton's.
const LEAST_DAMPING: f64 = 1e-15;

/// So many steps in a row that gain nothing to be seen are the end. Where
/// everything can be fitted exactly, or the start is the minimum, rounding is
/// all that steps can change.
const MOST_IDLE: usize = 12;

/// Share of the cost under which rounding hides whether it was lost.
const ROUNDING: f64 = 1e-13;

/// Minimises the cost of `problem` from `start`.
///
/// Finds a local minimum: it fails (ends elsewhere, [`Ending::MostSteps`]) where
/// the start is in another valley. Damping follows the ratio of the cost that
/// was lost to the cost that the linearisation promised (Nielsen 1999).
pub fn solve<P: Problem>(problem: &P, start: P::State, options: &Options) -> (P::State, Summary) {
    let mut summary = Summary {
        ending: Ending::NotFinite,
        accepted: 0,
        tried: 0,
        first_cost: f64::NAN,
        cost: f64::NAN,
    };
    let mut state = start;
    let Some(mut factor) = Factor::new(problem, &state) else {
        return (state, summary);
    };
    summary.first_cost = factor.cost();
    summary.cost = factor.cost();
    let (mut damping, mut grow) = (options.damping, 2.0);
    let mut travelled = 0.0_f64;
    let mut idle = 0;
    summary.ending = loop {
        if factor.gradient() <= options.gradient_tolerance {
            break Ending::Gradient;
        }
        if summary.tried == options.most_steps {
            break Ending::MostSteps;
        }
        summary.tried += 1;
        let trial = factor.step(damping).map(|step| {
            let moved = problem.moved(&state, &step.shared, &step.local);
            let cost = cost_of(problem, &moved);
            (step, moved, cost)
        });
        let Some((step, moved, cost)) = trial else {
            damping = (damping * grow).max(LEAST_DAMPING);
            grow *= 2.0;
            if !damping.is_finite() {
                break Ending::Step;
            }
            continue;
        };
        let small = step.promised <= options.cost_tolerance * summary.cost;
        let blurred =
            step.promised <= ROUNDING * summary.cost && cost <= summary.cost * (1.0 + ROUNDING);
        let gain = (summary.cost - cost) / step.promised.max(f64::MIN_POSITIVE);
        if cost.is_finite() && (gain > 1e-4 || blurred) {
            travelled = travelled.max(step.length);
            let short = step.length <= options.step_tolerance * travelled;
            let Some(next) = Factor::new(problem, &moved) else {
                damping *= grow;
                grow *= 2.0;
                continue;
            };
            (state, factor) = (moved, next);
            summary.cost = factor.cost();
            summary.accepted += 1;
            if blurred {
                idle += 1;
            } else {
                idle = 0;
                damping *= (1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3)).max(1.0 / 9.0);
            }
            damping = damping.max(LEAST_DAMPING);
            grow = 2.0;
            if small {
                break Ending::Cost;
            }
            if short || idle >= MOST_IDLE {
                break Ending::Step;
            }
        } else if small {
            // Rounding hides what is left to gain.
            break Ending::Cost;
        } else {
            damping *= grow;
            grow *= 2.0;
            idle += 1;
            if idle >= MOST_IDLE || step.length <= options.step_tolerance * travelled {
                break Ending::Step;
            }
        }
    };
    (state, summary)
}

/// Sum of squares at a state, losses applied; may be infinite or NaN.
pub(super) fn cost_of<P: Problem>(problem: &P, state: &P::State) -> f64 {
    let mut residuals = Vec::new();
    (0..problem.blocks())
        .map(|block| {
            residuals.clear();
            residuals.resize(problem.shape(block).residuals, 0.0);
            problem.evaluate(state, block, &mut residuals, None);
            let square: f64 = residuals.iter().map(|r| r * r).sum();
            problem.loss(block).of(square).0
        })
        .sum()
}
