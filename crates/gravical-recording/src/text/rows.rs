//! Rows as columns.

use std::collections::BTreeMap;
use std::ops::Range;

use gravical_judge::LineSpans;
use serde::{Deserialize, Serialize};

macro_rules! reasons {
    ($($reason:ident $name:literal $meaning:literal;)*) => {
        /// Why a line holds no row of the recording, or a row no measurement.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize)]
        pub enum Reason {
            $(#[doc = $meaning] #[serde(rename = $name)] $reason,)*
        }

        impl Reason {
            /// Stable name, for scripts.
            pub fn name(self) -> &'static str {
                match self {
                    $(Reason::$reason => $name,)*
                }
            }
        }
    };
}

reasons! {
    Header "header" "names the columns";
    Metadata "metadata-lines" "before the header";
    Comment "comment-lines" "comment";
    NamedGap "named-gap" "the logger reports missing rows";
    Rejected "rejected-samples" "no row; the logger rejected it";
    Blank "blank-rows" "blank";
    RepeatedHeader "repeated-header" "the header repeated";
    OtherSensor "other-sensor" "rows of another sensor";
    TornLine "torn-line" "fewer fields than the other rows (half-written)";
    TooManyFields "too-many-fields" "more fields than the other rows (lines run together?)";
    NotANumber "not-a-number" "no number where the rows have numbers";
    Continuation "continuation-lines" "continues the row above";
    Zeros "zero-rows" "all channels zero: the sensor was not read";
    Hung "sensor-hung" "all channels repeat for longer than noise allows: the sensor or its bus hung";
    CorruptBlock "corrupt-block" "damaged";
    LateBlock "late-block" "not later than the one before (repeated or out of order)";
    ErasedBlock "erased-block" "never written";
}

impl Reason {
    /// Whether it concerns a row that is not a measurement.
    pub(crate) fn is_of_row(self) -> bool {
        matches!(self, Reason::OtherSensor | Reason::Zeros | Reason::Hung)
    }
}

/// Lines that were set aside for one reason.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct AsideLines {
    /// Where they are
    pub lines: LineSpans,
    /// Text of the first, shortened
    pub first: String,
}

/// Account of all lines of a file: rows, and lines that were set aside, with the reason. Of a binary
/// file, samples and blocks are counted instead.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Lines read, the last one without a newline included
    pub lines: usize,
    /// Lines that were set aside, for each reason
    pub reasons: BTreeMap<Reason, AsideLines>,
}

/// Characters of an example.
const SHOWN: usize = 60;

impl Ledger {
    /// Counts a line.
    pub(crate) fn add(&mut self, reason: Reason, line: usize, text: &str) {
        let first = || text.chars().take(SHOWN).collect();
        self.lines_of(reason, first).push(line as u64);
    }

    fn lines_of(&mut self, reason: Reason, first: impl FnOnce() -> String) -> &mut LineSpans {
        let aside = self.reasons.entry(reason).or_insert_with(|| AsideLines {
            lines: LineSpans::default(),
            first: first(),
        });
        &mut aside.lines
    }

    /// Lines set aside for a reason.
    pub fn count(&self, reason: Reason) -> usize {
        let lines = self.reasons.get(&reason);
        lines.map_or(0, |r| r.lines.count() as usize)
    }

    /// Lines that are rows of the recording.
    pub fn rows(&self) -> usize {
        self.lines.saturating_sub(self.total())
    }

    /// Reasons that occurred, in order, and how many lines were set aside for each.
    pub fn counts(&self) -> impl Iterator<Item = (Reason, u64)> {
        let reasons = self.reasons.iter();
        reasons.map(|(reason, lines)| (*reason, lines.lines.count()))
    }

    /// All lines set aside.
    pub fn total(&self) -> usize {
        self.counts().map(|(_, lines)| lines as usize).sum()
    }

    /// The sum as text: `1020 lines = 1000 rows + 1 header + …`.
    pub fn sum(&self) -> String {
        let mut text = format!("{} lines = {} rows", self.lines, self.rows());
        for (reason, lines) in self.counts() {
            text += &format!(" + {lines} {}", reason.name());
        }
        text
    }

    /// Adds the lines that follow.
    pub fn append(&mut self, later: Ledger) {
        self.lines = self.lines.max(later.lines);
        for (reason, AsideLines { lines, first }) in later.reasons {
            self.lines_of(reason, || first).append(&lines);
        }
    }
}

/// So many rows of zeros in a row leave a break.
const MIN_ROWS_GONE: usize = 5;

