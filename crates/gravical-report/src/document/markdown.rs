//! A document as Markdown: CommonMark with the tables of GitHub and pandoc.

use super::inline::parts;
use super::{Block, Cell, Detail, Document, Remark, Section, Table, Verdict};
use gravical::escape::one_line;

impl Document<'_> {
    /// The whole document. A figure NAME is a link to `folder`/NAME.svg; without a folder
    /// figures are left out.
    #[must_use]
    pub fn to_markdown(&self, folder: Option<&str>) -> String {
        let mut out = format!("# {}\n", escaped(&self.title));
        for line in self.lead() {
            out.push_str(&format!("\n{}\n", escaped(line)));
        }
        if let Some(verdict) = &self.verdict {
            out.push_str(&verdict_markdown(verdict));
        }
        for section in &self.sections {
            out.push_str(&section_markdown(section, folder));
        }
        out
    }
}

fn verdict_markdown(v: &Verdict) -> String {
    let word = escaped(&v.word);
    let conclusion = v
        .conclusion
        .as_deref()
        .map(|text| format!(": {}", escaped(text)));
    let conclusion = conclusion.unwrap_or_default();
    let reasons = list(&v.reasons);
    let mut out = format!("\n## Verdict\n\n**{word}**{conclusion}\n\n{reasons}");
    if !v.next.is_empty() {
        out.push_str(&format!("\nNext:\n\n{}", list(&v.next)));
    }
    out
}

fn section_markdown(section: &Section<'_>, folder: Option<&str>) -> String {
    let blocks: String = section
        .shown(Detail::Full)
        .map(|block| block_markdown(block, section.title, folder))
        .filter(|text| !text.is_empty())
        .map(|text| format!("\n{text}"))
        .collect();
    match blocks.as_str() {
        "" => blocks,
        _ => format!("\n## {}\n{blocks}", section.title),
    }
}

fn block_markdown(block: &Block<'_>, title: &str, folder: Option<&str>) -> String {
    match block {
        Block::Paragraph(text) | Block::Note(text) => format!("{}\n", escaped(text)),
        Block::Equation(lines) => fenced("", &format!("{}\n", lines.join("\n"))),
        Block::Facts(facts) => {
            let line = |(name, text): &(String, String)| {
                format!("- {}: {}\n", escaped(name), escaped(text))
            };
            facts.iter().map(line).collect()
        }
        Block::Table(table) => table_markdown(table, title),
        Block::Figure(figure) => folder.map_or_else(String::new, |folder| {
            let caption = escaped(&figure.caption);
            let link: String = format!("{folder}/{}.svg", figure.name);
            format!(
                "![{}](<{}>)\n\n{caption}\n",
                escaped(&figure.title),
                target(&link)
            )
        }),
        Block::Snippets(snippets) => snippets
            .iter()
            .map(|s| format!("{}:\n\n{}", s.language, fenced(s.fence, &s.code)))
            .collect::<Vec<_>>()
            .join("\n"),
        Block::Findings(remarks) => remarks.iter().map(remark).collect(),
    }
}

fn remark(r: &Remark) -> String {
    let word = if r.warning { "warning" } else { "note" };
    let text = escaped(&r.describe());
    format!("- **{}** ({word}): {text}\n", escaped(&r.kind))
}

fn list(points: &[String]) -> String {
    points
        .iter()
        .map(|p| format!("- {}\n", escaped(p)))
        .collect()
}

/// A code block with a fence longer than any inside.
fn fenced(language: &str, code: &str) -> String {
    let fence = "`".repeat(3.max(1 + longest(code, '`')));
    format!("{fence}{language}\n{code}{fence}\n")
}

fn longest(text: &str, of: char) -> usize {
    let runs = text.split(|c| c != of);
    runs.map(|run| run.chars().count()).max().unwrap_or(0)
}

fn table_markdown(table: &Table, title: &str) -> String {
    let mut out = match &table.caption {
        caption if caption.is_empty() || caption == title => String::new(),
        caption => format!("{}:\n\n", escaped(caption)),
    };
    let name = |c: &super::Column| match c.group.as_str() {
        "" => escaped(&c.name),
        group => escaped(&format!("{group}: {}", c.name)),
    };
    out.push_str(&line(table.columns.iter().map(name)));
    let rule = |i: usize| if table.is_numeric(i) { "--:" } else { ":--" }.to_owned();
    out.push_str(&line((0..table.columns.len()).map(rule)));
    for row in &table.rows {
        out.push_str(&line(row.cells.iter().map(cell)));
        if !row.note.is_empty() {
            // Markdown tables have no cells that span columns.
            let note = std::iter::repeat_n(String::new(), table.columns.len().saturating_sub(1));
            out.push_str(&line(std::iter::once(escaped(&row.note)).chain(note)));
        }
    }
    let left_out = table.all.saturating_sub(table.rows.len());
    if left_out > 0 {
        out.push_str(&format!("\n… and {left_out} more; `--json` has all.\n"));
    }
    out
}

fn line(cells: impl Iterator<Item = String>) -> String {
    format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => escaped(text),
        Cell::Number(..) => number_text(&cell.plain()),
    }
}

fn number_text(text: &str) -> String {
    escaped(&text.replace('-', "−"))
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
    let parts = parts(text.trim()).enumerate();
    parts
        .map(|(i, (part, is_code))| {
            // A bar ends the cell of a table even within code.
            if is_code && !part.contains('|') {
                format!("`{part}`")
            } else {
                escaped_words(part, i == 0)
            }
        })
        .collect()
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
        if marks {
            out.push('\\');
        }
        out.push(c);
    }
    out
}
