//! Report of a check of a calibration.

use crate::document::{Block, Cell, Column, Document, Grade, Row, Section, Table, Verdict};
use gravical::calibration_file::GravitySource;
use gravical::check::{CheckReport, GyroscopeCheck, Judgement, StillCheck};
use gravical::numfmt::{fixed, milli_g, signed};
use gravical::segment::still::StillOptions;

use super::short_name;

/// The document of a check.
#[must_use]
pub fn check(report: &CheckReport) -> Document<'static> {
    let calibration = short_name(&report.calibration);
    let recordings = match &report.recordings[..] {
        [one] => short_name(one),
        several => format!("{} recordings", several.len()),
    };
    let stills = match report.static_intervals.len() {
        1 => "1 static interval".to_owned(),
        n => format!("{n} static intervals"),
    };
    let gravity = match (report.gravity_of_calibration, report.gravity_source) {
        (true, GravitySource::Standard) => "as assumed by the calibration",
        (true, _) => "as in the calibration",
        (false, GravitySource::Given) => "given",
        (false, GravitySource::Latitude) => "from latitude",
        (false, GravitySource::Standard) => "assumed",
    };
    let judgement = report.verdict.judgement;
    let grade = match judgement {
        Judgement::Fits => Grade::Good,
        Judgement::DoesNotFit => Grade::Poor,
        Judgement::Undecided => Grade::Unknown,
    };
    let mut document = Document {
        subject: vec![
            format!("{calibration} checked with {recordings}: {stills}"),
            format!("g = {} m/s² ({gravity})", fixed(report.gravity_mps2, 5)),
        ],
        verdict: Some(Verdict::new(
            grade,
            judgement.name(),
            &report.verdict.reasons,
        )),
        ..Document::new(format!("Check of {calibration}"))
    };
    document = document.with(stills_of(report));
    if let Some(gyroscope) = &report.gyroscope {
        document = document.with(gyroscope_at_rest(gyroscope));
    }
    document.with_findings(&report.findings, report.recordings.len() > 1)
}

fn stills_of(report: &CheckReport) -> Section<'static> {
    let columns = [
        Column::left("interval"),
        Column::number("rows"),
        Column::left("nearest face"),
        Column::number("angle to face, °"),
        Column::number("error of ‖a‖, mg"),
        Column::number("z"),
        Column::left(""),
    ];
    let rows = report.static_intervals.iter().enumerate();
    let table = Table::new("")
        .columns(columns)
        .rows(rows.map(|(i, still)| row(report, i, still)));
    let mg = |mps2: f64| format!("{} mg", fixed(milli_g(mps2), 2));
    let predicted = report
        .predicted_rms_mps2
        .map_or(String::new(), |p| format!(", {} predicted", mg(p)));
    let rms = format!("RMS {}{predicted}", mg(report.rms_mps2));
    Section::new("intervals", "Static intervals")
        .opening()
        .with(table)
        .with(Block::paragraph(rms))
        .with(Block::note(format!(
            "A static interval lasts at least {} here; `inspect` lists longer ones only.",
            StillOptions::short_rests().shortest()
        )))
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
    let mark = match (worst, still.counts) {
        (true, _) => "← largest",
        (false, false) if still.clipped > 0 => "clipped",
        (false, false) => "not counted",
        (false, true) => "",
    };
    let sigma = still
        .sigma_mps2
        .filter(|s| s.is_finite())
        .map(|s| fixed(milli_g(s), 2));
    let cells = [
        Cell::text(name),
        Cell::number(still.rows.to_string()),
        Cell::text(&still.nearest),
        Cell::number(fixed(still.face_angle_deg, 1)),
        Cell::number(signed(still.error_mg, 2)).plus_minus(sigma),
        Cell::maybe(still.z, |z| signed(z, 1)),
        Cell::text(mark),
    ];
    Row {
        stays: worst,
        ..Row::from(cells)
    }
}

fn gyroscope_at_rest(g: &GyroscopeCheck) -> Section<'static> {
    let rate = |i: usize| {
        let sigma = g.standard_error_deg_s.map(|e| fixed(e[i], 3));
        Cell::number(signed(g.rate_deg_s[i], 3)).plus_minus(sigma)
    };
    let rates = [Cell::text("rate, °/s"), rate(0), rate(1), rate(2)];
    let table = Table::new("")
        .columns([Column::left("")])
        .columns(Column::axes(""))
        .row(rates);
    let limit = g.limit_deg_s;
    let judgement = match g.judgement {
        Judgement::Fits => format!("within {limit} °/s: the bias fits"),
        Judgement::DoesNotFit => format!(
            "more than {limit} °/s: the bias has changed (it does with every power-up and with temperature); bias at rest now: {} {}",
            g.bias_now.map(|b| format!("{b:.5}")).join(", "),
            g.input_unit.name()
        ),
        Judgement::Undecided => {
            format!("too short or unsteady to test against {limit} °/s")
        }
    };
    Section::new("gyroscope", "Gyroscope at rest, calibrated")
        .with(table)
        .with(Block::paragraph(judgement))
}
