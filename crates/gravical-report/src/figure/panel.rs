//! Figure, panel, axis, series: what is drawn, in the units of the result.

/// A plot: one or several panels under one title.
#[must_use]
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
#[must_use]
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
#[must_use]
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
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
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
#[must_use]
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
    /// Symbol of points as a path about 0, 0; none for that of the role.
    pub symbol: Option<&'static str>,
}

/// The three axes of a vector with the roles of their series.
pub(super) const XYZ: [(&str, Role); 3] = [("x", Role::X), ("y", Role::Y), ("z", Role::Z)];

impl Figure {
    /// A figure without panels.
    pub fn new(name: &str, title: &str, caption: impl Into<String>) -> Self {
        Figure {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: caption.into(),
            beside: false,
            panels: Vec::new(),
        }
    }

    /// With one more panel.
    pub fn with(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// With these panels, side by side.
    pub fn beside(mut self, panels: impl IntoIterator<Item = Panel>) -> Self {
        self.beside = true;
        self.panels.extend(panels);
        self
    }
}

impl Panel {
    /// An empty panel.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Panel {
            title: title.to_owned(),
            x,
            y,
            equal: false,
            series: Vec::new(),
        }
    }

    /// With axes of equal units in a square plot.
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }

    /// With one more series.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
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

    /// An axis of positive numbers, of which series have the decimal logarithms.
    pub fn log(label: &str, unit: &str) -> Self {
        Axis {
            scale: Scale::Log,
            ..Axis::new(label, unit)
        }
    }

    /// An axis of names, which stand at 0, 1, 2, …; long ones lose their middle.
    pub fn names(label: &str, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let names = names.into_iter().map(|name| short(name.into()));
        let scale = Scale::Names(names.collect());
        Axis {
            scale,
            ..Axis::new(label, "")
        }
    }

    /// An axis that is not drawn, over these values at least.
    pub fn hidden(include: [f64; 2]) -> Self {
        Axis {
            scale: Scale::Hidden,
            ..Axis::new("", "").including(&include)
        }
    }

    /// With these values in view whatever the series are.
    pub fn including(mut self, values: &[f64]) -> Self {
        self.include.extend_from_slice(values);
        self
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
            symbol: None,
        }
    }

    /// A line through all points.
    pub fn line(name: &str, role: Role, x: Vec<f64>, y: Vec<f64>) -> Self {
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

    /// Thinned if its rows are many. It breaks where a value is not finite and at `breaks`: the
    /// rows, in order, before which samples are missing.
    pub fn thinned(mut self, breaks: &[usize]) -> Self {
        let (first, second) = match self.mark {
            Mark::Band => (&self.low, &self.high),
            _ => (&self.x, &self.y),
        };
        let rows = self.x.len().min(first.len()).min(second.len());
        let shown = thinned_rows(rows, breaks, |i| [first[i], second[i]]);
        let pick = |column: &Vec<f64>| -> Vec<f64> {
            let value = |i: &Option<usize>| i.map_or(f64::NAN, |i| column[i]);
            shown.iter().map(value).collect()
        };
        for column in [&mut self.x, &mut self.y, &mut self.low, &mut self.high] {
            if !column.is_empty() {
                *column = pick(column);
            }
        }
        self
    }

    /// Points.
    pub fn points(name: &str, role: Role, x: Vec<f64>, y: Vec<f64>) -> Self {
        Series::new(name, role, Mark::Points, x, y)
    }

    /// Points at 0, 1, 2, …, where names stand; what is not finite is left out.
    pub fn categorical(name: &str, role: Role, y: impl IntoIterator<Item = f64>) -> Self {
        let y: Vec<f64> = y.into_iter().collect();
        let x = (0..y.len()).map(|i| i as f64).collect();
        Series::points(name, role, x, y)
    }

    /// A horizontal line across as many names.
    pub fn rule(name: &str, y: f64, names: usize) -> Self {
        let x = vec![-0.5, names as f64 - 0.5];
        Series::line(name, Role::Reference, x, vec![y; 2])
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

    /// Whether there is something to draw.
    pub(super) fn has_values(&self) -> bool {
        let shade = self.mark == Mark::Shade && !self.x.is_empty();
        shade || self.y.iter().chain(&self.low).any(|v| v.is_finite())
    }

    /// With this symbol in place of the role's.
    pub fn drawn_as(mut self, symbol: &'static str) -> Self {
        self.symbol = Some(symbol);
        self
    }

    /// With a text at each point.
    pub fn labelled(mut self, labels: Vec<String>) -> Self {
        self.labels = labels.into_iter().map(short).collect();
        self
    }
}

/// Characters of the longest name that a figure has room for.
const MAX_NAME: usize = 23;

/// A longer name without its middle.
fn short(name: String) -> String {
    let count = name.chars().count();
    if count <= MAX_NAME {
        return name;
    }
    let head = name.chars().take(MAX_NAME / 2);
    let tail = name.chars().skip(count - MAX_NAME / 2);
    head.chain(['…']).chain(tail).collect()
}

/// Rows above which a series is thinned.
const LIMIT: usize = 8000;

/// Parts of equally many rows that a thinned series consists of: two to three for each dot of a
/// plot that fills a page, so that zooming in shows more.
const BUCKETS: usize = 2000;

/// The rows of a series to draw, in order; none where it breaks. Of each part the rows with the
/// smallest and the largest of either value stay, so that no spike is lost.
fn thinned_rows(
    rows: usize,
    breaks: &[usize],
    value: impl Fn(usize) -> [f64; 2],
) -> Vec<Option<usize>> {
    let step = if rows > LIMIT {
        rows.div_ceil(BUCKETS)
    } else {
        1
    };
    let missing = |i: &usize| value(*i).iter().any(|v| !v.is_finite());
    let all: Vec<usize> = (0..rows).collect();
    let together =
        |a: &usize, b: &usize| missing(a) == missing(b) && breaks.binary_search(b).is_err();
    let mut shown = Vec::new();
    for run in all.chunk_by(together).filter(|run| !missing(&run[0])) {
        if !shown.is_empty() {
            shown.push(None);
        }
        for part in run.chunks(step) {
            let mut extremes: Vec<usize> = Vec::new();
            for column in [0, 1] {
                let order =
                    |a: &&usize, b: &&usize| value(**a)[column].total_cmp(&value(**b)[column]);
                extremes.extend(part.iter().min_by(order));
                extremes.extend(part.iter().max_by(order));
            }
            extremes.sort_unstable();
            extremes.dedup();
            shown.extend(extremes.into_iter().map(Some));
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_spike_among_a_million_stays() {
        let t: Vec<f64> = (0..1_000_000).map(|i| f64::from(i) * 0.01).collect();
        let spike = |i: usize| match i {
            123_457 => 50.0,
            765_431 => -60.0,
            _ => (i as f64).sin(),
        };
        let y = |up: f64| (0..t.len()).map(|i| spike(i) + up).collect();
        let s = Series::line("a", Role::Raw, t.clone(), y(0.0)).thinned(&[]);
        assert!(s.x.len() <= 4 * BUCKETS && s.x.is_sorted());
        assert!(s.y.contains(&50.0) && s.y.contains(&-60.0));
        assert_eq!((s.x[0], s.x.last()), (0.0, t.last()));
        let s = Series::band("b", Role::Raw, t.clone(), y(0.0), y(1.0)).thinned(&[]);
        assert!(s.low.contains(&-60.0) && s.high.contains(&51.0));
    }

    #[test]
    fn no_line_leads_over_what_is_missing() {
        // The second is thinned; what is missing lies between the parts that are kept.
        for rows in [100, 100_000] {
            let missing = rows / 5 + 1..rows / 5 + rows / 20;
            let value = |i: usize| if missing.contains(&i) { f64::NAN } else { 1.0 };
            let (x, y) = (0..rows).map(|i| (i as f64, value(i))).unzip();
            let s = Series::line("a", Role::Raw, x, y).thinned(&[rows / 2]);
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
