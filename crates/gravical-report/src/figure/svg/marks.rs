//! Series as paths and symbols, in dots of the plot.

use std::fmt::Write;

use svg::node::element::{Group, Path, Rectangle, Text, Title};

use super::super::{Mark, Panel, Role, Scale, Series, Stretch};
use super::layout::{Map, Rect, View};
use super::pen::{clean, paint, round, text, upright};
use super::style::{Look, look_of};

/// A line as wide as its role wants.
pub(super) fn stroke(look: &Look, d: String) -> Path {
    let mut path = Path::new()
        .set("class", "s")
        .set("d", d)
        .set("stroke-linejoin", "round");
    for (key, value) in paint(look) {
        path = path.set(key, value);
    }
    if look.dash.is_empty() {
        path
    } else {
        path.set("stroke-dasharray", look.dash)
    }
}

/// A symbol at a place.
pub(super) fn symbol(look: &Look, x: f64, y: f64) -> Path {
    let path = Path::new()
        .set("d", look.symbol)
        .set("transform", place(x, y));
    if look.hollow {
        // Filled with the paper, so that lines below it do not run through it.
        path.set("class", "s hollow")
            .set("fill", "#ffffff")
            .set("stroke", look.colour)
            .set("stroke-width", 1.8)
    } else {
        path.set("class", "f").set("fill", look.colour)
    }
}

fn place(x: f64, y: f64) -> String {
    format!("translate({} {})", round(x), round(y))
}

/// Opacity of an area: a narrow band on a wide one is darker.
pub(super) fn opacity(series: &Series) -> f64 {
    match series.mark {
        Mark::Columns => 0.85,
        _ => 0.22,
    }
}

/// Opacity where areas of the same colour lie below it, as it is seen there.
pub(super) fn opacity_on(series: &Series, below: usize) -> f64 {
    round(1.0 - (0..=below).map(|_| 1.0 - opacity(series)).product::<f64>())
}

/// Ways from the lowest to the highest value above which a line is a zigzag.
const SWINGS: f64 = 40.0;

/// Dashes along a zigzag say nothing and tear it to pieces: it is drawn solid.
pub(super) fn undashed(series: &Series, look: Look) -> Look {
    let known = || series.y.iter().copied().filter(|v| v.is_finite());
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let way: f64 = known()
        .zip(known().skip(1))
        .map(|(a, b)| (b - a).abs())
        .sum();
    let zigzag = way > SWINGS * (high - low);
    let dash = if zigzag { "" } else { look.dash };
    Look { dash, ..look }
}

/// A shaded rectangle.
pub(super) fn stretch(x: f64, y: f64, w: f64, h: f64) -> Rectangle {
    Rectangle::new()
        .set("class", "stretch")
        .set("x", round(x))
        .set("y", round(y))
        .set("width", round(w))
        .set("height", round(h))
        .set("fill", "#e7eef4")
}

/// A shaded stretch of the x axis.
pub(super) fn shade(s: &Stretch, r: Rect, v: View) -> Group {
    let at = |x: f64| ((x - v.x[0]) / (v.x[1] - v.x[0]) * r.w).clamp(0.0, r.w);
    let (from, to) = (at(s.from), at(s.to));
    // A stretch of one sample is seen, too.
    let rect = stretch(from, 0.0, (to - from).max(0.8), r.h);
    Group::new()
        .set("class", "segments")
        .set("data-name", clean(&s.name))
        .add(Title::new(clean(&s.name)))
        .add(Group::new().set("class", "data").add(rect))
}

/// It has something to draw.
pub(super) fn shows(series: &Series) -> bool {
    series.y.iter().chain(&series.low).any(|v| v.is_finite())
}

