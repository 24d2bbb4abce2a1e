//! The parts of a document.

use super::ROWS;
use super::findings::Remark;
use crate::figure::Figure;
use gravical::finding::Finding;
use gravical::numfmt::fixed;

/// How much of a document is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// For a terminal: the main blocks, the first rows of long tables, the weightiest findings.
    Summary,
    /// Everything.
    Full,
}

/// The report of one result.
#[must_use]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document<'a> {
    /// Title of a page.
    pub title: String,
    /// Subject in one or two lines; a text begins with them.
    pub subject: Vec<String>,
    /// Time and command; on pages only.
    pub stamp: String,
    /// How good it is. A page begins with it, a text ends with it.
    pub verdict: Option<Verdict>,
    /// The rest, in order.
    pub sections: Vec<Section<'a>>,
}

/// How good a result is, why, and what to do next.
#[must_use]
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Which sign and colour it has.
    pub grade: Grade,
    /// The verdict in a word or two.
    pub word: String,
    /// One sentence that sums it up; by default the first reason.
    pub conclusion: Option<String>,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// Next steps.
    pub next: Vec<String>,
}

/// Sign and colour of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grade {
    /// ✓, green.
    Good,
    /// ~, amber.
    Fair,
    /// ✗, vermilion.
    Poor,
    /// ?, grey.
    Unknown,
}

/// A section with a heading.
#[must_use]
#[derive(Debug, Clone, PartialEq)]
pub struct Section<'a> {
    /// Its anchor in a page.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Its content, each block from this detail on.
    pub blocks: Vec<(Detail, Block<'a>)>,
}

/// A piece of a section.
#[must_use]
#[derive(Debug, Clone, PartialEq)]
pub enum Block<'a> {
    /// Sentences.
    Paragraph(String),
    /// A note on the block above.
    Note(String),
    /// One line each.
    Equation(Vec<&'static str>),
    /// Names and values.
    Facts(Vec<(String, String)>),
    /// Numbers.
    Table(Table),
    /// A figure.
    Figure(&'a Figure),
    /// Code in several languages, to copy.
    Snippets(Vec<Snippet>),
    /// Findings.
    Findings(Vec<Remark>),
}

/// Code to copy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Snippet {
    /// Name of the language.
    pub language: &'static str,
    /// Its name after the fence of a Markdown block; empty for plain text.
    pub fence: &'static str,
    /// The code, in whole lines.
    pub code: String,
}

/// Numbers and texts in rows. The first cell of a row names it.
#[must_use]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, [`ROWS`] at most.
    pub rows: Vec<Row>,
    /// Number of rows before [`ROWS`] cut them.
    pub all: usize,
}

/// A column of a table.
#[must_use]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Heading above this and the adjacent columns of the same group; empty for none.
    pub group: String,
    /// Quantity and unit.
    pub name: String,
}

/// A row of a table.
#[must_use]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// One cell for each column.
    pub cells: Vec<Cell>,
    /// A sentence below the row; empty for none.
    pub note: String,
}

/// A cell of a table.
#[must_use]
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number and its standard uncertainty, with significant digits and a hyphen as minus sign.
    Number(String, Option<String>),
}

impl<'a> Document<'a> {
    /// A document without anything in it.
    pub fn new(title: impl Into<String>) -> Self {
        Document {
            title: title.into(),
            ..Document::default()
        }
    }

    /// Subject and stamp below the title of a page: without the title where the subject repeats
    /// it.
    pub(crate) fn lead(&self) -> impl Iterator<Item = &str> {
        let title = format!("{}: ", self.title);
        let lines = self.subject.iter().chain([&self.stamp]);
        let lines = lines.filter(|line| !line.is_empty());
        lines.map(move |line| line.strip_prefix(title.as_str()).unwrap_or(line))
    }

    /// Adds a section, unless there is none or it is empty.
    pub fn with(mut self, section: impl Into<Option<Section<'a>>>) -> Self {
        let section = section.into().filter(|s| !s.blocks.is_empty());
        self.sections.extend(section);
        self
    }

    /// With a section of findings, of one file or of several.
    pub fn with_findings(self, findings: &[Finding], several_files: bool) -> Self {
        let section = Section::new("findings", "Findings");
        let mut remarks = Remark::all(findings, several_files);
        if remarks.is_empty() {
            return self.with(section.with(Block::paragraph("None.")));
        }
        let more = remarks.len().saturating_sub(ROWS);
        remarks.truncate(ROWS);
        let section = section.with(Block::Findings(remarks));
        self.with(match more {
            0 => section,
            n => section.with(Block::note(format!("… and {n} more; --json has all"))),
        })
    }
}

impl Verdict {
    /// A verdict with its reasons alone.
    pub fn new(grade: Grade, word: &str, reasons: &[String]) -> Self {
        Verdict {
            grade,
            word: word.to_owned(),
            conclusion: None,
            reasons: reasons.to_vec(),
            next: Vec::new(),
        }
    }
}

