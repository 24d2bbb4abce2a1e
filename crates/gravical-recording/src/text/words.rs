//! Numbers wrapped in words: a logger that prints sentences.
//!
//! The constant text of a line is its template; lines of one or more templates take turns. Each
//! number is a slot, and a slot is a column named by the words before it. Where lines are indented
//! below a heading, as YAML and JSON are, its words come first.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use gravical_judge::units::{is_listed, is_unit};
use gravical_judge::{Role, trend};

use super::names::{Column, axis, sensor, words};
use super::number::parse_cell;

/// Lines of which the templates are counted.
const MAX_LINES: usize = 4000;
/// Lines of a row as programs print them, and as they format structures.
const USUAL_CYCLE: usize = 4;
const MAX_CYCLE: usize = 32;
/// Rows that tell a clock from a count of measurement.
const RISING_ROWS: usize = 200;

/// Stands for a number in a template.
const SLOT: char = '\u{1}';
const SLOT_TEXT: &str = "\u{1}";

/// Characters of the longest date, time or unit: lines without end take no longer for it.
const MAX_WORD: usize = 32;

/// Lines with words.
#[derive(Clone, Debug)]
pub(crate) struct LinePattern {
    /// Skeletons of the lines of a row, in order, with the slots of each.
    cycle: Vec<(String, Range<usize>)>,
    /// Skeletons that stand for the first: only their words differ.
    variants: Vec<String>,
    /// Commas within numbers are points: `ax=0,12; ay=…`.
    decimal_comma: bool,
    /// Lines are indented below headings: what is no slot is structure.
    pub has_headings: bool,
    pub slots: usize,
}

/// What a line with words holds.
pub(crate) struct Sentence {
    /// Place of the line within its row.
    pub place: usize,
    /// Slots, and the text of the number in each, with a decimal point.
    pub numbers: Vec<(usize, String)>,
}

/// The last line without a number that names the lines indented below it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heading {
    indent: usize,
    words: String,
}

impl Heading {
    /// The template of a line below this heading, and its numbers.
    fn template<'a>(&mut self, line: &'a str) -> (String, Vec<&'a str>) {
        let (shape, numbers) = template(line);
        let indent = line.len() - line.trim_start().len();
        if indent <= self.indent {
            self.words.clear();
        }
        if !numbers.is_empty() && !self.words.is_empty() {
            return (format!("{} {}", self.words, shape.trim_start()), numbers);
        }
        let is_heading = shape.ends_with([':', '{', '[']) && shape.contains(char::is_alphabetic);
        if numbers.is_empty() && is_heading {
            let words = shape.trim_matches([' ', '"', ':', '{', '[']);
            (self.indent, self.words) = (indent, words.to_owned());
        }
        (shape, numbers)
    }
}

impl LinePattern {
    /// The templates that take turns, if there are any beside delimiters.
    pub(crate) fn sniff(lines: &[&str]) -> Option<Self> {
        let decimal_comma = has_decimal_commas(lines);
        let filled = lines.iter().filter(|l| !l.trim().is_empty());
        let (mut heading, mut has_headings) = (Heading::default(), false);
        let shape = |line: &&str| {
            let line = with_points(line, decimal_comma);
            let (shape, numbers) = heading.template(&line);
            has_headings |= !numbers.is_empty() && !heading.words.is_empty();
            shape
        };
        let order: Vec<String> = filled.take(MAX_LINES).map(shape).collect();
        let mut counts: HashMap<&String, usize> = HashMap::new();
        // An item of a list has no name.
        let is_item = |shape: &str| shape.strip_prefix('-') == Some(SLOT_TEXT);
        for shape in order.iter().filter(|s| s.contains(SLOT) && !is_item(s)) {
            *counts.entry(shape).or_default() += 1;
        }
        let most = *counts.values().max()?;
        counts.retain(|_, count| *count * 2 > most && *count > 2);
        let least = counts.values().copied().min().unwrap_or(most);
        let firsts = order.iter().filter(|shape| counts.remove(shape).is_some());
        let mut shapes: Vec<String> = firsts.cloned().collect();
        // Many lines are one row only where all are there equally often.
        let max_lines = if most <= least + 1 {
            MAX_CYCLE
        } else {
            USUAL_CYCLE
        };
        let is_cycle = (1..=max_lines).contains(&shapes.len())
            && most * shapes.len() * 5 >= order.len()
            && (shapes.iter().any(|s| is_decorated(s)) || has_stamp_lines(&shapes));
        if !is_cycle {
            return None;
        }
        // Shapes that do not take turns are one shape whose words change.
        let place = |shape: &String| shapes.iter().position(|s| s == shape);
        let turns: Vec<usize> = order.iter().filter_map(place).collect();
        let repeats = turns.windows(2).filter(|w| w[0] == w[1]).count();
        let are_variants = repeats * 2 > turns.len();
        let variants = shapes.split_off(if are_variants { 1 } else { shapes.len() });
        let mut slots = 0;
        let cycle = shapes.into_iter().map(|shape| {
            let first = slots;
            slots += shape.matches(SLOT).count();
            (shape, first..slots)
        });
        let cycle = cycle.collect();
        Some(LinePattern {
            cycle,
            variants,
            decimal_comma,
            has_headings,
            slots,
        })
    }