/// One series.
pub(super) fn series(s: &Series, panel: &Panel, r: Rect, v: View) -> Group {
    let look = look_of(s);
    let map = Map { r, v };
    let group = Group::new()
        .set("class", format!("series {}", look.class))
        .set("data-name", clean(&s.name))
        .set("data-mark", mark_name(s.mark))
        .set("data-samples", s.samples)
        .add(Title::new(clean(&s.name)));
    let data = Group::new().set("class", "data");
    match s.mark {
        Mark::Line => {
            let look = undashed(s, look);
            group.add(data.add(stroke(&look, line(s, &map))))
        }
        Mark::Band => {
            let area = Path::new()
                .set("class", "f")
                .set("d", band(s, &map))
                .set("fill", look.colour)
                .set("fill-opacity", opacity(s));
            group.add(data.add(area))
        }
        Mark::Rule => {
            let levels = s.y.iter().filter_map(|y| map.point(v.x[0], *y));
            let d: String = levels
                .map(|(_, y)| format!("M0 {}h{}", round(y), round(r.w)))
                .collect();
            group.add(data.add(stroke(&look, d)))
        }
        Mark::Columns => group.add(data.add(columns(s, panel, &look, &map))),
        Mark::Points => points(group, s, &look, &map),
    }
}

fn mark_name(mark: Mark) -> &'static str {
    match mark {
        Mark::Line => "line",
        Mark::Band => "band",
        Mark::Points => "points",
        Mark::Columns => "columns",
        Mark::Rule => "rule",
    }
}

fn line(s: &Series, map: &Map) -> String {
    let mut pen = Pen::default();
    for (x, y) in s.x.iter().zip(&s.y) {
        match map.point(*x, *y) {
            Some(p) => pen.to(p),
            None => pen.lift(),
        }
    }
    pen.lift();
    pen.path
}

fn band(s: &Series, map: &Map) -> String {
    let mut pen = Pen::default();
    let known = |i: usize| {
        let (x, low, high) = (s.x.get(i)?, s.low.get(i)?, s.high.get(i)?);
        Some((map.point(*x, *low)?, map.point(*x, *high)?))
    };
    let mut i = 0;
    while i < s.x.len() {
        let start = i;
        while i < s.x.len() && known(i).is_some() {
            i += 1;
        }
        for p in (start..i).filter_map(|k| Some(known(k)?.1)) {
            pen.to(p);
        }
        for p in (start..i).rev().filter_map(|k| Some(known(k)?.0)) {
            pen.to(p);
        }
        pen.close();
        i += 1;
    }
    pen.path
}

/// Columns stand beside each other where several series have the same places.
fn columns(s: &Series, panel: &Panel, look: &Look, map: &Map) -> Path {
    let all = panel.series.iter().filter(|o| o.mark == Mark::Columns);
    let (mut count, mut index) = (0, 0);
    for other in all {
        if std::ptr::eq(other, s) {
            index = count;
        }
        count += 1;
    }
    let room = match panel.x.scale {
        Scale::Names(_) => (map.x(1.0) - map.x(0.0)).abs(),
        _ => map.r.w / s.x.len().max(1) as f64,
    };
    let width = (0.7 * room / f64::from(count.max(1))).max(0.5);
    let mut d = String::new();
    for (x, y) in s.x.iter().zip(&s.y) {
        if let (Some((px, py)), Some((_, zero))) = (map.point(*x, *y), map.point(*x, 0.0)) {
            let left = px + width * (f64::from(index) - f64::from(count) / 2.0);
            let (top, height) = (py.min(zero), (py - zero).abs());
            let _ = write!(
                d,
                "M{} {}h{w}v{}h-{w}z",
                round(left),
                round(top),
                round(height),
                w = round(width)
            );
        }
    }
    Path::new()
        .set("class", "f")
        .set("d", d)
        .set("fill", look.colour)
        .set("fill-opacity", opacity(s))
}

