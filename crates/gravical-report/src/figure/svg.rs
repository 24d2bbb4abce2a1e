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
//!         g.data              paths with class s (stroke) or f (fill)
//!         g.at                symbols and texts, moved to their places
//! ```
//!
//! A panel over linear axes, in which the script reads values and zooms, has
//! `data-plot="x y w h"`, `data-view="x0 x1 y0 y1"`, the part of the axes that the plot shows,
//! `data-title`, `data-x` and `data-unit` (of y): a dot `(px, py)` of a path stands for
//! x0 + px/w (x1 − x0), y1 − py/h (y1 − y0), to 0.01 of a dot.

use std::fmt::Write;

use gravical::numfmt::{decimals_for, fixed};

use super::{Axis, Figure, Mark, Panel, Role, Scale, Series};

/// Writes to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($text:tt)*) => { { let _ = write!($out, $($text)*); } };
}

/// Width of a whole figure, and of a panel that stands beside others.
const WIDTH: f64 = 760.0;
const HALF: f64 = 372.0;

/// Largest number that is drawn: the difference of two must not overflow.
const MAX_DRAWN: f64 = 1e300;

/// The labels of more points than this show on hovering only.
const MAX_LABELLED: usize = 40;

/// Colours are those of Okabe and Ito (2008), which the colour blind can tell apart; dashes and
/// symbols differ too, for print in grey.
pub const STYLE: &str = "\
.gv{font-size:12px;font-family:system-ui,'DejaVu Sans','Segoe UI',sans-serif}.gv text{fill:#1a1a1a}\
.gv .minor{fill:#444;font-size:11px}.gv .panel-title,.gv .title{font-weight:bold}.gv .title{font-size:15px}\
.gv .paper{fill:#fff}.gv .frame{fill:none;stroke:#8a8a8a}.gv .ticks path{fill:none;stroke:#e3e3e3}.gv .interval .f{fill:#5b7c99;fill-opacity:.15}\
.gv .s{fill:none;stroke-width:1.6;stroke-linejoin:round;vector-effect:non-scaling-stroke}\
.gv .band{fill-opacity:.22}.gv .column{fill-opacity:.85}.gv .hollow{fill:#fff;stroke-width:1.8}\
.gv .halo{font-size:11px;paint-order:stroke;stroke:#fff;stroke-opacity:.8;stroke-width:3;stroke-linejoin:round}\
.gv .raw .s{stroke:#999}.gv .raw .f{fill:#999}.gv .raw .l{stroke-dasharray:6 3}\
.gv .result .s,.gv .z .s{stroke:#0072B2}.gv .result .f,.gv .z .f{fill:#0072B2}.gv .z .l{stroke-dasharray:2.5 2}\
.gv .reference .s{stroke:#000}.gv .reference .f{fill:#000}.gv .reference .l{stroke-dasharray:1.5 3}\
.gv .warning .s{stroke:#E69F00}.gv .warning .f{fill:#E69F00}\
.gv .x .s,.gv .bad .s{stroke:#D55E00}.gv .x .f,.gv .bad .f{fill:#D55E00}\
.gv .y .s{stroke:#009E73}.gv .y .f{fill:#009E73}.gv .y .l{stroke-dasharray:7 2.5}\
.gv .guide .s{stroke:#c8c8c8;stroke-width:.8}";

/// The same hues on a dark page, lighter where they would be too dark.
pub const DARK: &str = "\
.gv text{fill:#e6e6e6}.gv .minor{fill:#b4b9bf}.gv .paper,.gv .hollow{fill:#16191d}.gv .halo{stroke:#16191d}\
.gv .frame{stroke:#7d858d}.gv .ticks path{stroke:#30363c}.gv .interval .f{fill-opacity:.3}.gv .guide .s{stroke:#4a5057}\
.gv .raw .s{stroke:#a8a8a8}.gv .raw .f{fill:#a8a8a8}.gv .reference .s{stroke:#f0f0f0}.gv .reference .f{fill:#f0f0f0}\
.gv .result .s,.gv .z .s{stroke:#56B4E9}.gv .result .f,.gv .z .f{fill:#56B4E9}\
.gv .x .s,.gv .bad .s{stroke:#F0803C}.gv .x .f,.gv .bad .f{fill:#F0803C}.gv .y .s{stroke:#2DC89B}.gv .y .f{fill:#2DC89B}";

