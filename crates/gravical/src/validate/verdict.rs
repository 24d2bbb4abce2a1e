//! The grade of a calibration and its reasons.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::calibration_file::{
    AccelerometerSection, Grade, Position, PositionKind, TiltSource, Verdict,
};
use crate::estimate::accelerometer::Method;
use crate::recording::Finding;

use super::errors::free_norm_error;

/// Error of ‖a‖ in the worst direction, mg, up to which a result is good, and fair: by
/// the covariance (2σ), and by an error of one placement that nothing would show.
const GOOD_MG: f64 = 5.0;
const FAIR_MG: f64 = 20.0;
/// Predicted 2σ error over all directions beyond which a result that nothing verifies is poor: six
/// faces placed by hand stay below.
const UNVERIFIED_MG: f64 = 50.0;
/// With fewer degrees of freedom the readings leave nothing that could
/// contradict the result.
const LEAST_FREEDOM: f64 = 0.5;
/// Placements left out contradict the result when the largest of their errors,
/// each over its own standard deviation, is rarer than this among so many.
const CHANCE: f64 = 1e-3;

fn mg(mps2: f64) -> f64 {
    1000.0 * mps2 / STANDARD_GRAVITY_MPS2
}

/// A figure in mg with two digits that count.
fn figure(mps2: f64) -> String {
    let v = mg(mps2);
    if v.abs() < 0.995 {
        format!("{v:.2} mg")
    } else if v.abs() < 9.95 {
        format!("{v:.1} mg")
    } else {
        format!("{v:.0} mg")
    }
}

/// Grade and reasons.
#[must_use]
pub fn verdict(section: &AccelerometerSection, findings: &[Finding], gravity: f64) -> Verdict {
    let mut reasons: Vec<String> = findings
        .iter()
        .filter(|f| f.kind.is_gate())
        .map(|f| f.message.clone())
        .collect();
    let measured = measured(section);
    let grade = if reasons.is_empty() {
        measured
    } else {
        Grade::Poor
    };
    reasons.extend(worst_direction(section));
    reasons.extend(shown(section));
    if let Some(error) = section.predicted_norm_error_mps2 {
        let tilt = section.placement_tilt_deg.map_or(String::new(), |t| {
            format!(
                ", with a placement tilt of {:.2}° ({})",
                t.value,
                match t.source {
                    TiltSource::Given => "given",
                    TiltSource::Estimated => "what the faces show",
                    TiltSource::Assumed => "assumed",
                }
            )
        });
        reasons.push(format!(
            "predicted error of the magnitude at rest: {} (1σ, over all directions{tilt})",
            figure(error)
        ));
    }
    match section
        .leave_one_out_rms_mps2
        .filter(|_| verifiable(section))
    {
        Some(error) => reasons.push(format!(
            "{} placements left out of the fit one by one: the magnitude is off by {} rms",
            section
                .positions
                .iter()
                .filter(|p| p.left_out_error_mps2.is_some())
                .count(),
            figure(error)
        )),
        None => reasons.push(unverified(section)),
    }
    if let Some(c) = contradiction(section).filter(|_| verifiable(section)) {
        reasons.push(format!(
            "{} contradicts the others: left out, its magnitude is off by {}, {:.1} times what chance allows",
            c.position.label,
            figure(c.error_mps2),
            c.excess
        ));
    }
    if let Some(c) = &section.contradicted {
        reasons.push(format!(
            "{} does not fit the others: {:.1} times what chance allows, by the scatter that these have",
            c.label, c.excess
        ));
    }
    if section.leave_one_out_rms_mps2.is_none()
        && let Some((error, count)) = free_norm_error(&section.positions, gravity)
    {
        reasons.push(format!(
            "{count} oblique {} no part in the fit; there the magnitude is off by {} rms",
            if count == 1 {
                "placement took"
            } else {
                "placements took"
            },
            figure(error)
        ));
    }
    reasons.extend(open_angles(section));
    if let Some(worst) = &section.worst_pose
        && verifiable(section)
    {
        reasons.push(format!("hurts most: {} ({})", worst.label, worst.reason));
    }
    if let Some(next) = section.next_poses.first()
        && let Some(now) = section.predicted_norm_error_mps2
    {
        let last = section.next_poses.last().unwrap_or(next);
        reasons.push(format!(
            "would help most: a placement with {}: {} → {}{}",
            next.hint,
            figure(now),
            figure(next.predicted_norm_error_mps2),
            if section.next_poses.len() > 1 {
                format!(
                    "; {} such placements: {}",
                    section.next_poses.len(),
                    figure(last.predicted_norm_error_mps2)
                )
            } else {
                String::new()
            }
        ));
    } else if grade == Grade::NotVerifiable {
        reasons.push("what would verify it: a still reading in any oblique position, calibrated, has to be as long as gravity".to_owned());
    }
    Verdict { grade, reasons }
}

