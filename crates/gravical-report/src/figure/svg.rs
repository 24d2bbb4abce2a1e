//! Figures as SVG.
//!
//! # Structure, on which the script of the page and its style sheet rely
//!
//! ```text
//! svg.gv[role=img]            title and desc say what it is
//!   g.legend > g.entry[data-name]
//!   g.panel
//!     g.ticks.tx, g.ticks.ty  lines of the grid and their labels
//!     rect.frame
//!     svg.plot                clips to the plot; its own units are dots from its corner
//!       g.series.ROLE[data-name][data-mark]
//!         g.data              a path with class s (stroke) or f (fill)
//!         g.at                symbols and texts, moved to their places
//! ```
//!
//! A panel over linear axes, in which the script reads values and zooms, has
//! `data-plot="x y w h"`, `data-view="x0 x1 y0 y1"`, the part of the axes that the plot shows,
//! `data-title`, `data-x` and `data-unit` (of y): a dot `(px, py)` of a path stands for
//! x0 + px/w (x1 − x0), y1 − py/h (y1 − y0), to 0.01 of a dot.

use std::fmt::Write;

use gravical::escape;
use gravical::numfmt::{decimals_for, fixed};
use maud::{Markup, PreEscaped, html};

use super::{Axis, Figure, Mark, Panel, Role, Scale, Series};

/// Width of a whole figure, and of a panel that stands beside others.
const WIDTH: f64 = 760.0;
const HALF: f64 = 372.0;

/// Largest number that a view includes: the difference of two must not overflow.
const MAX_DRAWN: f64 = 1e300;

/// The labels of more points than this show on hovering only.
const MAX_LABELLED: usize = 40;

/// Colours are those of Okabe and Ito (2008), which the colour blind can tell apart; symbols and
/// lightness differ too, for print in grey.
const STYLE: &str = "\
.gv{font-size:12px;font-family:system-ui,'DejaVu Sans','Segoe UI',sans-serif}.gv text{fill:#1a1a1a}\
.gv .minor{fill:#444;font-size:11px}.gv .panel-title,.gv .title{font-weight:bold}.gv .title{font-size:15px}\
.gv .paper{fill:#fff}.gv .frame{fill:none;stroke:#8a8a8a}.gv .ticks path{fill:none;stroke:#e3e3e3}.gv .interval .f{fill:#5b7c99;fill-opacity:.15}\
.gv .s{fill:none;stroke-width:1.6;stroke-linejoin:round;stroke-linecap:round;vector-effect:non-scaling-stroke}\
.gv .band{fill-opacity:.22}.gv .hollow{fill:#fff;stroke-width:1.8}\
.gv .halo{font-size:11px;paint-order:stroke;stroke:#fff;stroke-opacity:.8;stroke-width:3;stroke-linejoin:round}\
.gv .raw .s{stroke:#999}.gv .raw .f{fill:#999}\
.gv .result .s{stroke:#0072B2}.gv .result .f{fill:#0072B2}\
.gv .reference .s{stroke:#000;stroke-dasharray:1.5 3;stroke-linecap:butt}.gv .reference .f{fill:#000}\
.gv .warning .s{stroke:#E69F00}.gv .warning .f{fill:#E69F00}\
.gv .bad .s{stroke:#D55E00}.gv .bad .f{fill:#D55E00}\
.gv .guide .s{stroke:#c8c8c8;stroke-width:.8}";

// Symbols about 0, 0.
const CIRCLE: &str = "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z";
const DIAMOND: &str = "M0-5.2L5.2 0L0 5.2L-5.2 0z";
const DOT: &str = "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0z";
const CROSS: &str = "M-4-4L4 4M-4 4L4-4";

/// Class of a role, the symbol of its points, and the symbol's class: filled, or an outline filled
/// with the paper, so that lines below do not run through it.
fn style_of(role: Role) -> (&'static str, &'static str, &'static str) {
    match role {
        Role::Raw => ("raw", CIRCLE, "s hollow"),
        Role::Result => ("result", CIRCLE, "f"),
        Role::Reference => ("reference", DOT, "f"),
        Role::Warning => ("warning", DIAMOND, "f"),
        Role::Bad => ("bad", CROSS, "s hollow"),
        Role::Interval => ("interval", DOT, "f"),
        Role::Guide => ("guide", DOT, "f"),
    }
}

