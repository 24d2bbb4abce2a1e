//! Parsing of one line of text to numbers: the innermost loop of reading.

use crate::scan::{parse_field, parse_field_decimal_comma, scan_number};

use super::board::BoardSettings;
use super::date::{parse_date, parse_date_day_first};

/// Number of slots of a row.
pub const SLOTS: usize = 8;
/// Slot of the time stamp.
pub const TIME: usize = 0;
/// Slot of the accelerometer's first axis; the others follow.
pub const ACCEL: usize = 1;
/// Slot of the gyroscope's first axis; the others follow.
pub const GYRO: usize = 4;
/// Slot of the temperature.
pub const TEMPERATURE: usize = 7;
/// A number of at least this magnitude, including infinity, is not a reading or a time and counts
/// as an empty field. Below it, squares, differences and sums of values stay finite.
const TOO_LARGE: f64 = 1e100;
/// Field that is not read.
const SKIP: u8 = u8::MAX;
/// Field that holds the label.
const LABEL: u8 = u8::MAX - 1;
/// Field that holds the number of the sensor.
const INSTANCE: u8 = u8::MAX - 2;

/// Field that holds the fraction of a second of the time stamp.
const FRACTION: u8 = u8::MAX - 3;

/// Numbers of one row, by slot; NaN if absent.
pub type Values = [f64; SLOTS];

/// Separator of the fields of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// One byte, with spaces around it tolerated.
    Byte(u8),
    /// Any run of spaces and tabs.
    Whitespace,
}

impl Delimiter {
    /// Name for messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Delimiter::Byte(b',') => "comma",
            Delimiter::Byte(b';') => "semicolon",
            Delimiter::Byte(b'\t') => "tab",
            Delimiter::Byte(b'|') => "bar",
            Delimiter::Byte(_) => "other",
            Delimiter::Whitespace => "white space",
        }
    }
}

/// Why a line is not a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowDefect {
    /// Fewer fields than the others.
    TooFewFields,
    /// More fields than the others.
    TooManyFields,
    /// This field (from 0) of a channel is not a number.
    NotANumber(usize),
    /// All channels are empty.
    Blank,
    /// A row of another sensor.
    OtherSensor,
}

/// Parses lines.
#[derive(Debug, Clone)]
pub struct RowScanner {
    delimiter: Delimiter,
    decimal_comma: bool,
    slot_of_field: Vec<u8>,
    /// Settings of the board whose counts the temperatures are.
    temperature_counts: Option<BoardSettings>,
    instance: f64,
    /// Size in s of one unit of the fraction field.
    fraction_s: f64,
    /// Dates have the day before the month.
    day_first: bool,
}

/// Computes time stamps from the time column: differences from row to row are summed, time stamps
/// are left unchanged.
#[derive(Debug, Clone)]
pub struct RowStamps {
    sum: Option<f64>,
}

impl RowStamps {
    /// `sums`: the column holds differences.
    #[must_use]
    pub fn new(sums: bool) -> Self {
        RowStamps {
            sum: sums.then_some(0.0),
        }
    }

    /// True if the time of a row depends on all rows before it.
    #[must_use]
    pub fn sums(&self) -> bool {
        self.sum.is_some()
    }

    /// Processes the next row.
    #[inline]
    pub fn stamp(&mut self, values: &mut Values) {
        if let Some(sum) = &mut self.sum {
            let step = values[TIME];
            *sum += if step.is_finite() { step } else { 0.0 };
            values[TIME] = if step.is_finite() { *sum } else { f64::NAN };
        }
    }
}

/// Byte range of a field within its line.
pub type Span = (u32, u32);

impl RowScanner {
    /// A scanner for lines of `fields` fields; channels are assigned afterwards.
    #[must_use]
    pub fn new(delimiter: Delimiter, decimal_comma: bool, fields: usize) -> Self {
        RowScanner {
            delimiter,
            decimal_comma,
            slot_of_field: vec![SKIP; fields],
            temperature_counts: None,
            instance: f64::NAN,
            fraction_s: 0.0,
            day_first: false,
        }
    }

    /// Dates have the day before the month.
    pub fn set_day_first(&mut self, day_first: bool) {
        self.day_first = day_first;
    }

    /// Field `field` is read into `slot`.
    pub fn assign(&mut self, field: usize, slot: usize) {
        if let Some(entry) = self.slot_of_field.get_mut(field) {
            *entry = slot as u8;
        }
    }

