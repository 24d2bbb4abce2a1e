//! Sections that the user gives: imucal's list, or a table
//! `label,start,end`.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;

use crate::calibration_file::{InputFile, InputRole};
use crate::{Error, Result};

/// A stretch of rows with a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// `x_p`, `z_rot`, `pose 7` ….
    pub label: String,
    /// Rows from 0, the end exclusive.
    pub rows: Range<usize>,
}

#[derive(Deserialize)]
struct Limits {
    start: f64,
    end: f64,
}

#[derive(Deserialize)]
struct Row {
    label: String,
    start: f64,
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
pub fn read_sections(path: &Path) -> Result<(Vec<Section>, InputFile)> {
    InputFile::read(path, InputRole::Sections, parse_sections)
}

/// The same from memory.
///
/// # Errors
///
/// As [`read_sections`].
pub fn parse_sections(bytes: &[u8]) -> Result<Vec<Section>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    let sections = match first {
        None => return Err(Error::input("sections-empty", "the section list is empty")),
        Some(b'{' | b'[') => from_json(bytes)?,
        Some(_) => from_csv(bytes)?,
    };
    if sections.is_empty() {
        return Err(Error::input(
            "sections-empty",
            "the section list has no section",
        ));
    }
    Ok(sections)
}

fn syntax(message: String, line: Option<u64>) -> Error {
    Error::input("sections-syntax", message)
        .at(Path::new(""), line)
        .with_hint("a section list is {\"x_p\": {\"start\": 0, \"end\": 500}, …} or lines of label,start,end")
}

fn from_json(bytes: &[u8]) -> Result<Vec<Section>> {
    let wrong = |e: serde_json::Error| syntax(e.to_string(), Some(e.line() as u64));
    let value: serde_json::Value = serde_json::from_slice(bytes).map_err(wrong)?;
    let list: Vec<Row> = match value {
        serde_json::Value::Object(map) => in_order(
            map.into_iter()
                .map(|(label, limits)| {
                    let limits: Limits = serde_json::from_value(limits)
                        .map_err(|e| syntax(format!("section \"{label}\": {e}"), None))?;
                    Ok(Row {
                        label,
                        start: limits.start,
                        end: limits.end,
                    })
                })
                .collect::<Result<_>>()?,
        ),
        other => serde_json::from_value(other).map_err(wrong)?,
    };
    list.iter().map(|row| section(row, None)).collect()
}

/// An object has no order: that of the recording.
fn in_order(mut list: Vec<Row>) -> Vec<Row> {
    list.sort_by(|a, b| a.start.total_cmp(&b.start));
    list
}

fn from_csv(bytes: &[u8]) -> Result<Vec<Section>> {
    let delimiter = [b';', b'\t']
        .into_iter()
        .find(|d| bytes.contains(d))
        .unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(bytes);
    let mut columns = [0, 1, 2];
    let mut sections = Vec::new();
    for (at, record) in reader.records().enumerate() {
        let record = record.map_err(|e| {
            let line = e.position().map(csv::Position::line);
            syntax(e.to_string(), line)
        })?;
        let line = record.position().map(csv::Position::line);
        if at == 0
            && let Some(found) = header(&record)
        {
            columns = found;
            continue;
        }
        let fields = columns.iter().map(|i| record.get(*i));
        let fields: csv::StringRecord = fields
            .collect::<Option<_>>()
            .ok_or_else(|| syntax("a line needs label, start and end".to_owned(), line))?;
        let row: Row = fields
            .deserialize(None)
            .map_err(|e| syntax(e.to_string(), line))?;
        sections.push(section(&row, line)?);
    }
    Ok(sections)
}

fn header(record: &csv::StringRecord) -> Option<[usize; 3]> {
    let find = |names: &[&str]| {
        record
            .iter()
            .position(|f| names.contains(&f.to_lowercase().as_str()))
    };
    let (start, end) = (find(&["start"])?, find(&["end", "stop"])?);
    let label = find(&["label", "part", "section", "name", "s_id", ""]).unwrap_or(0);
    Some([label, start, end])
}

fn section(row: &Row, line: Option<u64>) -> Result<Section> {
    let whole = |v: f64| v.fract() == 0.0 && (0.0..9.0e15).contains(&v);
    if !whole(row.start) || !whole(row.end) {
        return Err(syntax(
            format!(
                "section \"{}\": start {} and end {} have to be whole row numbers from 0",
                row.label, row.start, row.end
            ),
            line,
        ));
    }
    if row.end <= row.start {
        return Err(Error::input(
            "sections-order",
            format!(
                "section \"{}\" ends at {} and starts at {}: it has no rows",
                row.label, row.end, row.start
            ),
        )
        .at(Path::new(""), line)
        .with_hint("the end is exclusive: rows 0 to 499 are start 0, end 500"));
    }
    Ok(Section {
        label: row.label.clone(),
        rows: row.start as usize..row.end as usize,
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
            "start;end;label\n540;1271;x_p\n6770;7093;x_rot",
        ] {
            let sections = parse_sections(text.as_bytes()).unwrap().into_iter();
            let sections: Vec<_> = sections.map(|s| (s.label, s.rows)).collect();
            let expected = [("x_p", 540..1271), ("x_rot", 6770..7093)];
            assert_eq!(
                sections,
                expected.map(|(label, rows)| (label.to_owned(), rows)),
                "{text}"
            );
        }
        for text in ["  \n", "[]"] {
            let error = parse_sections(text.as_bytes()).unwrap_err();
            assert_eq!(error.code(), "sections-empty");
        }
    }
}