/// How every figure begins.
pub(super) const BEGIN: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"gv\" width=";

/// The figure as a file of its own, or for a page: with its title and style in it, and with what a
/// screen reader says.
pub fn standalone(figure: &Figure) -> String {
    let (drawing, height) = drawing(figure);
    let (id, height) = (&figure.name, r(height));
    let root = html! {
        svg xmlns="http://www.w3.org/2000/svg" class="gv" width=(WIDTH) height=(height)
            viewBox={ "0 0 " (WIDTH) " " (height) } role="img"
            aria-labelledby={ (id) "-title " (id) "-desc" } {
            title id={ (id) "-title" } { (figure.title) }
            desc id={ (id) "-desc" } { (figure.caption) }
            style { (PreEscaped(STYLE)) }
            rect.paper width="100%" height="100%" {}
            text.title x="16" y="22" { (figure.title) }
            (drawing)
        }
    };
    escape::shown(&root.into_string()).into_owned() + "\n"
}

/// Legend and panels below the title, one below the other or two in a row, and where they end.
fn drawing(figure: &Figure) -> (Markup, f64) {
    let (mut body, mut bottom) = legend(figure);
    let all = figure.panels.len();
    let (in_row, in_column, width) = if figure.beside && all > 1 {
        (2, 1, HALF)
    } else {
        (all.max(1), all.max(1), WIDTH)
    };
    for row in figure.panels.chunks(in_row) {
        let top = bottom + 6.0;
        for (i, panels) in row.chunks(in_column).enumerate() {
            let (panels, end) = column(panels, width, top);
            let place = translate(i as f64 * (WIDTH - width), 0.0);
            body += &html! { g transform=(place) { (PreEscaped(panels)) } }.into_string();
            bottom = bottom.max(end);
        }
    }
    (PreEscaped(body), bottom)
}

/// Names of series, each once, and where their lines end.
fn legend(figure: &Figure) -> (String, f64) {
    let (mut entries, mut names) = (String::new(), Vec::<&String>::new());
    let (mut x, mut y) = (16.0, 48.0);
    for s in figure.panels.iter().flat_map(|p| &p.series) {
        if !s.has_values() || s.role == Role::Guide || names.contains(&&s.name) {
            continue;
        }
        names.push(&s.name);
        let needs = 50.0 + width_of(&s.name);
        if x > 16.0 && x + needs > WIDTH {
            (x, y) = (16.0, y + 18.0);
        }
        let (class, symbol, symbol_class) = style_of(s.role);
        let (swatch, path) = match s.mark {
            Mark::Line => ("s", "M0-4h24"),
            Mark::Points => (symbol_class, symbol),
            Mark::Shade => ("f", "M0-9h24v10H0z"),
            Mark::Band => ("f band", "M0-9h24v10H0z"),
        };
        let middle = (s.mark == Mark::Points).then_some("translate(12 -4)");
        let entry = html! {
            g class={ "entry " (class) } data-name=(s.name) transform=(translate(x, y)) {
                path class=(swatch) d=(path) transform=[middle] {}
                text x="32" { (s.name) }
            }
        };
        entries += &entry.into_string();
        x += needs;
    }
    let bottom = if names.is_empty() { 34.0 } else { y + 6.0 };
    let legend = html! { g.legend { (PreEscaped(entries)) } };
    (legend.into_string(), bottom)
}

