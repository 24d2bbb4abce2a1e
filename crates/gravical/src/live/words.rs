//! Sentences of a session.

use crate::calibration_file::{CalibrationFile, Grade};
use crate::poses::face::{AXES, Face};

use super::mg;

/// `+x` as an attitude: `x up`.
pub(super) fn attitude(face: Face) -> String {
    let axis = AXES[face.axis];
    format!("{axis} {}", if face.up { "up" } else { "down" })
}

/// A list: `+x, -y or +z`.
pub(super) fn any_of(faces: &[Face]) -> String {
    let names: Vec<String> = faces.iter().map(|f| f.name()).collect();
    match names.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// The verdict in a sentence.
pub(super) fn verdict(file: &CalibrationFile) -> String {
    let worst = file.accelerometer.worst_direction.as_ref();
    let error = worst.map_or(String::new(), |w| {
        format!("error of ‖a‖ at most {:.1} mg (95 %)", mg(w.error_mps2))
    });
    // Where this is the larger error, it decides the grade.
    let undetected = file.accelerometer.undetected.as_ref();
    let unseen = undetected.map(|u| {
        let most = mg(u.effect_mps2);
        format!("an error of one pose could change ‖a‖ by {most:.0} mg undetected")
    });
    match (file.verdict.grade, unseen) {
        (Grade::Good, _) => format!("Good: {error}, verified."),
        (Grade::Fair, Some(unseen)) => {
            format!("Fair: {error}, but {unseen}; more free poses test it.")
        }
        (Grade::Fair, None) => format!("Fair: {error}; more free poses make it better."),
        (Grade::NotVerifiable, Some(unseen)) => {
            format!("Not verifiable yet: {unseen}; more free poses test it.")
        }
        (Grade::NotVerifiable, None) => {
            "Not verifiable yet: the poses determine the result, and none is left to test it."
                .to_owned()
        }
        (Grade::Poor, _) => match file.verdict.reasons.first() {
            Some(reason) => format!("Poor: {reason}"),
            None => "Poor.".to_owned(),
        },
    }
}