    /// Place of the last line of a row.
    pub(crate) fn last_place(&self) -> usize {
        self.cycle.len() - 1
    }

    /// Place and numbers of a line below a heading; `None` for a line of another template.
    pub(crate) fn parse(&self, line: &str, heading: &mut Heading) -> Option<Sentence> {
        let line = with_points(line, self.decimal_comma);
        let (shape, numbers) = heading.template(&line);
        let place = self.cycle.iter().position(|c| c.0 == shape);
        let place = place.or_else(|| self.variants.contains(&shape).then_some(0))?;
        let slots = self.cycle[place].1.clone();
        (numbers.len() == slots.len()).then(|| Sentence {
            place,
            numbers: slots.zip(numbers.into_iter().map(str::to_owned)).collect(),
        })
    }

    /// Lines above the first that is a part of a row, and the texts of each slot in the first rows.
    pub(crate) fn sample(&self, lines: &[&str]) -> Option<(usize, Vec<Vec<String>>)> {
        let mut heading = Heading::default();
        let (mut first, mut texts) = (None, vec![Vec::new(); self.slots]);
        for (at, line) in lines.iter().enumerate() {
            if let Some(sentence) = self.parse(line, &mut heading) {
                first.get_or_insert(at);
                for (slot, text) in sentence.numbers {
                    texts[slot].push(text);
                }
            }
            if texts[0].len() == RISING_ROWS {
                break;
            }
        }
        Some((first?, texts))
    }

    /// Names of the slots, by the words before them, else by a line above the rows.
    pub(crate) fn names(&self, above: &[&str], texts: &[Vec<String>]) -> Vec<String> {
        let rising: Vec<bool> = texts.iter().map(|texts| is_rising(texts)).collect();
        let cycle = self.cycle.iter();
        let names = cycle.flat_map(|(shape, slots)| slot_names(shape, &rising[slots.clone()]));
        let names: Vec<String> = names.collect();
        let is_accel = |name: &String| Column::from_name(name).is_accel();
        let mut above = above.iter().rev().filter(|_| !names.iter().any(is_accel));
        let header = above.find_map(|l| names_in_line(l, names.len()));
        header.unwrap_or(names)
    }
}

/// Whether numbers never fall and rise often, as those of a clock.
fn is_rising(texts: &[String]) -> bool {
    let values = texts.iter().filter_map(|text| parse_cell(text, false));
    let values: Vec<f64> = values.collect();
    let (rises, falls) = trend(&values);
    falls == 0.0 && rises >= 0.1
}

/// Whether commas join numbers in pairs only, `ax=0,12; ay=…`, and no number has a point.
fn has_decimal_commas(lines: &[&str]) -> bool {
    let pair = format!("{SLOT},{SLOT}");
    let mut has_pair = false;
    for line in lines.iter().take(MAX_LINES) {
        let (shape, numbers) = template(line);
        let has_point = numbers.iter().any(|n| n.contains('.') && !n.contains(':'));
        if has_point || shape.contains(&format!("{pair},{SLOT}")) {
            return false;
        }
        has_pair |= shape.contains(&pair);
    }
    has_pair
}