// Symbols about 0, 0.
pub(super) const CIRCLE: &str = "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z";
pub(super) const DIAMOND: &str = "M0-5.2L5.2 0L0 5.2L-5.2 0z";
pub(super) const DOT: &str = "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0z";
const SQUARE: &str = "M-3.5-3.5h7v7h-7z";
const TRIANGLE: &str = "M0-4.6L4.2 3.2H-4.2z";
const CROSS: &str = "M-4-4L4 4M-4 4L4-4";

/// Class of a role, the symbol of its points, and whether that is an outline.
fn style_of(role: Role) -> (&'static str, &'static str, bool) {
    match role {
        Role::Raw => ("raw", CIRCLE, true),
        Role::Result => ("result", CIRCLE, false),
        Role::Reference => ("reference", DOT, false),
        Role::Warning => ("warning", DIAMOND, false),
        Role::Bad => ("bad", CROSS, true),
        Role::X => ("x", CIRCLE, false),
        Role::Y => ("y", SQUARE, false),
        Role::Z => ("z", TRIANGLE, false),
        Role::Interval => ("interval", DOT, false),
        Role::Guide => ("guide", DOT, false),
    }
}

/// The figure as a file of its own, with its title in it; dark where the viewer is.
#[must_use]
pub fn standalone(figure: &Figure) -> String {
    let (width, drawings) = drawings(figure);
    let (mut body, mut bottom) = (String::new(), 30.0);
    // Two in a row, which end at one height.
    for row in drawings.chunks(2) {
        bottom += row.iter().map(|(_, height)| *height).fold(0.0, f64::max);
        for (i, (drawing, height)) in row.iter().enumerate() {
            let (left, top) = (i as f64 * (WIDTH - width), r(bottom - height));
            put!(
                body,
                "<g transform=\"translate({left} {top})\">{drawing}</g>"
            );
        }
    }
    let head = head(figure, &figure.name, WIDTH, bottom);
    let title = escape(&figure.title);
    format!(
        "{head}<style>{STYLE}@media (prefers-color-scheme: dark){{{DARK}}}</style>\
         <rect class=\"paper\" width=\"100%\" height=\"100%\"/><text class=\"title\" x=\"16\" y=\"22\">{title}</text>{body}</svg>\n"
    )
}

/// The figure for a page, which has its title and caption: one drawing, or one for each panel
/// where they stand side by side, so that the page can break between them.
#[must_use]
pub fn inline(figure: &Figure) -> Vec<String> {
    let (width, drawings) = drawings(figure);
    let svg = |(i, (body, height)): (usize, &(String, f64))| {
        let name = format!("{}-{}", figure.name, i + 1);
        head(figure, &name, width, *height) + body + "</svg>"
    };
    drawings.iter().enumerate().map(svg).collect()
}

/// The outermost element, with what a screen reader says.
/// How every figure begins.
pub(super) const BEGIN: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"gv\" width=";

fn head(figure: &Figure, id: &str, width: f64, height: f64) -> String {
    let (title, caption, height) = (escape(&figure.title), escape(&figure.caption), r(height));
    format!(
        "{BEGIN}\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{title}</title><desc id=\"{id}-desc\">{caption}</desc>"
    )
}

/// The drawings of a figure, all of one width, with their heights. The first carries the legend.
fn drawings(figure: &Figure) -> (f64, Vec<(String, f64)>) {
    let panels = &figure.panels;
    let together = if figure.beside {
        1
    } else {
        panels.len().max(1)
    };
    let width = if panels.len() > together { HALF } else { WIDTH };
    let (mut legend, bottom) = legend(figure, width);
    let mut top = bottom + 6.0;
    let draw = |panels| {
        let mut body = std::mem::take(&mut legend);
        let height = column(&mut body, panels, width, std::mem::replace(&mut top, 6.0));
        (body, height)
    };
    (width, panels.chunks(together).map(draw).collect())
}

