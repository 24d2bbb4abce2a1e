//! The summary of a run: a row for each item, as CSV or JSON.

use std::io::Write;
use std::path::Path;

use gravical::cohort::{Cohort, FORMAT, Gathered, Row, columns};
use gravical::escape::shown_json;
use gravical::{Error, Result, TOOL};
use serde::Serialize;

use super::words::Words;
use crate::table::write_file;

/// Format of a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Csv,
    Json,
}

impl Form {
    /// From the ending of the file.
    ///
    /// # Errors
    ///
    /// `summary-target` (usage).
    pub fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("csv") => Ok(Form::Csv),
            Some("json") => Ok(Form::Json),
            _ => Err(Error::usage(
                "summary-target",
                "the format of the summary is not clear from this name",
            )
            .at(path, None)
            .with_hint("use a name that ends in .csv or .json")),
        }
    }
}

/// How many items came to which end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub done: u64,
    pub poor: u64,
    pub error: u64,
}

/// Writes rows as they come.
pub struct Writer<'a> {
    path: &'a Path,
    columns: Vec<&'static str>,
    inner: Inner<'a>,
}

enum Inner<'a> {
    Csv(Box<csv::Writer<&'a mut dyn Write>>),
    Json { out: &'a mut dyn Write, rows: u64 },
}

impl<'a> Writer<'a> {
    /// Begins the summary of a run with these options, and with the columns `own` behind the
    /// common ones.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn new(
        path: &'a Path,
        form: Form,
        words: &Words,
        own: &[&'static str],
        out: &'a mut dyn Write,
    ) -> Result<Self> {
        let columns = columns(own);
        let inner = match form {
            Form::Csv => {
                let mut csv = csv::Writer::from_writer(out);
                let header = csv.write_record(&columns);
                header.map_err(|e| Error::io(path, e.into()))?;
                Inner::Csv(Box::new(csv))
            }
            Form::Json => {
                write!(
                    out,
                    "{{\n  \"format\": {},\n  \"tool\": {},\n  \"command\": {},\n  \"options\": {},\n  \"rows\": [",
                    json(&FORMAT, path)?,
                    json(&TOOL, path)?,
                    json(&words.verb, path)?,
                    json(&words.options, path)?
                )
                .map_err(|e| Error::io(path, e))?;
                Inner::Json { out, rows: 0 }
            }
        };
        Ok(Writer {
            path,
            columns,
            inner,
        })
    }

    /// Writes the row of the next item.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn row<V: Serialize>(&mut self, row: &Row<V>) -> Result<()> {
        let path = self.path;
        match &mut self.inner {
            Inner::Csv(csv) => {
                let fields = row
                    .fields(&self.columns)
                    .map_err(|e| Error::io(path, e.into()))?;
                csv.write_record(fields)
                    .map_err(|e| Error::io(path, e.into()))
            }
            Inner::Json { out, rows } => {
                let comma = if *rows > 0 { "," } else { "" };
                *rows += 1;
                write!(out, "{comma}\n    {}", json(row, path)?).map_err(|e| Error::io(path, e))
            }
        }
    }

    /// Ends the summary.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn finish(self, counts: &Counts) -> Result<()> {
        let path = self.path;
        match self.inner {
            Inner::Csv(mut csv) => csv.flush(),
            Inner::Json { out, .. } => {
                writeln!(out, "\n  ],\n  \"counts\": {}\n}}", json(counts, path)?)
            }
        }
        .map_err(|e| Error::io(path, e))
    }
}

/// Writes what many runs did as one summary.
///
/// # Errors
///
/// `summary-target`; errors of reading and writing.
pub fn write_table(path: &Path, force: bool, gathered: &Gathered) -> anyhow::Result<Cohort> {
    let form = Form::of(path)?;
    let words = Words {
        verb: gathered.table().command.to_owned(),
        options: gathered.options().to_vec(),
    };
    write_file(path, force, |out| {
        let mut writer = Writer::new(path, form, &words, gathered.table().names, out)?;
        let cohort = gathered.summarise(|row| writer.row(row))?;
        writer.finish(&Counts {
            done: cohort.counts.done,
            poor: cohort.counts.poor,
            error: cohort.counts.error + cohort.counts.missing - cohort.counts.unnamed,
        })?;
        Ok(cohort)
    })
}

/// On one line, control characters escaped.
fn json(value: &impl Serialize, path: &Path) -> Result<String> {
    let text = serde_json::to_string(value).map_err(|e| Error::io(path, e.into()))?;
    Ok(shown_json(&text).into_owned())
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use gravical::cohort::Columns as _;

    use super::super::tests::{Length, row};
    use super::*;

    fn written(form: Form) -> String {
        let words = Words {
            verb: "calibrate".to_owned(),
            options: vec!["--gravity=9.81".to_owned()],
        };
        let mut out = Vec::new();
        let path = Path::new("s");
        let mut writer = Writer::new(path, form, &words, Length::NAMES, &mut out).unwrap();
        writer.row(&row("a, b", Some(0.1))).unwrap();
        writer.row(&row("c", None)).unwrap();
        let counts = Counts {
            done: 2,
            ..Counts::default()
        };
        writer.finish(&counts).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn one_row_an_item() {
        assert_eq!(
            written(Form::Csv),
            "name,path,status,verdict,reason,error_code,hint,same_content_as,result,sha256,length_m\n\
             \"a, b\",\"in/a, b.csv\",done,good,,,,,,00,0.1\n\
             c,in/c.csv,done,good,,,,,,00,\n"
        );
        let value: Value = serde_json::from_str(&written(Form::Json)).unwrap();
        assert_eq!(value["rows"][0]["length_m"], 0.1);
        assert_eq!(
            (&value["counts"]["done"], &value["command"]),
            (&2.into(), &"calibrate".into())
        );
        assert_eq!(Form::of(Path::new("a.CSV")).unwrap(), Form::Csv);
        assert_eq!(
            Form::of(Path::new("a.txt")).unwrap_err().code(),
            "summary-target"
        );
    }
}
