//! What names of files and labels say of a face.

use super::{AXES, Face};

/// What a file name or label claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// This face.
    Face(Face),
    /// A placement along this axis, either way (`x_axis.csv`).
    Axis(usize),
    /// A turn about this axis.
    Turn(usize),
}

/// Reads a claim off a label or the stem of a file name: `x_axis_neg`,
/// `xminus`, `+z`, `z_p`, `x_a` (antiparallel), `y_rot`, `z_up` …. None when
/// it claims nothing.
pub fn claim(name: &str) -> Option<Claim> {
    let name = name.trim().to_lowercase().replace('−', "-");
    let (mut axis, mut turn, mut behind_axis) = (None, false, false);
    // By a whole word (`pos`, `neg`), which overrules a letter behind the axis (`x_a`).
    let (mut by_word, mut by_letter) = (None, None);
    for word in name.split(['_', ' ', '.', '/']).flat_map(words) {
        let (named, about) = match parted(word) {
            Some((axis, about)) => (axis_of(axis), about),
            None if axis_of(word).is_some() => (axis_of(word), ""),
            None => (None, word),
        };
        axis = axis.or(named);
        turn |= matches!(about, "rot" | "rotation" | "turn" | "spin");
        by_word = by_word.or(sign(about));
        if behind_axis || named.is_some() {
            by_letter = by_letter.or(letter(about));
        }
        behind_axis = named.is_some() && about.is_empty();
    }
    let axis = axis?;
    Some(match (turn, by_word.or(by_letter)) {
        (true, _) => Claim::Turn(axis),
        (false, Some(up)) => Claim::Face(Face { axis, up }),
        (false, None) => Claim::Axis(axis),
    })
}

/// The words of a part of a name: `+x` is one, `z-down` are two.
fn words(part: &str) -> Vec<&str> {
    if parted(part).is_some() {
        return vec![part];
    }
    let words = part.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty()).collect()
}

/// An axis in one word with what is said about it: `+x`, `xminus`, `plusx`, `xrot`.
fn parted(word: &str) -> Option<(&str, &str)> {
    let (head, rest) = word.split_at(word.chars().next()?.len_utf8());
    let is_about = matches!(rest, "rot" | "turn" | "axis");
    if axis_of(head).is_some() && (is_about || sign(rest).or(letter(rest)).is_some()) {
        return Some((head, rest));
    }
    let (rest, tail) = word.split_at(word.char_indices().next_back()?.0);
    (axis_of(tail).is_some() && sign(rest).is_some()).then_some((tail, rest))
}

fn axis_of(word: &str) -> Option<usize> {
    let is_axis = |axis: &char| word.len() == 1 && word.starts_with(*axis);
    AXES.iter().position(is_axis)
}

/// True for up.
fn sign(word: &str) -> Option<bool> {
    match word {
        "+" | "pos" | "positive" | "plus" | "up" | "parallel" => Some(true),
        "-" | "neg" | "negative" | "minus" | "anti" | "antiparallel" | "down" => Some(false),
        _ => None,
    }
}

fn letter(word: &str) -> Option<bool> {
    match word {
        "p" => Some(true),
        "n" | "m" | "a" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_wild() {
        for (face, names) in [
            ("-x", "x_axis_neg xminus neg_x"),
            ("+x", "x_axis_pos X%Up acc_xp sensor_a_x_axis_pos"),
            ("-y", "-y y_a y-"),
            ("+z", "zplus +z z_p"),
            ("-z", "session-z-down m_z_axis_neg"),
        ] {
            for name in names.split(' ').map(|name| name.replace('%', " ")) {
                match claim(&name) {
                    Some(Claim::Face(f)) => assert_eq!(f.name(), face, "{name}"),
                    other => panic!("{name}: {other:?}"),
                }
            }
        }
        assert_eq!(claim("x_rot"), Some(Claim::Turn(0)));
        assert_eq!(claim("y_axis"), Some(Claim::Axis(1)));
        for name in ["session", "calibration", "flat", "data2", "recording_01"] {
            assert_eq!(claim(name), None, "{name}");
        }
    }
}
