//! Figure of many sessions: all errors in a strip, the largest by name.

use gravical::calibration_file::Grade;
use gravical::numfmt::milli_g;

use super::drawing::Figure;
use super::panel::{Axis, Panel, Role, Series, extent};
use crate::report::Session;

/// Errors that stand apart are named, so many at least and at most.
const NAMED: [usize; 2] = [5, 20];
/// Beyond the upper quartile by this many times the distance between quartiles, of logarithms (Tukey 1977).
const APART: f64 = 1.5;

/// The error of each session in its worst direction, by its grade.
pub fn sessions(all: &[Session]) -> Vec<Figure> {
    let log = |s: &Session| {
        s.error_mps2
            .map_or(f64::NAN, |error| milli_g(error).log10())
    };
    let mut sorted: Vec<&Session> = all.iter().filter(|s| log(s).is_finite()).collect();
    sorted.sort_by(|a, b| log(b).total_cmp(&log(a)));
    if sorted.is_empty() {
        return Vec::new();
    }
    let quartile = |k: usize| log(sorted[(sorted.len() - 1) * k / 4]);
    let limit = quartile(1) + APART * (quartile(1) - quartile(3));
    let apart = sorted.iter().filter(|s| log(s) > limit).count();
    let named = &sorted[..apart.clamp(NAMED[0], NAMED[1]).min(sorted.len())];
    let [low, high] = extent(sorted.iter().map(|s| log(s)));
    let x = Axis::new("", "", [low - 0.1, high + 0.1]).log();
    let names = named.iter().map(|s| s.name.clone());
    let rows = Axis::rows(std::iter::once(format!("all {}", sorted.len())).chain(names));
    let groups = [
        (Some(Grade::Good), "good", Role::Claim),
        (Some(Grade::Fair), "fair", Role::Warning),
        (Some(Grade::Poor), "poor", Role::Bad),
        (Some(Grade::NotVerifiable), "not verifiable", Role::Raw),
    ];
    let series = groups.into_iter().flat_map(|(grade, name, role)| {
        let strip = sorted.iter().filter(|s| s.grade == grade);
        let strip = Series::ticks(name, role, strip.map(|s| log(s)));
        let dots = (1..).zip(named).filter(|(_, s)| s.grade == grade);
        let dots = dots.map(|(row, s)| [log(s), f64::from(row)]);
        [strip, Series::points(name, role, dots)]
    });
    let panel = Panel::new(
        "Error in the worst direction, 95 %",
        "mg",
        [x, rows],
        series,
    );
    let caption = format!(
        "A line for each session; the {} largest by name.",
        named.len()
    );
    vec![Figure::new(
        "sessions",
        "Error of each calibration",
        caption,
        [panel],
    )]
}
