//! Figure, panel, axis, series: what is drawn, in the units of the result.

use std::collections::BTreeSet;

/// A plot: one or several panels under one title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file and anchor in a page: lower case, words joined by `-`.
    pub name: String,
    /// Title.
    pub title: String,
    /// What it shows and what to look for, in a sentence or two. Screen readers read it in place
    /// of the picture.
    pub caption: String,
    /// Panels stand side by side, each with axes of its own; else one below the other over one
    /// x axis, which is labelled once.
    pub beside: bool,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// One pair of axes and what is drawn in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Title above it; empty for none.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// A unit is as long on both axes, in a square plot.
    pub equal: bool,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the quantity.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// What stands along it.
    pub scale: Scale,
    /// Values that must be in view, besides the series'.
    pub include: Vec<f64>,
    /// At most this is in view: what reaches beyond is cut off.
    pub within: Option<[f64; 2]>,
}

/// What stands along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Numbers.
    Linear,
    /// Positive numbers, of which series have the decimal logarithms.
    Log,
    /// Names at 0, 1, 2, …; of an x axis only.
    Names(Vec<String>),
    /// Nothing: both axes of a map, such as a sphere.
    Hidden,
}

/// What a series is, which decides its colour, dash and symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Without the calibration.
    Raw,
    /// The result, with it where there is one.
    Result,
    /// What is true or expected.
    Reference,
    /// Wants attention.
    Warning,
    /// Is wrong.
    Bad,
    /// Intervals of the x axis.
    Interval,
    /// Helps the eye: thin and pale, not in the legend. Its points are texts without a symbol.
    Guide,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line; it breaks where a value is not finite.
    Line,
    /// The area between `low` and `high`; it breaks likewise.
    Band,
    /// Points, with bars from `low` to `high` where these are given.
    Points,
    /// The height of the panel from each first to each second x.
    Shade,
}

/// Values of one name. All columns are equally long or empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend: series of one name in several panels are one entry.
    pub name: String,
    /// What it is.
    pub role: Role,
    /// How it is drawn.
    pub mark: Mark,
    /// Horizontal coordinates.
    pub x: Vec<f64>,
    /// Vertical coordinates; empty for a band.
    pub y: Vec<f64>,
    /// Lower ends of a band or of bars.
    pub low: Vec<f64>,
    /// Upper ends.
    pub high: Vec<f64>,
    /// A text for each point.
    pub labels: Vec<String>,
}

/// The axes of a vector.
pub(crate) const XYZ: [&str; 3] = ["x", "y", "z"];

impl Figure {
    /// A figure of these panels, one below the other.
    pub fn new(
        name: &str,
        title: &str,
        caption: impl Into<String>,
        panels: impl IntoIterator<Item = Panel>,
    ) -> Self {
        Figure {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: caption.into(),
            beside: false,
            panels: panels.into_iter().collect(),
        }
    }

    /// With the panels side by side.
    pub fn beside(mut self) -> Self {
        self.beside = true;
        self
    }
}

impl Panel {
    /// A panel of these series.
    pub fn new(title: &str, x: Axis, y: Axis, series: impl IntoIterator<Item = Series>) -> Self {
        Panel {
            title: title.to_owned(),
            x,
            y,
            equal: false,
            series: series.into_iter().collect(),
        }
    }

    /// With axes of equal units in a square plot.
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }
}

impl Axis {
    /// An axis of numbers; `unit` may be empty.
    pub fn new(label: &str, unit: &str) -> Self {
        Axis {
            label: label.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
            include: Vec::new(),
            within: None,
        }
    }

    /// An axis of this scale; long names lose their middle.
    pub fn scaled(label: &str, unit: &str, mut scale: Scale) -> Self {
        if let Scale::Names(names) = &mut scale {
            names.iter_mut().for_each(shorten);
        }
        Axis {
            scale,
            ..Axis::new(label, unit)
        }
    }
}

impl Series {
    fn new(name: &str, role: Role, mark: Mark, x: Vec<f64>, y: Vec<f64>) -> Self {
        Series {
            name: name.to_owned(),
            role,
            mark,
            x,
            y,
            low: Vec::new(),
            high: Vec::new(),
            labels: Vec::new(),
        }
    }

    /// A line through all points.
    pub fn line(name: &str, role: Role, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (x, y) = points.into_iter().unzip();
        Series::new(name, role, Mark::Line, x, y)
    }

    /// An area between two curves.
    pub fn band(name: &str, role: Role, x: Vec<f64>, low: Vec<f64>, high: Vec<f64>) -> Self {
        Series {
            low,
            high,
            ..Series::new(name, role, Mark::Band, x, Vec::new())
        }
    }

    /// Points.
    pub fn points(name: &str, role: Role, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (x, y) = points.into_iter().unzip();
        Series::new(name, role, Mark::Points, x, y)
    }

    /// Points at 0, 1, 2, …, where names stand; what is not finite is left out.
    pub fn categorical(name: &str, role: Role, y: impl IntoIterator<Item = f64>) -> Self {
        let y = y.into_iter().enumerate();
        Series::points(name, role, y.map(|(i, y)| (i as f64, y)))
    }

