//! Commands and options within a sentence: what is between backticks, and words such as
//! `--gravity`. Pages and Markdown set them as code.

/// A part of a sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part<'a> {
    /// Words.
    Words(&'a str),
    /// A command or an option, without its backticks.
    Code(&'a str),
}

/// The parts of `text`, in order.
pub(super) fn parts(text: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let (mut rest, mut words) = (text, 0);
    while let Some((before, code, length)) = first_code(rest, words) {
        if before > 0 {
            parts.push(Part::Words(&rest[..before]));
        }
        parts.push(Part::Code(code));
        rest = &rest[before + length..];
        words = 1;
    }
    if !rest.is_empty() {
        parts.push(Part::Words(rest));
    }
    parts
}

/// Start, text and length of the first code in `text`; `inside`: not 0 if text comes before it.
fn first_code(text: &str, inside: usize) -> Option<(usize, &str, usize)> {
    for (at, c) in text.char_indices() {
        let found = match c {
            '`' => quoted(&text[at..]),
            '-' => {
                let before = text[..at].chars().next_back();
                let starts = match before {
                    Some(c) => c.is_whitespace() || c == '(',
                    None => inside == 0,
                };
                option(&text[at..]).filter(|_| starts)
            }
            _ => None,
        };
        if let Some((code, length)) = found {
            return Some((at, code, length));
        }
    }
    None
}

/// `code` between two backticks, in one line.
fn quoted(text: &str) -> Option<(&str, usize)> {
    let inner = &text[1..];
    let end = inner.find('`')?;
    let code = &inner[..end];
    (!code.is_empty() && code.trim() == code).then_some((code, end + 2))
}

/// `--name`.
fn option(text: &str) -> Option<(&str, usize)> {
    let name = text.strip_prefix("--")?;
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let end = name.find(|c| !is_name(c)).unwrap_or(name.len());
    name.starts_with(|c: char| c.is_ascii_lowercase())
        .then(|| (&text[..end + 2], end + 2))
}
