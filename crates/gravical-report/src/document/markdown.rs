//! A document as Markdown: CommonMark with the tables of GitHub and pandoc.

use super::{Block, Cell, Detail, Document, Remark, Section, Table, left_out, parts};
use gravical::escape::one_line;

impl Document<'_> {
    /// The whole document. A figure NAME is a link to `folder`/NAME.svg; without a folder
    /// figures are left out.
    pub fn to_markdown(&self, folder: Option<&str>) -> String {
        let mut out = format!("# {}\n", escaped(&self.title));
        let subject = self.subject.iter();
        out.extend(subject.map(|line| format!("\n{}\n", escaped(line))));
        if let Some(v) = &self.verdict {
            let conclusion = v.conclusion.iter().map(|c| format!(": {}", escaped(c)));
            let conclusion: String = conclusion.collect();
            let (word, reasons, next) = (escaped(&v.word), list(&v.reasons), list(&v.next));
            out += &format!("\n## Verdict\n\n**{word}**{conclusion}\n\n{reasons}");
            if !next.is_empty() {
                out += &format!("\nNext:\n\n{next}");
            }
        }
        out.extend(self.sections.iter().map(|s| section(s, folder)));
        out
    }
}

fn section(section: &Section<'_>, folder: Option<&str>) -> String {
    let blocks = section.shown(Detail::Full).map(|b| block(b, folder));
    let blocks = blocks.filter(|text| !text.is_empty());
    let blocks: String = blocks.map(|text| format!("\n{text}")).collect();
    if blocks.is_empty() {
        return blocks;
    }
    format!("\n## {}\n{blocks}", section.title)
}

fn block(block: &Block<'_>, folder: Option<&str>) -> String {
    match block {
        Block::Paragraph(text) | Block::Note(text) => format!("{}\n", escaped(text)),
        Block::Equation(lines) => fenced("", &format!("{lines}\n")),
        Block::Facts(facts) => {
            let line = |(name, text): &(String, String)| {
                format!("- {}: {}\n", escaped(name), escaped(text))
            };
            facts.iter().map(line).collect()
        }
        Block::Table(t) => table(t),
        Block::Figure(figure) => folder.map_or_else(String::new, |folder| {
            let link = target(&format!("{folder}/{}.svg", figure.name));
            let [title, caption] = [&figure.title, &figure.caption].map(|t| escaped(t));
            format!("![{title}](<{link}>)\n\n{caption}\n")
        }),
        Block::Code(language, fence, code) => format!("{language}:\n\n{}", fenced(fence, code)),
        Block::Findings(remarks) => remarks.iter().map(remark).collect(),
    }
}

fn remark(r: &Remark) -> String {
    let word = if r.warning { "warning" } else { "note" };
    let [kind, text] = [&r.kind, &r.text].map(|t| escaped(t));
    format!("- **{kind}** ({word}): {text}\n")
}

fn list(all: &[String]) -> String {
    let points = all.iter().map(|text| format!("- {}\n", escaped(text)));
    points.collect()
}

/// A code block with a fence longer than any inside.
fn fenced(language: &str, code: &str) -> String {
    let longest = code.split(|c| c != '`').map(str::len).max();
    let fence = "`".repeat(longest.map_or(3, |n| 3.max(n + 1)));
    format!("{fence}{language}\n{code}{fence}\n")
}

fn table(table: &Table) -> String {
    let mut out = match table.caption.as_str() {
        "" => String::new(),
        caption => format!("{}:\n\n", escaped(caption)),
    };
    let names = table.columns.iter().map(|c| match c.group.as_str() {
        "" => escaped(&c.name),
        group => format!("{}: {}", escaped(group), escaped(&c.name)),
    });
    out += &line(names);
    let rules = (0..table.columns.len()).map(|i| table.is_numeric(i));
    out += &line(rules.map(|right| if right { "--:" } else { ":--" }.to_owned()));
    let (rows, more) = table.shown(Detail::Full);
    out.extend(rows.iter().map(|row| line(row.iter().map(cell))));
    if more > 0 {
        out += &format!("\n{}\n", escaped(&left_out(more)));
    }
    out
}

fn line(cells: impl Iterator<Item = String>) -> String {
    format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => escaped(text),
        Cell::Number(..) => escaped(&cell.plain().replace('-', "−")),
    }
}

/// The target of a link, percent-encoded where that is necessary.
fn target(link: &str) -> String {
    let encoded = |c: char| match c {
        '%' | '<' | '>' | '\\' | '#' | '?' | '\0'..='\x1f' => format!("%{:02X}", u32::from(c)),
        c => c.to_string(),
    };
    link.chars().map(encoded).collect()
}

/// The text in one line, with commands as code, and a backslash before everything
/// else that Markdown or HTML would interpret.
fn escaped(text: &str) -> String {
    let text = one_line(text);
    let words = parts(text.trim()).enumerate().map(|(i, (part, is_code))| {
        // A bar ends the cell of a table even within code.
        if is_code && !part.contains('|') {
            format!("`{part}`")
        } else {
            escaped_words(part, i == 0)
        }
    });
    words.collect()
}

/// `begins`: the words are the first of the line.
fn escaped_words(text: &str, begins: bool) -> String {
    let mut out = String::with_capacity(text.len());
    for (i, c) in text.char_indices() {
        let (before, behind) = (&text[..i], &text[i + c.len_utf8()..]);
        let ends_word = behind.is_empty() || behind.starts_with([' ', '\t']);
        let marks = match c {
            // They start a list or rule; two of them are a dash.
            '+' | '-' | '=' | ':' => {
                (begins && i == 0 && !behind.starts_with(|c: char| c.is_ascii_digit()))
                    || before.ends_with('-')
            }
            '.' | ')' => begins && i > 0 && ends_word && before.bytes().all(|b| b.is_ascii_digit()),
            _ => "\\`*_{}[]<>#|~^$&@!".contains(c),
        };
        out.extend(marks.then_some('\\'));
        out.push(c);
    }
    out
}
