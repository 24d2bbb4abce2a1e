//! What names of files and labels say of a face.

use super::{AXES, Face};

/// What a file name or label claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// This face.
    Face(Face),
    /// A placement along this axis, either way (`x_axis.csv`).
    Axis(usize),
    /// A turn about an axis.
    Turn,
}

/// Reads a claim off a label or the stem of a file name: `x_axis_neg`,
/// `xminus`, `+z`, `z_p`, `x_a` (antiparallel), `y_rot`, `z_up` …. None when
/// it claims nothing.
#[must_use]
pub fn claim(name: &str) -> Option<Claim> {
    let name = name.trim().to_lowercase();
    let mut words = Words::default();
    for token in name.split(['_', ' ', '.', '/']) {
        if let Some((axis, sign)) = signed_axis(token) {
            words.axis.get_or_insert(axis);
            words.up.get_or_insert(sign);
            continue;
        }
        for word in token
            .split(|c: char| !c.is_alphanumeric())
            .filter(|w| !w.is_empty())
        {
            words.read(word);
        }
    }
    let axis = words.axis?;
    Some(match (words.turn, words.up.or(words.letter)) {
        (true, _) => Claim::Turn,
        (false, Some(up)) => Claim::Face(Face { axis, up }),
        (false, None) => Claim::Axis(axis),
    })
}

fn axis_letter(text: &str) -> Option<usize> {
    AXES.iter()
        .position(|a| text.len() == 1 && text.starts_with(*a))
}

/// `+x`, `-x`, `x+`, `x-`.
fn signed_axis(token: &str) -> Option<(usize, bool)> {
    let sign = |c: char| match c {
        '+' => Some(true),
        '-' | '−' => Some(false),
        _ => None,
    };
    let mut letters = token.chars();
    let (first, last) = (letters.next()?, letters.next_back()?);
    if token.chars().count() != 2 {
        return None;
    }
    if let Some(up) = sign(first) {
        return Some((axis_letter(&last.to_string())?, up));
    }
    Some((axis_letter(&first.to_string())?, sign(last)?))
}

/// What the words of a name have said so far.
#[derive(Default)]
struct Words {
    axis: Option<usize>,
    /// By a whole word (`pos`, `neg`), which overrules a letter.
    up: Option<bool>,
    /// By one letter right behind the axis (`x_a`).
    letter: Option<bool>,
    turn: bool,
    after_axis: bool,
}

impl Words {
    fn read(&mut self, word: &str) {
        let whole = |word: &str| match word {
            "pos" | "positive" | "plus" | "up" | "parallel" => Some(true),
            "neg" | "negative" | "minus" | "anti" | "antiparallel" | "down" => Some(false),
            _ => None,
        };
        let letter = |word: &str| match word {
            "p" => Some(true),
            "n" | "m" | "a" => Some(false),
            _ => None,
        };
        let behind_axis = std::mem::take(&mut self.after_axis);
        if let Some(axis) = axis_letter(word) {
            self.axis.get_or_insert(axis);
            self.after_axis = true;
        } else if matches!(word, "rot" | "rotation" | "turn" | "spin") {
            self.turn = true;
        } else if let Some(sign) = whole(word) {
            self.up.get_or_insert(sign);
        } else if let Some(sign) = letter(word) {
            if behind_axis {
                self.letter.get_or_insert(sign);
            }
        } else if let Some(axis) = word.get(..1).and_then(axis_letter) {
            // `xminus`, `zp`, `xrot`, `xaxis` in one word.
            let rest = &word[1..];
            let sign = whole(rest).or_else(|| letter(rest));
            if matches!(rest, "rot" | "turn") || rest == "axis" || sign.is_some() {
                self.axis.get_or_insert(axis);
                self.turn |= matches!(rest, "rot" | "turn");
                if let Some(sign) = sign {
                    self.up.get_or_insert(sign);
                }
            }
        } else if let Some(axis) = word
            .get(word.len().saturating_sub(1)..)
            .and_then(axis_letter)
            && let Some(sign) = whole(&word[..word.len() - 1])
        {
            // `plusx`, `negz`.
            self.axis.get_or_insert(axis);
            self.up.get_or_insert(sign);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_wild() {
        for (name, face) in [
            ("x_axis_neg", "-x"),
            ("x_axis_pos", "+x"),
            ("xminus", "-x"),
            ("zplus", "+z"),
            ("+z", "+z"),
            ("-y", "-y"),
            ("z_p", "+z"),
            ("y_a", "-y"),
            ("X Up", "+x"),
            ("session-z-down", "-z"),
            ("neg_x", "-x"),
            ("y-", "-y"),
            ("acc_xp", "+x"),
            ("sensor_a_x_axis_pos", "+x"),
            ("m_z_axis_neg", "-z"),
        ] {
            match claim(name) {
                Some(Claim::Face(f)) => assert_eq!(f.name(), face, "{name}"),
                other => panic!("{name}: {other:?}"),
            }
        }
        assert_eq!(claim("x_rot"), Some(Claim::Turn));
        assert_eq!(claim("y_axis"), Some(Claim::Axis(1)));
        for name in ["session", "calibration", "flat", "data2", "recording_01"] {
            assert_eq!(claim(name), None, "{name}");
        }
    }
}
