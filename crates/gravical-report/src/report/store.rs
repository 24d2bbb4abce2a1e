//! Reports of a store: its sensors, a choice, the history of a sensor.

use std::path::Path;

use crate::document::{Block, Cell, Column, Document, Grade, Row, Section, Table, Verdict};
use crate::figure::Figure;
use gravical::compare::{ChangeTest, HistoryEntry, HistoryParameter, SincePrevious, Stability};
use gravical::escape::path_text;
use gravical::numfmt::{count, decimals_by, fixed, mg, signed};
use gravical::store::{
    Choice, LeftOutFile, QueryTimeSource, SensorHistory, StoreList, StoredTimeSource,
};
use gravical::uncertainty::ChiSquare;

use super::short_name;

/// The document of the sensors of a store.
#[must_use]
pub fn store_list(list: &StoreList) -> Document<'static> {
    let name = path_text(Path::new(&list.store));
    let all: usize = list.sensors.iter().map(|s| s.calibrations).sum();
    let table = Table::new("")
        .columns([Column::left("sensor"), Column::number("calibrations")])
        .columns(["first", "last", "last verdict"].map(Column::left))
        .columns([Column::number("its error, mg")])
        .rows(list.sensors.iter().map(|s| {
            let n = s.calibrations;
            Row::from([
                Cell::text(&s.sensor_id),
                Cell::number(n.to_string()),
                Cell::text(s.first.date()),
                Cell::text(s.last.date()),
                Cell::text(s.last_grade.name()),
                Cell::maybe(s.last_predicted_norm_error_mps2, mg),
            ])
        }));
    let mut section = Section::new("sensors", "Sensors").opening();
    if !list.sensors.is_empty() {
        section = section.with(table).with(Block::note(
            "Dates are UTC. Error: predicted error of ‖a‖ at rest (1σ).",
        ));
    }
    Document {
        subject: vec![format!(
            "{name}: {}, {}",
            count(list.sensors.len(), "sensor"),
            count(all, "calibration")
        )],
        ..Document::new(format!("Calibrations in {name}"))
    }
    .with(section)
    .with(left_out(&list.left_out))
}

/// JSON files that are no calibration of a sensor.
fn left_out(files: &[LeftOutFile]) -> Section<'static> {
    let section = Section::new("left-out", "JSON files that are left out");
    if files.is_empty() {
        return section;
    }
    let line = |f: &LeftOutFile| format!("{}: {}", f.path, f.reason);
    section.with(Block::List(files.iter().map(line).collect()))
}

/// Which calibration was taken from a store, and why.
#[must_use]
pub fn choice(choice: &Choice) -> Section<'static> {
    let source = match choice.recording_time_source {
        QueryTimeSource::Given => "given",
        QueryTimeSource::TimeStamps => "by its time stamps",
        QueryTimeSource::Now => "now: no date is given",
    };
    let mut facts = vec![
        ("calibration", choice.path.clone()),
        (
            "sensor",
            format!(
                "{}, {} in the store",
                choice.sensor_id,
                count(choice.candidates, "calibration")
            ),
        ),
        (
            "calibrated",
            format!("{} ({})", choice.time, choice.time_source.words()),
        ),
        ("recording", format!("{} ({source})", choice.recording_time)),
        ("why", choice.reasons.join("; ")),
    ];
    if !choice.left_out.is_empty() {
        let n = choice.left_out.len();
        facts.push((
            "left out",
            format!("{n} JSON files that are no calibration of a sensor"),
        ));
    }
    let facts = facts
        .into_iter()
        .map(|(name, text)| (name.to_owned(), text));
    let section =
        Section::new("choice", "Calibration from the store").with(Block::Facts(facts.collect()));
    if choice.rejected.is_empty() {
        return section;
    }
    let line = |r: &gravical::store::Rejected| format!("{}: {}", r.time, r.reasons.join(", "));
    section
        .with(Block::paragraph(match choice.rejected.len() {
            1 => "One does not fit:".to_owned(),
            n => format!("{n} do not fit:"),
        }))
        .with(Block::List(choice.rejected.iter().map(line).collect()))
}

