//! Names of faces, and whole sentences.

use gravical_calibrate::poses::face::Face;

/// The face with this name: `+x`; `−x` with a minus sign, too.
pub(crate) fn face_of(name: &str) -> Option<Face> {
    let name = name.replace('−', "-");
    Face::all().into_iter().find(|face| face.name() == name)
}

/// A list: `+x, -y or +z`.
pub(crate) fn any_of(faces: &[Face]) -> String {
    let names: Vec<String> = faces.iter().map(|f| f.name()).collect();
    match &names[..] {
        [] => "another direction".to_owned(),
        [one] => one.clone(),
        [_, _, _, _, _, _] => "any side".to_owned(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}

/// A whole sentence: it begins with a capital letter, unless that is the name of an axis, and ends with a
/// mark. Minus signs before numbers and names of faces are those of the page.
pub fn sentence(text: &str) -> String {
    let text = text.trim();
    let word = text.split(|c: char| !c.is_alphanumeric()).next();
    let is_axis = matches!(word, Some("x" | "y" | "z" | "ax" | "ay" | "az"));
    let is_counted = |c: char| c.is_ascii_digit() || matches!(c, 'x'..='z');
    let mut sentence = String::new();
    for (at, c) in text.char_indices() {
        let before = text[..at].chars().next_back().unwrap_or(' ');
        match c {
            '-' if " (,/“".contains(before) && text[at + 1..].starts_with(is_counted) => {
                sentence.push('−');
            }
            c if at == 0 && !is_axis => sentence.extend(c.to_uppercase()),
            c => sentence.push(c),
        }
    }
    if !text.is_empty() && !sentence.ends_with(['.', '!', '?', '…', ':']) {
        sentence.push('.');
    }
    sentence
}