    /// Field `field` is the label.
    pub fn assign_label(&mut self, field: usize) {
        if let Some(entry) = self.slot_of_field.get_mut(field) {
            *entry = LABEL;
        }
    }

    /// Only rows with the value `instance` in field `field` are read.
    pub fn assign_instance(&mut self, field: usize, instance: f64) {
        if let Some(entry) = self.slot_of_field.get_mut(field) {
            *entry = INSTANCE;
        }
        self.instance = instance;
    }

    /// Field `field` holds the fraction of a second of the time stamp, in units of `unit_s`.
    pub fn assign_fraction(&mut self, field: usize, unit_s: f64) {
        if let Some(entry) = self.slot_of_field.get_mut(field) {
            *entry = FRACTION;
        }
        self.fraction_s = unit_s;
    }

    /// Temperatures are counts of the sensor of this board. They are converted to °C.
    pub fn convert_temperature(&mut self, board: BoardSettings) {
        self.temperature_counts = Some(board);
    }

    /// Number of fields of a row.
    #[must_use]
    pub fn fields(&self) -> usize {
        self.slot_of_field.len()
    }

    /// Parses a row; `label` gets the range of the label field.
    ///
    /// # Errors
    ///
    /// The first defect of the line. Values before it are left in `values`.
    #[inline]
    pub fn scan(
        &self,
        line: &[u8],
        values: &mut Values,
        label: &mut Span,
    ) -> Result<(), RowDefect> {
        match self.delimiter {
            Delimiter::Byte(d) => self.scan_with(Delimiter::Byte(d), line, values, label, |_| {}),
            white => self.scan_with(white, line, values, label, |_| {}),
        }
    }

    /// `delimiter` is that of `self`. Compiled separately for each kind, to keep the check out of
    /// the loop over the fields.
    #[inline(always)]
    fn scan_with(
        &self,
        delimiter: Delimiter,
        line: &[u8],
        values: &mut Values,
        label: &mut Span,
        mut on_field: impl FnMut(Span),
    ) -> Result<(), RowDefect> {
        *values = [f64::NAN; SLOTS];
        let mut at = 0;
        let mut any = false;
        let mut field = 0;
        let mut fraction = 0.0;
        let mut is_of_sensor = true;
        loop {
            at = skip_spaces(line, at, delimiter);
            // White space at the end of a line does not begin another field.
            if at == line.len() && delimiter == Delimiter::Whitespace {
                break;
            }
            let Some(&slot) = self.slot_of_field.get(field) else {
                return Err(self.judge_surplus(&line[at..], any));
            };
            let from = at;
            let end;
            if usize::from(slot) < SLOTS {
                // The common case in one pass: the number ends where the field ends.
                match scan_number(&line[at..]) {
                    Some((value, n))
                        if value.abs() < TOO_LARGE && ends_field(line, at + n, delimiter) =>
                    {
                        end = at + n;
                        values[usize::from(slot)] = value;
                        any = true;
                    }
                    _ => {
                        end = self.field_end(line, at);
                        if let Some(value) = self.parse_slowly(&line[at..end], field)? {
                            values[usize::from(slot)] = value;
                            any = true;
                        }
                    }
                }
            } else {
                end = self.field_end(line, at);
                if slot == LABEL {
                    *label = (from as u32, end as u32);
                } else if slot == INSTANCE {
                    is_of_sensor = self.is_of_sensor(&line[at..end])?;
                } else if slot == FRACTION {
                    fraction = Self::below_a_second(&line[at..end]);
                }
            }
            on_field((from as u32, end as u32));
            field += 1;
            at = match delimiter {
                Delimiter::Whitespace => end,
                Delimiter::Byte(_) if end == line.len() => break,
                Delimiter::Byte(_) => end + 1,
            };
        }
        if field < self.slot_of_field.len() {
            return Err(if any || line.iter().any(|b| b.is_ascii_alphanumeric()) {
                RowDefect::TooFewFields
            } else {
                RowDefect::Blank
            });
        }
        if self.fraction_s > 0.0 {
            values[TIME] += fraction * self.fraction_s;
        }
        if let Some(board) = self.temperature_counts {
            values[TEMPERATURE] = board.celsius(values[TEMPERATURE]);
        }
        match (any, is_of_sensor) {
            (false, _) => Err(RowDefect::Blank),
            (true, false) => Err(RowDefect::OtherSensor),
            (true, true) => Ok(()),
        }
    }

