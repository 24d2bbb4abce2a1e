//! Rows as columns.

use std::collections::BTreeMap;
use std::fmt;

use memchr::memchr;

/// Why a line holds no row of the recording, or a row no measurement.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Reason {
    /// Nothing but blanks and delimiters
    Blank,
    /// Above the first row: header and metadata
    Head,
    /// A comment between rows
    Comment,
    /// More or fewer fields than a row has: torn lines
    Width,
    /// No number where the rows have numbers: repeated headers, messages
    NoNumbers,
    /// A further line of a row that is written in several
    Continuation,
    /// A row of another sensor
    OtherSensor,
    /// All channels zero: the sensor was not read
    Zeros,
    /// All channels repeat for longer than noise allows: sensor or bus hung
    Hung,
    /// Channels shifted by one or more places
    Slipped,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Reason::Blank => "blank",
            Reason::Head => "above the first row",
            Reason::Comment => "comments",
            Reason::Width => "with more or fewer fields than a row",
            Reason::NoNumbers => "without the numbers of a row",
            Reason::Continuation => "that continue a row",
            Reason::OtherSensor => "of other sensors",
            Reason::Zeros => "of zeros: the sensor was not read",
            Reason::Hung => "that repeat exactly: sensor or bus hung",
            Reason::Slipped => "whose channels are shifted",
        })
    }
}

/// Counts of the lines that hold no row; with the rows they are all lines.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Aside {
    /// Lines read
    pub lines: usize,
    /// Count and number of the first line, from 1
    pub reasons: BTreeMap<Reason, (usize, usize)>,
}

impl Aside {
    /// Counts a line, or a row that began in it.
    pub(crate) fn add(&mut self, reason: Reason, line: usize) {
        self.reasons.entry(reason).or_insert((0, line)).0 += 1;
    }

    /// Lines set aside for a reason.
    #[must_use]
    pub fn count(&self, reason: Reason) -> usize {
        self.reasons.get(&reason).map_or(0, |r| r.0)
    }

    /// All lines set aside.
    #[must_use]
    pub fn total(&self) -> usize {
        self.reasons.values().map(|r| r.0).sum()
    }

    fn append(&mut self, later: Aside) {
        self.lines = self.lines.max(later.lines);
        for (reason, (count, line)) in later.reasons {
            self.reasons.entry(reason).or_insert((0, line)).0 += count;
        }
    }
}

/// Rows as columns, in the unit of the file.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Batch {
    /// One for each column of the file, NaN for a cell that is empty or text; empty for a column
    /// that nobody asks for
    pub columns: Vec<Vec<f64>>,
    /// Which word of the column stands in the cell, from 1, and 0 for a number; empty for a column
    /// without text
    pub texts: Vec<Vec<u8>>,
    /// Words of each column of text, up to this batch, in order of appearance
    pub words: Vec<Vec<String>>,
    /// Number of the line in which each row begins, from 1
    pub lines: Vec<u32>,
    /// Rows before which a repeated header or a line `# gap:` stands
    pub breaks: Vec<usize>,
    /// Rows before which a blank line stands
    pub blanks: Vec<usize>,
    /// Samples that a logger says it rejected: lines `# rejected:`
    pub rejected: usize,
    /// Lines without a row
    pub aside: Aside,
    /// Text of columns, where it was asked for
    pub text: CopiedText,
}

/// Text of the columns that are copied, byte for byte but for NUL bytes.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct CopiedText {
    bytes: Vec<u8>,
    /// Ends of the pieces of all rows.
    ends: Vec<usize>,
    pieces: usize,
}

impl CopiedText {
    /// Without rows, for so many pieces a row; room for as many bytes as the batch before took.
    pub(crate) fn new(pieces: usize, bytes: usize, rows: usize) -> Self {
        CopiedText {
            bytes: Vec::with_capacity(bytes),
            ends: Vec::with_capacity(rows * pieces),
            pieces,
        }
    }

    pub(crate) fn push(&mut self, piece: &str) {
        if memchr(0, piece.as_bytes()).is_some() {
            self.bytes.extend(piece.bytes().filter(|b| *b != 0));
        } else {
            self.bytes.extend_from_slice(piece.as_bytes());
        }
        self.ends.push(self.bytes.len());
    }

    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// A piece of a row.
    #[must_use]
    pub fn piece(&self, row: usize, piece: usize) -> &[u8] {
        let at = row * self.pieces + piece;
        let from = at.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.bytes[from..self.ends[at]]
    }
}

impl Batch {
    pub(crate) fn new(fields: usize) -> Self {
        Batch {
            columns: vec![Vec::new(); fields],
            texts: vec![Vec::new(); fields],
            words: vec![Vec::new(); fields],
            ..Batch::default()
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// Bytes that the columns take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let columns: usize = self.columns.iter().map(|c| size_of_val(c.as_slice())).sum();
        let texts: usize = self.texts.iter().map(Vec::len).sum();
        columns + texts + size_of_val(self.lines.as_slice())
    }

    /// Adds the rows of the batch that follows, without their text.
    pub fn append(&mut self, mut later: Batch) {
        let (rows, later_rows) = (self.rows(), later.rows());
        (self.text, later.text) = Default::default();
        if rows == 0 && self.aside.lines == 0 {
            *self = later;
            return;
        }
        for (column, later) in self.columns.iter_mut().zip(&mut later.columns) {
            column.append(later);
        }
        for (texts, later) in self.texts.iter_mut().zip(&mut later.texts) {
            if !texts.is_empty() || !later.is_empty() {
                texts.resize(rows, 0);
                texts.append(later);
                texts.resize(rows + later_rows, 0);
            }
        }
        self.words = later.words;
        self.lines.append(&mut later.lines);
        self.breaks.extend(later.breaks.iter().map(|b| b + rows));
        self.blanks.extend(later.blanks.iter().map(|b| b + rows));
        self.rejected += later.rejected;
        self.aside.append(later.aside);
    }

    /// Keeps the rows that are marked and counts the others; they leave a break.
    pub(crate) fn keep(&mut self, keep: &[bool], reason: Reason) {
        if keep.iter().all(|k| *k) {
            return;
        }
        for (row, _) in keep.iter().enumerate().filter(|(_, k)| !**k) {
            self.aside.add(reason, self.lines[row] as usize);
        }
        let columns = self.columns.iter_mut().filter(|c| !c.is_empty());
        columns.for_each(|c| retain(c, keep));
        self.texts
            .iter_mut()
            .filter(|t| !t.is_empty())
            .for_each(|t| retain(t, keep));
        retain(&mut self.lines, keep);
        let mut kept_before = vec![0; keep.len() + 1];
        for (row, k) in keep.iter().enumerate() {
            kept_before[row + 1] = kept_before[row] + usize::from(*k);
        }
        for row in self.breaks.iter_mut().chain(&mut self.blanks) {
            *row = kept_before[*row];
        }
        if matches!(reason, Reason::Hung | Reason::Slipped) {
            let ends = keep.windows(2).enumerate().filter(|(_, k)| !k[0] && k[1]);
            self.breaks
                .extend(ends.map(|(row, _)| kept_before[row + 1]));
            self.breaks.sort_unstable();
        }
    }

    /// Whether most cells of a column are text.
    pub(crate) fn is_text(&self, column: usize) -> bool {
        self.texts[column].iter().filter(|t| **t > 0).count() * 2 > self.rows()
    }
}

/// Keeps the values that are marked.
pub(crate) fn retain<T: Copy>(values: &mut Vec<T>, keep: &[bool]) {
    let mut marks = keep.iter();
    values.retain(|_| marks.next().copied().unwrap_or(true));
}
