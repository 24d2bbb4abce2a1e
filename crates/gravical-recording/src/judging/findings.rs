//! What columns and lines tell.

use crate::finding::{Case, Finding, FindingKind};
use crate::judge;
use crate::role::Role;
use crate::spans::LineSpans;
use crate::text::{CALIBRATED, Format, Ledger, Reason, Rows};
use crate::write::input_name;

/// Columns that a finding names.
const MAX_NAMED: usize = 12;

/// Which columns are read, where that is not sure, and which are not.
pub(super) fn of_columns(format: &Format) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut sensors = format.sensors.iter().enumerate();
    let other = sensors.find(|(i, _)| *i != format.chosen);
    if let (Some(read), Some((_, other))) = (format.sensors.get(format.chosen), other) {
        let count = format.sensors.len();
        let all = format.sensors.join(", ");
        findings.push(raw_and_calibrated(format).unwrap_or_else(|| {
            let text = format!("{count} accelerometers: {all}; {read} is read");
            if format.chosen > 0 {
                let why = "of those before none answers and shows gravity at rest";
                return Finding::new(FindingKind::SeveralSensors, format!("{text}: {why}"));
            }
            let text = format!("{text}, unless another is chosen");
            Finding::new(FindingKind::SeveralSensors, text).advise("sensor", other)
        }));
    }
    if let Some(gravity) = format.added {
        let [read, added] = [format.accel, gravity].map(|axes| name(format, axes[0]).to_owned());
        let text = format!(
            "the acceleration ({read} …) lacks gravity, which stands in other columns ({added} …): their sum is read"
        );
        findings.push(Finding::new(FindingKind::SeveralSensors, text));
    }
    if !format.unread.is_empty() {
        let unread = format.unread.iter();
        let more = (unread.len() > MAX_NAMED).then(|| "…".to_owned());
        let names = unread.map(|c| input_name(format, *c));
        let names: Vec<String> = names.take(MAX_NAMED).chain(more).collect();
        let names = names.join(", ");
        let text = format!("columns of numbers that are not read: {names}");
        findings.push(Finding::new(FindingKind::ColumnsUnread, text));
    }
    if format.is_guessed {
        let why = format.misfit.as_deref().unwrap_or("no header");
        let text = format!("{why}; assigned by the numbers; give the columns to be sure");
        let guessed = Finding::new(FindingKind::ColumnsGuessed, text);
        findings.push(guessed.advise("columns", spec(format)));
    }
    if let [first, others @ ..] = &format.unnamed_clocks[..] {
        let clocks = format.unnamed_clocks.iter();
        let names: Vec<&str> = clocks.map(|c| name(format, *c)).collect();
        let what = match others {
            [] => "rises steadily and is used as the time",
            _ => "rise steadily: each could be the time, and none is used",
        };
        let text = format!(
            "no column is named as the time; {} {what}; name the one that is",
            names.join(", ")
        );
        let column = format!("t={}", name(format, *first));
        findings.push(Finding::new(FindingKind::UnnamedClock, text).advise("columns", column));
    }
    findings
}

fn name(format: &Format, column: usize) -> &str {
    format.names.get(column).map_or("", String::as_str)
}

/// A table of this program holds both.
fn raw_and_calibrated(format: &Format) -> Option<Finding> {
    let has = |own: &&[&str; 3]| own.iter().all(|own| format.names.iter().any(|n| n == own));
    let [x, y, z] = CALIBRATED.iter().find(has)?;
    let read = name(format, format.accel[0]);
    (read != *x).then(|| {
        let text = format!("a table of this program with raw and calibrated columns: the raw ones ({read} …) are read, unless the calibrated ones are named");
        let columns = format!("ax={x},ay={y},az={z}");
        Finding::new(FindingKind::SeveralSensors, text).advise("columns", columns)
    })
}

/// The columns as their option names them.
fn spec(format: &Format) -> String {
    let channel = |c: usize| match format.role(c) {
        role @ (Role::Accel(_) | Role::Gyro(_) | Role::Temperature) => role.name(c),
        // Of several the clock is found again.
        Role::Time if format.only_clock().is_none() => "_".to_owned(),
        Role::Time => "t".to_owned(),
        _ => "-".to_owned(),
    };
    let all: Vec<String> = (0..format.columns.len()).map(channel).collect();
    all.join(",")
}

/// Columns that were taken for an accelerometer by their numbers alone and do not behave like one:
/// an accelerometer always measures gravity, so that its magnitudes at rest and in motion are
/// similar.
pub(super) fn not_an_accelerometer(accel: &[Vec<f64>; 3]) -> Option<Finding> {
    let quiet = judge::quiet_norm(accel.each_ref().map(Vec::as_slice))?;
    let norm = |row: usize| accel.iter().map(|c| c[row] * c[row]).sum::<f64>().sqrt();
    let norms = (0..accel[0].len()).map(norm);
    let mut norms: Vec<f64> = norms.filter(|n| n.is_finite()).collect();
    let at = ((norms.len() * 49) / 50).min(norms.len().checked_sub(1)?);
    let high = *norms.select_nth_unstable_by(at, f64::total_cmp).1;
    (high > 4.0 * quiet).then(|| {
        let text = format!(
            "the magnitude is {quiet:.0} at rest and up to {high:.0} in motion: these columns look like a gyroscope"
        );
        Finding::new(FindingKind::NotAnAccelerometer, text)
    })
}

/// Cells of the channels that hold text.
pub(super) fn of_text_cells(format: &Format, rows: &Rows) -> Option<Finding> {
    let mut lines = Vec::new();
    let mut first = None;
    for column in format.channels() {
        let codes = rows.texts[column].iter().enumerate();
        for (row, code) in codes.filter(|(_, c)| **c > 0) {
            lines.push(u64::from(rows.lines[row]));
            first = first.or(rows.words[column].get(usize::from(*code) - 1));
        }
    }
    lines.sort_unstable();
    let cells = lines.len();
    lines.dedup();
    let first = first?;
    let text = format!(
        "{cells} cells hold text where the rows have numbers; they are empty, first: \"{first}\""
    );
    Some(Finding::new(FindingKind::NotANumber, text).at_lines(&lines.into_iter().collect()))
}

/// Lines that were set aside; none for those that every good file has, `blanks`: unless blank lines are.
pub(crate) fn of_lines(ledger: &Ledger, nul_lines: &LineSpans, blanks: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (reason, aside) in &ledger.reasons {
        // Kinds have the names of the reasons.
        let kind = FindingKind::ALL
            .iter()
            .find(|k| k.to_string() == reason.name());
        let Some(kind) = kind.filter(|_| blanks || *reason != Reason::Blank) else {
            continue;
        };
        let example = match reason {
            Reason::NamedGap | Reason::TornLine | Reason::TooManyFields | Reason::NotANumber => {
                format!(", first: \"{}\"", aside.first)
            }
            _ if reason.is_block() => format!(", first: {}", aside.first),
            _ => String::new(),
        };
        let noun = if reason.is_block() { "block" } else { "line" };
        let n = aside.lines.count();
        let plural = if n == 1 { "" } else { "s" };
        let text = format!("{n} {noun}{plural}: {}{example}", reason.meaning());
        findings.push(Finding::new(*kind, text).at_lines(&aside.lines));
    }
    if !nul_lines.is_empty() {
        let lines = nul_lines.count();
        findings.push(Case::NulBytes { lines }.finding().at_lines(nul_lines));
    }
    findings
}
