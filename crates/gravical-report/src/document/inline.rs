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
    // Everything before it is in the parts.
    let mut done = 0;
    for (at, c) in text.char_indices() {
        let code = match c {
            _ if at < done => None,
            '`' => quoted(&text[at..]),
            '-' if !text[..at].ends_with(|c: char| !c.is_whitespace() && c != '(') => {
                option(&text[at..]).map(|option| (option, option.len()))
            }
            _ => None,
        };
        if let Some((code, length)) = code {
            parts.extend((at > done).then(|| Part::Words(&text[done..at])));
            parts.push(Part::Code(code));
            done = at + length;
        }
    }
    parts.extend((done < text.len()).then(|| Part::Words(&text[done..])));
    parts
}

/// What stands between two backticks, and its length with them.
fn quoted(text: &str) -> Option<(&str, usize)> {
    let (code, _) = text[1..].split_once('`')?;
    (!code.is_empty() && code.trim() == code).then_some((code, code.len() + 2))
}

/// `--name`.
fn option(text: &str) -> Option<&str> {
    let name = text.strip_prefix("--")?;
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let end = name.find(|c| !is_name(c)).unwrap_or(name.len());
    name.starts_with(|c: char| c.is_ascii_lowercase())
        .then(|| &text[..end + 2])
}
