//! A document for each result, with two renderings.
//!
//! A [`Document`] consists of sentences, tables of numbers, figures, findings and a verdict.
//! [`Document::to_text`] renders it for a terminal of 80 columns, [`Document::to_html`] as a
//! self-contained page.
//! [`report`](crate::report) builds the documents. Renderings differ in their amount
//! ([`Detail`]), not in numbers or sentences.
//!
//! # Example
//!
//! ```
//! use gravical_report::document::{Cell, Detail, Document, Section, Table};
//!
//! let table = Table::new("", ["axis", "bias, m/s²"])
//!     .row("x", [Cell::number("0.0213")]);
//! let document = Document::new("Calibration").with(Section::new("Bias").with(table));
//! assert_eq!(document.to_text(Detail::Summary), "\nBias\n  axis  bias, m/s²\n  x         0.0213\n");
//! ```

mod findings;
mod html;
mod text;

#[cfg(test)]
mod tests;

pub(crate) use findings::short_name;
#[doc(hidden)]
pub use findings::{Remark, flag};
#[doc(hidden)]
pub use text::paragraph;

use crate::figure::{Figure, XYZ};
use gravical::calibration_file::Grade;
use gravical::finding::Finding;
use gravical::numfmt::{COVERAGE, fixed};
use gravical::poses::face::in_words;

/// The section of method and uncertainty; a page adds the reasons of the verdict.
pub(crate) const HOW: &str = "How do you know?";

/// Rows of a table at most, and in a summary.
const MAX_ROWS: usize = 200;
const MAX_SUMMARY_ROWS: usize = 24;

/// Reasons below a table, and rows that each names.
const MAX_REASONS: usize = 12;

/// How much of a document is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// For a terminal: the main blocks, the first rows of long tables, the weightiest findings.
    Summary,
    /// Everything.
    Full,
}

/// The report of one result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Document<'a> {
    /// Title of a page.
    pub title: String,
    /// Subject in one or two lines; a text begins with them.
    pub subject: Vec<String>,
    /// What was judged, of a page: name, value, remark.
    pub certificate: Vec<[String; 3]>,
    /// How good it is. A page begins with it, a text ends with it.
    pub verdict: Option<Verdict>,
    /// The rest, in order.
    pub sections: Vec<Section<'a>>,
}

/// How good a result is, why, and what to do next.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Which sign and colour it has.
    pub grade: Grade,
    /// The verdict in a word or two; empty where nothing is judged, of which a text says nothing.
    pub word: String,
    /// One number, the heading of a page, and what stands small beside it.
    pub headline: [String; 2],
    /// What proves it, in a sentence or two of a page; by default the first reasons.
    pub proof: Vec<String>,
    /// At most three numbers that answer other questions, of a page, and what they are.
    pub numbers: Vec<[String; 2]>,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// Next steps.
    pub next: Vec<Step>,
}

/// What to do next, for each rendering to say in its own way.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// By hand, in a sentence.
    Do(String),
    /// Record a pose with this direction of the sensor up (unit vector), and calibrate with all recordings.
    Pose([f64; 3]),
    /// What for, the verb of gravical, its files and options.
    Run(&'static str, &'static str, Vec<String>),
}

/// A section with a heading.
#[derive(Debug, Clone, PartialEq)]
pub struct Section<'a> {
    /// Its heading; in lower case, with hyphens, its anchor in a page.
    pub title: &'static str,
    /// Where it stands on a page.
    pub place: Place,
    /// Its content, each block from this detail on.
    pub blocks: Vec<(Detail, Block<'a>)>,
}

