//! Errors of the JSON parser in words.

use std::path::Path;

use serde_json::error::Category;

use crate::Error;

/// Messages of the parser about JSON itself, and what they mean.
const MEANING: [(&str, &str); 8] = [
    ("expected value", "a value is missing"),
    ("expected ident", "a word without double quotes"),
    ("key must be a string", "a name without double quotes"),
    ("trailing comma", "a comma before a closing bracket"),
    ("trailing characters", "text after the last bracket"),
    ("expected `:`", "a colon is missing"),
    ("expected `,` or `}`", "a comma or } is missing"),
    ("expected `,` or `]`", "a comma or ] is missing"),
];

/// `calibration-syntax` (input) with line and column; the file is for the caller to add.
pub(super) fn syntax(error: &serde_json::Error) -> Error {
    let (line, column) = (error.line() as u64, error.column() as u64);
    let text = error.to_string();
    let detail = text
        .strip_suffix(&format!(" at line {line} column {column}"))
        .unwrap_or(&text);
    let message = match error.classify() {
        Category::Eof if line <= 1 && column == 0 => "the file is empty".to_owned(),
        Category::Eof => {
            "this is not a calibration file: the JSON ends before its last bracket".to_owned()
        }
        Category::Syntax | Category::Io => {
            let known = MEANING.iter().find(|(said, _)| detail == *said);
            let detail = known.map_or(detail, |(_, means)| means);
            format!("this is not a calibration file: not JSON ({detail})")
        }
        Category::Data => format!("this is not a valid calibration: {}", field(detail)),
    };
    let mut out = Error::input("calibration-syntax", message);
    if line > 0 {
        out = out.at(Path::new(""), Some(line));
    }
    if column > 0 {
        out = out.at_column(column);
    }
    out.with_hint(
        "a calibration is what `gravical calibrate … -o cal.json` writes, or a file of imucal",
    )
}

/// What is wrong with a field.
fn field(detail: &str) -> String {
    if let Some(name) = detail.strip_prefix("missing field ") {
        return format!("the field {name} is missing");
    }
    match detail
        .strip_prefix("invalid type: ")
        .and_then(|rest| rest.split_once(", expected "))
    {
        Some((found, wanted)) => format!("{found} in place of {wanted}"),
        None => detail.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use crate::calibration_file::CalibrationFile;

    #[test]
    fn errors_of_the_parser_are_in_words() {
        const FORMAT: &str = "\"format\": \"gravical-calibration/2\"";
        for (text, wanted) in [
            ("", "the file is empty"),
            (
                "{\n\"format\": \n",
                "3: this is not a calibration file: the JSON ends before",
            ),
            (
                "t,ax,ay,az\n",
                "1:2: this is not a calibration file: not JSON (a word without",
            ),
            (
                "{\"a\": 1,}",
                "1:9: this is not a calibration file: not JSON (a comma before",
            ),
            (
                &format!("{{{FORMAT}}}"),
                "this is not a valid calibration: the field `created` is missing",
            ),
            (
                &format!("{{{FORMAT},\n\"created\": 3}}"),
                "2:12: this is not a valid calibration: integer `3` in place of a string",
            ),
            (
                "{\"K_a\": 3}",
                "this is not a valid calibration: integer `3` in place of an array of length 3",
            ),
        ] {
            let error = CalibrationFile::parse(text.as_bytes()).unwrap_err();
            assert_eq!(error.code(), "calibration-syntax");
            let said = error.to_string();
            assert!(said.contains(wanted), "{text}: {said}");
        }
    }
}