/// Names of series, each once, and where their lines end.
fn legend(figure: &Figure, width: f64) -> (String, f64) {
    let mut out = String::from("<g class=\"legend\">");
    let (mut x, mut y) = (16.0, 18.0);
    let mut names: Vec<&str> = Vec::new();
    for panel in &figure.panels {
        for (i, s) in panel.series.iter().enumerate() {
            if !s.has_values() || s.role == Role::Guide || names.contains(&s.name.as_str()) {
                continue;
            }
            names.push(&s.name);
            let needs = 50.0 + width_of(&s.name);
            if x > 16.0 && x + needs > width {
                (x, y) = (16.0, y + 18.0);
            }
            let (role, ..) = style_of(s.role);
            let (name, swatch) = (escape(&s.name), swatch(s, &panel.series[..i]));
            put!(
                out,
                "<g class=\"entry {role}\" data-name=\"{name}\" transform=\"translate({} {y})\"><g>{swatch}</g><text x=\"32\">{name}</text></g>",
                r(x)
            );
            x += needs;
        }
    }
    let bottom = if names.is_empty() { 4.0 } else { y + 6.0 };
    (out + "</g>", bottom)
}

/// How a series looks; `below` are those under it.
fn swatch(s: &Series, below: &[Series]) -> String {
    const BOX: &str = "M0-9h24v10H0z";
    match s.mark {
        Mark::Line | Mark::Rule => format!("<path class=\"{}\" d=\"M0-4h24\"/>", line_class(s)),
        Mark::Points => symbol(s, "translate(12 -4)"),
        Mark::Columns => format!("<path class=\"f column\" d=\"{BOX}\"/>"),
        Mark::Shade => format!("<path class=\"f\" d=\"{BOX}\"/>"),
        // A narrow band lies on a wide one and is darker there.
        Mark::Band => {
            let alike = |o: &&Series| o.mark == Mark::Band && o.role == s.role;
            format!("<path class=\"f band\" d=\"{BOX}\"/>")
                .repeat(1 + below.iter().filter(alike).count())
        }
    }
}

/// Panels one below the other over one x axis, from `top` on; returns where they end.
fn column(out: &mut String, panels: &[Panel], width: f64, top: f64) -> f64 {
    let ys: Vec<View> = panels.iter().map(View::of_y).collect();
    let margins = panels.iter().zip(&ys).map(|(p, y)| match p.y.scale {
        Scale::Hidden => 16.0,
        _ => 34.0 + widest(y.ticks(&p.y).iter().map(|(_, label)| label)),
    });
    let left = margins.fold(16.0, f64::max);
    // Half of the last tick's label may stand over the end.
    let hidden = panels.iter().all(|p| p.x.scale == Scale::Hidden);
    let length = width - left - if hidden { 16.0 } else { 22.0 };
    let x = View::of_x(panels, length);
    let mut at = top;
    for (i, (panel, mut y)) in panels.iter().zip(ys).enumerate() {
        if !panel.title.is_empty() {
            at += 20.0;
        }
        y.length = match panel.equal {
            Some(aspect) => (length * aspect.clamp(0.1, 2.0)).round(),
            None if width < WIDTH => 220.0,
            None if panels.len() > 1 => 130.0,
            None => 250.0,
        };
        let mut x = x;
        if panel.equal.is_some() {
            let unit = ((x.high - x.low) / x.length).max((y.high - y.low) / y.length);
            for view in [&mut x, &mut y] {
                let middle = view.low / 2.0 + view.high / 2.0;
                let half = unit * view.length / 2.0;
                (view.low, view.high) = (middle - half, middle + half);
            }
        }
        let height = y.length;
        let last = i + 1 == panels.len();
        Plot {
            panel,
            left,
            top: at,
            x,
            y,
            last,
        }
        .draw(out);
        at += height;
        at += if last {
            room_below(&panel.x, length)
        } else {
            12.0
        };
    }
    at + 4.0
}

/// The part of an axis that is shown, on `length` dots.
#[derive(Clone, Copy)]
struct View {
    low: f64,
    high: f64,
    length: f64,
}

impl View {
    fn of_x(panels: &[Panel], length: f64) -> View {
        let series = || panels.iter().flat_map(|p| &p.series);
        let points = series().any(|s| s.mark == Mark::Points);
        let pad = if points { 0.04 } else { 0.0 };
        let view = View::new(&panels[0].x, series().flat_map(|s| &s.x), pad);
        View { length, ..view }
    }

    fn of_y(panel: &Panel) -> View {
        let values = panel.series.iter().flat_map(|s| [&s.y, &s.low, &s.high]);
        let columns = panel.series.iter().any(|s| s.mark == Mark::Columns);
        let zero = columns.then_some(&0.0);
        View::new(&panel.y, values.flatten().chain(zero), 0.06)
    }