/// Where a section stands on a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// In sight, over so many of twelve columns.
    Card(u8),
    /// Folded, with a note of what is in it.
    Fold(String),
    /// In the foot.
    Foot,
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block<'a> {
    /// Sentences.
    Paragraph(String),
    /// A note on the block above.
    Note(String),
    /// Lines of formulas.
    Equation(&'static str),
    /// Names and values.
    Facts(Vec<(String, String)>),
    /// Numbers.
    Table(Table),
    /// A figure.
    Figure(&'a Figure),
    /// A board by its roll, pitch and yaw in degrees, which lies as at the cursor of the figure of this name.
    Board([f64; 3], &'static str),
    /// Code to copy: name of the language, lines.
    Code(&'static str, String),
    /// Findings.
    Findings(Vec<Remark>),
}

/// Numbers and texts in rows. The first cell of a row names it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows: a cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// A page sorts it by each column, and shows all rows.
    pub is_sortable: bool,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Heading above this and the adjacent columns of the same group; empty for none.
    pub group: String,
    /// Quantity and unit.
    pub name: String,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number and its expanded uncertainty (95 %), with significant digits and a hyphen as minus sign.
    Number(String, Option<String>),
    /// A share in percent, which a page draws.
    Share(f64),
    /// Words, and the address of the page that they lead to.
    Link(String, String),
}

impl Step {
    /// By hand.
    pub(crate) fn by_hand(text: &str) -> Self {
        Step::Do(text.to_owned())
    }

    /// With gravical: what for, the verb, its files and options in one line.
    pub(crate) fn run(what: &'static str, verb: &'static str, arguments: &str) -> Self {
        let arguments = arguments.split(' ').map(str::to_owned).collect();
        Step::Run(what, verb, arguments)
    }

    /// In a sentence, and the command.
    fn in_words(&self) -> (String, Option<String>) {
        match self {
            Step::Do(text) => (text.clone(), None),
            Step::Pose(up) => {
                let up = in_words(*up);
                let text =
                    format!("Record one more pose ({up}) and calibrate with all recordings again.");
                (text, None)
            }
            Step::Run(what, verb, arguments) => {
                let command = format!("gravical {verb} {}", arguments.join(" "));
                ((*what).to_owned(), Some(command))
            }
        }
    }
}

impl Verdict {
    /// What a page says where nothing is judged.
    pub(crate) fn without_word(headline: [String; 2], proof: String) -> Self {
        Verdict {
            grade: Grade::NotVerifiable,
            word: String::new(),
            headline,
            proof: Some(proof)
                .filter(|text| !text.is_empty())
                .into_iter()
                .collect(),
            numbers: Vec::new(),
            reasons: Vec::new(),
            next: Vec::new(),
        }
    }

    /// The headline in one line.
    fn in_a_line(&self) -> String {
        match &self.headline {
            [text, small] if small.is_empty() => text.clone(),
            [text, small] => format!("{text} ({small})"),
        }
    }
}

impl<'a> Document<'a> {
    /// A document without anything in it.
    pub fn new(title: impl Into<String>) -> Self {
        Document {
            title: title.into(),
            ..Document::default()
        }
    }

    /// Adds a section, unless there is none or it is empty.
    pub fn with(mut self, section: impl Into<Option<Section<'a>>>) -> Self {
        let section = section.into().filter(|s| !s.blocks.is_empty());
        self.sections.extend(section);
        self
    }

    /// With a section of findings, of one file or of several.
    pub fn with_findings(self, findings: &[Finding], several_files: bool) -> Self {
        let mut remarks = Remark::all(findings, several_files);
        let more = remarks.len().saturating_sub(MAX_ROWS);
        remarks.truncate(MAX_ROWS);
        let section = Section::new("Findings").with(match remarks.len() {
            0 => Block::Paragraph("None.".to_owned()),
            _ => Block::Findings(remarks),
        });
        let section = section.folded(findings.len().to_string());
        self.with(section.with((more > 0).then(|| Block::Note(left_out(more)))))
    }
}

/// What stands in place of what is left out.
fn left_out(rows: usize) -> String {
    format!("… and {rows} more; --json has all")
}

impl<'a> Section<'a> {
    /// An empty section.
    pub fn new(title: &'static str) -> Self {
        Section {
            title,
            place: Place::Card(12),
            blocks: Vec::new(),
        }
    }

    /// In sight on a page, over so many of twelve columns.
    pub fn wide(mut self, columns: u8) -> Self {
        self.place = Place::Card(columns);
        self
    }

    /// Folded on a page, with a note of what is in it.
    pub fn folded(mut self, note: impl Into<String>) -> Self {
        self.place = Place::Fold(note.into());
        self
    }

    /// With a block that every rendering has, unless there is none.
    pub fn with(mut self, block: impl Into<Option<Block<'a>>>) -> Self {
        let block = block.into().map(|block| (Detail::Summary, block));
        self.blocks.extend(block);
        self
    }

    /// With a block that only a full rendering has, unless there is none.
    pub fn full(mut self, block: impl Into<Option<Block<'a>>>) -> Self {
        let block = block.into().map(|block| (Detail::Full, block));
        self.blocks.extend(block);
        self
    }

    /// With a name and its value in the facts at the end, unless there is none.
    pub fn fact(mut self, name: &str, value: impl Into<Option<String>>) -> Self {
        let fact = value.into().map(|value| (name.to_owned(), value));
        if let Some((_, Block::Facts(facts))) = self.blocks.last_mut() {
            facts.extend(fact);
            return self;
        }
        self.with(fact.map(|fact| Block::Facts(vec![fact])))
    }

    /// With those of the figures that have one of these names, in this order.
    pub fn figures(self, figures: &'a [Figure], names: &[&str]) -> Self {
        let find = |name: &&str| figures.iter().find(|f| f.name == *name);
        let found = names.iter().filter_map(find);
        found.map(Block::Figure).fold(self, Section::full)
    }

    /// With the reasons of some rows of the table above, one note for each reason.
    pub(crate) fn reasons(self, reasons: impl IntoIterator<Item = (String, String)>) -> Self {
        let mut rows: Vec<(String, Vec<String>)> = Vec::new();
        for (row, reason) in reasons {
            match rows.iter_mut().find(|(other, _)| *other == reason) {
                Some((_, rows)) => rows.push(row),
                None => rows.push((reason, vec![row])),
            }
        }
        let more = rows.len().saturating_sub(MAX_REASONS);
        let notes = rows.iter().take(MAX_REASONS).map(|(reason, rows)| {
            let named = rows[..rows.len().min(MAX_REASONS)].join(", ");
            match rows.len().saturating_sub(MAX_REASONS) {
                0 => format!("{named}: {reason}"),
                more => format!("{named} and {more} more: {reason}"),
            }
        });
        let more = (more > 0).then(|| left_out(more));
        let notes = notes.chain(more).map(Block::Note);
        notes.fold(self, Section::with)
    }

    /// The blocks of this detail.
    fn shown(&self, detail: Detail) -> impl Iterator<Item = &Block<'a>> {
        let shown = self.blocks.iter().filter(move |(from, _)| *from <= detail);
        shown.map(|(_, block)| block)
    }
}

impl From<Table> for Option<Block<'_>> {
    fn from(table: Table) -> Self {
        Some(Block::Table(table))
    }
}

