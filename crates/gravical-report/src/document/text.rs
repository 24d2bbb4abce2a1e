//! A document for a terminal of 80 columns.

use std::borrow::Cow;

use super::{Block, Cell, Column, Detail, Document, Remark, Row, Section, Snippet, Table, Verdict};
use gravical::escape::one_line;

/// Width of a line.
const WIDTH: usize = 80;

/// Rows of a table in a summary.
const MAX_SUMMARY_ROWS: usize = 24;

/// Findings in a summary, unless one more would be all.
const FINDINGS: usize = 3;

/// Smallest width of a column of sentences.
const MIN_PROSE_WIDTH: usize = 20;

impl Document<'_> {
    /// The document in lines of 80 columns: subject, conclusion, sections, and the verdict with
    /// reasons and next steps at the end, where a terminal stops. In a table that is too wide, uncertainties
    /// are placed below their values. Figures are left out.
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
            out.push_str(&verdict_text(verdict));
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
    let shown = section.shown(detail);
    let mut before: Option<&Block<'_>> = None;
    let mut out = String::new();
    for block in shown.filter(|b| !matches!(b, Block::Figure(_))) {
        let apart = match (before, block) {
            (None, _) | (_, Block::Note(_)) => false,
            (Some(Block::Table(_) | Block::Facts(_)), _) | (_, Block::Table(_)) => true,
            _ => false,
        };
        if apart {
            out.push('\n');
        }
        out.push_str(&block_text(block, detail));
        before = Some(block);
    }
    if out.is_empty() {
        return out;
    }
    format!("\n{}\n{out}", section.title)
}

fn block_text(block: &Block<'_>, detail: Detail) -> String {
    match block {
        Block::Paragraph(text) | Block::Note(text) => paragraph("  ", text),
        Block::Equation(lines) => lines.iter().map(|l| paragraph("  ", l)).collect(),
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
    let mut out: String = remarks[..shown].iter().map(Remark::to_text).collect();
    if shown < remarks.len() {
        out.push_str(&format!(
            "  … and {} more (--verbose)\n",
            remarks.len() - shown
        ));
    }
    out
}

impl Remark {
    /// The finding with its place, in a paragraph.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mark = if self.warning { "  ! " } else { "  · " };
        paragraph(mark, &format!("{}: {}", self.kind, self.describe()))
    }
}

fn facts_text(facts: &[(String, String)]) -> String {
    let width = facts.iter().map(|(name, _)| length(name)).max();
    let width = width.unwrap_or(0);
    let line = |(name, text): &(String, String)| paragraph(&format!("  {name:<width$}  "), text);
    facts.iter().map(line).collect()
}