    #[inline]
    fn field_end(&self, line: &[u8], from: usize) -> usize {
        match self.delimiter {
            Delimiter::Byte(d) => {
                if line.get(from) == Some(&b'"') {
                    return quoted_end(line, from, d);
                }
                memchr::memchr(d, &line[from..]).map_or(line.len(), |n| from + n)
            }
            Delimiter::Whitespace => {
                memchr::memchr2(b' ', b'\t', &line[from..]).map_or(line.len(), |n| from + n)
            }
        }
    }

    /// Without a number the row may be blank, which is detected at its end.
    fn is_of_sensor(&self, field: &[u8]) -> Result<bool, RowDefect> {
        match parse_field(field) {
            Some(value) if value != self.instance => Err(RowDefect::OtherSensor),
            number => Ok(number.is_some()),
        }
    }

    /// Kept out of the loop, which it would slow down.
    #[cold]
    #[inline(never)]
    fn below_a_second(field: &[u8]) -> f64 {
        parse_field(field).unwrap_or(f64::NAN)
    }

    /// Defect of a line with too many fields; a row of delimiters is blank.
    #[cold]
    fn judge_surplus(&self, rest: &[u8], any: bool) -> RowDefect {
        if !any && !rest.iter().any(|b| b.is_ascii_alphanumeric()) {
            RowDefect::Blank
        } else {
            RowDefect::TooManyFields
        }
    }

    /// Parses everything except plain numbers: quotes, white space, decimal commas, words for a
    /// missing value, dates.
    #[cold]
    fn parse_slowly(&self, field: &[u8], index: usize) -> Result<Option<f64>, RowDefect> {
        let text = field.trim_ascii();
        let text = match text {
            [b'"', inner @ .., b'"'] => inner.trim_ascii(),
            other => other,
        };
        if text.is_empty() || is_missing_value(text) {
            return Ok(None);
        }
        let number = if self.decimal_comma {
            parse_field_decimal_comma(text).or_else(|| parse_field(text))
        } else {
            parse_field(text)
        };
        if let Some(value) = number {
            return Ok((value.abs() < TOO_LARGE).then_some(value));
        }
        // A row is valid without its time stamp or temperature.
        match self.slot_of_field.get(index).map(|slot| usize::from(*slot)) {
            Some(TIME) if self.day_first => Ok(parse_date_day_first(text)),
            Some(TIME) => Ok(parse_date(text)),
            Some(TEMPERATURE) => Ok(None),
            _ => Err(RowDefect::NotANumber(index)),
        }
    }
}

#[inline(always)]
fn ends_field(line: &[u8], at: usize, delimiter: Delimiter) -> bool {
    match (line.get(at), delimiter) {
        (None, _) => true,
        (Some(&b), Delimiter::Byte(d)) => b == d,
        (Some(&b), Delimiter::Whitespace) => b == b' ' || b == b'\t',
    }
}

#[inline(always)]
fn skip_spaces(line: &[u8], mut at: usize, delimiter: Delimiter) -> usize {
    while let Some(&b) = line.get(at) {
        let space = b == b' ' || (b == b'\t' && delimiter != Delimiter::Byte(b'\t'));
        if !space {
            break;
        }
        at += 1;
    }
    at
}

/// End of a quoted field; `""` inside is one quote.
#[cold]
pub(super) fn quoted_end(line: &[u8], from: usize, delimiter: u8) -> usize {
    let mut at = from + 1;
    while let Some(n) = memchr::memchr(b'"', &line[at..]) {
        at += n + 1;
        match line.get(at) {
            Some(b'"') => at += 1,
            _ => return memchr::memchr(delimiter, &line[at..]).map_or(line.len(), |n| at + n),
        }
    }
    // A quote that is never closed is an ordinary character.
    memchr::memchr(delimiter, &line[from..]).map_or(line.len(), |n| from + n)
}

/// Words that programs and boards write for a missing value.
#[must_use]
pub fn is_missing_value(text: &[u8]) -> bool {
    [
        "nan",
        "na",
        "n/a",
        "null",
        "none",
        "-",
        "inf",
        "-inf",
        "+inf",
        "ovf",
        "-nan",
        "nan(ind)",
        "-nan(ind)",
    ]
    .iter()
    .any(|word| text.eq_ignore_ascii_case(word.as_bytes()))
}