impl Table {
    /// A table of these columns, without rows.
    pub fn new<'n>(caption: impl Into<String>, columns: impl IntoIterator<Item = &'n str>) -> Self {
        let mut table = Table::default().columns(columns);
        table.caption = caption.into();
        table
    }

    /// With these columns on the right of those that it has.
    pub fn columns<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Self {
        self.group("", names)
    }

    /// With columns below one heading.
    pub fn group<'n>(mut self, group: &str, names: impl IntoIterator<Item = &'n str>) -> Self {
        let columns = names.into_iter().map(|name| Column {
            group: group.to_owned(),
            name: name.to_owned(),
        });
        self.columns.extend(columns);
        self
    }

    /// With a column for each axis below one heading.
    pub fn axes(self, group: &str) -> Self {
        self.group(group, XYZ)
    }

    /// With one more row: cells behind what they are.
    pub fn row(self, name: impl Into<String>, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.with([Cell::text(name)].into_iter().chain(cells))
    }

    /// With one more row.
    pub fn with(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.rows.push(cells.into_iter().collect());
        self
    }

    /// To be sorted, with all rows.
    pub fn sortable(mut self) -> Self {
        self.is_sortable = true;
        self
    }

    /// Whether this column holds numbers, which are right-aligned.
    fn is_numeric(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|r| r.get(column));
        cells.any(|c| matches!(c, Cell::Number(..) | Cell::Share(_)))
    }

    /// The rows of this detail, and how many are left out.
    fn shown(&self, detail: Detail) -> (&[Vec<Cell>], usize) {
        let all = self.rows.len();
        let shown = match detail {
            Detail::Summary if all > MAX_SUMMARY_ROWS => MAX_SUMMARY_ROWS - 1,
            _ if self.is_sortable => all,
            _ => all.min(MAX_ROWS),
        };
        (&self.rows[..shown], all - shown)
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
    pub fn axes(values: Option<[f64; 3]>, text: impl Fn(f64) -> String) -> [Self; 3] {
        std::array::from_fn(|k| Cell::maybe(values.map(|v| v[k]), &text))
    }

    /// With twice this standard uncertainty, where that is known: every ± is 95 %.
    pub fn plus_minus(self, sigma: Option<f64>, decimals: usize) -> Self {
        let sigma = sigma.filter(|s| s.is_finite());
        let sigma = sigma.map(|s| fixed(COVERAGE * s, decimals));
        match self {
            Cell::Number(text, _) => Cell::Number(text, sigma),
            other => other,
        }
    }

    /// The text of the cell in one line.
    fn plain(&self) -> String {
        match self {
            Cell::Text(text) | Cell::Link(text, _) | Cell::Number(text, None) => text.clone(),
            Cell::Number(text, Some(sd)) => format!("{text} ± {sd}"),
            Cell::Share(share) => format!("{share:.0}"),
        }
    }
}

/// A sentence that begins with a capital; the name of an axis stays as it is.
pub(crate) fn capital(text: &str) -> String {
    let mut rest = text.chars();
    match rest.next() {
        Some(first) if rest.as_str().starts_with(|c: char| c.is_alphabetic()) => {
            first.to_uppercase().collect::<String>() + rest.as_str()
        }
        _ => text.to_owned(),
    }
}

/// The parts of a sentence, in order, and whether they are code: commands and options are between
/// backticks. A backtick without its second is text.
fn parts(text: &str) -> impl Iterator<Item = (&str, bool)> {
    let paired = text.matches('`').count() / 2 * 2;
    let parts = text.splitn(paired + 1, '`').enumerate();
    let parts = parts.map(|(i, part)| (part, i % 2 == 1));
    parts.filter(|(part, _)| !part.is_empty())
}
