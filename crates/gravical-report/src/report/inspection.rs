//! Report of the content of a recording.

use std::fmt::Display;

use gravical::finding::Severity;
use gravical::inspect::{Inspection, StillSpan};
use gravical::numfmt::{count, decimals_of, digits, fixed};
use gravical::poses::face::CaseAxes;
use gravical::poses::rests::MIN_REST_S;
use gravical::recording::Origin;
use gravical::recording::full_scale::range_of_16_bits;
use gravical::recording::units::{AccelUnit, GyroUnit};

use super::{drift, largest, short_name};
use crate::document::{Block, Cell, Document, Section, Table, Verdict};
use crate::figure::Figure;

/// More static intervals than this are folded on a page.
const MAX_SHOWN: usize = 24;

/// The document of an inspection.
pub fn inspection<'a>(inspection: &Inspection, figures: &'a [Figure]) -> Document<'a> {
    let labels = inspection.labels.iter().take(12);
    let labels = labels.map(|(name, rows)| format!("{name} {rows}"));
    let more = inspection.labels.len().checked_sub(12).filter(|n| *n > 0);
    let labels = labels.chain(more.map(|n| format!("… and {n} more")));
    let labels = labels.collect::<Vec<_>>().join(", ");
    let serial = inspection.serial.as_ref();
    let serial = serial.map(|serial| format!("serial number {serial}"));
    let missing = inspection.timing.missing_share.filter(|share| *share > 0.0);
    let missing = missing.map(|share| format!("{} % of the samples", digits(100.0 * share, 2)));
    let a = inspection.accelerometer;
    let per_g = a.lsb_per_g.filter(|_| a.unit == AccelUnit::Counts);
    let gyro = inspection.gyroscope.map(|g| {
        let per_deg_s = g.lsb_per_deg_s.filter(|_| g.unit == GyroUnit::Counts);
        scale(g.unit, per_deg_s, "°/s", g.origin)
    });
    let temperature = inspection.temperature_c;
    let temperature = temperature.map(|[low, high]| format!("{low:.1} to {high:.1} °C"));
    let reading = Section::new("How it was read")
        .fact("format", inspection.description.clone())
        .fact("sensor", serial)
        .fact("lines", inspection.row_counts.sum.clone())
        .fact("time", time(inspection))
        .fact("missing", missing)
        .fact("accel", scale(a.unit, per_g, "g", a.origin))
        .fact("gyro", gyro)
        .fact("temp", temperature.clone())
        .fact("labels", Some(labels).filter(|all| !all.is_empty()))
        .fact("static", stillness(inspection));
    let intervals = &inspection.static_intervals;
    let drift = inspection.temperature_drift.as_ref();
    let warnings = inspection.findings.iter();
    let warnings = warnings.filter(|f| f.severity != Severity::Note).count();
    Document {
        subject: vec![inspection.file.clone()],
        certificate: vec![
            entry(
                "Sensor",
                inspection
                    .serial
                    .clone()
                    .unwrap_or_else(|| "not named".to_owned()),
            ),
            entry("Rows", inspection.row_counts.rows.to_string()),
            entry("Accelerometer", a.unit.to_string()),
            entry(
                "Gyroscope",
                inspection
                    .gyroscope
                    .map_or("none".to_owned(), |g| g.unit.to_string()),
            ),
            entry(
                "Temperature",
                temperature
                    .clone()
                    .unwrap_or_else(|| "not recorded".to_owned()),
            ),
        ],
        verdict: Some(Verdict::without_word(
            [headline(inspection), String::new()],
            match warnings {
                0 => "Nothing is odd.".to_owned(),
                n => format!("{}: see the findings.", count(n, "warning")),
            },
        )),
        ..Document::new(format!("Recording {}", short_name(&inspection.file)))
    }
    .with(
        Section::new("Recording")
            .figures(figures, &["recording"])
            .wide(12),
    )
    .with(Section::new("Steps").figures(figures, &["steps"]).wide(12))
    .with(reading)
    .with((!intervals.is_empty()).then(|| stills(intervals, inspection.case_axes)))
    .with(drift.map(|model| self::drift(Section::new("Temperature"), model)))
    .with_findings(&inspection.findings, false)
}