/// Panels one below the other over one x axis, from `top` on, and where they end.
fn column(panels: &[Panel], width: f64, top: f64) -> (String, f64) {
    let ys = panels.iter().map(|p| {
        let values = p.series.iter().flat_map(|s| [&s.y, &s.low, &s.high]);
        View::new(&p.y, values.flatten(), 0.06)
    });
    let ys: Vec<View<'_>> = ys.collect();
    let labels = ys.iter().flat_map(View::ticks).map(|(_, label)| label);
    let left = r(34.0 + widest(&labels.collect::<Vec<_>>()));
    let series = || panels.iter().flat_map(|p| &p.series);
    let points = series().any(|s| s.mark == Mark::Points);
    let pad = if points { 0.04 } else { 0.0 };
    let mut shared = View::new(&panels[0].x, series().flat_map(|s| &s.x), pad);
    // Half of the last tick's label may stand over the end.
    shared.length = width - left - 22.0;
    let (mut body, mut bottom) = (String::new(), top);
    for (i, (panel, mut y)) in panels.iter().zip(ys).enumerate() {
        let mut x = shared;
        y.length = match panels.len() {
            _ if panel.equal => x.length.round(),
            _ if width < WIDTH => 220.0,
            1 => 250.0,
            _ => 130.0,
        };
        if panel.equal {
            let unit = ((x.high - x.low) / x.length).max((y.high - y.low) / y.length);
            for view in [&mut x, &mut y] {
                let middle = view.low / 2.0 + view.high / 2.0;
                let half = unit * view.length / 2.0;
                (view.low, view.high) = (middle - half, middle + half);
            }
        }
        let last = i + 1 == panels.len();
        let top = r(bottom + if panel.title.is_empty() { 0.0 } else { 20.0 });
        let plot = Plot {
            panel,
            left,
            top,
            x,
            y,
            last,
        };
        body += &plot.draw().into_string();
        bottom = top + y.length + plot.room_below();
    }
    (body, bottom + 4.0)
}

/// The part of an axis that is shown, on `length` dots.
#[derive(Clone, Copy)]
struct View<'a> {
    axis: &'a Axis,
    low: f64,
    high: f64,
    length: f64,
}

impl<'a> View<'a> {
    /// From the smallest to the largest finite value, `pad` of the span wider; on 250 dots.
    fn new(axis: &'a Axis, values: impl Iterator<Item = &'a f64>, pad: f64) -> Self {
        let values = values.chain(&axis.include).copied();
        let (mut low, mut high) = extent(values.filter(|v| v.abs() < MAX_DRAWN));
        if let Scale::Names(names) = &axis.scale {
            (low, high) = (-0.5, names.len().max(1) as f64 - 0.5);
        } else if low > high {
            (low, high) = (0.0, 1.0);
        } else if high - low <= 1e-12 * low.abs().max(high.abs()) {
            // A constant stands in the middle; so does what differs by rounding only.
            let half = if low == 0.0 { 1.0 } else { 0.05 * low.abs() };
            (low, high) = (low - half, high + half);
        } else {
            let pad = pad * (high - low);
            (low, high) = (low - pad, high + pad);
        }
        if let Some([from, to]) = axis.within.filter(|[from, to]| *from < high && *to > low) {
            (low, high) = (low.max(from), high.min(to));
        }
        let length = 250.0;
        View {
            axis,
            low,
            high,
            length,
        }
    }

    /// Dots from the lower end.
    fn at(&self, v: f64) -> f64 {
        (v - self.low) / (self.high - self.low) * self.length
    }

    /// Ticks with their labels, in units of the view.
    fn ticks(&self) -> Vec<(f64, String)> {
        let most = match self.length {
            l if l > 500.0 => 8,
            l if l > 200.0 => 5,
            _ => 4,
        };
        match &self.axis.scale {
            Scale::Hidden => Vec::new(),
            Scale::Linear => ticks(self.low, self.high, most),
            Scale::Log => log_ticks(self.low, self.high, most),
            Scale::Names(names) => {
                // As many as do not overlap when they hang.
                let step = names.len().div_ceil((self.length / 14.0) as usize).max(1);
                let shown = names.iter().enumerate().step_by(step);
                shown.map(|(i, name)| (i as f64, name.clone())).collect()
            }
        }
    }

    /// Width of the longest name, if the names are too long to stand side by side.
    fn hanging(&self) -> Option<f64> {
        let Scale::Names(names) = &self.axis.scale else {
            return None;
        };
        let long = widest(names);
        (long + 6.0 > self.length / names.len().max(1) as f64).then_some(long)
    }

    /// `velocity, m/s`.
    fn name(&self) -> String {
        match (self.axis.label.as_str(), self.axis.unit.as_str()) {
            (name, "") | ("", name) => name.to_owned(),
            (label, unit) => format!("{label}, {unit}"),
        }
    }
}

/// Smallest and largest; the first is the larger where there is none.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.fold(none, |(low, high), v| (low.min(v), high.max(v)))
}

/// A panel in its place.
struct Plot<'a> {
    panel: &'a Panel,
    left: f64,
    top: f64,
    x: View<'a>,
    y: View<'a>,
    /// Below it there is none over the same x axis: its axis is labelled.
    last: bool,
}

