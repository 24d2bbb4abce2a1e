//! The skeleton of a line: its text with a slot for each number.

use crate::units::{is_listed, is_unit};

/// Stands for a number in a skeleton.
pub(crate) const SLOT: char = '\u{1}';

/// Characters of the longest date, time or unit: lines without end take no longer for it.
const MAX_WORD: usize = 32;

/// The line with [`SLOT`] for each number, and the numbers. Blanks beside a number do not count.
pub(crate) fn skeleton(line: &str) -> (String, Vec<&str>) {
    let line = without_checksum(line);
    let (mut out, mut numbers, mut at) = (String::new(), Vec::new(), 0);
    let mut before = ' ';
    while let Some(c) = line[at..].chars().next() {
        let can_start = !(before.is_alphanumeric() || "_^.²".contains(before));
        if can_start
            && let Some(n) = number_length(&line[at..])
            && !is_glued(&line[at + n..])
        {
            out.truncate(out.trim_end().len());
            out.push(SLOT);
            numbers.push(&line[at..at + n]);
            before = line[..at + n].chars().next_back().unwrap_or(' ');
            at += n;
            continue;
        }
        if !c.is_whitespace() {
            out.push(c);
        } else if !out.ends_with([' ', SLOT]) {
            out.push(' ');
        }
        before = c;
        at += c.len_utf8();
    }
    out.truncate(out.trim_end().len());
    (out, numbers)
}

/// Without the checksum of a sentence of NMEA 0183: `*5A`.
fn without_checksum(line: &str) -> &str {
    match line.rsplit_once('*') {
        Some((rest, sum)) if sum.len() == 2 && sum.bytes().all(|b| b.is_ascii_hexdigit()) => rest,
        _ => line,
    }
}

/// Whether a word that is no unit follows without a blank: `2nd`.
fn is_glued(rest: &str) -> bool {
    let is_end = |(_, c): &(usize, char)| c.is_whitespace() || ",;|)]}".contains(*c);
    let end = rest.char_indices().take(MAX_WORD).find(is_end);
    let is_word = rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let word = end.map_or(rest, |(end, _)| &rest[..end]);
    is_word && (word.len() > MAX_WORD || !is_unit(word))
}

/// Whether there is more between the slots than delimiters and fields of text.
pub(crate) fn is_decorated(skeleton: &str) -> bool {
    const DELIMITERS: [char; 3] = [',', ';', '|'];
    let mut pieces = skeleton.split(SLOT).map(|p| p.trim_matches([' ', '"']));
    let is_prefixed = pieces.next().is_some_and(|p| !p.is_empty());
    // What follows the last slot does not count.
    let inner = skeleton.matches(SLOT).count().saturating_sub(1);
    let mut inner = pieces.take(inner);
    is_prefixed
        || inner.any(|p| {
            let is_field = p.starts_with(DELIMITERS) && p.ends_with(DELIMITERS);
            !p.trim_matches(DELIMITERS).is_empty() && !is_field
        })
}

/// How many of the first bytes are of a kind.
fn prefix(bytes: &[u8], is: impl Fn(&u8) -> bool) -> usize {
    let bytes = bytes.iter().take(MAX_WORD);
    bytes.take_while(|b| is(b)).count()
}

/// Length of the number, or of the time of day with its date, that a text starts with.
fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    if let Some(n) = time_length(bytes) {
        return Some(n);
    }
    let day = prefix(bytes, |b| b.is_ascii_digit() || b"-/.".contains(b));
    if (8..=10).contains(&day)
        && matches!(bytes.get(day), Some(b' ' | b'T'))
        && let Some(n) = time_length(&bytes[day + 1..])
    {
        return Some(day + 1 + n);
    }
    if let Ok((_, n)) = fast_float2::parse_partial::<f64, _>(bytes)
        && bytes[..n].iter().any(u8::is_ascii_digit)
    {
        return Some(n);
    }
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let word = text[sign..].split(|c: char| !c.is_alphanumeric()).next()?;
    let is_missing = is_listed("nan null none inf", &word.to_ascii_lowercase());
    is_missing.then_some(sign + word.len())
}

/// Length of `hh:mm`, `h:m:s.f` or `h:m:s:ffff`.
fn time_length(bytes: &[u8]) -> Option<usize> {
    let n = prefix(bytes, |b| b.is_ascii_digit() || *b == b':');
    let lengths: Vec<usize> = bytes[..n].split(|b| *b == b':').map(<[u8]>::len).collect();
    let is_time = match lengths.len() {
        2 => lengths.iter().all(|l| *l == 2),
        3 => lengths.iter().all(|l| (1..=2).contains(l)),
        4 => lengths.iter().all(|l| *l > 0),
        _ => false,
    };
    is_time.then(|| match bytes.get(n) {
        Some(b'.') => n + 1 + prefix(&bytes[n + 1..], u8::is_ascii_digit),
        _ => n,
    })
}
