//! Panel, axis, series: what is drawn, in the units of the result.

use std::collections::BTreeSet;

/// One pair of axes and what is drawn in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Quantity and unit, above it.
    pub name: String,
    /// What stands behind the name, such as an rms; empty for nothing.
    pub note: String,
    /// Unit of the values, that the cursor reads.
    pub unit: String,
    /// Below it.
    pub x: Axis,
    /// On its left.
    pub y: Axis,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
    /// Panels of one link have one cursor and one zoom, across figures.
    pub link: Option<&'static str>,
    /// Height at least, in rem; it grows with its card.
    pub height_rem: f64,
}

/// An axis; its range is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name and unit; empty for none.
    pub name: String,
    /// What the cursor says, with {} for the value: `t = {} s`.
    pub reads: &'static str,
    /// What is in view: logarithms on a logarithmic axis.
    pub range: [f64; 2],
    /// What stands along it.
    pub scale: Scale,
}

/// What stands along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Numbers.
    Linear,
    /// Series have the decimal logarithms.
    Log,
    /// A row for each name, from the top, at 0, 1, 2, …; of a y axis only.
    Rows(Vec<String>),
}

/// What a series is, which decides its colour and dash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Without the calibration.
    Raw,
    /// The result, with it where there is one.
    Result,
    /// What is true or expected.
    Reference,
    /// What is claimed.
    Claim,
    /// Wants attention.
    Warning,
    /// Is wrong.
    Bad,
    /// Where the sensor rests.
    Rest,
    /// Along x, y or z.
    Axis(usize),
}

/// Values of one name, in the units of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend, which series of one name share; empty for none.
    pub name: String,
    /// What it is.
    pub role: Role,
    /// Its values.
    pub mark: Mark,
}

/// How they are drawn. What is not finite is left out, and breaks a line.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line.
    Line(Vec<[f64; 2]>),
    /// The area between two lines: x, low, high.
    Band(Vec<[f64; 3]>),
    /// Points; with half of a horizontal bar where it is finite.
    Points(Vec<[f64; 3]>),
    /// The height of the panel from each first to each second x.
    Shade(Vec<[f64; 2]>),
    /// Short lines at the top.
    Ticks(Vec<f64>),
}

/// The axes of a vector.
pub(crate) const XYZ: [&str; 3] = ["x", "y", "z"];

/// Height of a panel, rem: alone, and of one of three.
pub(super) const ALONE_REM: f64 = 14.0;
const USUAL_REM: f64 = 6.6;
/// Of a row, and of what a panel of rows has besides.
const ROW_REM: f64 = 1.25;

impl Role {
    /// Class of the style sheet.
    pub(super) fn class(self) -> &'static str {
        match self {
            Role::Raw => "raw",
            Role::Result => "result",
            Role::Reference => "reference",
            Role::Claim => "claim",
            Role::Warning => "warn",
            Role::Bad => "bad",
            Role::Rest => "rest",
            Role::Axis(k) => XYZ[k % 3],
        }
    }
}

impl Panel {
    /// A panel of these series: its name is the quantity with its unit.
    pub fn new(
        quantity: &str,
        unit: &str,
        [x, y]: [Axis; 2],
        series: impl IntoIterator<Item = Series>,
    ) -> Self {
        let parts = [quantity, unit].into_iter().filter(|part| !part.is_empty());
        let rows = match &y.scale {
            Scale::Rows(names) => Some(names.len()),
            _ => None,
        };
        Panel {
            name: parts.collect::<Vec<_>>().join(", "),
            note: String::new(),
            unit: unit.to_owned(),
            x,
            y,
            series: series.into_iter().collect(),
            link: None,
            height_rem: rows.map_or(USUAL_REM, |rows| ROW_REM * rows.max(4) as f64),
        }
    }

