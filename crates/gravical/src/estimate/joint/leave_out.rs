//! Error of ‖a‖ on poses that were left out of the fit.

use gravical_core::matrix3;

use crate::estimate::solve::Problem;
use crate::predicted;
use crate::segment::face::angle_deg;

use super::fit::{Fit, Held, Pose, axes_of, fit, rough_fit, roughly};
use super::model::{self, Elements, State};
use super::reduced::Reduced;

/// Neighbours within this angle know a pose's answer, degrees.
pub(super) const NEIGHBOUR_DEG: f64 = 25.0;
/// Poses that have to remain: as many as a diagonal model has parameters.
const LEAST_POSES: usize = 6;
/// What remains determines nothing when its condition, prior off, is worse.
const MOST_CONDITION: f64 = 1e4;
/// A step that stretches by no more than this, and moves b by no more of g, is
/// taken for the refit: what it neglects is its square, 4 µg.
const SMALL_STEP: f64 = 2e-3;

/// ‖a‖ − g of a pose that a fit does not know, and the standard deviation that
/// fit and reading predict for it, m/s².
#[derive(Debug, Clone, Copy)]
pub(super) struct LeftOut {
    pub error: f64,
    pub sd: f64,
}

/// For every pose: refit without it and every pose within 25° of it, and
/// ‖M⁻¹(u − b)‖ − g there. None where what remains does not determine the
/// parameters without the data-sheet prior, and for poses that were left out as
/// bad.
pub(super) fn errors(
    work: &[Pose],
    found: &Fit,
    reduced: &Reduced,
    held: &Held,
) -> Vec<Option<LeftOut>> {
    let directions: Vec<[f64; 3]> = (0..found.model.places.len())
        .map(|place| found.model.direction(&found.state, place))
        .collect();
    (0..work.len())
        .map(|k| {
            let own = directions[found.place_of[k]?];
            let gone: Vec<bool> = directions
                .iter()
                .map(|d| angle_deg(*d, own) <= NEIGHBOUR_DEG)
                .collect();
            let without = without(&gone, work, found, reduced, held)?;
            let parameters = without.parameters;
            let inverse = matrix3::inverse(&parameters.m)?;
            let offset = parameters.offset(work[k].warmer_c);
            let force = matrix3::mul_vec(&inverse, &matrix3::sub(&work[k].mean, &offset));
            let h = predicted::sensitivity(&inverse, matrix3::unit(&force), held.gravity);
            // The last three are the derivatives by b, and by the reading.
            let reading = work[k].sd.map(|s| s.hypot(held.model_error));
            let noise: f64 = (0..3).map(|i| (h[9 + i] * reading[i]).powi(2)).sum();
            Some(LeftOut {
                error: matrix3::norm(&force) - held.gravity,
                sd: ((without.variance)(&model::by_drift(&h, work[k].warmer_c))? + noise).sqrt(),
            })
        })
        .collect()
}

/// A fit without some poses.
struct Without<'a> {
    parameters: State,
    variance: Variance<'a>,
}

/// The fit without the places that are `gone`; none where what remains determines too
/// little.
fn without<'a>(
    gone: &[bool],
    work: &[Pose],
    found: &'a Fit,
    reduced: &Reduced,
    held: &Held,
) -> Option<Without<'a>> {
    let is_left = |k: usize| found.place_of[k].is_some_and(|place| !gone[place]);
    if (0..work.len()).filter(|&k| is_left(k)).count() < LEAST_POSES {
        return None;
    }
    let rest = || {
        let mut rest = work.to_vec();
        for (k, pose) in rest.iter_mut().enumerate() {
            pose.left_out = !is_left(k);
        }
        rest
    };
    let faces = (0..work.len())
        .filter(|&k| is_left(k))
        .filter_map(|k| work[k].face);
    if axes_of(faces) < 2 && found.model.elements == Elements::All {
        let other = in_another_frame(&rest(), found, held)?;
        return Some(Without {
            parameters: other.state.clone(),
            variance: Box::new(move |h| other.variance(h)),
        });
    }
    let [bare, whole] = reduced.without(gone)?;
    if bare.condition() > MOST_CONDITION {
        return None;
    }
    let elements = found.model.list();
    Some(Without {
        parameters: refit(rest, found, held, &whole.step()?)?,
        variance: Box::new(move |h| {
            let h: Vec<f64> = elements.iter().map(|&e| h[e]).collect();
            whole.variance(&h)
        }),
    })
}

/// Variance of hᵀ(M, b, drift of b).
type Variance<'a> = Box<dyn Fn(&[f64; 15]) -> Option<f64> + 'a>;

/// M, b and its drift after a step of the shared parameters, or by a search where the step
/// is too large to be believed.
///
/// M + dM = M(I + E). The antisymmetric part of E is a rotation of the whole
/// frame, which no length sees; without a face it may be large, and taken as
/// linear it would lengthen all. So it is left away.
fn refit(rest: impl Fn() -> Vec<Pose>, found: &Fit, held: &Held, step: &[f64]) -> Option<State> {
    let still = vec![0.0; 2 * found.model.places.len()];
    let moved = found.model.moved(&found.state, step, &still);
    let m = &found.state.m;
    let inverse = matrix3::inverse(m)?;
    let relative = matrix3::mul(&inverse, &moved.m);
    let stretch: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (relative[i][j] + relative[j][i])));
    let off = matrix3::mul_vec(&inverse, &matrix3::sub(&moved.b, &found.state.b));
    if held.elements.is_some() {
        // Given elements may miss the poses by much, and a linear step errs by its share of
        // gravity. The second search has the weights of the first one's result.
        let first = fit(&rest(), held, &found.start())?;
        let second = fit(&rest(), held, &first.start())?;
        return second.converged.then_some(second.state);
    }
    let small = (0..3).all(|i| {
        off[i].abs() <= SMALL_STEP * held.gravity
            && (0..3).all(|j| (stretch[i][j] - f64::from(i == j)).abs() <= SMALL_STEP)
    });
    if small {
        return Some(State {
            m: matrix3::mul(m, &stretch),
            ..moved
        });
    }
    roughly(&rest(), held, &found.start())
}

/// Too few faces remain to hold the frame to the case: M is triangular then.
fn in_another_frame(rest: &[Pose], found: &Fit, held: &Held) -> Option<Fit> {
    let open = Held {
        prior: None,
        ..*held
    };
    let bare = rough_fit(rest, &open, &found.start())?;
    if bare.covariance.values.is_none() || bare.covariance.condition > MOST_CONDITION {
        return None;
    }
    rough_fit(rest, held, &bare.start()).filter(|f| f.converged)
}