/// The error of ‖a‖ that the covariance predicts in the worst direction.
fn worst_direction(section: &AccelerometerSection) -> Option<String> {
    let worst = section.worst_direction.as_ref()?;
    Some(format!(
        "error of ‖a‖ at most {} (2σ) in the worst direction ({})",
        figure(worst.error_mps2),
        worst.hint
    ))
}

/// Which error of one placement would have shown, what a smaller one can do, and the
/// placement that would test it.
fn shown(section: &AccelerometerSection) -> Option<String> {
    if !verifiable(section) || !tests_placements(section) {
        return None;
    }
    let now = section
        .undetected
        .as_ref()
        .map_or(f64::INFINITY, |u| u.effect_mps2);
    let next = tested_by(section, now).unwrap_or_default();
    let Some(hidden) = &section.undetected else {
        return Some(format!(
            "the placements leave too little over to show an error of one of them, whatever its size{next}"
        ));
    };
    let effect = figure(hidden.effect_mps2);
    let reading = figure(hidden.reading_mps2);
    let label = &hidden.label;
    Some(if mg(hidden.effect_mps2) <= GOOD_MG {
        format!(
            "an error in one placement that changes ‖a‖ by more than {effect} would have shown (in 9 of 10 sessions; {label} off by {reading})"
        )
    } else {
        format!(
            "an error in one placement could change ‖a‖ by {effect} unseen ({}), {label} being off by {reading}{next}",
            hidden.hint
        )
    })
}

/// How many of the proposed placements leave least to hide, where that is less than now.
fn tested_by(section: &AccelerometerSection, now_mps2: f64) -> Option<String> {
    let (count, least) = (1..)
        .zip(&section.next_poses)
        .filter_map(|(count, next)| Some((count, next.undetected_effect_mps2?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, least)| *least < now_mps2)?;
    let first = &section.next_poses.first()?.hint;
    Some(if count == 1 {
        format!("; a placement with {first} leaves {}", figure(least))
    } else {
        format!(
            "; {count} more placements, the first with {first}, leave {}",
            figure(least)
        )
    })
}

/// The method tests each placement against the others.
fn tests_placements(section: &AccelerometerSection) -> bool {
    section.method == Method::Joint.name()
}

/// The grade by the error that is predicted in the worst direction, by what placements
/// left out say of it, and by what an error of one of them could do unseen. Their number
/// alone says nothing.
fn measured(section: &AccelerometerSection) -> Grade {
    let Some(predicted) = section.predicted_norm_error_mps2 else {
        return Grade::NotVerifiable;
    };
    let left_out = contradiction(section);
    let excess = section.contradicted.as_ref().map_or(1.0, |c| c.excess);
    let excess = left_out.as_ref().map_or(excess, |c| c.excess.max(excess));
    let error = left_out.as_ref().map_or(0.0, |c| mg(c.error_mps2));
    let worst = section
        .worst_direction
        .as_ref()
        .map_or(f64::INFINITY, |w| mg(w.error_mps2));
    let seen = error.max(worst * excess);
    let unseen = match &section.undetected {
        Some(hidden) => mg(hidden.effect_mps2),
        None if tests_placements(section) => f64::INFINITY,
        // Methods without a test of single placements are held to what is left out alone.
        None => 0.0,
    };
    if verifiable(section) && unseen <= FAIR_MG {
        return if seen.max(unseen) <= GOOD_MG {
            Grade::Good
        } else if seen <= FAIR_MG {
            Grade::Fair
        } else {
            Grade::Poor
        };
    }
    let contradicted = left_out.is_some() || section.contradicted.is_some();
    if 2.0 * mg(predicted) <= UNVERIFIED_MG && (!contradicted || seen <= FAIR_MG) {
        Grade::NotVerifiable
    } else {
        Grade::Poor
    }
}

/// True when a placement can be left out, and the readings leave something over
/// to judge by.
fn verifiable(section: &AccelerometerSection) -> bool {
    section.leave_one_out_rms_mps2.is_some() && !nothing_left(section)
}

/// True when there are as many parameters as readings to tell them.
fn nothing_left(section: &AccelerometerSection) -> bool {
    section.fit.is_some_and(|f| f.freedom < LEAST_FREEDOM)
}

/// A placement that the fit without it did not foresee.
struct Contradiction<'a> {
    position: &'a Position,
    error_mps2: f64,
    /// Its error over the largest that chance makes.
    excess: f64,
}