fn entry(name: &str, value: String) -> [String; 3] {
    [name.to_owned(), value, String::new()]
}

/// Length, rate and rests.
fn headline(inspection: &Inspection) -> String {
    let t = &inspection.timing;
    let rate = t.median_rate_hz.or(t.nominal_rate_hz);
    let rate = rate.map_or("rate unknown".to_owned(), |rate| {
        format!("{} Hz", digits(rate, 4))
    });
    let rows = inspection.row_counts.rows;
    let long = t
        .duration_s
        .map_or(format!("{rows} rows"), |s| format!("{} s", digits(s, 4)));
    let rests = count(inspection.static_intervals.len(), "rest");
    format!("{long} at {rate}; {rests}")
}

fn time(inspection: &Inspection) -> String {
    let t = &inspection.timing;
    let duration = t.duration_s.map(|duration| format!("{duration:.2} s"));
    let mut parts = Vec::from_iter(duration);
    match (t.unit_s, t.median_rate_hz, t.nominal_rate_hz) {
        (Some(unit_s), Some(rate), _) => {
            let named = t.unit.map(|unit| unit.name().to_owned());
            let unit =
                named.unwrap_or_else(|| format!("units of {} s", (1e6 * unit_s).round() / 1e6));
            parts.push(format!("stamps in {unit}, {rate:.2} Hz"));
            let jitter = t.jitter_s.map(|s| format!("jitter {:.2} ms", 1000.0 * s));
            parts.extend(jitter);
        }
        (.., Some(rate)) => parts.push(format!("no time stamps; {rate} Hz according to the file")),
        _ => parts.push("no time stamps, rate unknown (--rate)".to_owned()),
    }
    parts.join(", ")
}

/// How a unit is known.
pub fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Given => "given",
        Origin::Data => "from the data",
        Origin::Header => "from the header",
        Origin::Assumed => "assumed",
    }
}

/// A unit with the sensitivity of counts of known range, per g or °/s, and how it is known.
fn scale(unit: impl Display, lsb: Option<f64>, per: &str, known: Origin) -> String {
    let counts = lsb.map(|lsb| {
        let range = range_of_16_bits(lsb).map(|range| format!(" (±{range} {per})"));
        let lsb = (10.0 * lsb).round() / 10.0;
        format!(", {lsb} per {per}{}", range.unwrap_or_default())
    });
    format!("{unit}{}, {}", counts.unwrap_or_default(), origin(known))
}

fn stillness(inspection: &Inspection) -> String {
    let share = 100.0 * inspection.static_share;
    match inspection.static_intervals.len() {
        0 if inspection.row_counts.rows < 40 => "too few rows".to_owned(),
        0 => "never".to_owned(),
        1 => format!("{share:.0} % of the rows, one interval"),
        n => format!("{share:.0} % of the rows, {n} intervals"),
    }
}

fn stills<'a>(all: &[StillSpan], case_axes: Option<CaseAxes>) -> Section<'a> {
    let columns = ["", "lines", "from, s", "to, s", "face", "angle to face, °"];
    let mut table = Table::new("", columns).axes("mean reading");
    for (number, still) in (1..).zip(all) {
        let n = decimals_of(largest(&still.mean), 4);
        let seconds = |v: Option<f64>| Cell::maybe(v, |v| fixed(v, 1));
        let cells = [
            Cell::text(format!("{}–{}", still.lines[0], still.lines[1])),
            seconds(still.start_s),
            seconds(still.end_s),
            Cell::text(still.face.as_deref().unwrap_or("–")),
            Cell::number(fixed(still.face_angle_deg, 1)),
        ];
        let mean = Cell::axes(Some(still.mean), |v| fixed(v, n));
        table = table.row(number.to_string(), cells.into_iter().chain(mean));
    }
    let section = Section::new("Static intervals");
    let section = match all.len() {
        0..=MAX_SHOWN => section,
        many => section.folded(many.to_string()),
    };
    section
        .with(table)
        .with(case_axes.map(|axes| Block::Note(axes.advice("interval"))))
        .full(Block::Note(format!(
            "A static interval lasts at least {MIN_REST_S} s. angle to face: angle of the mean reading to the nearest face, by tilt, bias and misalignment together."
        )))
}
