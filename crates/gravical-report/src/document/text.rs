//! A document for a terminal of 80 columns.

use std::borrow::Cow;

use super::{Block, Cell, Column, Detail, Document, Remark, Row, Section, Snippet, Table, Verdict};
use gravical::escape::one_line;
use gravical::numfmt::count;

/// Width of a line.
const WIDTH: usize = 80;

/// Rows of a table in a summary.
const LISTED: usize = 24;

/// Findings in a summary, unless one more would be all.
const FINDINGS: usize = 3;

/// Smallest width of a column of sentences.
const NARROWEST: usize = 20;

/// Its width in a table that is split; two of them fit side by side.
const PART: usize = 36;

impl Document<'_> {
    /// The document in lines of 80 columns: subject, conclusion, sections, and the verdict with
    /// its reasons at the end, where a terminal stops. In a table that is too wide, uncertainties
    /// are placed below their values; then it is split. Figures are left out.
    #[must_use]
    pub fn to_text(&self, detail: Detail) -> String {
        let mut out: String = self.subject.iter().map(|l| paragraph("", l)).collect();
        if let Some(verdict) = &self.verdict {
            out.push_str(&conclusion(verdict));
        }
        for section in &self.sections {
            out.push_str(&section_text(section, detail));
        }
        if let Some(verdict) = &self.verdict {
            out.push_str(&verdict_text(verdict, detail));
        }
        out
    }
}

/// The verdict in one sentence.
fn conclusion(verdict: &Verdict) -> String {
    let reason = verdict.reasons.first().map_or("", |r| r);
    let text = verdict.conclusion.as_deref().unwrap_or(reason);
    paragraph("", &format!("{}: {text}", verdict.word))
}

fn section_text(section: &Section<'_>, detail: Detail) -> String {
    let shown = || {
        section
            .shown(detail)
            .filter(|b| !matches!(b, Block::Figure(_)))
    };
    if shown().next().is_none() {
        return String::new();
    }
    let mut out = String::new();
    if !section.opening {
        out.push_str(&format!("\n{}\n", section.title));
    }
    let mut before: Option<&Block<'_>> = None;
    for block in shown() {
        let apart = match (before, block) {
            (None, Block::Table(_)) => section.opening,
            (None, _) | (_, Block::Note(_)) => false,
            (Some(Block::Table(_) | Block::Facts(_)), _) => true,
            (_, Block::Table(_)) => true,
            _ => false,
        };
        if apart {
            out.push('\n');
        }
        out.push_str(&block_text(block, detail));
        before = Some(block);
    }
    out
}

fn block_text(block: &Block<'_>, detail: Detail) -> String {
    match block {
        Block::Paragraph(text) | Block::Note(text) => paragraph("  ", text),
        Block::Equation(lines) => lines.iter().map(|l| paragraph("  ", l)).collect(),
        Block::List(points) => points.iter().map(|p| paragraph("  - ", p)).collect(),
        Block::Facts(facts) => facts_text(facts),
        Block::Table(table) => table_text(table, detail),
        Block::Figure(_) => String::new(),
        Block::Snippets(snippets) => {
            let indented = |code: &str| code.replace('\n', "\n    ");
            let one =
                |s: &Snippet| format!("  {}\n    {}\n", s.language, indented(s.code.trim_end()));
            snippets.iter().map(one).collect()
        }
        Block::Findings(remarks) => findings_text(remarks, detail),
    }
}

/// All findings, or the weightiest and the number of the others.
fn findings_text(remarks: &[Remark], detail: Detail) -> String {
    let shown = match detail {
        Detail::Summary if remarks.len() > FINDINGS + 1 => FINDINGS,
        _ => remarks.len(),
    };
    let (shown, more) = remarks.split_at(shown);
    let mut out: String = shown.iter().map(Remark::to_text).collect();
    if !more.is_empty() {
        let warnings = more.iter().filter(|r| r.warning).count();
        let parts = [(warnings, "warning"), (more.len() - warnings, "note")];
        let parts = parts.iter().filter(|(n, _)| *n > 0);
        let parts: Vec<String> = parts.map(|(n, word)| count(n, word)).collect();
        out.push_str(&format!("  … and {} (--verbose)\n", parts.join(", ")));
    }
    out
}

impl Remark {
    /// The finding with its place, in a paragraph.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mark = if self.warning { "  ! " } else { "  · " };
        paragraph(mark, &format!("{}: {}", self.kind, self.said()))
    }
}

fn facts_text(facts: &[(String, String)]) -> String {
    let width = facts.iter().map(|(name, _)| length(name)).max();
    let width = width.unwrap_or(0);
    let line = |(name, text): &(String, String)| paragraph(&format!("  {name:<width$}  "), text);
    facts.iter().map(line).collect()
}