fn with_points(line: &str, decimal_comma: bool) -> Cow<'_, str> {
    if !decimal_comma || !line.contains(',') {
        return Cow::Borrowed(line);
    }
    let is_digit = |c: char| c.is_ascii_digit();
    let mut pieces = line.split(',');
    let mut out = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let is_point = out.ends_with(is_digit) && piece.starts_with(is_digit);
        out.push(if is_point { '.' } else { ',' });
        out.push_str(piece);
    }
    out.into()
}

/// A line above the rows whose last words (all, or all but the stamp's) name an accelerometer.
fn names_in_line(line: &str, slots: usize) -> Option<Vec<String>> {
    let words = line.split([',', ';', '\t', '|', ' ']).map(str::trim);
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    [slots, slots - 1].into_iter().find_map(|count| {
        let names = &words[words.len().checked_sub(count)?..];
        let is_accel = |w: &&&str| Column::from_name(w).is_accel();
        let mut out = vec!["time".to_owned(); slots - count];
        out.extend(names.iter().map(|w| (*w).to_owned()));
        (names.iter().filter(is_accel).count() >= 3).then_some(out)
    })
}

/// `, Acc (mg) [` → `Acc (mg)`: words, and units in brackets.
fn label(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let close = match c {
            '(' => rest.find(')'),
            '[' => rest.find(']'),
            _ => None,
        };
        if let Some(end) = close.filter(|end| rest[..*end].contains(char::is_alphabetic)) {
            out.push_str(&format!(" ({})", &rest[1..end]));
            rest = &rest[end + 1..];
            continue;
        }
        let is_kept = c.is_alphanumeric() || "_/.°²".contains(c);
        out.push(if is_kept { c } else { ' ' });
        rest = &rest[c.len_utf8()..];
    }
    let words = out.split_whitespace();
    let words = words.filter(|w| w.chars().any(char::is_alphanumeric));
    words.collect::<Vec<_>>().join(" ")
}

/// Names the slots of a template.
///
/// `Acceleration X: #, Y: #` and `a/g: # # # # # #` name more slots than one: the words stay in
/// force until their three axes are used up. A unit behind a slot holds for the slots before it
/// that share its words.
fn slot_names(template: &str, rising: &[bool]) -> Vec<String> {
    let pieces = template.split(SLOT).enumerate();
    let pieces: Vec<(&str, &str)> = pieces
        .map(|(i, piece)| leading_unit(piece, i > 0))
        .collect();
    let mut names = Vec::new();
    let mut groups = Vec::new();
    // Words in force, and how many axes of theirs are used up.
    let (mut heads, mut used, mut group) = (Vec::new(), 0, 0);
    // Groups of slots of which the words name an axis.
    let mut named_axes = Vec::new();
    for (slot, is_rising) in rising.iter().enumerate() {
        let text = pieces[slot].1;
        let mut words = label(last_clause(text));
        let lone_axis = axis(&words.to_lowercase());
        if let Some((head, clock)) = split_clock(text) {
            (heads, used, words) = (vec![head], 0, clock);
            group += 1;
        } else if !words.is_empty() && lone_axis.is_none() {
            (heads, used) = heads_of(&words);
            group += 1;
        }
        groups.push(group);
        let last = words.split_whitespace().last().unwrap_or_default();
        if axis(&last.to_lowercase()).is_some() {
            named_axes.push(group);
        }
        used = lone_axis.unwrap_or(used);
        names.push(match heads.get(used / 3) {
            Some(_) if *is_rising || Column::from_name(&words).role == Role::Time => {
                "time".to_owned()
            }
            Some(head) => {
                used += 1;
                format!("{head} {}", ["x", "y", "z"][(used - 1) % 3])
            }
            None if *is_rising && words.len() < 2 => "time".to_owned(),
            None => words,
        });
    }
    // One number behind a word is not a sensor: `gyro 3, accel 0` are states.
    for (name, group) in names.iter_mut().zip(&groups) {
        let is_alone = groups.iter().filter(|other| *other == group).count() < 3;
        if is_alone && !named_axes.contains(group) {
            let word = name.strip_suffix([' ', 'x', 'y', 'z'].as_slice());
            let word = word.and_then(|word| word.strip_suffix(' '));
            *name = word.unwrap_or(name).to_owned();
        }
    }
    let mut unit = "";
    for (slot, name) in names.iter_mut().enumerate().rev() {
        let own = pieces[slot + 1].0;
        if !own.is_empty() || groups.get(slot + 1) != Some(&groups[slot]) {
            unit = own;
        }
        if !unit.is_empty() && !name.is_empty() && !name.contains('(') {
            name.push_str(&format!(" ({unit})"));
        }
    }
    names
}