    /// From the smallest to the largest finite value, `pad` of the span wider.
    fn new<'a>(axis: &'a Axis, values: impl Iterator<Item = &'a f64>, pad: f64) -> View {
        let values = values.chain(&axis.include).filter(|v| v.is_finite());
        let (low, high) = extent(values.map(|v| v.clamp(-MAX_DRAWN, MAX_DRAWN)));
        let (mut low, mut high) = if let Scale::Names(names) = &axis.scale {
            (-0.5, names.len().max(1) as f64 - 0.5)
        } else if low > high {
            (0.0, 1.0)
        } else if high - low <= 1e-12 * low.abs().max(high.abs()) {
            // A constant stands in the middle; so does what differs by rounding only.
            let half = if low == 0.0 { 1.0 } else { 0.05 * low.abs() };
            (low - half, high + half)
        } else {
            let pad = pad * (high - low);
            (low - pad, high + pad)
        };
        if let Some([from, to]) = axis.within.filter(|[from, to]| *from < high && *to > low) {
            (low, high) = (low.max(from), high.min(to));
        }
        let length = 250.0;
        View { low, high, length }
    }

    /// Dots from the lower end.
    fn at(&self, v: f64) -> f64 {
        (v - self.low) / (self.high - self.low) * self.length
    }

    /// Ticks with their labels, in units of the view.
    fn ticks(&self, axis: &Axis) -> Vec<(f64, String)> {
        let most = match self.length {
            l if l > 500.0 => 8,
            l if l > 200.0 => 5,
            _ => 4,
        };
        match &axis.scale {
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
    x: View,
    y: View,
    /// Below it there is none over the same x axis: its axis is labelled.
    last: bool,
}

impl Plot<'_> {
    fn draw(&self, out: &mut String) {
        let Plot { panel, x, y, .. } = self;
        let (left, top, width, height) = (r(self.left), r(self.top), r(x.length), y.length);
        out.push_str("<g class=\"panel\"");
        let linear = |axis: &Axis| axis.scale == Scale::Linear;
        if linear(&panel.x) && linear(&panel.y) && panel.equal.is_none() {
            put!(
                out,
                " data-plot=\"{left} {top} {width} {height}\" data-view=\"{} {} {} {}\" data-title=\"{}\" data-x=\"{}\" data-unit=\"{}\"",
                x.low,
                x.high,
                y.low,
                y.high,
                escape(&panel.title),
                escape(&axis_name(&panel.x)),
                escape(&panel.y.unit)
            );
        }
        out.push('>');
        text(out, "panel-title", left, top - 6.0, "start", &panel.title);
        let place = format!("x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"");
        if panel.x.scale != Scale::Hidden {
            self.axes(out);
            put!(out, "<rect class=\"frame\" {place}/>");
        }
        put!(out, "<svg class=\"plot\" {place} overflow=\"hidden\">");
        let mut taken = self.symbols();
        let series: Vec<&Series> = panel.series.iter().filter(|s| s.has_values()).collect();
        for s in &series {
            self.series(out, s, &mut taken);
        }
        if series.is_empty() {
            let (x, y) = (width / 2.0, height / 2.0 + 4.0);
            text(out, "minor", x, y, "middle", "no values");
        }
        out.push_str("</svg></g>");
    }

    /// Grid, ticks and names of the axes.
    fn axes(&self, out: &mut String) {
        let Plot { panel, x, y, .. } = self;
        let (left, top, bottom) = (r(self.left), r(self.top), self.top + y.length);
        let hang = matches!(&panel.x.scale, Scale::Names(names) if names_hang(names, x.length));
        out.push_str("<g class=\"ticks tx\">");
        for (value, label) in x.ticks(&panel.x) {
            let at = r(left + x.at(value));
            put!(out, "<path d=\"M{at} {top}v{}\"/>", y.length);
            if self.last && hang {
                let (x, y, label) = (r(at + 3.0), r(bottom + 11.0), escape(&label));
                put!(
                    out,
                    "<text class=\"minor\" x=\"{x}\" y=\"{y}\" text-anchor=\"end\" transform=\"rotate(-50 {x} {y})\">{label}</text>"
                );
            } else if self.last {
                text(out, "minor", at, bottom + 15.0, "middle", &label);
            }
        }
        out.push_str("</g><g class=\"ticks ty\">");
        for (value, label) in y.ticks(&panel.y) {
            let at = r(bottom - y.at(value));
            put!(out, "<path d=\"M{left} {at}h{}\"/>", r(x.length));
            text(out, "minor", left - 6.0, at + 4.0, "end", &label);
        }
        out.push_str("</g>");
        if self.last {
            let (at, name) = (
                bottom + room_below(&panel.x, x.length) - 4.0,
                axis_name(&panel.x),
            );
            text(out, "name", left + x.length / 2.0, at, "middle", &name);
        }
        let (middle, name) = (r(top + y.length / 2.0), escape(&axis_name(&panel.y)));
        put!(
            out,
            "<text x=\"13\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 13 {middle})\">{name}</text>"
        );
    }

    /// Dots of the plot, in which y runs down.
    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        // Far outside a point only says where its line leaves the plot.
        let place = [self.x.at(x), self.y.length - self.y.at(y)];
        let [x, y] = place.map(|v| v.clamp(-1e6, 1e6));
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    fn series(&self, out: &mut String, s: &Series, taken: &mut Vec<[f64; 4]>) {
        let (role, ..) = style_of(s.role);
        let name = escape(&s.name);
        let mark = match s.mark {
            Mark::Line => "line",
            Mark::Band => "band",
            _ => "",
        };
        put!(
            out,
            "<g class=\"series {role}\" data-name=\"{name}\" data-mark=\"{mark}\"><title>{name}</title><g class=\"data\">"
        );
        let mut points = String::new();
        let (class, path) = match s.mark {
            Mark::Line => {
                let places = s.x.iter().zip(&s.y).map(|(x, y)| self.place(*x, *y));
                (line_class(s), path(places))
            }
            Mark::Band => ("f band", self.band(s)),
            Mark::Points => ("s", self.points(s, &mut points, taken)),
            Mark::Columns => ("f column", self.columns(s, out)),
            Mark::Rule => {
                let levels = s.y.iter().filter_map(|y| self.place(self.x.low, *y));
                let rules = levels.map(|(_, y)| format!("M0 {}h{}", r(y), r(self.x.length)));
                (line_class(s), rules.collect())
            }
            Mark::Shade => ("f", self.intervals(s)),
        };
        put!(
            out,
            "<path class=\"{class}\" d=\"{path}\"/></g>{points}</g>"
        );
    }

    /// What hovering over a value shows: the series, where it is, value and half of its bar.
    fn hint(&self, s: &Series, i: usize) -> String {
        let (x, y) = (&self.panel.x, &self.panel.y);
        let log = |axis: &Axis, v: f64| match axis.scale {
            Scale::Log => format!("{:.2e}", 10_f64.powf(v)),
            _ => fixed(v, decimals_for((self.y.high - self.y.low) / 100.0)),
        };
        let at = match (&x.scale, s.labels.get(i)) {
            (_, Some(label)) => label.clone(),
            (Scale::Names(names), _) => names.get(i).cloned().unwrap_or_default(),
            (Scale::Log, _) => format!("{} {} {}", x.label, log(x, s.x[i]), x.unit),
            _ => s.name.clone(),
        };
        if y.scale == Scale::Hidden || s.role == Role::Guide || self.panel.equal.is_some() {
            return escape(&at);
        }
        let bar = match (s.low.get(i), s.high.get(i)) {
            (Some(low), Some(high)) if (high - low).is_finite() => {
                format!(" ± {}", log(y, (high - low) / 2.0))
            }
            _ => String::new(),
        };
        escape(&format!(
            "{}, {at}: {}{bar} {}",
            s.name,
            log(y, s.y[i]),
            y.unit
        ))
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

    fn band(&self, s: &Series) -> String {
        let ends = |i: usize| {
            let upper = self.place(s.x[i], s.high[i])?;
            Some([upper, self.place(s.x[i], s.low[i])?])
        };
        let ends: Vec<Option<[(f64, f64); 2]>> = (0..s.x.len()).map(ends).collect();
        let pieces = ends
            .split(Option::is_none)
            .filter(|piece| !piece.is_empty());
        let outline = |piece: &[Option<[(f64, f64); 2]>]| {
            let upper = piece.iter().map(|ends| Some(ends.as_ref()?[0]));
            let lower = piece.iter().rev().map(|ends| Some(ends.as_ref()?[1]));
            path(upper.chain(lower)) + "z"
        };
        pieces.map(outline).collect()
    }

    /// Columns of several series stand beside each other. Written to `out`, each with its value.
    fn columns(&self, s: &Series, out: &mut String) -> String {
        let columns = self.panel.series.iter().filter(|o| o.mark == Mark::Columns);
        let names: Vec<&str> = columns.map(|o| o.name.as_str()).collect();
        let index = names.iter().position(|n| *n == s.name).unwrap_or(0) as f64;
        let count = names.len().max(1) as f64;
        let width = (0.7 * (self.x.at(1.0) - self.x.at(0.0)) / count).max(0.5);
        for (i, (x, y)) in s.x.iter().zip(&s.y).enumerate() {
            if let (Some((x, y)), Some((_, zero))) = (self.place(*x, *y), self.place(*x, 0.0)) {
                let (left, wide) = (r(x + width * (index - count / 2.0)), r(width));
                let (top, height, hint) = (r(y.min(zero)), r((y - zero).abs()), self.hint(s, i));
                put!(
                    out,
                    "<path class=\"f column\" d=\"M{left} {top}h{wide}v{height}h-{wide}z\"><title>{hint}</title></path>"
                );
            }
        }
        String::new()
    }

    /// Writes the points to `out`; returns the path of their bars.
    fn points(&self, s: &Series, out: &mut String, taken: &mut Vec<[f64; 4]>) -> String {
        let mut bars = String::new();
        let guide = s.role == Role::Guide;
        for (i, (x, y)) in s.x.iter().zip(&s.y).enumerate() {
            let Some((px, py)) = self.place(*x, *y) else {
                continue;
            };
            let (rx, ry) = (r(px), r(py));
            let end = |ends: &[f64]| Some(self.place(*x, *ends.get(i)?)?.1);
            if let Some((low, high)) = end(&s.low).zip(end(&s.high)) {
                put!(bars, "M{rx} {}V{}", r(high), r(low));
            }
            put!(
                out,
                "<g class=\"at\" transform=\"translate({rx} {ry})\"><title>{}</title>",
                self.hint(s, i)
            );
            if !guide {
                out.push_str(&symbol(s, ""));
            }
            let label = s.labels.get(i).map_or("", String::as_str);
            let (places, class) = if guide {
                (&ON[..], "minor halo")
            } else {
                (&BESIDE[..], "halo")
            };
            // Poses of one name lie at one place.
            let again = !guide && s.labels[..i.min(s.labels.len())].iter().any(|l| l == label);
            if !label.is_empty() && s.labels.len() <= MAX_LABELLED && !again {
                self.label(out, class, label, (px, py), places, taken);
            }
            out.push_str("</g>");
        }
        bars
    }

    /// What the symbols of points cover.
    fn symbols(&self) -> Vec<[f64; 4]> {
        let points = self.panel.series.iter();
        let points = points.filter(|s| s.mark == Mark::Points && s.role != Role::Guide);
        let places = points.flat_map(|s| s.x.iter().zip(&s.y));
        let places = places.filter_map(|(x, y)| self.place(*x, *y));
        places
            .map(|(x, y)| [x - 4.0, y - 5.0, x + 4.0, y + 5.0])
            .collect()
    }

    /// Writes a text about a point at the first of the places where it covers nothing; there it
    /// covers what others must not.
    fn label(
        &self,
        out: &mut String,
        class: &str,
        label: &str,
        (x, y): (f64, f64),
        places: &[Place],
        taken: &mut Vec<[f64; 4]>,
    ) {
        for (dx, dy, anchor, before) in places {
            let from = x + dx - before * width_of(label);
            let [x0, y0, x1, y1] = [from, y + dy - 9.0, from + width_of(label), y + dy + 2.0];
            let inside = x0 >= 0.0 && y0 >= 0.0 && x1 <= self.x.length && y1 <= self.y.length;
            let apart = |t: &[f64; 4]| x1 <= t[0] || x0 >= t[2] || y1 <= t[1] || y0 >= t[3];
            if inside && taken.iter().all(apart) {
                taken.push([x0, y0, x1, y1]);
                return text(out, class, *dx, *dy, anchor, label);
            }
        }
    }
}

/// A text about a point: right and down by, anchor, and what part of it lies before that.
type Place = (f64, f64, &'static str, f64);

const ON: [Place; 1] = [(0.0, 4.0, "middle", 0.5)];
const BESIDE: [Place; 4] = [
    (7.0, 4.0, "start", 0.0),
    (-7.0, 4.0, "end", 1.0),
    (0.0, -8.0, "middle", 0.5),
    (0.0, 16.0, "middle", 0.5),
];

/// A line through places; it breaks where there is none. A lone place is a dot. Steps are half as
/// long to write as places; they lead from one rounded place to the next, so errors do not add up.
fn path(places: impl Iterator<Item = Option<(f64, f64)>>) -> String {
    let (mut path, mut last, mut length) = (String::new(), (0.0, 0.0), 0);
    for place in places.chain([None]) {
        if let Some((x, y)) = place.map(|(x, y)| (r(x), r(y))) {
            if length == 0 {
                put!(path, "M{x} {y}");
            } else {
                put!(path, "l{} {}", r(x - last.0), r(y - last.1));
            }
            (last, length) = ((x, y), length + 1);
        } else {
            path.push_str(if length == 1 { "h.01" } else { "" });
            length = 0;
        }
    }
    path
}

/// Total variation of a line, in units of its range, above which it is noise, which dashes would
/// tear to pieces: it is drawn solid.
const MAX_DASHED_VARIATION: f64 = 40.0;

fn line_class(s: &Series) -> &'static str {
    let (low, high) = extent(s.y.iter().copied());
    let steps = s.y.windows(2).map(|y| (y[1] - y[0]).abs());
    let variation: f64 = steps.filter(|step| step.is_finite()).sum();
    if variation > MAX_DASHED_VARIATION * (high - low) {
        "s"
    } else {
        "s l"
    }
}

/// An outline is filled with the paper, so that lines below do not run through it.
fn symbol(s: &Series, transform: &str) -> String {
    let (_, symbol, hollow) = style_of(s.role);
    let class = if hollow { "s hollow" } else { "f" };
    let symbol = s.symbol.unwrap_or(symbol);
    match transform {
        "" => format!("<path class=\"{class}\" d=\"{symbol}\"/>"),
        moved => format!("<path class=\"{class}\" d=\"{symbol}\" transform=\"{moved}\"/>"),
    }
}

/// Nothing for an empty text.
fn text(out: &mut String, class: &str, x: f64, y: f64, anchor: &str, content: &str) {
    if content.is_empty() {
        return;
    }
    let (x, y, content) = (r(x), r(y), escape(content));
    put!(
        out,
        "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{content}</text>"
    );
}

/// `velocity, m/s`.
fn axis_name(axis: &Axis) -> String {
    match (axis.label.as_str(), axis.unit.as_str()) {
        (name, "") | ("", name) => name.to_owned(),
        (label, unit) => format!("{label}, {unit}"),
    }
}

/// Width of a text, about: the mean of the usual fonts.
fn width_of(text: &str) -> f64 {
    6.7 * text.chars().count() as f64
}

fn widest<'a>(texts: impl IntoIterator<Item = &'a String>) -> f64 {
    texts.into_iter().map(|t| width_of(t)).fold(0.0, f64::max)
}

/// Names that are too long to stand side by side hang.
fn names_hang(names: &[String], length: f64) -> bool {
    widest(names) + 6.0 > length / names.len().max(1) as f64
}

/// Room for ticks and name below an x axis.
fn room_below(axis: &Axis, length: f64) -> f64 {
    let name = if axis_name(axis).is_empty() {
        6.0
    } else {
        22.0
    };
    match &axis.scale {
        Scale::Hidden => 8.0,
        Scale::Names(names) if names_hang(names, length) => 14.0 + name + 0.8 * widest(names),
        _ => 16.0 + name,
    }
}

/// To a hundredth of a dot.
fn r(v: f64) -> f64 {
    (100.0 * v).round() / 100.0
}

/// Without the control characters that XML does not allow; file names may have any.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\0'..' ' | '\u{7f}' | '\u{fffe}' | '\u{ffff}' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Round values between `from` and `to`, about `most` of them, with labels.
pub(super) fn ticks(from: f64, to: f64, most: usize) -> Vec<(f64, String)> {
    let raw = (to - from) / most.max(1) as f64;
    let power = 10_f64.powf(raw.log10().floor());
    let mut steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter();
    let step = steps.find(|s| *s >= 0.8 * raw).unwrap_or(f64::NAN);
    if !(step > 0.0 && step.is_finite()) {
        return Vec::new();
    }
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
    let step = (decades / most.max(1) as f64).ceil().max(1.0) as i32;
    let mantissas: &[f64] = if decades < 2.5 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let first = (from / f64::from(step)).floor() as i32 * step;
    let powers = (first..=to.floor() as i32).step_by(step as usize);
    let ticks = powers.flat_map(|p| {
        mantissas
            .iter()
            .map(move |m| (f64::from(p) + m.log10(), log_label(*m, p)))
    });
    ticks
        .filter(|(v, _)| (from - 1e-9..=to + 1e-9).contains(v))
        .collect()
}

/// A number of one digit times a power of ten.
fn log_label(mantissa: f64, power: i32) -> String {
    if (-3..=4).contains(&power) {
        let decimals = usize::try_from(-power).unwrap_or(0);
        return format!("{:.decimals$}", mantissa * 10_f64.powi(power));
    }
    format!("{mantissa}e{power}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(values: Vec<f64>) -> String {
        let y = Axis::new("<y>", "\u{1}");
        let x = (0..values.len()).map(|i| i as f64).collect();
        let line = Series::line("a", Role::Raw, x, values);
        let panel = Panel::new("", Axis::new("t", "s"), y).with(line);
        let text = standalone(&Figure::new("e", "\"E\" & more", "").with(panel));
        roxmltree::Document::parse(&text).unwrap();
        text
    }

    #[test]
    fn odd_values_are_drawn_or_said_to_be_none() {
        for values in [
            vec![1e308, -1e308],
            vec![0.0, 0.0],
            vec![f64::INFINITY, 1.0],
            vec![5e-324, 0.0],
            vec![1e15, 1e15 + 1.0],
        ] {
            let text = drawn(values);
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
        assert!(drawn(vec![f64::NAN; 3]).contains("no values"));
        assert!(standalone(&Figure::new("e", "E", "")).ends_with("</svg>\n"));
    }

    #[test]
    fn a_drawing_says_what_it_is() {
        let text = drawn(vec![0.0, 1.0]);
        let said = "aria-labelledby=\"e-title e-desc\"><title id=\"e-title\">&quot;E&quot; &amp; more</title><desc id=\"e-desc\">";
        assert!(text.contains(said), "{text}");
    }

    #[test]
    fn paths_are_short_and_break() {
        let text = drawn(vec![0.0, 1.0, f64::NAN, 0.5, f64::NAN, 0.0]);
        let path = text.split("<path class=\"s l\" d=\"").last().unwrap();
        let path = path.split('"').next().unwrap();
        assert_eq!(path.matches('M').count(), 3, "{path}");
        assert_eq!(
            (path.matches('l').count(), path.matches("h.01").count()),
            (1, 2),
            "{path}"
        );
    }

    #[test]
    fn ticks_are_round() {
        let labels = |ticks: Vec<(f64, String)>| ticks.into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(labels(ticks(-9.9, 10.2, 4)), ["−5", "0", "5", "10"]);
        assert_eq!(labels(ticks(9.803, 9.809, 4)), ["9.804", "9.806", "9.808"]);
        assert_eq!(labels(ticks(0.0, 5e9, 2)), ["0", "2e9", "4e9"]);
        let decades = ["0.01", "0.1", "1", "10", "100", "1000", "10000"];
        assert_eq!(labels(log_ticks(-2.3, 4.2, 8)), decades);
        assert_eq!(
            labels(log_ticks(-6.0, 1.0, 4)),
            ["1e−6", "1e−4", "0.01", "1"]
        );
        assert_eq!(
            labels(log_ticks(-3.1, -2.2, 5)),
            ["0.001", "0.002", "0.005"]
        );
    }

    #[test]
    fn labels_do_not_overlap() {
        let x = vec![0.0, 0.5, 0.51, 0.52, 0.53, 0.54, 1.0];
        let y = vec![0.5; 7];
        let labels = (0..7).map(|i| format!("pose {i}")).collect();
        let points = Series::points("pose", Role::X, x, y).labelled(labels);
        let panel = Panel::new("", Axis::new("x", ""), Axis::new("y", "")).with(points);
        let text = inline(&Figure::new("e", "E", "").with(panel)).concat();
        // Lone points have theirs; of those on one another as many as find room.
        let shown = |i: usize| text.contains(&format!(">pose {i}</text>"));
        assert!(shown(0) && shown(6) && (1..6).any(shown) && !(1..6).all(shown));
        assert_eq!(text.matches("<title>pose, pose ").count(), 7);
    }
}