/// Rows as columns, in the unit of the file.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Rows {
    /// One for each column of the file, NaN for a cell that is empty or text; empty for a column
    /// that nobody asks for
    pub columns: Vec<Vec<f64>>,
    /// Which word of the column stands in the cell, from 1, and 0 for a number; empty for a column
    /// without text
    pub texts: Vec<Vec<u8>>,
    /// Words of each column of text, in order of appearance
    pub words: Vec<Vec<String>>,
    /// Number of the line in which each row begins, from 1
    pub lines: Vec<u32>,
    /// Rows that do not go on from the row before: after a named gap, a restart, or rows set aside
    pub breaks: Vec<usize>,
    /// Rows before which the header is repeated
    pub headers: Vec<usize>,
    /// Rows before which blank lines stand, and how many
    pub blanks: Vec<(usize, usize)>,
    /// Lines with NUL bytes, which were removed
    pub nul_lines: LineSpans,
    /// Lines without a row
    pub ledger: Ledger,
    /// Text of columns, where it was asked for
    pub text: CopiedText,
}

/// Text of the columns that are copied, byte for byte but for NUL bytes and blanks at the end.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct CopiedText {
    bytes: Vec<u8>,
    /// Ends of the pieces of all rows.
    ends: Vec<usize>,
    /// Pieces of a row.
    pub(crate) pieces: usize,
}

impl CopiedText {
    /// One piece a row.
    pub fn of_rows<'a>(rows: impl IntoIterator<Item = &'a str>) -> Self {
        let mut text = CopiedText::new(1);
        rows.into_iter().for_each(|row| text.push(row.as_bytes()));
        text
    }

    pub(crate) fn new(pieces: usize) -> Self {
        CopiedText {
            pieces,
            ..CopiedText::default()
        }
    }

    /// Adds the text of the rows that follow.
    pub(crate) fn append(&mut self, later: &CopiedText) {
        let bytes = self.bytes.len();
        self.bytes.extend_from_slice(&later.bytes);
        self.ends.extend(later.ends.iter().map(|end| end + bytes));
    }

    pub(crate) fn push(&mut self, piece: &[u8]) {
        self.bytes.extend_from_slice(piece);
        self.ends.push(self.bytes.len());
    }

    /// A piece of a row.
    pub fn piece(&self, row: usize, piece: usize) -> &[u8] {
        let at = row * self.pieces + piece;
        let from = at.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.bytes[from..self.ends[at]]
    }
}

