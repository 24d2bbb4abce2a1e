//! Figure, panel, axis, series.

/// A plot: one or several panels under one title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file and anchor in a page: lower case, words joined by `-`.
    pub name: String,
    /// Title.
    pub title: String,
    /// What it shows and what to look for, in a sentence or two. Screen readers
    /// read it in place of the picture.
    pub caption: String,
    /// How the panels stand.
    pub arrangement: Arrangement,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// How the panels of a figure stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// One below the other over the same x axis, which is labelled once.
    Stacked,
    /// Side by side, each with axes of its own; below each other where a page is
    /// narrow.
    Beside,
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
    /// A unit is as long on both axes.
    pub equal: bool,
    /// Height over width of the plot; none for the usual.
    pub aspect: Option<f64>,
    /// Shaded stretches of the x axis.
    pub stretches: Vec<Stretch>,
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
    /// No more than this is in view at first: what reaches beyond is cut off.
    pub within: Option<[f64; 2]>,
}

/// What stands along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Numbers.
    Linear,
    /// Positive numbers, equal ratios equally long.
    Log,
    /// Names at 0, 1, 2, …
    Names(Vec<String>),
    /// Nothing: a map, such as a sphere.
    Hidden,
}

/// A shaded stretch of the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// What it is: stretches of one name are toggled together.
    pub name: String,
    /// Where it starts.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
}

/// What a series is, which decides its colour, dash and symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Without the calibration: grey, dashed.
    Raw,
    /// With it: blue.
    Calibrated,
    /// What is true or expected: black, dotted.
    Reference,
    /// Wants attention: orange.
    Warning,
    /// Is wrong: vermilion.
    Bad,
    /// Along x: vermilion.
    X,
    /// Along y: green, dashed.
    Y,
    /// Along z: blue, dotted.
    Z,
    /// Helps the eye: thin and pale, not in the legend. Its points are texts
    /// without a symbol, about their places.
    Guide,
}

/// A symbol of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ×
    Cross,
    /// A small dot.
    Dot,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line; it breaks where a value is not finite.
    Line,
    /// The area between `low` and `high`; it breaks likewise.
    Band,
    /// Points, with bars from `low` to `high` where these are given and a text
    /// each where `labels` are.
    Points,
    /// Columns from 0 to y.
    Columns,
    /// A horizontal line right across at each y.
    Rule,
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
    /// Horizontal coordinates, unit of the axis; empty for a rule.
    pub x: Vec<f64>,
    /// Vertical coordinates; empty for a band.
    pub y: Vec<f64>,
    /// Lower ends of a band or of bars.
    pub low: Vec<f64>,
    /// Upper ends.
    pub high: Vec<f64>,
    /// A text for each point.
    pub labels: Vec<String>,
    /// Symbol of points; none for that of the role.
    pub symbol: Option<Symbol>,
    /// Samples that it stands for: more than its points where it was thinned.
    pub samples: usize,
}

impl Figure {
    /// The figure as it is drawn: on logarithmic axes with the logarithms to base ten. What is not
    /// positive has none.
    pub(super) fn drawn(&self) -> std::borrow::Cow<'_, Self> {
        let is_log = |axis: &Axis| axis.scale == Scale::Log;
        if !self.panels.iter().any(|p| is_log(&p.x) || is_log(&p.y)) {
            return std::borrow::Cow::Borrowed(self);
        }
        let mut figure = self.clone();
        let log = |v: &mut f64| *v = if *v > 0.0 { v.log10() } else { f64::NAN };
        for panel in &mut figure.panels {
            for axis in [&mut panel.x, &mut panel.y] {
                if is_log(axis) {
                    axis.include.iter_mut().for_each(log);
                    axis.within.iter_mut().flatten().for_each(log);
                }
            }
            if is_log(&panel.x) {
                panel.series.iter_mut().flat_map(|s| &mut s.x).for_each(log);
                for stretch in &mut panel.stretches {
                    [&mut stretch.from, &mut stretch.to]
                        .into_iter()
                        .for_each(log);
                }
            }
            if is_log(&panel.y) {
                for series in &mut panel.series {
                    let columns = [&mut series.y, &mut series.low, &mut series.high];
                    columns.into_iter().flatten().for_each(log);
                }
            }
        }
        std::borrow::Cow::Owned(figure)
    }

    /// A figure without panels, which will be stacked.
    #[must_use]
    pub fn new(name: &str, title: &str, caption: impl Into<String>) -> Self {
        Figure {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: caption.into(),
            arrangement: Arrangement::Stacked,
            panels: Vec::new(),
        }
    }

    /// The same, its panels side by side.
    #[must_use]
    pub fn beside(mut self) -> Self {
        self.arrangement = Arrangement::Beside;
        self
    }

    /// With one more panel.
    #[must_use]
    pub fn with(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }
}