/// The placement left out that contradicts the result most, if one does: its
/// error over its own standard deviation is beyond Student's t with the degrees
/// of freedom that the model error was estimated from (Bonferroni's correction
/// for looking at all). Without standard deviations the predicted error over all
/// directions has to do.
fn contradiction(section: &AccelerometerSection) -> Option<Contradiction<'_>> {
    let usual = section.predicted_norm_error_mps2?;
    let left_out: Vec<(&Position, f64, f64)> = section
        .positions
        .iter()
        .filter_map(|p| {
            let error = p.left_out_error_mps2?.abs();
            Some((p, error, p.left_out_sd_mps2.unwrap_or(usual)))
        })
        .collect();
    if left_out.is_empty() {
        return None;
    }
    let freedom = section.fit.map_or(1.0, |f| f.freedom.max(1.0));
    let limit = StudentsT::new(0.0, 1.0, freedom)
        .ok()?
        .inverse_cdf(1.0 - 0.5 * CHANCE / left_out.len() as f64);
    left_out
        .into_iter()
        .map(|(position, error_mps2, sd)| Contradiction {
            position,
            error_mps2,
            excess: error_mps2 / (limit * sd),
        })
        .max_by(|a, b| a.excess.total_cmp(&b.excess))
        .filter(|c| c.excess > 1.0)
}

fn unverified(section: &AccelerometerSection) -> String {
    let fitted = section.positions.iter().filter(|p| p.fitted);
    let faces = fitted
        .clone()
        .filter(|p| p.kind == PositionKind::Face)
        .count();
    if section.method == "ferraris" && section.degrees_of_freedom > 0 {
        return "the six-face method compares no placement that it was not fitted to: its residuals prove nothing".to_owned();
    }
    if fitted.clone().count() == faces && faces == 6 {
        return "six faces determine six parameters of the magnitude exactly: the residuals of the fitted placements prove nothing".to_owned();
    }
    if nothing_left(section) {
        return format!(
            "{} placements determine the parameters and leave nothing over that could contradict them: nothing verifies the result",
            fitted.count()
        );
    }
    "too few placements to leave one out: nothing verifies the result".to_owned()
}

/// Angles between the axes that the placements do not tell from their own tilt.
fn open_angles(section: &AccelerometerSection) -> Option<String> {
    let d = section.deviations.as_ref()?;
    let tilt = section.placement_tilt_deg?;
    let worst = d.axis_angle_deg.iter().fold(0.0_f64, |m, a| m.max(*a));
    (worst > 0.3).then(|| {
        format!(
            "faces alone cannot tell how crookedly a placement lay (σ {:.1}°) from how crookedly the axes sit: the angles between the axes are known to ±{worst:.1}° (1σ); oblique placements tell them apart",
            tilt.value
        )
    })
}