impl Rows {
    pub(crate) fn new(fields: usize) -> Self {
        Rows {
            columns: vec![Vec::new(); fields],
            texts: vec![Vec::new(); fields],
            words: vec![Vec::new(); fields],
            ..Rows::default()
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The values of columns.
    pub(crate) fn slices(&self, columns: &[usize]) -> Vec<&[f64]> {
        columns.iter().map(|c| &self.columns[*c][..]).collect()
    }

    /// Adds the rows that follow.
    pub(crate) fn append(&mut self, mut later: Rows) {
        let (rows, later_rows) = (self.rows(), later.rows());
        later.renumber_words(&mut self.words);
        for (column, later) in self.columns.iter_mut().zip(&mut later.columns) {
            append(column, later);
        }
        for (texts, later) in self.texts.iter_mut().zip(&mut later.texts) {
            if !texts.is_empty() || !later.is_empty() {
                texts.resize(rows, 0);
                texts.append(later);
                texts.resize(rows + later_rows, 0);
            }
        }
        append(&mut self.lines, &mut later.lines);
        for row in later.breaks {
            mark(&mut self.breaks, row + rows);
        }
        for row in later.headers {
            mark(&mut self.headers, row + rows);
        }
        for (row, lines) in later.blanks {
            self.add_blanks(row + rows, lines);
        }
        self.text.append(&later.text);
        self.nul_lines.append(&later.nul_lines);
        self.ledger.append(later.ledger);
    }

    /// Adds blank lines before a row.
    pub(crate) fn add_blanks(&mut self, row: usize, lines: usize) {
        match self.blanks.last_mut() {
            Some((last, count)) if *last == row => *count += lines,
            _ => self.blanks.push((row, lines)),
        }
    }

    /// Moves the marks behind the last row to the rows that follow.
    pub(crate) fn take_marks(&mut self, next: &mut Rows) {
        let end = self.rows();
        let take = |marks: &mut Vec<usize>| marks.pop_if(|row| *row == end).map(|_| 0);
        next.breaks.extend(take(&mut self.breaks));
        next.headers.extend(take(&mut self.headers));
        let blanks = self.blanks.pop_if(|(row, _)| *row == end);
        next.blanks.extend(blanks.map(|(_, lines)| (0, lines)));
    }

    /// Gives the words of text the numbers that they have among others, which get the new ones.
    fn renumber_words(&mut self, words: &mut [Vec<String>]) {
        let columns = self.texts.iter_mut().zip(&self.words).zip(words);
        for ((texts, own), words) in columns.filter(|((texts, _), _)| !texts.is_empty()) {
            let numbers: Vec<u8> = own.iter().map(|word| number_of_word(words, word)).collect();
            for code in texts.iter_mut().filter(|code| **code > 0) {
                *code = numbers
                    .get(usize::from(*code) - 1)
                    .copied()
                    .unwrap_or(u8::MAX);
            }
        }
    }

    /// Moves the marks before rows to others, or forgets them.
    fn move_marks(&mut self, to: impl Fn(usize) -> Option<usize>) {
        for marks in [&mut self.breaks, &mut self.headers] {
            *marks = marks.iter().filter_map(|row| to(*row)).collect();
        }
        let blanks = self.blanks.iter();
        let blanks = blanks.filter_map(|(row, n)| Some((to(*row)?, *n)));
        self.blanks = blanks.collect();
    }

    /// Forgets the other rows, but not the lines set aside.
    pub(crate) fn crop(&mut self, rows: Range<usize>) {
        let slice = self.slice(rows);
        *self = Rows {
            nul_lines: std::mem::take(&mut self.nul_lines),
            ledger: std::mem::take(&mut self.ledger),
            ..slice
        };
        self.ledger.lines = self.rows() + self.ledger.total();
    }

    /// Keeps the rows that are marked and counts the others; where a sensor hung, or was not read
    /// for several rows, they leave a break.
    pub(crate) fn keep(&mut self, keep: &[bool], reason: Reason) {
        if keep.iter().all(|k| *k) {
            return;
        }
        let least = match reason {
            Reason::Hung => 1,
            Reason::Zeros => MIN_ROWS_GONE,
            _ => usize::MAX,
        };
        let (mut kept_before, mut breaks) = (vec![0], Vec::new());
        let (mut kept, mut gone) = (0, 0);
        for (row, keep) in keep.iter().enumerate() {
            if *keep {
                breaks.extend((gone >= least).then_some(kept));
                (kept, gone) = (kept + 1, 0);
            } else {
                self.ledger.add(reason, self.lines[row] as usize, "");
                gone += 1;
            }
            kept_before.push(kept);
        }
        self.columns.iter_mut().for_each(|c| retain(c, keep));
        self.texts.iter_mut().for_each(|t| retain(t, keep));
        retain(&mut self.lines, keep);
        // Marks of rows at the end are gone.
        self.move_marks(|row| Some(kept_before[row]).filter(|row| *row < kept));
        self.breaks.append(&mut breaks);
        self.breaks.sort_unstable();
        self.breaks.dedup();
    }

    /// Some rows with the marks before them.
    pub(crate) fn slice(&self, rows: Range<usize>) -> Rows {
        fn cut<T: Copy>(values: &[T], rows: &Range<usize>) -> Vec<T> {
            let end = rows.end.min(values.len());
            values.get(rows.start..end).unwrap_or_default().to_vec()
        }
        let mut slice = Rows {
            columns: self.columns.iter().map(|c| cut(c, &rows)).collect(),
            texts: self.texts.iter().map(|t| cut(t, &rows)).collect(),
            words: self.words.clone(),
            lines: cut(&self.lines, &rows),
            breaks: self.breaks.clone(),
            headers: self.headers.clone(),
            blanks: self.blanks.clone(),
            ..Rows::default()
        };
        slice.move_marks(|row| rows.contains(&row).then(|| row - rows.start));
        slice
    }

    /// Adds a word to the cells of a column of text.
    pub(crate) fn push_word(&mut self, column: usize, word: &str) {
        let number = number_of_word(&mut self.words[column], word);
        self.texts[column].push(number);
    }

    /// Whether most cells of a column are text.
    pub(crate) fn is_text(&self, column: usize) -> bool {
        self.texts[column].iter().filter(|t| **t > 0).count() * 2 > self.rows()
    }
}

/// Marks a row, once.
pub(crate) fn mark(marks: &mut Vec<usize>, row: usize) {
    if marks.last() != Some(&row) {
        marks.push(row);
    }
}

/// The number of a word among others, from 1, to which it is added; words beyond the limit share the
/// last number.
fn number_of_word(words: &mut Vec<String>, word: &str) -> u8 {
    let at = words.iter().position(|w| w == word).unwrap_or(words.len());
    if at == words.len() && at < usize::from(u8::MAX) - 1 {
        words.push(word.to_owned());
    }
    u8::try_from(at + 1).unwrap_or(u8::MAX)
}

/// Adds values to others, in a little more room: twice as much would be too large.
fn append<T>(values: &mut Vec<T>, later: &mut Vec<T>) {
    if values.capacity() < values.len() + later.len() {
        values.reserve_exact(later.len().max(values.len() / 8));
    }
    values.append(later);
}

/// Keeps the values that are marked.
fn retain<T: Copy>(values: &mut Vec<T>, keep: &[bool]) {
    let mut marks = keep.iter();
    values.retain(|_| marks.next().copied().unwrap_or(true));
}
