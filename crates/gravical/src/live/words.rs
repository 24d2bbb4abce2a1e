//! Sentences of a session.

use crate::calibration_file::{CalibrationFile, Grade};
use crate::numfmt::count;
use crate::poses::face::Face;

use super::event::{Fit, Pose, Undone};
use super::mg;

/// Whole sentences: each part begins with a capital letter, unless that is the name of an axis, and ends
/// with a mark. Minus signs before numbers and names of faces are those of the page.
pub fn sentences<'a>(parts: impl IntoIterator<Item = &'a str>) -> String {
    let parts = parts.into_iter().map(str::trim);
    let all: Vec<String> = parts.filter(|p| !p.is_empty()).map(sentence).collect();
    all.join(" ")
}

fn sentence(text: &str) -> String {
    let word = text.split(|c: char| !c.is_alphanumeric()).next();
    let is_axis = matches!(word, Some("x" | "y" | "z" | "ax" | "ay" | "az"));
    let mut characters = text.chars().peekable();
    let mut sentence = String::new();
    let mut last = ' ';
    while let Some(c) = characters.next() {
        let is_sign = c == '-' && " (,/“".contains(last);
        let is_next = |next: &char| next.is_ascii_digit() || matches!(next, 'x'..='z');
        sentence.push(match c {
            '-' if is_sign && characters.peek().is_some_and(is_next) => '−',
            c if sentence.is_empty() && !is_axis => c.to_uppercase().next().unwrap_or(c),
            c => c,
        });
        last = c;
    }
    if !sentence.ends_with(['.', '!', '?', '…', ':']) {
        sentence.push('.');
    }
    sentence
}

/// The name of a face with the minus sign of the page.
pub(super) fn signed(face: &str) -> String {
    face.replace('-', "−")
}

/// The face of a pose, or `free pose`.
fn name(face: Option<&str>) -> String {
    face.map_or_else(|| "free pose".to_owned(), signed)
}

/// A list: `+x, −y or +z`.
pub(super) fn any_of(faces: &[Face]) -> String {
    let names: Vec<String> = faces.iter().map(|f| signed(&f.name())).collect();
    match names.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// A face that is tilted by more than this is noted, degrees.
const FINE_TILT_DEG: f64 = 10.0;

/// An accepted pose, and how many faces and free poses there are with it.
pub(super) fn accepted(pose: &Pose, faces: usize, free: usize) -> String {
    let face = name(pose.face.as_deref());
    let done = format!("{face} is done");
    let numbers = format!(
        "‖a‖ {:.3} m/s², noise {:.1} mg ({faces} of 6 faces, {free} free)",
        pose.norm_mps2, pose.noise_mg
    );
    let note = match pose.face {
        Some(_) if pose.tilt_deg > FINE_TILT_DEG => format!(
            "{:.0}° from {face}: a pose nearer to the face determines the axes better",
            pose.tilt_deg
        ),
        _ => String::new(),
    };
    sentences([&*done, &*numbers, &*note])
}

/// A pose that no longer counts.
pub(super) fn undone(pose: &Pose, why: Undone) -> String {
    let face = name(pose.face.as_deref());
    let what = format!("pose {} ({face}) no longer counts", pose.pose);
    let next = match why {
        Undone::Redo => format!("put {face} up again"),
        Undone::Undo => "the others are untouched".to_owned(),
    };
    sentences([&*what, &*next])
}

/// The calibration from the poses so far.
pub(super) fn fit(fit: &Fit) -> String {
    let mg = |value: Option<f64>| value.map_or("unknown".to_owned(), |v| format!("{v:.1} mg"));
    let [x, y, z] = fit.bias_mg;
    sentences([&*format!(
        "bias {x:.1}, {y:.1}, {z:.1} mg; error of ‖a‖ at most {} (95 %); leave-one-out {}; {}",
        mg(fit.worst_mg),
        mg(fit.leave_one_out_mg),
        fit.grade
    )])
}

/// That the poses are safe; nothing without any.
pub(super) fn safe(poses: usize) -> String {
    match poses {
        0 => String::new(),
        1 => "1 pose is safe".to_owned(),
        n => format!("{} are safe", count(n, "pose")),
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
            Some(reason) => sentences([&*format!("Poor: {reason}")]),
            None => "Poor.".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::sentences;

    #[test]
    fn parts_become_sentences() {
        for (parts, text) in [
            (
                &["it moved: 84 mg, limit -3 mg"][..],
                "It moved: 84 mg, limit −3 mg.",
            ),
            (
                &["x up, tilted 30°", "lean it"],
                "x up, tilted 30°. Lean it.",
            ),
            (&["ay keeps one value", ""], "ay keeps one value."),
            (
                &["-x is done!", " redo -y; --baud 9600 "],
                "−x is done! Redo −y; --baud 9600.",
            ),
        ] {
            assert_eq!(sentences(parts.iter().copied()), text);
        }
    }
}
