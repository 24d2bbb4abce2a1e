//! What columns and lines tell.

use gravical_judge::finding::Case;
use gravical_judge::{self as judge, Finding, LineSpans, Role};

use crate::text::{CALIBRATED, Format, Ledger, Reason, Rows};
use crate::write::input_name;

/// Which columns are read, where that is not sure, and which are not.
pub(super) fn of_columns(format: &Format) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut sensors = format.sensors.iter().enumerate();
    let other = sensors.find(|(i, _)| *i != format.chosen);
    if let (Some(read), Some((_, other))) = (format.sensors.get(format.chosen), other) {
        let (sensors, read) = (format.sensors.clone(), read.clone());
        findings.push(raw_and_calibrated(format).unwrap_or_else(|| {
            if format.chosen > 0 {
                return Case::SilentSensors { sensors, read }.finding();
            }
            let several = Case::SeveralSensors { sensors, read }.finding();
            several.advise("sensor", other)
        }));
    }
    if let Some(gravity) = format.added {
        let [read, gravity] = [format.accel, gravity].map(|axes| name(format, axes[0]).to_owned());
        findings.push(Case::GravityAdded { read, gravity }.finding());
    }
    if !format.unread.is_empty() {
        let unread = format.unread.iter();
        let columns = unread.map(|c| input_name(format, *c)).collect();
        findings.push(Case::ColumnsUnread { columns }.finding());
    }
    if format.is_guessed {
        let misfit = format.misfit;
        let guessed = misfit.map_or(Case::NoHeader, |misfit| Case::NamesMisfit { misfit });
        findings.push(guessed.finding().advise("columns", spec(format)));
    }
    if let [first, others @ ..] = &format.unnamed_clocks[..] {
        let column = name(format, *first).to_owned();
        let advice = format!("t={column}");
        let case = if others.is_empty() {
            Case::UnnamedClock { column }
        } else {
            let clocks = format.unnamed_clocks.iter();
            let columns = clocks.map(|c| name(format, *c).to_owned()).collect();
            Case::UnnamedClocks { columns }
        };
        findings.push(case.finding().advise("columns", advice));
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
        let columns = format!("ax={x},ay={y},az={z}");
        let read = read.to_owned();
        let both = Case::RawAndCalibrated { read }.finding();
        both.advise("columns", columns)
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
    let norm_at_rest = judge::quiet_norm(accel.each_ref().map(Vec::as_slice))?;
    let norm = |row: usize| accel.iter().map(|c| c[row] * c[row]).sum::<f64>().sqrt();
    let norms = (0..accel[0].len()).map(norm);
    let mut norms: Vec<f64> = norms.filter(|n| n.is_finite()).collect();
    let at = ((norms.len() * 49) / 50).min(norms.len().checked_sub(1)?);
    let norm_in_motion = *norms.select_nth_unstable_by(at, f64::total_cmp).1;
    (norm_in_motion > 4.0 * norm_at_rest).then(|| {
        let case = Case::NotAnAccelerometer {
            norm_at_rest,
            norm_in_motion,
        };
        case.finding()
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
    let first = first?.clone();
    let text_cells = Case::TextCells { cells, first }.finding();
    Some(text_cells.at_lines(&lines.into_iter().collect()))
}

/// Lines that were set aside; none for those that every good file has, `blanks`: unless blank lines are.
pub(crate) fn of_lines(ledger: &Ledger, nul_lines: &LineSpans, blanks: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (reason, aside) in &ledger.reasons {
        let (lines, first) = (aside.lines.count(), aside.first.clone());
        let blocks = lines;
        let case = match reason {
            Reason::NamedGap => Case::NamedGap { lines, first },
            Reason::Blank if blanks => Case::BlankRows { lines },
            Reason::RepeatedHeader => Case::RepeatedHeader { lines },
            Reason::TornLine => Case::TornLine { lines, first },
            Reason::TooManyFields => Case::TooManyFields { lines, first },
            Reason::NotANumber => Case::NotANumber { lines, first },
            Reason::Zeros => Case::ZeroRows { lines },
            Reason::Hung => Case::SensorHung { lines },
            Reason::CorruptBlock => Case::CorruptBlock { blocks, first },
            Reason::LateBlock => Case::LateBlock { blocks, first },
            _ => continue,
        };
        findings.push(case.finding().at_lines(&aside.lines));
    }
    if !nul_lines.is_empty() {
        let lines = nul_lines.count();
        findings.push(Case::NulBytes { lines }.finding().at_lines(nul_lines));
    }
    findings
}
