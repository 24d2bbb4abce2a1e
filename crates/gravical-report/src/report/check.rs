//! Report of a check of a calibration.

use gravical::calibration_file::Grade;
use gravical::check::{CheckReport, Judgement, StillCheck};
use gravical::numfmt::{count, fixed, milli_g, signed, words};

use super::{gravity_source, short_name};
use crate::document::{Cell, Document, Section, Table, Verdict};

/// The document of a check.
pub fn check(report: &CheckReport) -> Document<'static> {
    let calibration = short_name(&report.calibration);
    let recordings = match &report.recordings[..] {
        [one] => short_name(one),
        several => format!("{} recordings", several.len()),
    };
    let stills = count(report.static_intervals.len(), "static interval");
    let of_calibration = if report.gravity_of_calibration {
        ", as in the calibration"
    } else {
        ""
    };
    let (g, source) = (report.gravity_mps2, gravity_source(report.gravity_source));
    Document {
        subject: vec![
            format!("{calibration} checked with {recordings}: {stills}"),
            format!("g = {} m/s² ({source}{of_calibration})", fixed(g, 5)),
        ],
        verdict: Some(judged(&report.verdict, next(report))),
        ..Document::new(format!("Check of {calibration}"))
    }
    .with(intervals(report))
    .with_findings(&report.findings, report.recordings.len() > 1)
}

/// The verdict of `check` or `compare`, with the next step.
pub(super) fn judged(verdict: &gravical::check::Verdict, next: Option<&str>) -> Verdict {
    let grade = match verdict.judgement {
        Judgement::Fits | Judgement::Agree => Grade::Good,
        Judgement::DoesNotFit | Judgement::Differ => Grade::Poor,
        Judgement::Undecided => Grade::NotVerifiable,
    };
    Verdict {
        next: next.map(str::to_owned).into_iter().collect(),
        ..Verdict::new(grade, words(&verdict.judgement), &verdict.reasons)
    }
}

/// What to do about it.
fn next(report: &CheckReport) -> Option<&'static str> {
    match report.verdict.judgement {
        Judgement::Undecided if report.only_fitted => {
            Some("Record the sensor at rest again, and check with that recording")
        }
        Judgement::Undecided => Some(
            "Calibrate from recordings, not from means, so that the calibration has a covariance",
        ),
        judgement if judgement.is_change() && report.gravity_of_calibration => Some(
            "Give the gravity of this place if it is another; if it does not fit then, either, calibrate again",
        ),
        judgement if judgement.is_change() => Some("Calibrate again"),
        _ if !report.untested_axes.is_empty() => {
            Some("To test the other axes, too, record the sensor with each of them up")
        }
        _ => None,
    }
}

fn intervals(report: &CheckReport) -> Section<'static> {
    let columns = "interval|rows|nearest face|angle to face, °|error of ‖a‖, mg|z|";
    let mut table = Table::new("").columns(columns.split('|'));
    // The largest error first: a long table is cut.
    let mut stills: Vec<(usize, &StillCheck)> =
        report.static_intervals.iter().enumerate().collect();
    stills.sort_by_key(|(i, _)| *i != report.worst);
    for (i, still) in &stills {
        let at = still.start_s.map_or_else(
            || format!("line {}", still.lines[0]),
            |s| format!("{s:.2} s"),
        );
        let name = match (&still.label, report.recordings.len()) {
            (Some(label), _) => label.clone(),
            (None, 1) => format!("at {at}"),
            (None, _) => format!("{} {at}", short_name(&still.file)),
        };
        let mark = match still {
            _ if *i == report.worst && stills.len() > 1 => "← largest",
            still if still.counts => "",
            still if still.clipped > 0 => "clipped",
            _ => "not counted",
        };
        let error = Cell::number(signed(milli_g(still.error_mps2), 2));
        let cells = [
            Cell::number(still.rows.to_string()),
            Cell::text(&still.nearest),
            Cell::number(fixed(still.face_angle_deg, 1)),
            error.plus_minus(Some(milli_g(still.sigma_mps2)), 2),
            Cell::number(signed(still.z, 1)),
            Cell::text(mark),
        ];
        table = table.row(name, cells);
    }
    Section::new("Static intervals").with(table)
}
