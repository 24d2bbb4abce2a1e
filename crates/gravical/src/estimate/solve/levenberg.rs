//! The search itself.

use super::{Ending, Factor, Options, Problem, Summary};

/// Least damping: below it a step is Gauss–Newton's.
const LEAST_DAMPING: f64 = 1e-15;

/// Share of the cost under which rounding hides whether it was lost: residuals
/// that are small differences of large numbers bring 1e-12 (Bennett5 of NIST).
const ROUNDING: f64 = 1e-11;

/// A step is taken when it loses this share of what was promised.
const LEAST_GAIN: f64 = 1e-4;

/// So many refused steps in a row are the end: damping has grown by 2⁷⁸. Where
/// everything can be fitted exactly, rounding is all that steps can change.
const MOST_REFUSED: usize = 12;

/// Minimises the cost of `problem` from `start`.
///
/// Finds a local minimum: it fails (ends elsewhere, [`Ending::MostSteps`]) where
/// the start is in another valley. Damping follows the ratio of the cost that
/// was lost to the cost that the linearisation promised (Nielsen 1999), and acts
/// on each parameter by the greatest length that its column ever had (Moré,
/// Lecture Notes in Mathematics 630 (1978) 105): a column that vanishes on the
/// way would else let its parameter go anywhere.
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
    let mut longest = Vec::new();
    let mut refused = 0;
    summary.ending = loop {
        if factor.gradient() <= options.gradient_tolerance {
            break Ending::Gradient;
        }
        if summary.tried == options.most_steps {
            break Ending::MostSteps;
        }
        summary.tried += 1;
        factor.lengthen(&mut longest);
        let trial = factor.step(damping, &longest).map(|step| {
            let moved = problem.moved(&state, &step.shared, &step.local);
            let cost = cost_of(problem, &moved);
            (step, moved, cost)
        });
        let Some((step, moved, cost)) = trial else {
            // A shared column without length is damped, a local one is not.
            damping = (damping * grow).max(LEAST_DAMPING);
            grow *= 2.0;
            if !damping.is_finite() {
                break Ending::NotFinite;
            }
            continue;
        };
        let small = step.promised <= options.cost_tolerance * summary.cost;
        let blurred = step.promised <= ROUNDING * summary.cost;
        let gain = (summary.cost - cost) / step.promised.max(f64::MIN_POSITIVE);
        let next = if cost.is_finite() && (gain > LEAST_GAIN || blurred) {
            Factor::new(problem, &moved)
        } else {
            None
        };
        // Where rounding hides the cost, the gradient shows what is better.
        let next = next.filter(|next| {
            !blurred
                || (cost <= summary.cost * (1.0 + ROUNDING) && next.gradient() < factor.gradient())
        });
        let Some(next) = next else {
            if small {
                break Ending::Cost;
            }
            damping *= grow;
            grow *= 2.0;
            refused += 1;
            if refused == MOST_REFUSED || step.length <= options.step_tolerance * travelled {
                break Ending::Step;
            }
            continue;
        };
        refused = 0;
        travelled = travelled.max(step.length);
        (state, factor) = (moved, next);
        summary.cost = factor.cost();
        summary.accepted += 1;
        let gain = if blurred { 1.0 } else { gain.min(1.0) };
        damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 9.0);
        damping = damping.max(LEAST_DAMPING);
        grow = 2.0;
        if small {
            break Ending::Cost;
        }
        if step.length <= options.step_tolerance * travelled {
            break Ending::Step;
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