/// The words that name sensors, and the axis with which they begin.
fn heads_of(label: &str) -> (Vec<String>, usize) {
    let names = |part: &&str| words(part).iter().any(|w| sensor(w).is_some());
    let last = label.split_whitespace().last().unwrap_or_default();
    // `a/g`: one after the other; `acc/mg`, `Acc (m/s^2)`: one with its unit.
    let parts: Vec<&str> = label.split('/').collect();
    let heads = match Column::from_name(label).role {
        Role::Accel(i) | Role::Gyro(i) if axis(&last.to_lowercase()).is_some() => {
            return (vec![label[..label.len() - last.len()].trim().to_owned()], i);
        }
        Role::Accel(_) | Role::Gyro(_) | Role::Time | Role::Step => Vec::new(),
        _ if !label.contains('(') && parts.iter().all(names) => parts,
        _ if names(&label) => vec![label],
        _ => Vec::new(),
    };
    (heads.into_iter().map(str::to_owned).collect(), 0)
}

/// `rest: ax=` → `ax=`, if the words behind the colon name an axis by themselves.
fn last_clause(text: &str) -> &str {
    let clause = text.trim_end_matches([':', '=', ' ', '"', '\'']);
    let clause = clause.rsplit(':').next().unwrap_or_default();
    let column = Column::from_name(&label(clause));
    if column.is_accel() || column.is_gyro() {
        clause
    } else {
        text
    }
}

/// `G:  t:` → `G`, `t`: the words behind the colon name a clock, those before it what follows.
fn split_clock(text: &str) -> Option<(String, String)> {
    let (head, clock) = text.trim_end_matches([':', '=', ' ']).rsplit_once(':')?;
    let (head, clock) = (label(head), label(clock));
    let is_clock = Column::from_name(&clock).role == Role::Time;
    (is_clock && !head.is_empty()).then_some((head, clock))
}

/// The unit with which the text behind a number begins, and what follows it.
fn leading_unit(piece: &str, is_behind_number: bool) -> (&str, &str) {
    let text = piece.trim_start_matches([')', ']', ' ']);
    let end = text.find([',', ';', '|', ' ', ')', ']', '}']);
    let end = end.unwrap_or(text.len());
    if is_behind_number && is_unit(&text[..end]) {
        (&text[..end], &text[end..])
    } else {
        ("", piece)
    }
}

/// The line with [`SLOT`] for each number, and the numbers. Blanks beside a number do not count.
fn template(line: &str) -> (String, Vec<&str>) {
    // In JSON the last of a list has no comma behind it.
    let line = without_checksum(line).trim_end_matches([',', ' ']);
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
fn is_decorated(template: &str) -> bool {
    const DELIMITERS: [char; 3] = [',', ';', '|'];
    let mut pieces = template.split(SLOT).map(|p| p.trim_matches([' ', '"']));
    let is_prefixed = pieces.next().is_some_and(|p| !p.is_empty());
    // What follows the last slot does not count.
    let inner = template.matches(SLOT).count().saturating_sub(1);
    let mut inner = pieces.take(inner);
    is_prefixed
        || inner.any(|p| {
            let is_field = p.starts_with(DELIMITERS) && p.ends_with(DELIMITERS);
            !p.trim_matches(DELIMITERS).is_empty() && !is_field
        })
}

/// Whether lines of a stamp alone and lines of values take turns.
fn has_stamp_lines(shapes: &[String]) -> bool {
    shapes.len() == 2 && shapes[0] == SLOT_TEXT && shapes[1].matches(SLOT).count() > 1
}

/// How many of the first bytes are of a kind.
fn prefix(bytes: &[u8], is: impl Fn(&u8) -> bool) -> usize {
    let bytes = bytes.iter().take(MAX_WORD);
    bytes.take_while(|b| is(b)).count()
}

/// Length of the number, or of the time of day with its date, that a text starts with.
fn number_length(text: &str) -> Option<usize> {
    if let Some(rest) = text.strip_prefix('\u{2212}') {
        let is_number = rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        let length = is_number.then(|| number_length(rest)).flatten()?;
        return Some(text.len() - rest.len() + length);
    }
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