fn verdict_text(verdict: &Verdict, detail: Detail) -> String {
    let mut out = paragraph("\nVerdict: ", &verdict.word);
    let mut points = verdict.reasons.clone();
    if detail == Detail::Full {
        let figures = verdict.figures.iter();
        points.extend(figures.map(|f| format!("{} {}: {}", f.value, f.unit, f.what)));
        points.extend(verdict.next.iter().cloned());
    }
    for point in &points {
        out.push_str(&paragraph("  - ", point));
    }
    out
}

/// A paragraph of 80 columns, indented by `first`. Words, options, paths and commands are not broken.
#[must_use]
pub fn paragraph(first: &str, text: &str) -> String {
    let rest = " ".repeat(length(first.trim_start_matches('\n')));
    let options = options(WIDTH)
        .initial_indent(first)
        .subsequent_indent(&rest)
        .break_words(false);
    // Code stays on one line, to be copied.
    let parts = one_line(text);
    let parts = parts.split('`').enumerate().map(|(i, part)| match i % 2 {
        0 => part.to_owned(),
        _ => part.replace(' ', UNBROKEN),
    });
    let text = parts.collect::<Vec<String>>().join("`");
    let mut out = textwrap::fill(&text, options).replace(UNBROKEN, " ");
    out.push('\n');
    out
}

/// Stands for a space at which no line ends; in private use, so that no text has it.
const UNBROKEN: &str = "\u{f8ff}";

fn options<'a>(width: usize) -> textwrap::Options<'a> {
    textwrap::Options::new(width).word_splitter(textwrap::WordSplitter::NoHyphenation)
}

fn length(text: &str) -> usize {
    text.chars().count()
}

/// How the columns of a table are narrowed.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// Uncertainties are below their values.
    below: bool,
    /// Spaces between columns.
    gap: usize,
    /// Smallest width to which headings are wrapped.
    head: usize,
    /// Largest width of sentences.
    room: Option<usize>,
}

/// Layouts of a table; the first that fits is used.
const LAYOUTS: [Layout; 5] = [
    layout(false, 2, 16),
    layout(false, 2, 8),
    layout(false, 1, 5),
    layout(true, 2, 8),
    layout(true, 2, 5),
];

const fn layout(below: bool, gap: usize, head: usize) -> Layout {
    Layout {
        below,
        gap,
        head,
        room: None,
    }
}

/// A column in print: its heading, and the lines of each cell.
struct Printed {
    group: String,
    head: Vec<String>,
    /// By row, then by line.
    cells: Vec<Vec<String>>,
    right: bool,
    width: usize,
    /// Spaces before it.
    gap: usize,
}

fn table_text(table: &Table, detail: Detail) -> String {
    let cut = match detail {
        Detail::Summary if table.all > LISTED => LISTED - 1,
        _ => table.rows.len(),
    };
    let listed = |(i, row): &(usize, &Row)| *i < cut || row.stays;
    let rows: Vec<&Row> = table
        .rows
        .iter()
        .enumerate()
        .filter(listed)
        .map(|(_, row)| row)
        .collect();
    let print = |layout: Layout| -> Vec<Printed> {
        let columns = table.columns.iter().enumerate();
        columns
            .filter(|(_, c)| c.detail <= detail)
            .map(|(i, c)| {
                let cells = rows.iter().filter_map(|r| r.cells.get(i));
                Printed::new(c, table.is_numeric(i), cells, layout)
            })
            .collect()
    };
    let mut layouts = LAYOUTS.into_iter().map(print);
    let mut columns = layouts.by_ref().next().unwrap_or_default();
    while total(&columns) > WIDTH
        && let Some(narrower) = layouts.next()
    {
        columns = narrower;
    }
    // Sentences share what the numbers leave; if that is too little, the table is split.
    let over = total(&columns).saturating_sub(WIDTH);
    if over > 0 {
        let prose = columns.iter().filter(|c| !c.right).map(|c| c.width).max();
        let room = prose.and_then(|width| width.checked_sub(over));
        let room = room.filter(|room| *room >= NARROWEST).unwrap_or(PART);
        let [.., last] = LAYOUTS;
        columns = print(Layout {
            room: Some(room),
            ..last
        });
    }
    let mut out = String::new();
    if !table.caption.is_empty() {
        out.push_str(&paragraph("  ", &table.caption));
    }
    // The first column names the row: it is repeated in each part.
    let mut columns = columns.into_iter();
    let Some(first) = columns.next() else {
        return out;
    };
    let mut part = vec![first];
    for column in columns {
        if part.len() > 1 && total(&part) + column.gap + column.width > WIDTH {
            out.push_str(&part_text(&part, &rows));
            out.push('\n');
            part.truncate(1);
        }
        part.push(column);
    }
    out.push_str(&part_text(&part, &rows));
    let left_out = table.all.saturating_sub(rows.len());
    if left_out > 0 {
        out.push_str(&format!("  … and {left_out} more; --json has all\n"));
    }
    out
}