impl Plot<'_> {
    fn draw(&self) -> Markup {
        let (left, top, x, y) = (self.left, self.top, self.x, self.y);
        let Panel { title, equal, .. } = self.panel;
        let (width, height) = (r(x.length), y.length);
        let linear = |view: View<'_>| view.axis.scale == Scale::Linear;
        let reads = linear(x) && linear(y) && !equal;
        let plot = format!("{left} {top} {width} {height}");
        let view = format!("{} {} {} {}", x.low, x.high, y.low, y.high);
        let series = self.panel.series.iter().filter(|s| s.has_values());
        let series: Vec<&Series> = series.collect();
        let mut taken = Vec::new();
        html! {
            g.panel data-plot=[reads.then_some(plot)] data-view=[reads.then_some(view)]
                data-title=[reads.then_some(title)] data-x=[reads.then(|| x.name())]
                data-unit=[reads.then_some(&y.axis.unit)] {
                (text("panel-title", left, top - 6.0, "start", title))
                @if x.axis.scale != Scale::Hidden {
                    (self.axes())
                    rect.frame x=(left) y=(top) width=(width) height=(height) {}
                }
                svg.plot x=(left) y=(top) width=(width) height=(height) overflow="hidden" {
                    @for s in &series { (self.series(s, &mut taken)) }
                    @if series.is_empty() {
                        (text("minor", width / 2.0, height / 2.0 + 4.0, "middle", "no values"))
                    }
                }
            }
        }
    }

    /// Room for ticks and name below the plot.
    fn room_below(&self) -> f64 {
        let name = if self.x.name().is_empty() { 6.0 } else { 22.0 };
        match self.x.hanging() {
            _ if !self.last => 12.0,
            _ if self.x.axis.scale == Scale::Hidden => 8.0,
            Some(long) => 14.0 + name + 0.8 * long,
            None => 16.0 + name,
        }
    }

    /// Grid, ticks and names of the axes.
    fn axes(&self) -> Markup {
        let (left, top, x, y) = (self.left, self.top, self.x, self.y);
        let (bottom, middle) = (top + y.length, r(top + y.length / 2.0));
        let name_at = bottom + self.room_below() - 4.0;
        html! {
            g.ticks.tx {
                @for (at, label) in x.ticks().iter().map(|(v, l)| (r(left + x.at(*v)), l)) {
                    path d={ "M" (at) " " (top) "v" (y.length) } {}
                    @if self.last && x.hanging().is_some() {
                        text.minor text-anchor="end"
                            transform={ (translate(at + 3.0, bottom + 11.0)) " rotate(-50)" } { (label) }
                    } @else if self.last {
                        (text("minor", at, bottom + 15.0, "middle", label))
                    }
                }
            }
            g.ticks.ty {
                @for (at, label) in y.ticks().iter().map(|(v, l)| (r(bottom - y.at(*v)), l)) {
                    path d={ "M" (left) " " (at) "h" (r(x.length)) } {}
                    (text("minor", left - 6.0, at + 4.0, "end", label))
                }
            }
            @if self.last { (text("name", left + x.length / 2.0, name_at, "middle", &x.name())) }
            text text-anchor="middle" transform={ (translate(13.0, middle)) " rotate(-90)" } { (y.name()) }
        }
    }

    /// Dots of the plot, in which y runs down.
    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        // Far outside a point only says where its line leaves the plot.
        let place = [self.x.at(x), self.y.length - self.y.at(y)];
        let [x, y] = place.map(|v| v.clamp(-1e6, 1e6));
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    fn series(&self, s: &Series, taken: &mut Vec<[f64; 4]>) -> Markup {
        let along = |y: &[f64]| -> Vec<Option<(f64, f64)>> {
            s.x.iter().zip(y).map(|(x, y)| self.place(*x, *y)).collect()
        };
        let places = along(&s.y);
        let ends = along(&s.low).into_iter().zip(along(&s.high));
        let ends: Vec<Ends> = ends.map(|(low, high)| low.zip(high)).collect();
        let (mark, class, path) = match s.mark {
            Mark::Line => ("line", "s", path(places.iter().copied())),
            Mark::Band => ("band", "f band", band(&ends)),
            Mark::Points => ("points", "s", bars(&ends)),
            Mark::Shade => ("shade", "f", self.intervals(s)),
        };
        let points = places.iter().enumerate().filter(|_| s.mark == Mark::Points);
        let (role, symbol, symbol_class) = style_of(s.role);
        html! {
            g class={ "series " (role) } data-name=(s.name) data-mark=(mark) {
                title { (s.name) }
                g.data { path class=(class) d=(path) {} }
                @for (i, (x, y)) in points.filter_map(|(i, place)| Some((i, (*place)?))) {
                    g.at transform=(translate(x, y)) {
                        title { (self.hint(s, i)) }
                        @if s.role != Role::Guide { path class=(symbol_class) d=(symbol) {} }
                        (self.label(s, i, (x, y), taken))
                    }
                }
            }
        }
    }

    /// What hovering over a point shows: the series, where it is, value and half of its bar.
    fn hint(&self, s: &Series, i: usize) -> String {
        let Plot { x, y, .. } = self;
        if s.role == Role::Guide || self.panel.equal {
            return s.labels.get(i).unwrap_or(&s.name).clone();
        }
        let number = |view: &View<'_>, v: f64| match view.axis.scale {
            Scale::Log => format!("{:.2e}", 10_f64.powf(v)),
            _ => fixed(v, decimals_for((view.high - view.low) / 100.0)),
        };
        let at = match &x.axis.scale {
            Scale::Names(names) => names.get(i).cloned().unwrap_or_default(),
            _ => format!("{} {} {}", x.axis.label, number(x, s.x[i]), x.axis.unit),
        };
        let half = s.high.get(i).map(|high| high - s.y[i]);
        let half = half.filter(|half| half.is_finite());
        let bar = half.map_or(String::new(), |half| format!(" ± {}", number(y, half)));
        let (name, value, unit) = (&s.name, number(y, s.y[i]), &y.axis.unit);
        format!("{name}, {at}: {value}{bar} {unit}")
    }

    /// One of a single sample is seen, too.
    fn intervals(&self, s: &Series) -> String {
        let interval = |ends: &[f64]| {
            let at = |x: &f64| self.x.at(*x).clamp(0.0, self.x.length);
            let (from, to) = (at(&ends[0]), ends.last().map_or(0.0, at));
            let (from, wide, height) = (r(from), r((to - from).max(0.8)), self.y.length);
            format!("M{from} 0h{wide}v{height}h-{wide}z")
        };
        s.x.chunks(2).map(interval).collect()
    }

    /// The text of a point, right of it or left, where it covers no other; there it covers what
    /// others must not. That of a guide stands on its place.
    fn label(&self, s: &Series, i: usize, (x, y): (f64, f64), taken: &mut Vec<[f64; 4]>) -> Markup {
        let label = s.labels.get(i).map_or("", String::as_str);
        // Where it begins, its anchor, and what part of it lies before that.
        let places: &[(f64, &str, f64)] = match s.role {
            _ if s.labels.len() > MAX_LABELLED => &[],
            Role::Guide => &[(0.0, "middle", 0.5)],
            _ => &[(7.0, "start", 0.0), (-7.0, "end", 1.0)],
        };
        for (dx, anchor, before) in places {
            let x0 = x + dx - before * width_of(label);
            let [x1, y0, y1] = [x0 + width_of(label), y - 5.0, y + 6.0];
            let inside = x0 >= 0.0 && y0 >= 0.0 && x1 <= self.x.length && y1 <= self.y.length;
            let apart = |t: &[f64; 4]| x1 <= t[0] || x0 >= t[2] || y1 <= t[1] || y0 >= t[3];
            if inside && taken.iter().all(apart) {
                taken.push([x0, y0, x1, y1]);
                return text("minor halo", *dx, 4.0, anchor, label);
            }
        }
        Markup::default()
    }
}

