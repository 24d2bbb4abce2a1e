//! Panels: frame, grid, ticks, labels, legend.

use svg::node::element::{Group, Path, Rectangle, SVG, Text};

use super::super::{Axis, Figure, Mark, Scale};
use super::layout::{Entry, Placed, Rect, names_hang, width_of};
use super::pen::{clean, round, text};
use super::style::{look, look_of};
use super::{layout, marks, ticks};

/// Names of a crowded axis that are shown at most.
const NAMES: usize = 48;

/// The legend from `top` on, and where it ends.
pub(super) fn legend(figure: &Figure, width: f64, top: f64) -> (Group, f64) {
    let entries = layout::legend(figure);
    let mut group = Group::new().set("class", "legend");
    if entries.is_empty() {
        return (group, top);
    }
    let (mut x, mut y) = (16.0, top + 14.0);
    for entry in &entries {
        let name = entry.name();
        let needs = 34.0 + width_of(name) + 16.0;
        if x > 16.0 && x + needs > width {
            x = 16.0;
            y += 18.0;
        }
        let one = Group::new()
            .set("class", format!("entry {}", class(entry)))
            .set("data-name", clean(name))
            .add(swatch(entry, x, y - 4.0))
            .add(text(name, x + 32.0, y, "start"));
        group = group.add(one);
        x += needs;
    }
    (group, y + 6.0)
}