fn verdict_text(verdict: &Verdict) -> String {
    let mut out = paragraph("\nVerdict: ", &verdict.word);
    for reason in &verdict.reasons {
        out.push_str(&paragraph("  - ", reason));
    }
    for (i, step) in verdict.next.iter().enumerate() {
        let start = if i == 0 { "\nNext: " } else { "      " };
        out.push_str(&paragraph(start, step));
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
#[derive(Clone, Copy)]
struct Layout {
    /// Uncertainties are below their values.
    below: bool,
    /// Spaces between columns.
    gap: usize,
    /// Smallest width to which headings are wrapped.
    head: usize,
}

const fn layout(below: bool, gap: usize, head: usize) -> Layout {
    Layout { below, gap, head }
}

/// Layouts of a table, from wide to narrow; the first that fits is used.
const LAYOUTS: [Layout; 6] = [
    layout(false, 2, 16),
    layout(false, 2, 8),
    layout(false, 1, 5),
    layout(true, 2, 8),
    layout(true, 2, 5),
    layout(true, 1, 5),
];

/// A column in print.
struct Printed {
    group: String,
    /// Lines of the heading, then those of each cell.
    cells: Vec<Vec<String>>,
    right: bool,
    width: usize,
}

fn table_text(table: &Table, detail: Detail) -> String {
    let rows = match detail {
        Detail::Summary if table.all > MAX_SUMMARY_ROWS => &table.rows[..MAX_SUMMARY_ROWS - 1],
        _ => &table.rows[..],
    };
    let print = |layout: &Layout, room: usize| -> Vec<Printed> {
        let columns = table.columns.iter().enumerate();
        let print = |(i, column)| {
            let cells = rows.iter().map(|r| &r.cells[i]);
            Printed::new(column, table.is_numeric(i), cells, layout, room)
        };
        columns.map(print).collect()
    };
    let fits = |layout: &&Layout| total(&print(layout, usize::MAX), layout.gap) <= WIDTH;
    let layout = LAYOUTS.iter().find(fits).unwrap_or(&LAYOUTS[5]);
    let mut columns = print(layout, usize::MAX);
    // Sentences share what the numbers leave.
    let over = total(&columns, layout.gap).saturating_sub(WIDTH);
    if over > 0 {
        let prose = columns.iter().filter(|c| !c.right).map(|c| c.width).max();
        let room = prose.map_or(0, |width| width.saturating_sub(over));
        columns = print(layout, room.max(MIN_PROSE_WIDTH));
    }
    let mut out = String::new();
    if !table.caption.is_empty() {
        out.push_str(&paragraph("  ", &table.caption));
    }
    out.push_str(&grid_text(&columns, rows, layout.gap));
    let left_out = table.all.saturating_sub(rows.len());
    if left_out > 0 {
        out.push_str(&format!("  … and {left_out} more; --json has all\n"));
    }
    out
}

/// Width of the columns side by side, behind an indent.
fn total(columns: &[Printed], gap: usize) -> usize {
    let widths: usize = columns.iter().map(|c| c.width).sum();
    2 + widths + gap * columns.len().saturating_sub(1)
}

impl Printed {
    fn new<'c>(
        column: &Column,
        right: bool,
        cells: impl Iterator<Item = &'c Cell>,
        layout: &Layout,
        room: usize,
    ) -> Self {
        let cells = cells.map(|cell| match cell {
            Cell::Text(text) if !right => lines(&one_line(text), room),
            Cell::Number(q, Some(sd)) if layout.below => vec![q.clone(), format!("± {sd}")],
            _ => vec![one_line(&cell.plain()).into_owned()],
        });
        let mut cells: Vec<Vec<String>> = cells.collect();
        let widest = |cells: &[Vec<String>]| cells.iter().flatten().map(|t| length(t)).max();
        let words = column.name.split(' ').map(length).max();
        let room = widest(&cells).max(words).unwrap_or(0).max(layout.head);
        let head = match column.name.rsplit_once(", ") {
            // A unit gets its own line if that is enough.
            Some((name, unit)) if length(&column.name) > room && length(name) < room => {
                vec![format!("{name},"), unit.to_owned()]
            }
            _ => lines(&column.name, room),
        };
        cells.insert(0, head);
        Printed {
            group: column.group.clone(),
            width: widest(&cells).unwrap_or(0),
            cells,
            right,
        }
    }

    fn padded(&self, text: &str) -> String {
        let width = self.width;
        if self.right {
            format!("{text:>width$}")
        } else {
            format!("{text:<width$}")
        }
    }
}

/// The text in lines of at most this width.
fn lines(text: &str, width: usize) -> Vec<String> {
    let options = options(width).break_words(true);
    let lines = textwrap::wrap(text, options);
    lines.into_iter().map(Cow::into_owned).collect()
}

fn grid_text(columns: &[Printed], rows: &[Row], gap: usize) -> String {
    let mut out = groups_text(columns, gap);
    for i in 0..=rows.len() {
        let high = columns.iter().map(|c| c.cells[i].len()).max().unwrap_or(0);
        for k in 0..high {
            let line = |c: &Printed| {
                let lines = &c.cells[i];
                // Headings are aligned at the bottom.
                let above = if i == 0 { high - lines.len() } else { 0 };
                let line = k.checked_sub(above).and_then(|k| lines.get(k));
                c.padded(line.map_or("", |t| t))
            };
            let cells: Vec<String> = columns.iter().map(line).collect();
            let line = cells.join(&" ".repeat(gap));
            out.push_str(format!("  {line}").trim_end());
            out.push('\n');
        }
        if let Some(row) = i.checked_sub(1).map(|i| &rows[i])
            && !row.note.is_empty()
        {
            out.push_str(&paragraph("      ", &row.note));
        }
    }
    out
}

/// The line above the headings: groups, centred on their columns.
fn groups_text(columns: &[Printed], gap: usize) -> String {
    let groups = columns.chunk_by(|a, b| a.group == b.group).map(|group| {
        let width = total(group, gap) - 2;
        let name: String = group[0].group.chars().take(width).collect();
        format!("{name:^width$}")
    });
    let line = groups.collect::<Vec<_>>().join(&" ".repeat(gap));
    match line.trim_end() {
        "" => String::new(),
        line => format!("  {line}\n"),
    }
}

impl Cell {
    /// The text of the cell in one line.
    pub(super) fn plain(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number(q, None) => q.clone(),
            Cell::Number(q, Some(sd)) => format!("{q} ± {sd}"),
        }
    }
}
