//! From the head of a file to its format.

use gravical_judge::finding::Misfit;
use gravical_judge::units::{is_listed, is_unit};
use gravical_judge::{Error, ReadOptions, Role};

use super::dialect::{Dialect, fields, is_blank, is_comment, uncommented};
use super::format::Format;
use super::header::{Header, names_sensor};
use super::lines::trim_end;
use super::names::{self, Column};
use super::number::parse_cell;
use super::parse::{MANY_WORDS, Parser};
use super::roles;
use super::rows::Rows;
use super::words::LinePattern;
use crate::board::BoardSettings;
use crate::date::{self, parse_date};
use crate::metadata;
use crate::problem::Problem;

/// Of a text without a table at most one line in this many looks like a row.
const LINES_PER_ROW: usize = 10;

/// Lines by which the dialect is recognised.
const DIALECT_LINES: usize = 400;

/// What a text without a table of samples is, or else why it has none.
fn no_table(head: &str, why: Problem) -> Problem {
    let head = head.trim_start_matches('\u{feff}').trim_start();
    match head.chars().next() {
        Some('{' | '[') => Problem::IsJson,
        Some('<') => Problem::IsMarkup,
        _ if has_one_number_a_line(head) => Problem::OneNumberALine,
        _ => why,
    }
}

/// Whether most lines are nothing but a number.
fn has_one_number_a_line(head: &str) -> bool {
    let lines = head.lines().map(str::trim).filter(|l| !l.is_empty());
    let numbers = lines.clone().filter(|l| parse_cell(l, false).is_some());
    2 * numbers.count() > lines.count()
}

/// Reads the head of a file, as UTF-8; the name of the file (without its folder) may tell the
/// sensor.
///
/// # Errors
///
/// There is no table of samples, its columns are not understood, there is no accelerometer, or the
/// file holds counts per epoch.
pub fn sniff(head: &str, file_name: &str, options: &ReadOptions) -> Result<Format, Error> {
    if head.trim().is_empty() {
        return Err(Problem::EmptyFile.error());
    }
    let (line_end, lines) = split_lines(head);
    let with_roles = |format: Format| format.with_roles(head, file_name, options);
    let table = Format::table(&lines, line_end, true);
    let is_axis = |column: &Column| column.is_accel() || column.is_gyro();
    let names_axes = table.iter().flat_map(|t| &t.columns).any(is_axis);
    let table = table
        .ok_or_else(|| no_table(head, Problem::NoTable))
        .and_then(|format| {
            if options.columns.is_none() && has_few_rows(&format, &lines, head) {
                return Err(no_table(head, Problem::FewRows));
            }
            with_roles(format).or_else(|problem| {
                // A comment above the rows may as well be about something else.
                use Problem::{NoAccelerometer, TooFewAxes};
                let is_unnamed = matches!(problem, TooFewAxes { .. } | NoAccelerometer { .. });
                let unnamed = Format::table(&lines, line_end, false).filter(|_| is_unnamed);
                unnamed.and_then(|f| with_roles(f).ok()).ok_or(problem)
            })
        });
    let (is_wordy, is_guessed) = match &table {
        Ok((format, is_wordy)) => (*is_wordy, format.is_guessed),
        Err(_) => (true, true),
    };
    if (is_wordy || is_guessed)
        && let Some(Ok((sentences, _))) = Format::sentences(&lines, line_end).map(with_roles)
    {
        let has_clock = |format: &Format| format.columns.iter().any(|c| c.role == Role::Time);
        // A table has no stamps where they are on lines of their own.
        let has_more = has_clock(&sentences) && !table.as_ref().is_ok_and(|t| has_clock(&t.0));
        // Where a header names axes, words have to name them, too: numbers alone may be those of a date.
        let x = &sentences.columns[sentences.accel[0]];
        let is_told = is_axis(x) && !x.is_given;
        if (is_wordy || !sentences.is_guessed || has_more) && (!names_axes || is_told) {
            return Ok(sentences);
        }
    }
    Ok(table?.0)
}

/// What ends the lines of a text, and these.
fn split_lines(head: &str) -> (u8, Vec<&str>) {
    let line_end = if head.contains('\n') { b'\n' } else { b'\r' };
    let lines = head.split(char::from(line_end)).map(trim_end);
    (line_end, lines.collect())
}

/// The fields of a `sensor_msgs/Imu` message, in order.
fn ros_imu() -> Vec<String> {
    let vectors = [
        ("orientation", "xyzw"),
        ("angular_velocity", "xyz"),
        ("linear_acceleration", "xyz"),
    ];
    let mut names = ["sec", "nanosec", "frame_id"]
        .map(|n| format!("header.stamp.{n}"))
        .to_vec();
    for (vector, axes) in vectors {
        names.extend(axes.chars().map(|axis| format!("{vector}.{axis}")));
        names.extend((0..9).map(|i| format!("{vector}_covariance[{i}]")));
    }
    names
}