impl<'a> Section<'a> {
    /// An empty section.
    pub fn new(id: &'static str, title: &'static str) -> Self {
        Section {
            id,
            title,
            blocks: Vec::new(),
        }
    }

    /// With a block that every rendering has.
    pub fn with(mut self, block: impl Into<Block<'a>>) -> Self {
        self.blocks.push((Detail::Summary, block.into()));
        self
    }

    /// With a block that only a full rendering has.
    pub fn full(mut self, block: impl Into<Block<'a>>) -> Self {
        self.blocks.push((Detail::Full, block.into()));
        self
    }

    /// With figures.
    pub fn figures(mut self, figures: impl IntoIterator<Item = &'a Figure>) -> Self {
        let blocks = figures.into_iter().map(Block::Figure);
        self.blocks.extend(blocks.map(|b| (Detail::Full, b)));
        self
    }

    /// The blocks of this detail.
    pub(super) fn shown(&self, detail: Detail) -> impl Iterator<Item = &Block<'a>> {
        self.blocks
            .iter()
            .filter(move |(from, _)| *from <= detail)
            .map(|(_, block)| block)
    }
}

impl Block<'_> {
    /// Sentences.
    pub fn paragraph(text: impl Into<String>) -> Self {
        Block::Paragraph(text.into())
    }

    /// Names and values; those without a value are left out.
    pub fn facts<const N: usize>(facts: [(&str, Option<String>); N]) -> Self {
        let facts = facts.into_iter();
        let known = facts.filter_map(|(name, text)| Some((name.to_owned(), text?)));
        Block::Facts(known.collect())
    }

    /// Small print.
    pub fn note(text: impl Into<String>) -> Self {
        Block::Note(text.into())
    }
}

impl From<Table> for Block<'_> {
    fn from(table: Table) -> Self {
        Block::Table(table)
    }
}

impl Table {
    /// An empty table.
    pub fn new(caption: impl Into<String>) -> Self {
        Table {
            caption: caption.into(),
            ..Table::default()
        }
    }

    /// With these columns on the right of those that it has.
    pub fn columns<C: Into<Column>>(mut self, columns: impl IntoIterator<Item = C>) -> Self {
        self.columns.extend(columns.into_iter().map(Into::into));
        self
    }

    /// Whether this column holds numbers, which are right-aligned.
    pub(super) fn is_numeric(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|r| r.cells.get(column));
        cells.any(|c| matches!(c, Cell::Number(..)))
    }

    /// With one more row.
    pub fn row(self, row: impl Into<Row>) -> Self {
        self.rows([row.into()])
    }

    /// With more rows; beyond [`ROWS`] they are counted and not kept.
    pub fn rows(mut self, rows: impl IntoIterator<Item = Row>) -> Self {
        for row in rows {
            self.all += 1;
            if self.all <= ROWS {
                self.rows.push(row);
            }
        }
        self
    }
}

impl Column {
    /// Adjacent columns below one heading.
    pub fn group<const N: usize>(group: &str, names: [&str; N]) -> [Self; N] {
        names.map(|name| Column {
            group: group.to_owned(),
            ..Column::from(name)
        })
    }

    /// Three columns of numbers, for the axes.
    pub fn axes(group: &str) -> [Self; 3] {
        Column::group(group, ["x", "y", "z"])
    }
}

impl From<&str> for Column {
    fn from(name: &str) -> Self {
        Column {
            group: String::new(),
            name: name.to_owned(),
        }
    }
}

impl<C: IntoIterator<Item = Cell>> From<C> for Row {
    fn from(cells: C) -> Self {
        Row {
            cells: cells.into_iter().collect(),
            ..Row::default()
        }
    }
}

impl Row {
    /// Cells behind what they are.
    pub fn named(name: impl Into<String>, cells: impl IntoIterator<Item = Cell>) -> Self {
        std::iter::once(Cell::text(name)).chain(cells).into()
    }

    /// With a sentence below it.
    pub fn noted(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Cell::Text(text.into())
    }

    /// A number without an uncertainty.
    pub fn number(text: impl Into<String>) -> Self {
        Cell::Number(text.into(), None)
    }

    /// A number that may be missing.
    pub fn maybe(value: Option<f64>, text: impl Fn(f64) -> String) -> Self {
        Cell::number(value.map_or("–".to_owned(), text))
    }

    /// Three numbers, for the axes.
    pub fn axes(values: Option<[f64; 3]>, text: impl Fn(usize, f64) -> String) -> [Self; 3] {
        std::array::from_fn(|k| Cell::maybe(values.map(|v| v[k]), |v| text(k, v)))
    }

    /// With its standard uncertainty, where that is known.
    pub fn plus_minus(self, sigma: Option<f64>, decimals: usize) -> Self {
        let sigma = sigma.filter(|s| s.is_finite()).map(|s| fixed(s, decimals));
        match self {
            Cell::Number(text, _) => Cell::Number(text, sigma),
            other => other,
        }
    }
}