    /// With a text behind its name.
    pub fn noted(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// With cursor and zoom in common with others of this link.
    pub fn linked(mut self, link: &'static str) -> Self {
        self.link = Some(link);
        self
    }

    /// As high as one that stands alone.
    pub fn alone(mut self) -> Self {
        self.height_rem = ALONE_REM;
        self
    }
}

impl Axis {
    /// Numbers in this range.
    pub fn new(name: &str, reads: &'static str, [low, high]: [f64; 2]) -> Self {
        let range = match high - low {
            span if span > 0.0 && span.is_finite() => [low, high],
            _ if low.is_finite() => [low - 1.0, low + 1.0],
            _ => [0.0, 1.0],
        };
        Axis {
            name: name.to_owned(),
            reads,
            range,
            scale: Scale::Linear,
        }
    }

    /// Numbers, from the smallest to the largest of the values and this share of them beyond.
    pub fn over(
        name: &str,
        reads: &'static str,
        values: impl IntoIterator<Item = f64>,
        margin: f64,
    ) -> Self {
        let [low, high] = extent(values);
        let room = margin * (high - low);
        Axis::new(name, reads, [low - room, high + room])
    }

    /// The same distance on both sides of zero, a tenth beyond the largest value.
    pub fn around_zero(name: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let sizes = values.into_iter().map(f64::abs).filter(|v| v.is_finite());
        let most = 1.1 * sizes.fold(0.0, f64::max);
        Axis::new(name, "", [-most, most])
    }

    /// A row for each name.
    pub fn rows(names: impl IntoIterator<Item = String>) -> Self {
        let names = names.into_iter().map(|name| shorten(signs(&name)));
        let names: Vec<String> = names.collect();
        Axis {
            scale: Scale::Rows(names.clone()),
            ..Axis::new("", "", [0.0, names.len() as f64])
        }
    }

    /// The same over logarithms.
    pub fn log(self) -> Self {
        let scale = Scale::Log;
        Axis { scale, ..self }
    }
}

impl Series {
    fn new(name: &str, role: Role, mark: Mark) -> Self {
        let name = name.to_owned();
        Series { name, role, mark }
    }

    /// A line through all points, thinned; it breaks where one is not finite, and at `breaks`: the rows, in order,
    /// before which samples are missing.
    pub fn line(
        name: &str,
        role: Role,
        points: impl IntoIterator<Item = [f64; 2]>,
        breaks: &[usize],
    ) -> Self {
        Series::new(name, role, Mark::Line(kept(points, breaks)))
    }

    /// An area between two curves, thinned likewise: x, low, high.
    pub fn band(
        name: &str,
        role: Role,
        rows: impl IntoIterator<Item = [f64; 3]>,
        breaks: &[usize],
    ) -> Self {
        Series::new(name, role, Mark::Band(kept(rows, breaks)))
    }

    /// Points.
    pub fn points(name: &str, role: Role, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let points = points.into_iter().map(|[x, y]| [x, y, f64::NAN]);
        Series::new(name, role, Mark::Points(points.collect()))
    }

    /// A value in each row, with half of its bar.
    pub fn in_rows(name: &str, role: Role, values: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let points = values.into_iter().enumerate();
        let points = points.map(|(i, [value, half])| [value, i as f64, half]);
        Series::new(name, role, Mark::Points(points.collect()))
    }

    /// Shaded intervals of the x axis.
    pub fn shade(name: &str, role: Role, intervals: &[[f64; 2]]) -> Self {
        let known = intervals
            .iter()
            .filter(|ends| ends.iter().all(|v| v.is_finite()));
        Series::new(name, role, Mark::Shade(known.copied().collect()))
    }

    /// Short lines at the top.
    pub fn ticks(name: &str, role: Role, at: impl IntoIterator<Item = f64>) -> Self {
        let known = at.into_iter().filter(|at| at.is_finite());
        Series::new(name, role, Mark::Ticks(known.collect()))
    }