fn points(mut group: Group, s: &Series, look: &Look, map: &Map) -> Group {
    let is_shown = s.labels.len() <= MAX_LABELLED || s.role == Role::Guide;
    let mut bars = Group::new().set("class", "data");
    let mut symbols = Vec::new();
    for (i, (x, y)) in s.x.iter().zip(&s.y).enumerate() {
        let Some((px, py)) = map.point(*x, *y) else {
            continue;
        };
        let ends = s.low.get(i).zip(s.high.get(i));
        let ends = ends.and_then(|(l, h)| Some((map.point(*x, *l)?.1, map.point(*x, *h)?.1)));
        if let Some((low, high)) = ends {
            let bar = upright(px, high, low)
                .set("class", "s")
                .set("stroke", look.colour)
                .set("stroke-width", 1.6)
                .set("vector-effect", "non-scaling-stroke");
            bars = bars.add(bar);
        }
        let mut at = Group::new()
            .set("class", "at")
            .set("data-x", round(px))
            .set("data-y", round(py))
            .set("transform", place(px, py));
        if let Some((low, high)) = ends {
            at = at.set("data-pm", round((low - high) / 2.0));
        }
        if s.role != Role::Guide {
            at = at.add(symbol(look, 0.0, 0.0).set("transform", "translate(0 0)"));
        }
        if let Some(label) = s.labels.get(i).filter(|l| !l.is_empty()) {
            at = at.add(Title::new(clean(label)));
            if is_shown {
                let offset = match s.role {
                    Role::Guide => (0.0, 4.0, "middle"),
                    _ if px > map.r.w / 2.0 => (-7.0, 4.0, "end"),
                    _ => (7.0, 4.0, "start"),
                };
                at = at.add(label_at(label, offset, s.role));
            }
        }
        symbols.push(at);
    }
    group = group.add(bars);
    symbols.into_iter().fold(group, Group::add)
}

/// The labels of more points than this show on hovering only.
const MAX_LABELLED: usize = 12;

/// A label beside its point.
fn label_at(label: &str, (x, y, anchor): (f64, f64, &str), role: Role) -> Text {
    let (class, colour) = match role {
        Role::Guide => ("minor halo", "#444444"),
        _ => ("halo", "#1a1a1a"),
    };
    // A rim of paper keeps it readable on lines.
    text(label, x, y, anchor)
        .set("class", class)
        .set("fill", colour)
        .set("font-size", 11)
        .set("paint-order", "stroke")
        .set("stroke", "#ffffff")
        .set("stroke-opacity", 0.8)
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
}

/// Writes a path with steps from point to point: half as long as with places.
/// Steps are differences of rounded places, so that errors do not add up.
#[derive(Default)]
struct Pen {
    path: String,
    last: Option<(i64, i64)>,
}

impl Pen {
    fn to(&mut self, (x, y): (f64, f64)) {
        // Far outside a point only says where its line leaves the plot.
        let hundredths = |v: f64| (100.0 * v.clamp(-1e6, 1e6)).round() as i64;
        let p = (hundredths(x), hundredths(y));
        match self.last {
            None => {
                self.path.push('M');
                self.two(p);
            }
            Some(last) => {
                self.path.push('l');
                self.two((p.0 - last.0, p.1 - last.1));
            }
        }
        self.last = Some(p);
    }

    /// The line breaks. A lone point shows as a dot.
    fn lift(&mut self) {
        if self.last.take().is_some() && self.alone() {
            self.path.push_str("h.01");
        }
    }

    fn close(&mut self) {
        if self.last.take().is_some() {
            self.path.push('z');
        }
    }

    fn alone(&self) -> bool {
        self.path.rfind('M') > self.path.rfind('l') || !self.path.contains('l')
    }

    fn two(&mut self, (x, y): (i64, i64)) {
        self.number(x);
        if y >= 0 {
            self.path.push(' ');
        }
        self.number(y);
    }

    fn number(&mut self, hundredths: i64) {
        if hundredths < 0 {
            self.path.push('-');
        }
        let (whole, part) = (hundredths.abs() / 100, hundredths.abs() % 100);
        // Writing to a string cannot fail.
        let _ = match (whole, part) {
            (w, 0) => write!(self.path, "{w}"),
            (0, p) if p % 10 == 0 => write!(self.path, ".{}", p / 10),
            (w, p) if p % 10 == 0 => write!(self.path, "{w}.{}", p / 10),
            (0, p) => write!(self.path, ".{p:02}"),
            (w, p) => write!(self.path, "{w}.{p:02}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_short_and_exact() {
        let mut pen = Pen::default();
        for p in [(0.0, 1.5), (0.123, 1.0), (100.0, -3.0)] {
            pen.to(p);
        }
        assert_eq!(pen.path, "M0 1.5l.12-.5l99.88-4");
        pen.lift();
        pen.to((5.0, 5.0));
        pen.lift();
        assert!(pen.path.ends_with("M5 5h.01"), "{}", pen.path);
    }
}
