//! A document for a terminal of 80 columns.

use std::borrow::Cow;

use super::{Block, Cell, Column, Detail, Document, Remark, Section, Table, Verdict, left_out};
use gravical::escape::one_line;

/// Width of a line.
const WIDTH: usize = 80;

/// Findings in a summary, unless one more would be all.
const FINDINGS: usize = 3;

/// Smallest width of a column of sentences.
const MIN_PROSE_WIDTH: usize = 20;

impl Document<'_> {
    /// The document in lines of 80 columns: subject, headline, sections, and the verdict with
    /// reasons and next steps at the end, where a terminal stops. In a table that is too wide, uncertainties
    /// are placed below their values. Figures are left out.
    pub fn to_text(&self, detail: Detail) -> String {
        let mut out: String = self.subject.iter().map(|l| paragraph("", l)).collect();
        let verdict = self.verdict.as_ref().filter(|v| !v.word.is_empty());
        if let Some(v) = verdict {
            out += &paragraph("", &format!("{}: {}", v.word, v.in_a_line()));
        }
        out.extend(self.sections.iter().map(|s| section_text(s, detail)));
        out.extend(verdict.map(verdict_text));
        out
    }
}

fn section_text(section: &Section<'_>, detail: Detail) -> String {
    let shown = section.shown(detail);
    let blocks: Vec<&Block<'_>> = shown
        .filter(|b| !matches!(b, Block::Figure(_) | Block::Board(..)))
        .collect();
    if blocks.is_empty() {
        return String::new();
    }
    let mut out = format!("\n{}\n", section.title);
    let ends = |block: &Block<'_>| matches!(block, Block::Table(_) | Block::Facts(_));
    for (i, block) in blocks.iter().enumerate() {
        let is_apart = matches!(block, Block::Table(_)) || i > 0 && ends(blocks[i - 1]);
        let joins = i == 0 || matches!(block, Block::Note(_));
        out += if is_apart && !joins { "\n" } else { "" };
        out += &block_text(block, detail);
    }
    out
}

fn block_text(block: &Block<'_>, detail: Detail) -> String {
    match block {
        Block::Paragraph(text) | Block::Note(text) => paragraph("  ", text),
        Block::Equation(lines) => lines.lines().map(|l| paragraph("  ", l)).collect(),
        Block::Facts(facts) => {
            let names = facts.iter().map(|(name, _)| length(name));
            let width = names.max().unwrap_or(0);
            let line =
                |(name, text): &(String, String)| paragraph(&format!("  {name:<width$}  "), text);
            facts.iter().map(line).collect()
        }
        Block::Table(table) => table_text(table, detail),
        Block::Figure(_) | Block::Board(..) => String::new(),
        Block::Code(language, code) => {
            let code = code.trim_end().replace('\n', "\n    ");
            format!("  {language}\n    {code}\n")
        }
        Block::Findings(remarks) => {
            let shown = match detail {
                Detail::Summary if remarks.len() > FINDINGS + 1 => FINDINGS,
                _ => remarks.len(),
            };
            let mut out: String = remarks[..shown].iter().map(Remark::to_text).collect();
            if shown < remarks.len() {
                out += &format!("  … and {} more (--verbose)\n", remarks.len() - shown);
            }
            out
        }
    }
}

impl Remark {
    /// The finding in a paragraph.
    pub fn to_text(&self) -> String {
        let mark = if self.warning { "  ! " } else { "  · " };
        paragraph(mark, &format!("{}: {}", self.kind, self.text))
    }
}

fn verdict_text(verdict: &Verdict) -> String {
    let mut out = paragraph("\nVerdict: ", &verdict.word);
    let reasons = verdict.reasons.iter();
    out.extend(reasons.map(|reason| paragraph("  - ", reason)));
    for (i, step) in verdict.next.iter().enumerate() {
        let start = if i == 0 { "\nNext: " } else { "      " };
        let text = match step.in_words() {
            (text, None) => text,
            (text, Some(command)) => format!("{text}: `{command}`"),
        };
        out += &paragraph(start, &text);
    }
    out
}

/// A paragraph of 80 columns, indented by `first`. Words, options, paths and commands are not broken.
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
    textwrap::fill(&text, options).replace(UNBROKEN, " ") + "\n"
}

/// Stands for a space at which no line ends; in private use, so that no text has it.
const UNBROKEN: &str = "\u{f8ff}";

fn options<'a>(width: usize) -> textwrap::Options<'a> {
    textwrap::Options::new(width).word_splitter(textwrap::WordSplitter::NoHyphenation)
}

fn length(text: &str) -> usize {
    text.chars().count()
}

/// Layouts of a table, from wide to narrow; the first that fits is used: whether uncertainties are
/// below their values, spaces between columns, smallest width to which headings are wrapped.
const LAYOUTS: [(bool, usize, usize); 6] = [
    (false, 2, 16),
    (false, 2, 8),
    (false, 1, 5),
    (true, 2, 8),
    (true, 2, 5),
    (true, 1, 5),
];

