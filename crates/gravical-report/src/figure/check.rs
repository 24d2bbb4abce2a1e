//! Figures of a check and of a comparison.

use gravical::check::{CheckReport, StillCheck};
use gravical::compare::Comparison;
use gravical::numfmt::{COVERAGE, digits, milli_g, unit};

use super::drawing::Figure;
use super::panel::{Axis, Panel, Role, Series};

/// More rests than this are not shown one by one: those that are off most are.
const MAX_ROWS: usize = 40;

/// What an error is drawn over varies by more than this: °C, days.
const MIN_SPREAD: f64 = 1.0;

/// A static interval by its label, else by its time or line, with its file where there are several.
pub(crate) fn still_name(report: &CheckReport, still: &StillCheck) -> String {
    let at = still.start_s.map_or_else(
        || format!("line {}", still.lines[0]),
        |s| format!("{s:.2} s"),
    );
    match (&still.label, report.recordings.len()) {
        (Some(label), _) => label.clone(),
        (None, 1) => format!("at {at}"),
        (None, _) => format!("{} {at}", still.file.rsplit('/').next().unwrap_or_default()),
    }
}

/// The error of each rest, and over temperature and date where they are known.
pub fn check(report: &CheckReport) -> Vec<Figure> {
    let mut stills: Vec<&StillCheck> = report.static_intervals.iter().collect();
    let all = stills.len();
    if all > MAX_ROWS {
        stills.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        stills.truncate(MAX_ROWS);
    }
    let name = |s: &&StillCheck| format!("{}, {} up", still_name(report, s), s.nearest);
    let bar = |s: &&StillCheck| [milli_g(s.error_mps2), COVERAGE * milli_g(s.sigma_mps2)];
    let role = |s: &&StillCheck| match s.error_mps2.abs() > COVERAGE * s.sigma_mps2 {
        _ if !s.counts => Role::Raw,
        true => Role::Bad,
        false => Role::Result,
    };
    // Each rest has its row, in the colour of what it says.
    let rows = |of: Role, title: &str| {
        let values = stills
            .iter()
            .map(|s| if role(s) == of { bar(s) } else { [f64::NAN; 2] });
        Series::in_rows(title, of, values)
    };
    let series = [
        rows(Role::Result, "error ± 95 %"),
        rows(Role::Bad, "beyond its bar"),
        rows(Role::Raw, "does not count"),
    ];
    let ends = stills.iter().map(|s| bar(s)[0].abs() + bar(s)[1]);
    let axes = [
        Axis::around_zero("", ends),
        Axis::rows(stills.iter().map(name)),
    ];
    let rms = digits(milli_g(report.rms_mps2), 2);
    let panel = Panel::new("Error of ‖a‖", "mg", axes, series).noted(format!("rms {rms}"));
    let mut caption = "If the calibration still fits, 95 % of the bars reach zero.".to_owned();
    if all > stills.len() {
        caption += &format!(" The {} that are off most, of {all}.", stills.len());
    }
    let errors = Figure::new("errors", "Error of ‖a‖ of each rest", caption, [panel]);
    std::iter::once(errors)
        .chain(by_temperature(report))
        .chain(by_date(report))
        .collect()
}

fn by_temperature(report: &CheckReport) -> Option<Figure> {
    let names = ["temperature", "Error by temperature"];
    let axis = ["temperature, °C", "T = {} °C"];
    let caption =
        "An error that grows with the distance from the temperature of the calibration is drift.";
    by(report, names, axis, caption, |s| s.temperature_c)
}

fn by_date(report: &CheckReport) -> Option<Figure> {
    let stills = report.static_intervals.iter();
    let first = stills.filter_map(|s| s.recorded).min();
    let (since, name) = match report.sides[0].recorded {
        Some(calibrated) => (calibrated, "days since the calibration was recorded"),
        None => (first?, "days since the first rest"),
    };
    let days = |s: &StillCheck| Some(s.recorded?.days_since(since));
    let names = ["date", "Error by date"];
    let axis = [name, "{} d"];
    let caption = "An error that grows with time is drift of the sensor.";
    by(report, names, axis, caption, days)
}

/// The error of each rest over what `of` says of it; none where that hardly varies.
fn by(
    report: &CheckReport,
    [id, title]: [&str; 2],
    [name, at]: [&'static str; 2],
    caption: &str,
    of: impl Fn(&StillCheck) -> Option<f64>,
) -> Option<Figure> {
    let stills = report.static_intervals.iter();
    let points = stills.filter_map(|s| Some([of(s)?, milli_g(s.error_mps2)]));
    let points: Vec<[f64; 2]> = points.collect();
    let x = Axis::over(name, at, points.iter().map(|p| p[0]), 0.08);
    let is_spread = x.range[1] - x.range[0] > MIN_SPREAD && points.len() > 1;
    let y = Axis::around_zero("", points.iter().map(|p| p[1]));
    let series = [Series::points("rest", Role::Result, points)];
    let panel = Panel::new("Error of ‖a‖", "mg", [x, y], series).alone();
    is_spread.then(|| Figure::new(id, title, caption, [panel]))
}

/// Each parameter, B − A, in its own 95 % bar.
pub fn comparison(c: &Comparison) -> Vec<Figure> {
    let known = c
        .parameters
        .iter()
        .filter(|p| p.sigma.is_some_and(|s| s > 0.0));
    let known: Vec<_> = known.collect();
    let z = |p: &&gravical::compare::ParameterDifference| p.z.unwrap_or(f64::NAN);
    let rows = |of: Role, title: &str, is_in: &dyn Fn(f64) -> bool| {
        let values = known.iter().map(|p| {
            if is_in(z(p).abs()) {
                [z(p) / 2.0, 1.0]
            } else {
                [f64::NAN; 2]
            }
        });
        Series::in_rows(title, of, values)
    };
    let series = [
        rows(Role::Result, "B − A, ± 95 %", &|z| z <= 2.0),
        rows(Role::Bad, "beyond its bar", &|z| z > 2.0),
    ];
    let name = |p: &&gravical::compare::ParameterDifference| {
        format!("{}, {}", p.name.replace('_', " "), unit(p.unit))
    };
    let ends = known.iter().map(|p| (z(p) / 2.0).abs() + 1.0);
    let axes = [
        Axis::around_zero("", ends),
        Axis::rows(known.iter().map(name)),
    ];
    let panel = Panel::new("B − A, in its ± 95 %", "", axes, series);
    let caption = "A bar that reaches zero agrees: 95 % do where nothing changed.";
    let figure = Figure::new("parameters", "Each parameter", caption, [panel]);
    Some(figure)
        .filter(|_| !known.is_empty())
        .into_iter()
        .collect()
}