/// Names of the columns below another head: of the CSV that the PC software of GENEActiv writes below
/// its hundred lines, and of `sensor_msgs/Imu` as `ros2 topic echo --csv` prints it.
fn known_names(above: &[&str], first_row: &[&str]) -> Vec<String> {
    const GENEACTIV: &str = "time,x (g),y (g),z (g),light (lux),button,temperature (C)";
    let is_geneactiv = above.iter().any(|line| {
        line.starts_with("Device Type") && names::words(line).iter().any(|w| w == "geneactiv")
    });
    let names_frame = first_row.get(2).is_some_and(|f| f.parse::<f64>().is_err());
    match first_row.len() {
        7 if is_geneactiv => GENEACTIV.split(',').map(str::to_owned).collect(),
        40 if names_frame => ros_imu(),
        _ => Vec::new(),
    }
}

/// Whether the rows are a few among lines of words or of markup.
fn has_few_rows(format: &Format, lines: &[&str], head: &str) -> bool {
    let below = lines[format.head_lines..].iter();
    let below = below.filter(|l| !l.trim().is_empty());
    let rows = below.clone().filter(|l| format.dialect.is_row(l)).count();
    let is_markup = head.trim_start().starts_with(['{', '[', '<']);
    // JSON may be a single line.
    let is_line = is_markup && lines.iter().filter(|l| !l.trim().is_empty()).count() == 1;
    let are_few = rows * LINES_PER_ROW < below.count();
    is_line || are_few && (is_markup || is_prose(head.as_bytes()))
}

/// True for text that consists of words: two thirds of its visible characters are letters.
pub fn is_prose(text: &[u8]) -> bool {
    let count = |is: fn(&u8) -> bool| text.iter().filter(|b| is(b)).count();
    3 * count(u8::is_ascii_alphabetic) > 2 * count(u8::is_ascii_graphic)
}

impl Format {
    /// The format of a table in memory.
    pub(crate) fn of_table(
        names: &[String],
        columns: usize,
        sample: &Rows,
        options: &ReadOptions,
    ) -> Result<Self, Error> {
        if columns == 0 {
            let sum = sample.ledger.sum();
            return Err(Problem::NoRowRead { sum }.error());
        }
        let mut format = Format::new(Dialect::of_commas(columns), b'\n', names.to_vec());
        format.options = options.clone();
        roles::assign(&mut format, sample, "")?;
        Ok(format)
    }

    fn with_head(mut self, lines: &[&str], head_lines: usize) -> Self {
        self.head_lines = head_lines;
        let above = lines[..head_lines].iter();
        self.metadata = above.map(|l| (*l).to_owned()).collect();
        self.rate_hz = metadata::rate_hz(&self.metadata);
        self.board = BoardSettings::last(&self.metadata);
        self
    }

    /// The format of a table; its columns may be named by a comment or not.
    fn table(lines: &[&str], line_end: u8, is_named_by_comment: bool) -> Option<Self> {
        let head = &lines[..lines.len().min(DIALECT_LINES)];
        let dialect = Dialect::sniff(head).or_else(|| Dialect::sniff(lines))?;
        let measured = lines.iter().position(|l| dialect.is_row(l))?;
        let head_lines = Header::first_row(&lines[..measured], dialect).unwrap_or(measured);
        let above = &lines[..head_lines];
        let mut header = Header::parse(above, &lines[head_lines..], dialect);
        let header_line = header.line.checked_sub(1).map(|at| lines[at].trim_start());
        if !is_named_by_comment && header_line.is_some_and(is_comment) {
            header = Header::default();
        }
        let first_row: Vec<&str> = fields(lines[measured], dialect.delimiter).collect();
        let mut misfit = None;
        if header.names.is_empty() {
            header.names = known_names(above, &first_row);
            misfit = find_misfit(above, dialect);
        }
        let mut format = Format::new(dialect, line_end, header.names);
        (format.header_line, format.misfit) = (header.line, misfit);
        for (column, unit) in format.columns.iter_mut().zip(&header.units) {
            // `S_Timestamp_CAL` is not in seconds if the row of units says ms.
            if column.unit.is_empty() || is_unit(unit) {
                column.unit = unit.to_lowercase();
            }
        }
        for (column, cell) in format.columns.iter_mut().zip(&first_row) {
            column.is_dated = cell.contains(':') || parse_date(cell, false).is_some();
        }
        let is_day_first = metadata::is_day_first(above).or_else(|| {
            let mut dated = (0..dialect.fields).filter(|c| format.columns[*c].is_dated);
            dated.find_map(|c| {
                let rows = lines[measured..].iter();
                date::is_day_first(rows.filter_map(|l| fields(l, dialect.delimiter).nth(c)))
            })
        });
        format.dialect.day_first = is_day_first == Some(true);
        Some(format.with_head(lines, head_lines))
    }