/// A column in print.
struct Printed<'a> {
    group: &'a str,
    /// Lines of the heading, then those of each cell.
    cells: Vec<Vec<String>>,
    right: bool,
    width: usize,
}

fn table_text(table: &Table, detail: Detail) -> String {
    let (rows, more) = table.shown(detail);
    let print = |(below, gap, head): (bool, usize, usize), room: usize| {
        let columns = table.columns.iter().enumerate().map(|(i, column)| {
            let cells = rows.iter().map(|row| &row[i]);
            Printed::new(column, table.is_numeric(i), cells, (below, head, room))
        });
        let columns: Vec<Printed<'_>> = columns.collect();
        let over = total(&columns, gap).saturating_sub(WIDTH);
        (columns, gap, over)
    };
    let mut printed = LAYOUTS.iter().map(|layout| print(*layout, usize::MAX));
    let fits = printed.find(|(.., over)| *over == 0);
    let (columns, gap, _) = fits.unwrap_or_else(|| {
        // Sentences share what the numbers leave.
        let narrow = LAYOUTS[LAYOUTS.len() - 1];
        let (columns, _, over) = print(narrow, usize::MAX);
        let prose = columns.iter().filter(|c| !c.right).map(|c| c.width).max();
        let room = prose.map_or(0, |width| width.saturating_sub(over));
        print(narrow, room.max(MIN_PROSE_WIDTH))
    });
    let caption = Some(&table.caption).filter(|c| !c.is_empty());
    let mut out = caption.map_or_else(String::new, |c| paragraph("  ", c));
    out += &grid_text(&columns, rows.len(), gap);
    if more > 0 {
        out += &format!("  {}\n", left_out(more));
    }
    out
}

/// Width of the columns side by side, behind an indent.
fn total(columns: &[Printed<'_>], gap: usize) -> usize {
    let widths: usize = columns.iter().map(|c| c.width).sum();
    2 + widths + gap * columns.len().saturating_sub(1)
}

impl<'a> Printed<'a> {
    /// Headings are wrapped to `head` at least, sentences to `room`.
    fn new<'c>(
        column: &'a Column,
        right: bool,
        cells: impl Iterator<Item = &'c Cell>,
        (below, head, room): (bool, usize, usize),
    ) -> Self {
        let cells = cells.map(|cell| match cell {
            Cell::Text(text) if !right => lines(&one_line(text), room),
            Cell::Number(q, Some(sd)) if below => vec![q.clone(), format!("± {sd}")],
            _ => vec![one_line(&cell.plain()).into_owned()],
        });
        let mut cells: Vec<Vec<String>> = cells.collect();
        let widest = |cells: &[Vec<String>]| cells.iter().flatten().map(|t| length(t)).max();
        let words = column.name.split(' ').map(length).max();
        let room = widest(&cells).max(words).unwrap_or(0).max(head);
        let head = match column.name.rsplit_once(", ") {
            // A unit gets its own line if that is enough.
            Some((name, unit)) if length(&column.name) > room && length(name) < room => {
                vec![format!("{name},"), unit.to_owned()]
            }
            _ => lines(&column.name, room),
        };
        cells.insert(0, head);
        Printed {
            group: &column.group,
            width: widest(&cells).unwrap_or(0),
            cells,
            right,
        }
    }
}

/// The text in lines of at most this width.
fn lines(text: &str, width: usize) -> Vec<String> {
    let lines = textwrap::wrap(text, options(width).break_words(true));
    lines.into_iter().map(Cow::into_owned).collect()
}

/// Groups, headings, rows.
fn grid_text(columns: &[Printed<'_>], rows: usize, gap: usize) -> String {
    let line = |cells: Vec<String>| format!("  {}", cells.join(&" ".repeat(gap)));
    let groups = columns.chunk_by(|a, b| a.group == b.group).map(|group| {
        let width = total(group, gap) - 2;
        let name: String = group[0].group.chars().take(width).collect();
        format!("{name:^width$}")
    });
    let groups = Some(line(groups.collect())).filter(|line| !line.trim().is_empty());
    let mut out: Vec<String> = groups.into_iter().collect();
    for i in 0..=rows {
        let high = columns.iter().map(|c| c.cells[i].len()).max().unwrap_or(0);
        out.extend((0..high).map(|k| {
            let cell = |c: &Printed<'_>| {
                // Headings are aligned at the bottom.
                let above = if i == 0 { high - c.cells[i].len() } else { 0 };
                let text = k.checked_sub(above).and_then(|k| c.cells[i].get(k));
                let (text, width) = (text.map_or("", |t| t), c.width);
                if c.right {
                    format!("{text:>width$}")
                } else {
                    format!("{text:<width$}")
                }
            };
            line(columns.iter().map(cell).collect())
        }));
    }
    out.iter()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect()
}
