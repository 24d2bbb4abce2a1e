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
    let lines = text.split('\n').map(|line| {
        let coloured = one(line, after_blank);
        after_blank = line.is_empty();
        coloured
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn one(line: &str, after_blank: bool) -> String {
    if let Some(grade) = line.strip_prefix("Verdict: ") {
        let style = match grade {
            "good" | "fits" | "agree" | "bounded" => GOOD,
            "poor" | "does not fit" | "differ" | "not usable" => BAD,
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