    fn sentences(lines: &[&str], line_end: u8) -> Option<Self> {
        let sentences = LinePattern::sniff(lines)?;
        let (head_lines, texts) = sentences.sample(lines)?;
        let mut names = sentences.names(&lines[..head_lines], &texts);
        if names.iter().all(String::is_empty) {
            names.clear();
        }
        let mut format = Format::new(Dialect::of_commas(sentences.slots), line_end, names);
        for (column, texts) in format.columns.iter_mut().zip(&texts) {
            column.is_dated = texts.first().is_some_and(|text| text.contains(':'));
        }
        format.sentences = Some(sentences);
        Some(format.with_head(lines, head_lines))
    }

    /// Assigns roles by names and by the rows of the head. True if a column of text always
    /// differs: perhaps numbers wrapped in words.
    fn with_roles(
        mut self,
        head: &str,
        file_name: &str,
        options: &ReadOptions,
    ) -> Result<(Self, bool), Problem> {
        self.options = options.clone();
        if counts_epochs(&self.metadata) {
            return Err(Problem::EpochsOfCounts);
        }
        let mut parser = Parser::new(&self, &[]);
        // What of it is before an error: that is reported when the rows are read.
        let _ = parser.read(head.as_bytes());
        let mut sample = parser.take();
        if let Some(rate_hz) = start_and_rate(&sample) {
            self.rate_hz = Some(rate_hz);
            self.head_lines = sample.lines[1] as usize;
            sample.crop(2..usize::MAX);
        }
        let is_wordy = sample.texts.iter().flatten().any(|t| *t >= MANY_WORDS);
        roles::assign(&mut self, &sample, file_name)?;
        let is_added = |c: usize| self.added.is_some_and(|added| added.contains(&c));
        let is_asked =
            |c: usize| self.role(c) != Role::Other || self.sensor == Some(c) || is_added(c);
        // Names of other quantities, constants and counts of rows are known for what they are.
        let is_open = |c: &usize| {
            let (column, values) = (&self.columns[*c], &sample.columns[*c]);
            let is_sensor = column.is_accel() || column.is_gyro();
            let is_told = is_asked(*c) || is_sensor || column.is_foreign || column.is_dropped;
            let changes = values.windows(2).any(|w| w[0] != w[1] && !w[0].is_nan());
            !is_told && changes && !sample.is_text(*c) && !roles::is_counter(values)
        };
        let unread = (0..self.columns.len()).filter(is_open).collect();
        let is_read = |c: usize| self.sentences.is_some() || is_asked(c);
        self.is_read = (0..self.columns.len()).map(is_read).collect();
        self.unread = unread;
        Ok((self, is_wordy))
    }
}

/// Why a line above the rows that names a sensor is no header.
fn find_misfit(above: &[&str], dialect: Dialect) -> Option<Misfit> {
    let at = above.iter().rposition(|l| !is_blank(l))?;
    let names: Vec<&str> = fields(uncommented(above[at]), dialect.delimiter).collect();
    let (count, columns) = (names.len(), dialect.fields);
    (count != columns && names_sensor(&names)).then_some(Misfit::Names {
        line: at + 1,
        names: count,
        columns,
    })
}

/// Counts per epoch are no acceleration: `Epoch Period (hh:mm:ss) 00:00:15`. The Unix epoch is none of
/// these.
fn counts_epochs(metadata: &[String]) -> bool {
    let is_of_epochs = |line: &&String| {
        let mut words = names::words(line).into_iter().skip_while(|w| w != "epoch");
        let behind = words.nth(1);
        behind.is_some_and(|w| is_listed("period length duration interval", &w))
    };
    let epochs = metadata.iter().filter(is_of_epochs);
    let mut words = epochs.flat_map(|l| l.split([' ', ',', ';', '\t']));
    words.any(|w| w.contains(':') && parse_cell(w, false).is_some_and(|s| s > 0.0))
}

/// Empatica: the start in all columns, then the rate in all columns. Returns the rate in Hz.
fn start_and_rate(sample: &Rows) -> Option<f64> {
    let common = |row: usize| {
        let mut cells = sample.columns.iter().map(|c| c.get(row));
        let first = *cells.next()??;
        cells.all(|cell| cell == Some(&first)).then_some(first)
    };
    let (start_s, rate_hz) = (common(0)?, common(1)?);
    (start_s > 1e9 && rate_hz > 0.0 && sample.rows() > 2).then_some(rate_hz)
}
