//! Text that is safe where it is written: for a terminal, in JSON, as a word of a command line.

use std::borrow::Cow;
use std::path::Path;

/// A character that controls a terminal or the direction of text: C0 except tab, DEL, C1,
/// bidirectional marks, and Unicode line separators.
fn is_control(c: char) -> bool {
    (c.is_control() && c != '\t')
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str, stays: impl Fn(char) -> bool, write: fn(char) -> String) -> Cow<'_, str> {
    let is_escaped = |c: char| is_control(c) && !stays(c);
    if !text.contains(is_escaped) {
        return Cow::Borrowed(text);
    }
    let escape = |c: char| if is_escaped(c) { write(c) } else { c.into() };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Text that is safe for a terminal, whatever recordings, file names and calibrations it
/// contains: characters that control the terminal are written as `\u{1b}`. Line ends are kept.
/// All text output passes through this function.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n', |c| c.escape_unicode().to_string())
}

/// The same for a part of a line, such as a file name or a label: line ends are escaped too.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false, |c| c.escape_unicode().to_string())
}

/// The path as text of one line.
pub fn path_text(path: &Path) -> String {
    one_line(&path.to_string_lossy()).into_owned()
}

/// Equivalent JSON with such characters escaped; they can only occur in strings.
pub fn shown_json(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n', |c| format!("\\u{:04x}", u32::from(c)))
}

/// A word of a command line for a shell, with quotes if necessary.
pub fn shell_word(text: &str) -> String {
    // On Windows it separates the folders of a path, and single quotes quote nothing.
    let is_path = |c: char| cfg!(windows) && c == '\\';
    let plain = |c: char| c.is_alphanumeric() || "_./+-:=,@%".contains(c) || is_path(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    // Double quotes work in every shell if nothing inside is special.
    let special = |c: char| "\"$`\\!".contains(c) && !is_path(c);
    if text.contains(special) {
        return format!("'{}'", text.replace('\'', "'\\''"));
    }
    format!("\"{text}\"")
}

/// The path as a word of a command line for a shell; `./` is added if it begins with a dash, so that it is not an option.
pub fn path_word(path: &Path) -> String {
    let text = path_text(path);
    match text.strip_prefix('-') {
        Some(rest) if !rest.is_empty() => shell_word(&format!("./{text}")),
        _ => shell_word(&text),
    }
}