/// A place on each of two lines, the lower first, if both are known there.
type Ends = Option<((f64, f64), (f64, f64))>;

/// The area between two lines, in pieces where both are known.
fn band(ends: &[Ends]) -> String {
    let pieces = ends.split(Option::is_none).filter(|p| !p.is_empty());
    let outline = |piece: &[Ends]| {
        let upper = piece.iter().map(|ends| ends.map(|(_, high)| high));
        let lower = piece.iter().rev().map(|ends| ends.map(|(low, _)| low));
        path(upper.chain(lower)) + "z"
    };
    pieces.map(outline).collect()
}

/// Bars of points.
fn bars(ends: &[Ends]) -> String {
    let bar = |((x, low), (_, high))| format!("M{} {}V{}", r(x), r(high), r(low));
    ends.iter().flatten().copied().map(bar).collect()
}

/// A line through places; it breaks where there is none. A lone place is a dot. Steps are half as
/// long to write as places; they lead from one rounded place to the next, so errors do not add up.
fn path(places: impl Iterator<Item = Option<(f64, f64)>>) -> String {
    let (mut path, mut last, mut length) = (String::new(), (0.0, 0.0), 0);
    for place in places.chain([None]) {
        if let Some((x, y)) = place.map(|(x, y)| (r(x), r(y))) {
            // Writing to a string cannot fail.
            let _ = match length {
                0 => write!(path, "M{x} {y}"),
                _ => write!(path, "l{} {}", r(x - last.0), r(y - last.1)),
            };
            (last, length) = ((x, y), length + 1);
        } else {
            path.push_str(if length == 1 { "h.01" } else { "" });
            length = 0;
        }
    }
    path
}