fn class(entry: &Entry<'_>) -> &'static str {
    match entry {
        Entry::Series(s, _) => look(s.role).class,
        Entry::Stretch(_) => "shade",
    }
}

fn swatch(entry: &Entry<'_>, x: f64, y: f64) -> Group {
    let group = Group::new();
    match entry {
        Entry::Stretch(_) => group.add(marks::stretch(x, y - 6.0, 24.0, 12.0)),
        Entry::Series(s, below) => {
            let l = look_of(s);
            match s.mark {
                Mark::Points => group.add(marks::symbol(&l, x + 12.0, y)),
                Mark::Band | Mark::Columns => group.add(
                    Rectangle::new()
                        .set("class", "f")
                        .set("x", x)
                        .set("y", y - 5.0)
                        .set("width", 24)
                        .set("height", 10)
                        .set("fill", l.colour)
                        .set("fill-opacity", marks::opacity_on(s, *below)),
                ),
                Mark::Line | Mark::Rule => {
                    let d = format!("M{} {}h24", round(x), round(y));
                    let l = marks::undashed(s, l);
                    group.add(marks::stroke(&l, d))
                }
            }
        }
    }
}

/// One panel with all that is in it.
pub(super) fn panel(placed: &Placed<'_>) -> Group {
    let (p, r, v) = (placed.panel, placed.plot, placed.view);
    let mut group = Group::new()
        .set("class", "panel")
        .set(
            "data-plot",
            format!("{} {} {} {}", r.x, r.y, round(r.w), r.h),
        )
        .set(
            "data-view",
            format!("{} {} {} {}", v.x[0], v.x[1], v.y[0], v.y[1]),
        )
        .set("data-title", clean(&p.title));
    for (key, axis) in [("x", &p.x), ("y", &p.y)] {
        group = group
            .set(format!("data-{key}"), clean(&axis.label))
            .set(format!("data-{key}u"), clean(&axis.unit));
        group = match &axis.scale {
            Scale::Linear => group,
            Scale::Log => group.set(format!("data-{key}log"), "1"),
            Scale::Hidden => group.set(format!("data-{key}hidden"), "1"),
            Scale::Names(names) => {
                let lines: Vec<String> = names.iter().map(|n| clean(n)).collect();
                group.set(format!("data-{key}names"), lines.join("\n"))
            }
        };
    }
    if p.equal {
        group = group.set("data-equal", "1");
    }
    if placed.labelled {
        group = group.set("data-labelled", "1");
    }
    if !p.title.is_empty() {
        let title = text(&p.title, r.x, r.y - 6.0, "start");
        group = group.add(title.set("class", "panel-title").set("font-weight", "bold"));
    }
    group = axes(group, placed);
    let mut plot = SVG::new()
        .set("class", "plot")
        .set("x", r.x)
        .set("y", r.y)
        .set("width", round(r.w))
        .set("height", r.h)
        .set("overflow", "hidden");
    for s in &p.stretches {
        plot = plot.add(marks::shade(s, r, v));
    }
    for s in &p.series {
        plot = plot.add(marks::series(s, p, r, v));
    }
    group = group.add(plot);
    let empty = !p.series.iter().any(marks::shows);
    if empty {
        let note = text(
            "no values",
            r.x + r.w / 2.0,
            r.y + r.h / 2.0 + 4.0,
            "middle",
        );
        group = group.add(note.set("class", "minor").set("fill", "#555555"));
    }
    group
}

fn axes(mut group: Group, placed: &Placed<'_>) -> Group {
    let (p, r, v) = (placed.panel, placed.plot, placed.view);
    let hidden = matches!(p.x.scale, Scale::Hidden) && matches!(p.y.scale, Scale::Hidden);
    if hidden {
        return group;
    }
    let (mut grid, mut along, mut up) = (
        Group::new().set("class", "grid"),
        Group::new().set("class", "ticks tx"),
        Group::new().set("class", "ticks ty"),
    );
    let line = |d: String| {
        Path::new()
            .set("d", d)
            .set("stroke", "#e3e3e3")
            .set("stroke-width", 1)
            .set("fill", "none")
    };
    for (x, label) in places(&p.x, v.x, r.w) {
        let px = round(r.x + x);
        grid = grid.add(line(format!("M{px} {}v{}", r.y, r.h)));
        if placed.labelled {
            along = along.add(tick_below(&label, px, r, &p.x));
        }
    }
    let flipped = places(&p.y, v.y, r.h);
    for (y, label) in flipped {
        let py = round(r.y + r.h - y);
        grid = grid.add(line(format!("M{} {py}h{}", r.x, round(r.w))));
        up = up.add(minor(text(&label, r.x - 6.0, py + 4.0, "end")));
    }
    let frame = Rectangle::new()
        .set("class", "frame")
        .set("x", r.x)
        .set("y", r.y)
        .set("width", round(r.w))
        .set("height", r.h)
        .set("fill", "none")
        .set("stroke", "#8a8a8a");
    group = group.add(grid).add(frame).add(along).add(up);
    let name = p.x.text();
    if placed.labelled && !name.is_empty() {
        let y = r.y + r.h + below(&p.x, r.w);
        group = group.add(text(&name, r.x + r.w / 2.0, y, "middle").set("class", "label lx"));
    }
    let name = p.y.text();
    if !name.is_empty() {
        let (x, y) = (13.0, r.y + r.h / 2.0);
        let turned = text(&name, x, y, "middle")
            .set("class", "label ly")
            .set("transform", format!("rotate(-90 {x} {y})"));
        group = group.add(turned);
    }
    group
}

/// Where the name of an x axis stands below the plot.
fn below(axis: &Axis, w: f64) -> f64 {
    match &axis.scale {
        Scale::Names(names) if names_hang(names, w) => {
            let longest = names.iter().map(|n| width_of(n)).fold(0.0, f64::max);
            28.0 + longest.min(160.0) * 0.8
        }
        _ => 34.0,
    }
}

fn minor(text: Text) -> Text {
    text.set("class", "minor")
        .set("fill", "#444444")
        .set("font-size", 11)
}

fn tick_below(label: &str, px: f64, r: Rect, axis: &Axis) -> Text {
    let y = r.y + r.h + 15.0;
    match &axis.scale {
        Scale::Names(names) if names_hang(names, r.w) => {
            let (x, y) = (px + 3.0, y - 4.0);
            minor(text(label, x, y, "end")).set("transform", format!("rotate(-50 {x} {y})"))
        }
        _ => minor(text(label, px, y, "middle")),
    }
}

/// Ticks of an axis that is `length` dots long: distance from its start, label.
fn places(axis: &Axis, view: [f64; 2], length: f64) -> Vec<(f64, String)> {
    let at = |v: f64| (v - view[0]) / (view[1] - view[0]) * length;
    match &axis.scale {
        Scale::Hidden => Vec::new(),
        Scale::Names(names) => {
            let step = names.len().div_ceil(NAMES).max(1);
            let some = names.iter().enumerate().step_by(step);
            some.map(|(i, n)| (at(i as f64), n.clone())).collect()
        }
        Scale::Log => {
            let ticks = ticks::log_ticks(view[0], view[1], most_ticks(length));
            ticks.into_iter().map(|(v, label)| (at(v), label)).collect()
        }
        Scale::Linear => {
            let most = most_ticks(length);
            let (values, decimals) = ticks::ticks(view[0], view[1], most);
            let label = |v: f64| ticks::label(v, decimals);
            values.into_iter().map(|v| (at(v), label(v))).collect()
        }
    }
}

/// About how many ticks an axis of this length has.
fn most_ticks(length: f64) -> usize {
    if length > 500.0 {
        8
    } else if length > 200.0 {
        5
    } else {
        4
    }
}
