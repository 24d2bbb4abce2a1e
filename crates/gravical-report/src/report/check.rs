//! Report of a check of a calibration.

use crate::document::{Cell, Document, Grade, Row, Section, Table, Verdict};
use gravical::check::{CheckReport, Judgement, StillCheck};
use gravical::numfmt::{fixed, milli_g, signed, words};

use super::{gravity_source, short_name};

/// The document of a check.
pub fn check(report: &CheckReport) -> Document<'static> {
    let calibration = short_name(&report.calibration);
    let recordings = match &report.recordings[..] {
        [one] => short_name(one),
        several => format!("{} recordings", several.len()),
    };
    let stills = gravical::numfmt::count(report.static_intervals.len(), "static interval");
    let of_calibration = if report.gravity_of_calibration {
        ", as in the calibration"
    } else {
        ""
    };
    let gravity = gravity_source(report.gravity_source);
    Document {
        subject: vec![
            format!("{calibration} checked with {recordings}: {stills}"),
            format!(
                "g = {} m/s² ({gravity}{of_calibration})",
                fixed(report.gravity_mps2, 5)
            ),
        ],
        verdict: Some(Verdict {
            next: next(report),
            ..judged(&report.verdict)
        }),
        ..Document::new(format!("Check of {calibration}"))
    }
    .with(intervals(report))
    .with_findings(&report.findings, report.recordings.len() > 1)
}

/// The verdict of `check` or `compare`.
pub(super) fn judged(verdict: &gravical::check::Verdict) -> Verdict {
    let grade = match verdict.judgement {
        Judgement::Fits | Judgement::Agree => Grade::Good,
        Judgement::DoesNotFit | Judgement::Differ => Grade::Poor,
        Judgement::Undecided => Grade::Unknown,
    };
    Verdict::new(grade, &words(&verdict.judgement), &verdict.reasons)
}

/// What to do about it.
fn next(report: &CheckReport) -> Vec<String> {
    let step = match report.verdict.judgement {
        Judgement::Undecided if report.only_fitted => {
            "Record the sensor at rest again, and check with that recording"
        }
        Judgement::Undecided => {
            "Calibrate from recordings, not from means, so that the calibration has a covariance"
        }
        judgement if judgement.is_change() && report.gravity_of_calibration => {
            "Give the gravity of this place if it is another; if it does not fit then, either, calibrate again"
        }
        judgement if judgement.is_change() => "Calibrate again",
        _ if !report.untested_axes.is_empty() => {
            "To test the other axes, too, record the sensor with each of them up"
        }
        _ => return Vec::new(),
    };
    vec![step.to_owned()]
}

fn intervals(report: &CheckReport) -> Section<'static> {
    let columns = [
        "interval",
        "rows",
        "nearest face",
        "angle to face, °",
        "error of ‖a‖, mg",
        "z",
        "",
    ];
    // The largest error first: a long table is cut.
    let mut rows: Vec<_> = report.static_intervals.iter().enumerate().collect();
    rows.sort_by_key(|(i, _)| *i != report.worst);
    let rows = rows.into_iter().map(|(i, still)| row(report, i, still));
    let table = Table::new("").columns(columns).rows(rows);
    Section::new("intervals", "Static intervals").with(table)
}

fn row(report: &CheckReport, i: usize, still: &StillCheck) -> Row {
    let at = still.start_s.map_or_else(
        || format!("line {}", still.lines[0]),
        |s| format!("{s:.2} s"),
    );
    let name = match (&still.label, report.recordings.len()) {
        (Some(label), _) => label.clone(),
        (None, 1) => format!("at {at}"),
        (None, _) => format!("{} {at}", short_name(&still.file)),
    };
    let worst = i == report.worst && report.static_intervals.len() > 1;
    let mark = if worst {
        "← largest"
    } else if still.counts {
        ""
    } else if still.clipped > 0 {
        "clipped"
    } else {
        "not counted"
    };
    let mg = |mps2: f64| signed(milli_g(mps2), 2);
    let cells = [
        Cell::text(name),
        Cell::number(still.rows.to_string()),
        Cell::text(&still.nearest),
        Cell::number(fixed(still.face_angle_deg, 1)),
        Cell::number(mg(still.error_mps2)).plus_minus(Some(milli_g(still.sigma_mps2)), 2),
        Cell::number(signed(still.z, 1)),
        Cell::text(mark),
    ];
    Row::from(cells)
}
