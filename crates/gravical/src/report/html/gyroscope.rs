//! The gyroscope of a calibration.

use maud::{Markup, html};

use super::super::gyroscope::deviations;
use super::cells::{digits, number, shown_unit};
use super::parameters::{self, matrix};
use crate::calibration_file::GyroscopeSection;

pub(super) fn gyroscope(g: &GyroscopeSection) -> Markup {
    let unit = &shown_unit(g.input_unit.name());
    let how = match g.method.as_str() {
        "turns" => "From three known turns and the rests (Ferraris).",
        "motion" => {
            "From the motions between rests: gravity, turned by the integrated rate, has to arrive where the accelerometer sees it."
        }
        "bias" => "Its bias alone, from the rests; no turn shows the scale, which is nominal.",
        _ => "How it was estimated is not known here.",
    };
    let sd = if g.method == "bias" {
        bias_alone(g)
    } else {
        deviations(g)
    };
    let coupled = g.g_sensitivity.iter().flatten().any(|v| *v != 0.0);
    html! {
        p { (how) }
        p.equation {
            "raw = K R ω + b + S a" br; "calibrated = matrix · (raw − b − S a)"
        }
        p { "ω is angular rate in rad/s, counter-clockwise about each axis; raw values are in " (unit) "." }
        (parameters::gyroscope(g, sd))
        div.pair {
            (matrix("R", "/gyroscope/orientation", &g.orientation))
            (matrix(&format!("matrix, rad/s per {unit}"), "/gyroscope/matrix", &g.matrix))
        }
        @if coupled { (matrix(&format!("S, {unit} per m/s²"), "/gyroscope/g_sensitivity", &g.g_sensitivity)) }
        @if let (Some(residual), Some(motions)) = (g.residual_deg, g.motions) {
            p {
                "From " (number("/gyroscope/motions/used", f64::from(motions.used), &motions.used.to_string()))
                " motions; " (number("/gyroscope/motions/left_out", f64::from(motions.left_out), &motions.left_out.to_string()))
                " were left out. Turned by it, gravity is off by "
                (number("/gyroscope/residual_deg", residual, &digits(residual, 2))) "° rms after a motion"
                @if let Some(left) = g.leave_one_out_deg {
                    ", " (number("/gyroscope/leave_one_out_deg", left, &digits(left, 2)))
                    "° when the motion takes no part"
                }
                "."
            }
        }
    }
}

/// Standard deviations where the covariance is of the bias alone: those of the
/// scale are not known.
fn bias_alone(g: &GyroscopeSection) -> Option<([f64; 3], [f64; 3])> {
    let c = &g.covariance.as_ref()?.values;
    let at = |i: usize| Some(c.get(i)?.get(i)?.sqrt());
    Some(([at(0)?, at(1)?, at(2)?], [f64::NAN; 3]))
}