/// Width of the columns side by side, behind an indent.
fn total(columns: &[Printed]) -> usize {
    2 + columns.iter().map(|c| c.gap + c.width).sum::<usize>()
        - columns.first().map_or(0, |c| c.gap)
}

impl Printed {
    fn new<'c>(
        column: &Column,
        right: bool,
        cells: impl Iterator<Item = &'c Cell>,
        layout: Layout,
    ) -> Self {
        let cells: Vec<Vec<String>> = cells
            .map(|cell| match (cell, layout.room) {
                (Cell::Text(text), Some(room)) if !right => lines(&one_line(text), room),
                (Cell::Number(q, Some(sd)), _) if layout.below => {
                    vec![q.clone(), format!("± {sd}")]
                }
                _ => vec![one_line(&cell.plain()).into_owned()],
            })
            .collect();
        let longest = |texts: &mut dyn Iterator<Item = &str>| texts.map(length).max().unwrap_or(0);
        let widest = longest(&mut cells.iter().flatten().map(String::as_str));
        let room = widest
            .max(longest(&mut column.name.split(' ')))
            .max(layout.head);
        let head = match column.name.rsplit_once(", ") {
            // A unit gets its own line if that is enough.
            Some((name, unit)) if length(&column.name) > room && length(name) < room => {
                vec![format!("{name},"), unit.to_owned()]
            }
            _ => lines(&column.name, room),
        };
        let width = widest.max(longest(&mut head.iter().map(String::as_str)));
        Printed {
            group: column.group.clone(),
            head,
            cells,
            right,
            width,
            gap: layout.gap,
        }
    }

    fn padded(&self, text: &str) -> String {
        let (gap, width) = (self.gap, self.width);
        if self.right {
            format!("{:gap$}{text:>width$}", "")
        } else {
            format!("{:gap$}{text:<width$}", "")
        }
    }
}

/// The text in lines of at most this width.
fn lines(text: &str, width: usize) -> Vec<String> {
    let options = options(width).break_words(true);
    let lines = textwrap::wrap(text, options);
    lines.into_iter().map(Cow::into_owned).collect()
}

fn part_text(columns: &[Printed], rows: &[&Row]) -> String {
    let mut out = groups_text(columns);
    let line = |out: &mut String, texts: &mut dyn Iterator<Item = String>| {
        let text: String = texts.collect();
        // The indent replaces the gap of the first column.
        let first = columns.first().map_or(0, |c| c.gap);
        out.push_str(format!("  {}", text.get(first..).unwrap_or("")).trim_end());
        out.push('\n');
    };
    let high = columns.iter().map(|c| c.head.len()).max().unwrap_or(0);
    for i in 0..high {
        // Headings are aligned at the bottom.
        let text = |c: &Printed| {
            let at = (i + c.head.len()).checked_sub(high);
            c.padded(at.and_then(|at| c.head.get(at)).map_or("", |t| t))
        };
        line(&mut out, &mut columns.iter().map(text));
    }
    for (i, row) in rows.iter().enumerate() {
        let cell = |c: &Printed| c.cells.get(i).map_or(0, Vec::len);
        let high = columns.iter().map(cell).max().unwrap_or(0);
        for k in 0..high {
            let text = |c: &Printed| {
                let cell = c.cells.get(i).and_then(|lines| lines.get(k));
                c.padded(cell.map_or("", |t| t))
            };
            line(&mut out, &mut columns.iter().map(text));
        }
        if !row.note.is_empty() {
            out.push_str(&paragraph("      ", &row.note));
        }
    }
    out
}

/// The line above the headings: groups, centred on their columns.
fn groups_text(columns: &[Printed]) -> String {
    let mut line = String::new();
    for group in columns.chunk_by(|a, b| a.group == b.group) {
        let name = group.first().map_or("", |c| &c.group);
        let gap = group.first().map_or(0, |c| c.gap);
        let width = total(group) - 2;
        let name: String = name.chars().take(width).collect();
        let gap = if line.is_empty() { 2 } else { gap };
        line.push_str(&format!("{:gap$}{name:^width$}", ""));
    }
    match line.trim_end() {
        "" => String::new(),
        line => format!("{line}\n"),
    }
}

impl Cell {
    /// The text of the cell in one line.
    pub(super) fn plain(&self) -> String {
        match self {
            Cell::Text(text) | Cell::Code(text) => text.clone(),
            Cell::Number(q, None) => q.clone(),
            Cell::Number(q, Some(sd)) => format!("{q} ± {sd}"),
        }
    }
}
