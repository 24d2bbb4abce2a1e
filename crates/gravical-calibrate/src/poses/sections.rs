//! Sections that the user gives: imucal's list, or a table
//! `label,start,end`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;

use crate::calibration_file::{InputFile, InputRole};
use crate::problem::Problem;
use crate::{Error, Result};
use gravical_recording::source::Named;

/// A stretch of rows with a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// `x_p`, `z_rot`, `pose 7` ….
    pub label: String,
    /// Rows from 0, the end exclusive.
    pub rows: Range<usize>,
}

/// Names of the column with the labels, the likeliest first; the index of a data frame has none.
const LABELS: [&str; 9] = [
    "label",
    "part",
    "section",
    "pose",
    "face",
    "placement",
    "name",
    "s_id",
    "",
];

/// A section as it is written.
#[derive(Deserialize)]
struct Row {
    label: String,
    start: f64,
    #[serde(alias = "stop")]
    end: f64,
}

/// A section that is named outside.
#[derive(Deserialize)]
struct Limits {
    start: f64,
    #[serde(alias = "stop")]
    end: f64,
}

/// Reads a section list, and says which file it was. JSON: `{"x_p": {"start": 540, "end": 1271}, …}`
/// as imucal writes it, or a list of `{"label", "start", "end"}`; CSV: `label,start,end` on each
/// line, with or without a header. Rows are counted from 0, the end is exclusive.
///
/// # Errors
///
/// `sections-syntax` (input) with the line, `sections-empty`, `sections-order` if a section ends
/// before it starts.
pub fn read_sections<'a>(file: impl Into<Named<'a>>) -> Result<(Vec<Section>, InputFile)> {
    InputFile::read(file, InputRole::Sections, parse_sections)
}

/// The same from memory.
///
/// # Errors
///
/// As [`read_sections`].
pub fn parse_sections(bytes: &[u8]) -> Result<Vec<Section>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes.iter().copied().find(|b| !b.is_ascii_whitespace());
    let rows = match first {
        None => Vec::new(),
        Some(first @ (b'{' | b'[')) => from_json(bytes, first == b'[')?,
        Some(_) => from_csv(bytes)?,
    };
    if rows.is_empty() {
        return Err(Problem::NoSection.error());
    }
    rows.into_iter().map(section).collect()
}

fn syntax(why: String, line: Option<u64>) -> Error {
    let error = Problem::NoSectionList { why }.error();
    error.at(Path::new(""), line)
}

/// Sections with their lines, where known.
type Rows = Vec<(Row, Option<u64>)>;

fn from_json(bytes: &[u8], is_list: bool) -> Result<Rows> {
    let wrong = |e: serde_json::Error| syntax(e.to_string(), Some(e.line() as u64));
    let rows: Vec<Row> = if is_list {
        serde_json::from_slice(bytes).map_err(wrong)?
    } else {
        let named: BTreeMap<String, Limits> = serde_json::from_slice(bytes).map_err(wrong)?;
        let row = |(label, Limits { start, end })| Row { label, start, end };
        let mut rows: Vec<Row> = named.into_iter().map(row).collect();
        // An object has no order: that of the recording.
        rows.sort_by(|a, b| a.start.total_cmp(&b.start));
        rows
    };
    Ok(rows.into_iter().map(|row| (row, None)).collect())
}

fn from_csv(bytes: &[u8]) -> Result<Rows> {
    let mut delimiters = [b';', b'\t'].into_iter();
    let delimiter = delimiters.find(|d| bytes.contains(d)).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(bytes);
    let mut names = csv::StringRecord::from(vec!["label", "start", "end"]);
    let mut rows = Vec::new();
    for (at, record) in reader.records().enumerate() {
        let wrong = |e: &csv::Error| syntax(e.to_string(), e.position().map(csv::Position::line));
        let record = record.map_err(|e| wrong(&e))?;
        let has = |name: &str| record.iter().any(|field| field.eq_ignore_ascii_case(name));
        if at == 0 && has("start") && (has("end") || has("stop")) {
            let label = LABELS.into_iter().find(|name| has(name));
            let name = |field: &str| match label {
                Some(label) if field.eq_ignore_ascii_case(label) => "label".to_owned(),
                _ => field.to_lowercase(),
            };
            names = record.iter().map(name).collect();
            continue;
        }
        let line = record.position().map(csv::Position::line);
        let row = record.deserialize(Some(&names));
        rows.push((row.map_err(|e| syntax(e.to_string(), line))?, line));
    }
    Ok(rows)
}

fn section((row, line): (Row, Option<u64>)) -> Result<Section> {
    let Row { label, start, end } = row;
    let whole = |v: f64| v.fract() == 0.0 && (0.0..9.0e15).contains(&v);
    if !whole(start) || !whole(end) {
        let problem = Problem::NotWhole { label, start, end };
        return Err(problem.error().at(Path::new(""), line));
    }
    if end <= start {
        let problem = Problem::SectionEndsFirst { label, start, end };
        return Err(problem.error().at(Path::new(""), line));
    }
    Ok(Section {
        label,
        rows: start as usize..end as usize,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_says_the_same() {
        for text in [
            r#"{"x_p":{"start":540,"end":1271},"x_rot":{"start":6770,"end":7093}}"#,
            r#"[{"label":"x_p","start":540,"end":1271},{"label":"x_rot","start":6770,"end":7093}]"#,
            "label,start,end\nx_p,540,1271\nx_rot, 6770, 7093\n",
            ",start,end\nx_p,540,1271\nx_rot,6770,7093\n",
            "start;end;label\n540;1271;x_p\n6770;7093;x_rot",
        ] {
            let sections = parse_sections(text.as_bytes()).unwrap();
            let found = sections.iter().map(|s| (&*s.label, s.rows.clone()));
            let expected = [("x_p", 540..1271_usize), ("x_rot", 6770..7093)];
            assert!(found.eq(expected), "{text}: {sections:?}");
        }
        for text in ["  \n", "[]"] {
            let error = parse_sections(text.as_bytes()).unwrap_err();
            assert_eq!(error.code(), "sections-empty");
        }
    }
}