    /// Whether there is something to draw.
    pub fn has_values(&self) -> bool {
        match &self.mark {
            Mark::Line(points) => points.iter().flatten().any(|v| v.is_finite()),
            Mark::Band(rows) => rows.iter().flatten().any(|v| v.is_finite()),
            Mark::Points(points) => points.iter().any(|p| p[0].is_finite() && p[1].is_finite()),
            Mark::Shade(spans) => !spans.is_empty(),
            Mark::Ticks(at) => !at.is_empty(),
        }
    }
}

/// Smallest and largest of the finite values.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let values = values.into_iter().filter(|v| v.is_finite());
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

/// With typographic minus signs before numbers and axes.
pub(crate) fn signs(text: &str) -> String {
    let mut before = ' ';
    let mut chars = text.chars().peekable();
    let mut out = String::with_capacity(text.len());
    while let Some(c) = chars.next() {
        let follows = |next: &char| next.is_ascii_digit() || "xyz".contains(*next);
        let is_sign = c == '-' && " (±".contains(before) && chars.peek().is_some_and(follows);
        out.push(if is_sign { '−' } else { c });
        before = c;
    }
    out
}

/// Characters of the longest name that a figure has room for.
const MAX_NAME: usize = 23;

/// Takes the middle out of a longer name.
fn shorten(name: String) -> String {
    let count = name.chars().count();
    if count <= MAX_NAME {
        return name;
    }
    let head = name.chars().take(MAX_NAME / 2);
    let tail = name.chars().skip(count - MAX_NAME / 2);
    head.chain(['…']).chain(tail).collect()
}

/// Parts of a curve of which only the extremes are drawn where it is still long: more than that are noise on a screen.
const PARTS: usize = 400;
/// The same before the curve is straightened, which takes time.
const FINE_PARTS: usize = 4 * PARTS;
/// A row stays if a straight line misses it by more than this share of its column's range: a tenth of a dot.
const TOLERANCE: f64 = 6e-4;

/// The rows to draw, x first, with one that is no number where the line breaks.
fn kept<const N: usize>(
    rows: impl IntoIterator<Item = [f64; N]>,
    breaks: &[usize],
) -> Vec<[f64; N]> {
    let rows: Vec<[f64; N]> = rows.into_iter().collect();
    let spans: [f64; N] = std::array::from_fn(|c| {
        let [low, high] = extent(rows.iter().map(|row| row[c]));
        if high > low { high - low } else { 1.0 }
    });
    let missing = |i: usize| rows[i].iter().any(|v| !v.is_finite());
    let together =
        |a: &usize, b: &usize| missing(*a) == missing(*b) && breaks.binary_search(b).is_err();
    let all: Vec<usize> = (0..rows.len()).collect();
    let thinned = |run: Vec<usize>, parts: usize| -> Vec<usize> {
        let part = rows.len().div_ceil(parts);
        let parts = run.chunk_by(|a, b| a / part == b / part);
        let inner = parts.flat_map(|part| extremes(&rows, part));
        let ends = [run.first(), run.last()].into_iter().flatten().copied();
        let kept: BTreeSet<usize> = inner.chain(ends).collect();
        kept.into_iter().collect()
    };
    let (mut out, mut straight) = (Vec::new(), 0);
    for run in all.chunk_by(together).filter(|run| !missing(run[0])) {
        if !out.is_empty() {
            out.push([f64::NAN; N]);
        }
        let mut run = run.to_vec();
        if rows.len() > 4 * FINE_PARTS {
            run = thinned(run, FINE_PARTS);
        }
        run = straightened(&rows, &run, &spans);
        straight += run.len();
        if straight > 2 * PARTS {
            run = thinned(run, PARTS);
        }
        out.extend(run.into_iter().map(|i| rows[i]));
    }
    out
}

/// Of some rows those with the smallest and the largest of each value over x, so that no spike is lost.
fn extremes<const N: usize>(rows: &[[f64; N]], part: &[usize]) -> BTreeSet<usize> {
    let of = |c: usize| {
        let order = |a: &&usize, b: &&usize| rows[**a][c].total_cmp(&rows[**b][c]);
        [part.iter().min_by(order), part.iter().max_by(order)]
    };
    (1..N).flat_map(of).flatten().copied().collect()
}

/// Of the rows `run` those between which straight lines are off by at most [`TOLERANCE`] (Ramer, Computer Graphics and
/// Image Processing 1, 1972; Douglas and Peucker, Cartographica 10, 1973).
pub(super) fn straightened<const N: usize>(
    rows: &[[f64; N]],
    run: &[usize],
    spans: &[f64; N],
) -> Vec<usize> {
    let mut kept = vec![0];
    let mut open = vec![run.len() - 1];
    while let (Some(&b), Some(&a)) = (open.last(), kept.last()) {
        let (from, to) = (rows[run[a]], rows[run[b]]);
        let off = |i: usize| {
            let row = rows[run[i]];
            let share = (row[0] - from[0]) / (to[0] - from[0]).max(f64::MIN_POSITIVE);
            let off = |c: usize| (row[c] - from[c] - share * (to[c] - from[c])).abs() / spans[c];
            (1..N).map(off).fold(0.0, f64::max)
        };
        let worst = (a + 1..b).map(|i| (i, off(i)));
        let worst = worst.max_by(|x, y| x.1.total_cmp(&y.1));
        match worst.filter(|(_, off)| *off > TOLERANCE) {
            Some((i, _)) => open.push(i),
            None => kept.extend(open.pop().filter(|b| *b > a)),
        }
    }
    kept.into_iter().map(|i| run[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: impl IntoIterator<Item = [f64; 2]>, breaks: &[usize]) -> Vec<[f64; 2]> {
        match Series::line("a", Role::Raw, points, breaks).mark {
            Mark::Line(points) => points,
            _ => Vec::new(),
        }
    }

    #[test]
    fn one_spike_among_a_million_stays() {
        let spike = |i: u32| match i {
            123_457 => 50.0,
            765_431 => -60.0,
            _ => f64::from(i).sin(),
        };
        let points = line((0..1_000_000).map(|i| [f64::from(i) * 0.01, spike(i)]), &[]);
        assert!(points.len() <= 4 * PARTS + 4 && points.is_sorted_by(|a, b| a[0] <= b[0]));
        let has = |v: f64| points.iter().any(|p| p[1] == v);
        assert!(has(50.0) && has(-60.0));
        assert_eq!(
            (points[0][0], points.last().map(|p| p[0])),
            (0.0, Some(9999.99))
        );
    }

    #[test]
    fn a_smooth_curve_is_no_further_off_than_said() {
        let curve = |x: f64| (x * x).sin();
        let points = line(
            (0..3000)
                .map(|i| f64::from(i) * 1e-3)
                .map(|x| [x, curve(x)]),
            &[],
        );
        assert!(points.len() < 400, "{}", points.len());
        for pair in points.windows(2) {
            let [[a, ya], [b, yb]] = [pair[0], pair[1]];
            let x = 0.5 * (a + b);
            assert!((curve(x) - 0.5 * (ya + yb)).abs() < 2.2 * TOLERANCE);
        }
    }

    #[test]
    fn no_line_leads_over_what_is_missing() {
        // The second is thinned; what is missing lies between the parts that are kept.
        for rows in [100, 100_000] {
            let missing = rows / 5 + 1..rows / 5 + rows / 20;
            let value = |i: usize| if missing.contains(&i) { f64::NAN } else { 1.0 };
            let points = line((0..rows).map(|i| [i as f64, value(i)]), &[rows / 2]);
            let gaps: Vec<usize> = (0..points.len())
                .filter(|i| points[*i][0].is_nan())
                .collect();
            let ends: Vec<[f64; 2]> = gaps
                .iter()
                .map(|&i| [points[i - 1][0], points[i + 1][0]])
                .collect();
            let around = |from: usize, to: usize| [(from - 1) as f64, to as f64];
            let expected = [
                around(missing.start, missing.end),
                around(rows / 2, rows / 2),
            ];
            assert_eq!(ends, expected);
        }
    }
}