    /// Shaded intervals of the x axis.
    pub fn intervals(name: &str, intervals: &[[f64; 2]]) -> Self {
        let x = intervals.as_flattened().to_vec();
        Series::new(name, Role::Interval, Mark::Shade, x, Vec::new())
    }

    /// With bars of ± `half` at the points; a half that is not finite draws none.
    pub fn plus_minus(mut self, half: &[f64]) -> Self {
        self.low = self.y.iter().zip(half).map(|(y, h)| y - h).collect();
        self.high = self.y.iter().zip(half).map(|(y, h)| y + h).collect();
        self
    }

    /// With a text at each point.
    pub fn labelled(mut self, labels: impl IntoIterator<Item = String>) -> Self {
        self.labels = labels.into_iter().collect();
        self.labels.iter_mut().for_each(shorten);
        self
    }

    /// Whether there is something to draw.
    pub(super) fn has_values(&self) -> bool {
        let shade = self.mark == Mark::Shade && !self.x.is_empty();
        shade || self.y.iter().chain(&self.low).any(|v| v.is_finite())
    }

    /// Thinned if its rows are many. It breaks where a value is not finite and at `breaks`: the
    /// rows, in order, before which samples are missing.
    pub fn thinned(mut self, breaks: &[usize]) -> Self {
        let rows = match self.mark {
            Mark::Band => thinned_rows([&self.low, &self.high], breaks),
            _ => thinned_rows([&self.x, &self.y], breaks),
        };
        for column in [&mut self.x, &mut self.y, &mut self.low, &mut self.high] {
            if !column.is_empty() {
                let value = |row: &Option<usize>| row.map_or(f64::NAN, |i| column[i]);
                *column = rows.iter().map(value).collect();
            }
        }
        self
    }
}

/// Characters of the longest name that a figure has room for.
const MAX_NAME: usize = 23;

/// Takes the middle out of a longer name.
fn shorten(name: &mut String) {
    let count = name.chars().count();
    if count > MAX_NAME {
        let head = name.chars().take(MAX_NAME / 2);
        let tail = name.chars().skip(count - MAX_NAME / 2);
        *name = head.chain(['…']).chain(tail).collect();
    }
}

/// Rows above which a series is thinned.
const LIMIT: usize = 8000;

/// Parts of equally many rows that a thinned series consists of: two to three for each dot of a
/// plot that fills a page, so that zooming in shows more.
const BUCKETS: usize = 2000;

/// The rows of a series to draw, in order; none where it breaks. Of each part the rows with the
/// smallest and the largest of either value stay, so that no spike is lost.
fn thinned_rows(values: [&[f64]; 2], breaks: &[usize]) -> Vec<Option<usize>> {
    let all: Vec<usize> = (0..values[0].len()).collect();
    let step = match all.len() {
        rows if rows > LIMIT => rows.div_ceil(BUCKETS),
        _ => 1,
    };
    let missing = |i: usize| values.iter().any(|v| !v[i].is_finite());
    let together =
        |a: &usize, b: &usize| missing(*a) == missing(*b) && breaks.binary_search(b).is_err();
    let mut rows = Vec::new();
    for run in all.chunk_by(together).filter(|run| !missing(run[0])) {
        if !rows.is_empty() {
            rows.push(None);
        }
        for part in run.chunks(step) {
            let extremes = values.iter().flat_map(|v| {
                let order = |a: &&usize, b: &&usize| v[**a].total_cmp(&v[**b]);
                [part.iter().min_by(order), part.iter().max_by(order)]
            });
            let extremes: BTreeSet<usize> = extremes.flatten().copied().collect();
            rows.extend(extremes.into_iter().map(Some));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_spike_among_a_million_stays() {
        let spike = |i: u32| match i {
            123_457 => 50.0,
            765_431 => -60.0,
            _ => f64::from(i).sin(),
        };
        let points = (0..1_000_000).map(|i| (f64::from(i) * 0.01, spike(i)));
        let s = Series::line("a", Role::Raw, points).thinned(&[]);
        assert!(s.x.len() <= 4 * BUCKETS && s.x.is_sorted());
        assert!(s.y.contains(&50.0) && s.y.contains(&-60.0));
        assert_eq!((s.x[0], s.x.last()), (0.0, Some(&9999.99)));
    }

    #[test]
    fn no_line_leads_over_what_is_missing() {
        // The second is thinned; what is missing lies between the parts that are kept.
        for rows in [100, 100_000] {
            let missing = rows / 5 + 1..rows / 5 + rows / 20;
            let value = |i: usize| if missing.contains(&i) { f64::NAN } else { 1.0 };
            let points = (0..rows).map(|i| (i as f64, value(i)));
            let s = Series::line("a", Role::Raw, points).thinned(&[rows / 2]);
            let gaps: Vec<usize> = (0..s.x.len()).filter(|i| s.x[*i].is_nan()).collect();
            let ends: Vec<[f64; 2]> = gaps.iter().map(|&i| [s.x[i - 1], s.x[i + 1]]).collect();
            let around = |from: usize, to: usize| [(from - 1) as f64, to as f64];
            let expected = [
                around(missing.start, missing.end),
                around(rows / 2, rows / 2),
            ];
            assert_eq!(ends, expected);
        }
    }
}