/// The document of a history; `figures` are those of [`crate::figure::history`].
#[must_use]
pub fn history<'a>(h: &SensorHistory, figures: &'a [Figure]) -> Document<'a> {
    let verdict = &h.history.verdict;
    let grade = match verdict.judgement {
        Stability::Unchanged => Grade::Good,
        Stability::Changed => Grade::Poor,
        Stability::Undecided => Grade::Unknown,
    };
    let span = match (h.calibrations.first(), h.calibrations.last()) {
        (Some(first), Some(last)) if h.calibrations.len() > 1 => {
            let (n, tested) = (h.calibrations.len(), h.history.tested);
            let not = match n - tested {
                0 => String::new(),
                _ => format!(" ({tested} tested)"),
            };
            format!(
                "{n} calibrations{not} from {} to {}",
                first.time.date(),
                last.time.date()
            )
        }
        (Some(one), _) => format!("one calibration, of {}", one.time.date()),
        _ => "no calibration".to_owned(),
    };
    let id = &h.sensor_id;
    let parts = [
        ("bias", "Bias, m/s²"),
        ("scale", "Scale, deviation from nominal in %"),
        ("angle", "Angles between the axes beyond 90°, °"),
        (
            "rotation",
            "Rotation of the frame against the first tested one, °",
        ),
    ];
    let mut parameters = Section::new("parameters", "Parameters");
    for (kind, caption) in parts {
        let Some(table) = over_time(h, kind, caption) else {
            continue;
        };
        parameters = match kind {
            "bias" | "scale" => parameters.with(table),
            _ => parameters.full(table),
        };
    }
    parameters = parameters
        .with(Block::note(
            "± 1σ, that of gravity included; the figures show intervals of 95 %.",
        ))
        .figures(figures);
    Document {
        subject: vec![format!("Sensor {id}: {span}")],
        verdict: Some(Verdict::new(
            grade,
            verdict.judgement.name(),
            &verdict.reasons,
        )),
        ..Document::new(format!("History of sensor {id}"))
    }
    .with(calibrations(h))
    .with(parameters)
    .with(tests(h))
    .with_findings(&h.history.findings, true)
    .with(left_out(&h.left_out))
}

/// The calibrations with the test against the one before.
fn calibrations(h: &SensorHistory) -> Section<'static> {
    let p = |_: String, test: Option<ChiSquare>| {
        Cell::maybe(test.map(|t| t.p_value), |p| {
            ChiSquare::probability(p)
                .trim_start_matches("p = ")
                .trim_start_matches("p ")
                .to_owned()
        })
    };
    let row = |(i, (c, entry)): (usize, (&gravical::store::HistoryCalibration, &HistoryEntry))| {
        let since = |test: &str| format!("/history/entries/{i}/since_previous/{test}/p_value");
        let of = |get: fn(&SincePrevious) -> Option<ChiSquare>| {
            entry.since_previous.as_ref().and_then(get)
        };
        let verdict = match entry.not_tested {
            Some(_) => format!("{}, not tested", c.grade.name()),
            None => c.grade.name().to_owned(),
        };
        Row::from([
            Cell::text(c.time.minute()),
            Cell::text(verdict),
            Cell::maybe(c.temperature_c.map(|t| t.mean), |t| fixed(t, 1)),
            p(since("magnitude"), of(|s| s.magnitude)),
            p(since("orientation"), of(|s| s.orientation)),
            Cell::text(&c.method),
            Cell::number(fixed(c.gravity_mps2, 5)),
            Cell::text(match c.time_source {
                StoredTimeSource::Recording => "recording",
                StoredTimeSource::Calibration => "calibration",
                StoredTimeSource::FileName => "file name",
            }),
            Cell::text(short_name(&c.path)),
        ])
    };
    let rows = h.calibrations.iter().zip(&h.history.entries).enumerate();
    let table = Table::new("")
        .columns(["time (UTC)", "verdict"].map(Column::left))
        .columns([Column::number("°C")])
        .columns(["p of ‖a‖", "p of frame"].map(Column::number))
        .columns([
            Column::left("method").full(),
            Column::number("g, m/s²").full(),
            Column::left("time of").full(),
            Column::left("file").full(),
        ])
        .rows(rows.map(row));
    Section::new("calibrations", "Calibrations")
        .opening()
        .with(table)
        .with(Block::note(
            "p: against the tested calibration before, as by `gravical compare`: what changes ‖a‖, and the rotation of the frame.",
        ))
}