/// Nothing for an empty text.
fn text(class: &str, x: f64, y: f64, anchor: &str, content: &str) -> Markup {
    html! {
        @if !content.is_empty() {
            text class=(class) x=(r(x)) y=(r(y)) text-anchor=(anchor) { (content) }
        }
    }
}

fn translate(x: f64, y: f64) -> String {
    format!("translate({} {})", r(x), r(y))
}

/// Width of a text, about: the mean of the usual fonts.
fn width_of(text: &str) -> f64 {
    6.7 * text.chars().count() as f64
}

fn widest(texts: &[String]) -> f64 {
    texts.iter().map(|t| width_of(t)).fold(0.0, f64::max)
}

/// To a hundredth of a dot.
fn r(v: f64) -> f64 {
    (100.0 * v).round() / 100.0
}

/// Round values between `from` and `to`, about `most` of them, with labels.
fn ticks(from: f64, to: f64, most: usize) -> Vec<(f64, String)> {
    let raw = (to - from) / most as f64;
    let power = 10_f64.powf(raw.log10().floor());
    let mut steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter();
    let Some(step) = steps.find(|s| *s >= 0.8 * raw && *s > 0.0 && s.is_finite()) else {
        return Vec::new();
    };
    let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    let first = (from / step - 1e-6).ceil();
    let values = (0..=most + most / 2 + 1).map(|k| (first + k as f64) * step + 0.0);
    let values = values.take_while(|v| *v <= to + 1e-6 * step);
    values.map(|v| (v, label(v, decimals))).collect()
}

/// Plain up to six digits, else with a power of ten.
fn label(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let text = if size >= 1e7 || (size > 0.0 && size < 1e-6) {
        // Six digits at most.
        let short = format!("{value:.5e}").parse().unwrap_or(value);
        format!("{short:e}")
    } else {
        format!("{value:.decimals$}")
    };
    // A minus sign is as wide as a digit; a hyphen is not.
    text.replace('-', "−")
}

/// Ticks between two decimal logarithms: powers of ten, with 2 and 5 where these are few.
fn log_ticks(from: f64, to: f64, most: usize) -> Vec<(f64, String)> {
    let decades = to - from;
    if !(decades > 0.0 && decades < 600.0) {
        return Vec::new();
    }
    let step = (decades / most as f64).ceil() as i32;
    let shown = if decades < 2.5 { 3 } else { 1 };
    let mantissas = &[1.0, 2.0, 5.0][..shown];
    let powers = (from.floor() as i32..=to.floor() as i32).filter(|p| p % step == 0);
    let tick = |p: i32, m: f64| {
        let text = match p {
            -3..=4 => label(m * 10_f64.powi(p), usize::try_from(-p).unwrap_or(0)),
            _ => format!("{m}e{p}").replace('-', "−"),
        };
        (f64::from(p) + m.log10(), text)
    };
    let ticks = powers.flat_map(|p| mantissas.iter().map(move |m| tick(p, *m)));
    ticks
        .filter(|(v, _)| (from - 1e-9..=to + 1e-9).contains(v))
        .collect()
}