impl Panel {
    /// An empty panel.
    #[must_use]
    pub fn new(x: Axis, y: Axis) -> Self {
        Panel {
            title: String::new(),
            x,
            y,
            equal: false,
            aspect: None,
            stretches: Vec::new(),
            series: Vec::new(),
        }
    }

    /// With a title.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// With axes of equal units in a plot of this height over width.
    #[must_use]
    pub fn equal(mut self, aspect: f64) -> Self {
        self.equal = true;
        self.aspect = Some(aspect);
        self
    }

    /// With one more series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// With a shaded stretch.
    #[must_use]
    pub fn shaded(mut self, name: &str, from: f64, to: f64) -> Self {
        let name = name.to_owned();
        self.stretches.push(Stretch { name, from, to });
        self
    }
}

impl Axis {
    /// An axis of numbers; `unit` may be empty.
    #[must_use]
    pub fn new(label: &str, unit: &str) -> Self {
        Axis {
            label: label.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
            include: Vec::new(),
            within: None,
        }
    }

    /// The same on a logarithmic scale.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.scale = Scale::Log;
        self
    }

    /// An axis of names, which stand at 0, 1, 2, …
    #[must_use]
    pub fn names(label: &str, names: Vec<String>) -> Self {
        Axis {
            scale: Scale::Names(names),
            ..Axis::new(label, "")
        }
    }

    /// An axis that is not drawn.
    #[must_use]
    pub fn hidden() -> Self {
        Axis {
            scale: Scale::Hidden,
            ..Axis::new("", "")
        }
    }

    /// With these values in view whatever the series are.
    #[must_use]
    pub fn including(mut self, values: &[f64]) -> Self {
        self.include.extend_from_slice(values);
        self
    }

    /// `velocity, m/s`.
    #[must_use]
    pub fn text(&self) -> String {
        match (self.label.as_str(), self.unit.as_str()) {
            (label, "") => label.to_owned(),
            ("", unit) => unit.to_owned(),
            (label, unit) => format!("{label}, {unit}"),
        }
    }
}

impl Series {
    fn new(name: &str, role: Role, mark: Mark, samples: usize) -> Self {
        Series {
            name: name.to_owned(),
            role,
            mark,
            x: Vec::new(),
            y: Vec::new(),
            low: Vec::new(),
            high: Vec::new(),
            labels: Vec::new(),
            symbol: None,
            samples,
        }
    }

    /// A line through all points; for long recordings see
    /// [`thin::line`](super::thin::line).
    #[must_use]
    pub fn line(name: &str, role: Role, x: Vec<f64>, y: Vec<f64>) -> Self {
        let samples = y.len();
        Series {
            x,
            y,
            ..Series::new(name, role, Mark::Line, samples)
        }
    }

    /// An area; for long recordings see [`thin::band`](super::thin::band).
    #[must_use]
    pub fn band(name: &str, role: Role, x: Vec<f64>, low: Vec<f64>, high: Vec<f64>) -> Self {
        let samples = x.len();
        Series {
            x,
            low,
            high,
            ..Series::new(name, role, Mark::Band, samples)
        }
    }

    /// Points.
    #[must_use]
    pub fn points(name: &str, role: Role, x: Vec<f64>, y: Vec<f64>) -> Self {
        let samples = y.len();
        Series {
            x,
            y,
            ..Series::new(name, role, Mark::Points, samples)
        }
    }

    /// Columns from zero.
    #[must_use]
    pub fn columns(name: &str, role: Role, x: Vec<f64>, y: Vec<f64>) -> Self {
        Series {
            mark: Mark::Columns,
            ..Series::points(name, role, x, y)
        }
    }

    /// A horizontal line across the panel.
    #[must_use]
    pub fn rule(name: &str, role: Role, y: f64) -> Self {
        Series {
            y: vec![y],
            ..Series::new(name, role, Mark::Rule, 1)
        }
    }

    /// With bars of ± `half` at the points; a half that is not finite draws none.
    #[must_use]
    pub fn plus_minus(mut self, half: &[f64]) -> Self {
        self.low = self.y.iter().zip(half).map(|(y, h)| y - h).collect();
        self.high = self.y.iter().zip(half).map(|(y, h)| y + h).collect();
        self
    }

    /// With this symbol in place of the role's.
    #[must_use]
    pub fn drawn_as(mut self, symbol: Symbol) -> Self {
        self.symbol = Some(symbol);
        self
    }

    /// With a text at each point.
    #[must_use]
    pub fn labelled(mut self, labels: Vec<String>) -> Self {
        self.labels = labels;
        self
    }
}