/// The parameters of one kind, with their places in the list.
fn of_kind<'h>(
    entry: &'h HistoryEntry,
    kind: &'h str,
) -> impl Iterator<Item = (usize, &'h HistoryParameter)> {
    let all = entry.parameters.iter().enumerate();
    all.filter(move |(_, p)| p.name.starts_with(kind))
}

/// A table of three parameters over time.
fn over_time(h: &SensorHistory, kind: &str, caption: &str) -> Option<Table> {
    let entries = &h.history.entries;
    let all = || entries.iter().flat_map(|entry| of_kind(entry, kind));
    let sigmas = all().filter_map(|(_, p)| p.sigma).filter(|s| *s > 0.0);
    let least = sigmas.min_by(f64::total_cmp);
    let digits = least.map_or(4, |least| decimals_by(Some(least), 1.0));
    let names: Vec<&str> = all()
        .take(3)
        .filter_map(|(_, p)| p.name.split('_').nth(1))
        .collect();
    if names.is_empty() {
        return None;
    }
    let table = Table::new(caption.to_owned())
        .columns([Column::left("time (UTC)")])
        .columns(names.into_iter().map(Column::number));
    let row = |(_, entry): (usize, &HistoryEntry)| {
        let cells = of_kind(entry, kind).map(|(_, p)| {
            let sigma = p.sigma.filter(|s| s.is_finite()).map(|s| fixed(s, digits));
            let value = Cell::number(signed(p.value, digits));
            value.plus_minus(sigma)
        });
        let name = std::iter::once(Cell::text(&entry.name));
        let none = std::iter::repeat_with(Cell::none);
        Row::from(name.chain(cells).chain(none).take(4).collect::<Vec<_>>())
    };
    Some(table.rows(entries.iter().enumerate().map(row)))
}

/// The tests over all calibrations.
fn tests(h: &SensorHistory) -> Section<'static> {
    let section = Section::new("tests", "Did the sensor change?");
    let row = |name: &str, _: &str, test: &ChangeTest| {
        let mut cells = vec![
            Cell::text(name),
            Cell::number(fixed(test.whole.chi2, 1)),
            Cell::number(test.whole.degrees_of_freedom.to_string()),
        ];
        cells.extend(match &test.step {
            Some(step) => [
                Cell::text(format!("{} to {}", day(&step.after), day(&step.until))),
                Cell::number(fixed(step.test.chi2, 1)),
            ],
            None => [Cell::none(), Cell::none()],
        });
        let p = ChiSquare::probability(test.p_value);
        let p = p
            .trim_start_matches("p = ")
            .trim_start_matches("p ")
            .to_owned();
        cells.push(Cell::number(p));
        Row::from(cells)
    };
    let tests = [
        ("bias, scale, angles", "magnitude", &h.history.magnitude),
        (
            "… at one gravity",
            "magnitude_at_one_gravity",
            &h.history.magnitude_at_one_gravity,
        ),
        (
            "rotation of the frame",
            "orientation",
            &h.history.orientation,
        ),
    ];
    let rows: Vec<Row> = tests
        .iter()
        .filter_map(|(name, key, test)| Some(row(name, key, test.as_ref()?)))
        .collect();
    if rows.is_empty() {
        return section;
    }
    let table = Table::new("")
        .columns([Column::left("")])
        .columns(["χ²", "of"].map(Column::number))
        .columns([Column::left("largest step")])
        .columns(["its χ²", "p"].map(Column::number))
        .rows(rows);
    section.with(table).with(Block::note(
        "χ²: about the weighted mean, with that many degrees of freedom. p: probability of both together if nothing changed; below 0.005 it is a change. At most 1 % of unchanged sensors are reported as changed.",
    ))
}

/// The date of a time.
fn day(time: &str) -> &str {
    time.get(..10).unwrap_or(time)
}

/// The document of the calibration that would be taken, with why.
#[must_use]
pub fn stored<'a>(chosen: &gravical::store::StoredCalibration, why: &Choice) -> Document<'a> {
    let mut document = super::calibration(&chosen.file, Some(&chosen.path), &[]);
    document.sections.insert(0, choice(why).opening());
    document
}
