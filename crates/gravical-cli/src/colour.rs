//! Colours for text reports, line by line. The writer removes them for `NO_COLOR`, pipes and
//! files.

use anstyle::{AnsiColor, Style};

const GOOD: Style = AnsiColor::Green.on_default().bold();
const CAUTION: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const BOLD: Style = Style::new().bold();

/// The same lines with verdicts, warnings and headings coloured.
pub fn report(text: &str) -> String {
    let mut after_blank = false;
    let mut out = String::with_capacity(text.len() + 256);
    for line in text.split_inclusive('\n') {
        let (body, end) = match line.strip_suffix('\n') {
            Some(body) => (body, "\n"),
            None => (line, ""),
        };
        out.push_str(&one(body, after_blank));
        out.push_str(end);
        after_blank = body.is_empty();
    }
    out
}

fn one(line: &str, after_blank: bool) -> String {
    if let Some(grade) = line.strip_prefix("Verdict: ") {
        let style = match grade {
            "good" | "fits" | "agree" | "bounded" | "unchanged" => GOOD,
            "poor" | "does not fit" | "differ" | "not usable" | "changed" => BAD,
            _ => CAUTION,
        };
        return format!("{BOLD}Verdict:{BOLD:#} {style}{grade}{style:#}");
    }
    if let Some((kind, rest)) = line.strip_prefix("  ! ").and_then(|w| w.split_once(':')) {
        return format!("  {CAUTION}! {kind}:{CAUTION:#}{rest}");
    }
    // A heading ends before its unit or note.
    if after_blank && line.starts_with(|c: char| c.is_ascii_uppercase()) {
        let length = line.find([':', ',', '(']).unwrap_or(line.len());
        let (heading, rest) = line.split_at(length);
        return format!("{BOLD}{heading}{BOLD:#}{rest}");
    }
    line.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a.csv\n  still   100 %\n\nFindings\n  ! gap: 3 rows: lost\n\nVerdict: poor\n  - why\n\nMoves, m (± 1σ)\n";

    #[test]
    fn nothing_but_colours_is_added() {
        let plain = anstream::adapter::strip_str(&report(TEXT)).to_string();
        assert_eq!(plain, TEXT);
    }

    #[test]
    fn verdicts_warnings_and_headings_stand_out() {
        let text = report(TEXT);
        assert!(text.contains("\u{1b}[31m") && text.contains("\u{1b}[33m"));
        assert!(text.contains("! gap:\u{1b}[0m 3 rows: lost"));
        assert!(text.contains("\u{1b}[1mMoves\u{1b}[0m, m"));
        assert!(
            text.starts_with("a.csv\n  still   100 %\n"),
            "data stay plain"
        );
        assert!(report("Verdict: good").contains("\u{1b}[32m"));
    }
}
