//! A figure as a part of a page, and as a drawing of its own.
//!
//! Curves are paths on a grid that the page stretches to the room there is; texts and grid lines are placed by
//! percentages and are not stretched. So a figure has the width it is given without a script, and the script reads its
//! values back from the paths: they are the only copy of the data.

use std::fmt::Write;

use gravical::escape;
use maud::{Markup, PreEscaped, html};

use super::drawing::{Drawing, Figure};
use super::panel::{ALONE_REM, Axis, Mark, Panel, Scale, Series, signs};

/// Parts of each axis of a plot.
const GRID: f64 = 10_000.0;
/// What reaches beyond the plot is cut off there, in grids.
const BEYOND: f64 = 3.0;

/// A figure of a page, below its heading.
pub(crate) fn figure(f: &Figure) -> Markup {
    html! {
        figure id=(f.name) aria-label=(f.title) {
            div.head { figcaption { h2 { (f.title) } } }
            @if !f.caption.is_empty() { p.note { (signs(&f.caption)) } }
            @match &f.drawing {
                Drawing::Panels(panels) => {
                    @let rows = is_rows(panels);
                    div.keys { (keys(f)) output.at aria-live="off" {} }
                    div.panels.rows[rows] style=[names(panels)] {
                        @for (i, p) in panels.iter().enumerate() {
                            (panel(p, rows || i + 1 == panels.len(), i == 0))
                        }
                    }
                }
                Drawing::Beside(panels) => {
                    div.keys { (keys(f)) output.at aria-live="off" {} }
                    div.panels.beside { @for p in panels { (panel(p, true, true)) } }
                }
                Drawing::Space(space) => {
                    div.keys { (keys(f)) @if !space.note.is_empty() { span { (space.note) } } }
                    (space.markup())
                }
            }
        }
    }
}

fn is_rows(panels: &[Panel]) -> bool {
    panels.iter().any(|p| matches!(p.y.scale, Scale::Rows(_)))
}

/// Room for the names of rows, on the left.
fn names(panels: &[Panel]) -> Option<String> {
    let Scale::Rows(names) = &panels.first()?.y.scale else {
        return None;
    };
    let longest = names.iter().map(|name| name.chars().count()).max()?;
    Some(format!("--names:{:.1}rem", 1.0 + 0.44 * longest as f64))
}

fn panel(p: &Panel, last: bool, first: bool) -> Markup {
    let rows = match &p.y.scale {
        Scale::Rows(names) => Some(names.len()),
        _ => None,
    };
    let log = [(&p.x, "x"), (&p.y, "y")];
    let log = log.into_iter().filter(|(a, _)| a.scale == Scale::Log);
    let log = log.map(|(_, name)| name).collect::<Vec<_>>().join(" ");
    let range = |a: &Axis| {
        a.range
            .map(|v| format!("{v:.6e}").parse::<f64>().unwrap_or(v))
    };
    let range = |a: &Axis| format!("{} {}", range(a)[0], range(a)[1]);
    html! {
        div.panel data-x=(range(&p.x)) data-y=(range(&p.y)) data-unit=(p.unit) data-across=(p.x.reads)
            data-log=[Some(log).filter(|l| !l.is_empty())] data-rows=[rows] data-link=[p.link] {
            div.name { span { b { (p.name) } } output aria-live="off" { (p.note) } }
            svg.plot.labelled[last].named[last && !p.x.name.is_empty()]
                style={ "--high:" (p.height_rem) "rem" } role="img" aria-label=(p.name) {
                (plot(p, [GRID, GRID], last, first))
            }
        }
    }
}

/// Grid, texts and curves; `size` of the curves' own units.
fn plot(p: &Panel, size: [f64; 2], last: bool, first: bool) -> Markup {
    html! {
        g.gx { (vertical(p, last)) }
        g.gy { (horizontal(&p.y, first)) }
        @if last && !p.x.name.is_empty() {
            text x="100%" y="100%" dy="2.55em" text-anchor="end" { (p.x.name) }
        }
        rect.frame width="100%" height="100%" {}
        svg.data width="100%" height="100%" viewBox={ "0 0 " (size[0]) " " (size[1]) }
            preserveAspectRatio="none" {
            @for s in &p.series {
                @if let Some(d) = bars(s, p, size) {
                    path.bars.(s.role.class()) data-name=(s.name) d=(d) {}
                }
                path.(s.mark.class()).(s.role.class()) data-name=(s.name) d=(path(s, p, size)) {}
            }
        }
    }
}

fn vertical(p: &Panel, labelled: bool) -> Markup {
    // Panels of rows lie side by side.
    let most = if matches!(p.y.scale, Scale::Rows(_)) {
        4.0
    } else {
        7.0
    };
    html! {
        @for (i, (share, text, zero)) in ticks(&p.x, most).into_iter().enumerate() {
            line.gridline.zero[zero] x1=(percent(share)) x2=(percent(share)) y2="100%" {}
            @if labelled {
                text.few[i % 2 == 1] x=(percent(share)) y="100%" dy="1.3em" text-anchor="middle" { (text) }
            }
        }
    }
}

fn horizontal(y: &Axis, named: bool) -> Markup {
    let (class, ticks) = match &y.scale {
        Scale::Rows(names) => {
            let share = |i: usize| 1.0 - (i as f64 + 0.5) / names.len() as f64;
            let names = names.iter().enumerate();
            let names = names.map(|(i, name)| (share(i), name.clone(), false));
            ("rowname", names.collect())
        }
        _ => ("", ticks(y, 4.0)),
    };
    html! {
        @for (share, text, zero) in ticks {
            line.gridline.zero[zero] y1=(percent(1.0 - share)) y2=(percent(1.0 - share)) x2="100%" {}
            @if named || class.is_empty() {
                text.(class) x="-7" y=(percent(1.0 - share)) dy=".35em" text-anchor="end" { (text) }
            }
        }
    }
}

fn percent(share: f64) -> String {
    format!("{:.2}%", 100.0 * share)
}

impl Mark {
    fn class(&self) -> &'static str {
        match self {
            Mark::Line(_) => "line",
            Mark::Band(_) => "band",
            Mark::Points(_) => "dots",
            Mark::Shade(_) => "shade",
            Mark::Ticks(_) => "ticks",
        }
    }
}

/// Where a place of the panel lies in a plot of this size, in which y runs down.
fn place(p: &Panel, size: [f64; 2], x: f64, y: f64) -> [f64; 2] {
    let share = |a: &Axis, v: f64| (v - a.range[0]) / (a.range[1] - a.range[0]);
    let down = match &p.y.scale {
        Scale::Rows(names) => (y + 0.5) / names.len() as f64,
        _ => 1.0 - share(&p.y, y),
    };
    [share(&p.x, x), down]
        .map(|v| v.clamp(-BEYOND, 1.0 + BEYOND))
        .into_iter()
        .zip(size)
        .map(|(share, size)| share * size)
        .collect::<Vec<f64>>()
        .try_into()
        .unwrap_or(size)
}

/// The path of a series.
fn path(s: &Series, p: &Panel, size: [f64; 2]) -> String {
    let at = |x: f64, y: f64| place(p, size, x, y);
    let r = |v: f64| rounded(v, size);
    let (x, high) = (|v: f64| place(p, size, v, 0.0)[0], size[1]);
    match &s.mark {
        Mark::Line(points) => line(points.iter().map(|[x, y]| at(*x, *y)), size),
        Mark::Band(rows) => {
            let runs = rows.split(|row| row.iter().any(|v| !v.is_finite()));
            let run = |run: &[[f64; 3]]| {
                let upper = run.iter().map(|[x, _, high]| at(*x, *high));
                let lower = run.iter().rev().map(|[x, low, _]| at(*x, *low));
                line(upper.chain(lower), size) + "z"
            };
            runs.filter(|r| !r.is_empty()).map(run).collect()
        }
        Mark::Points(points) => {
            let places = points.iter().map(|[x, y, _]| at(*x, *y));
            let places = places.filter(|p| p.iter().all(|v| v.is_finite()));
            places
                .map(|[x, y]| format!("M{} {}h0", r(x), r(y)))
                .collect()
        }
        Mark::Shade(spans) => {
            let shade = |[from, to]: &[f64; 2]| {
                let wide = r((x(*to) - x(*from)).max(8e-4 * size[0]));
                format!("M{} 0h{wide}v{high}h-{wide}z", r(x(*from)))
            };
            spans.iter().map(shade).collect()
        }
        Mark::Ticks(at) => {
            let tick = |at: &f64| format!("M{} 0v{}", r(x(*at)), r(0.07 * high));
            at.iter().map(tick).collect()
        }
    }
}

/// Horizontal bars of points, where there are any.
fn bars(s: &Series, p: &Panel, size: [f64; 2]) -> Option<String> {
    let Mark::Points(points) = &s.mark else {
        return None;
    };
    let bar = |[x, y, half]: &[f64; 3]| {
        let ([from, y], [to, _]) = (place(p, size, x - half, *y), place(p, size, x + half, *y));
        let r = |v: f64| rounded(v, size);
        format!("M{} {}h{}", r(from), r(y), r(to - from))
    };
    let barred = points.iter().filter(|b| b.iter().all(|v| v.is_finite()));
    let bars: String = barred.map(bar).collect();
    Some(bars).filter(|bars| !bars.is_empty())
}

/// A line through places; it breaks where one is not finite. Steps are half as long to write as places; they lead from
/// one rounded place to the next, so errors do not add up.
fn line(places: impl Iterator<Item = [f64; 2]>, size: [f64; 2]) -> String {
    let (mut path, mut last) = (String::new(), None);
    let r = |v: f64| rounded(v, size);
    for [x, y] in places {
        if !(x.is_finite() && y.is_finite()) {
            last = None;
            continue;
        }
        let (x, y) = (r(x), r(y));
        // Writing to a string cannot fail.
        let _ = match last {
            None => write!(path, "M{x} {y}l0 0"),
            Some((a, b)) => write!(path, " {} {}", r(x - a), r(y - b)),
        };
        last = Some((x, y));
    }
    path
}

/// To a part of the grid; a drawing in dots is finer.
fn rounded(v: f64, size: [f64; 2]) -> f64 {
    let parts = if size[0] < GRID { 10.0 } else { 1.0 };
    (parts * v).round() / parts + 0.0
}

/// The legend: each name once, with the marks of all series that have it.
fn keys(f: &Figure) -> Markup {
    let all = match &f.drawing {
        Drawing::Space(space) => &space.keys[..],
        _ => &[],
    };
    let all: Vec<&Series> = all
        .iter()
        .chain(f.panels().iter().flat_map(|p| &p.series))
        .collect();
    let mut names: Vec<&str> = Vec::new();
    for s in all.iter().filter(|s| !s.name.is_empty() && s.has_values()) {
        if !names.contains(&s.name.as_str()) {
            names.push(&s.name);
        }
    }
    html! {
        @for name in names {
            span { (symbol(all.iter().filter(|s| s.name == name))) (name) }
        }
    }
}

/// The marks of series, each kind once.
fn symbol<'s>(series: impl Iterator<Item = &'s &'s Series>) -> Markup {
    let mut drawn: Vec<(&str, &str)> = Vec::new();
    for s in series {
        let barred =
            matches!(&s.mark, Mark::Points(points) if points.iter().any(|p| p[2].is_finite()));
        let marks = barred.then_some("bars").into_iter().chain([s.mark.class()]);
        for mark in marks.map(|mark| (mark, s.role.class())) {
            if !drawn.contains(&mark) {
                drawn.push(mark);
            }
        }
    }
    let path = |mark: &str| match mark {
        "dots" => "M12 6h0",
        "ticks" => "M12 0v12",
        "line" | "bars" => "M0 6h24",
        _ => "M0 0h24v12H0z",
    };
    html! {
        svg.key viewBox="0 0 24 12" aria-hidden="true" {
            @for (mark, role) in drawn { path.(mark).(role) d=(path(mark)) {} }
        }
    }
}

/// How a file of a figure begins.
pub(super) const BEGIN: &str =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"gravical\" width=";
/// Its width, dots.
const WIDTH: f64 = 736.0;
/// Colours and strokes of a file: light, without variables, which few programs know.
const FILE_STYLE: &str = include_str!("file.css");

/// A figure as an SVG file, in dots. The plots are those of a page, with curves in dots.
pub fn standalone(f: &Figure) -> String {
    const TOP: f64 = 18.0;
    const BELOW: f64 = 26.0;
    let panels = f.panels();
    let rows = is_rows(panels);
    let beside = rows || matches!(f.drawing, Drawing::Beside(_));
    let lines = wrapped(&f.caption, 100);
    let top = 62.0 + 16.0 * lines.len() as f64;
    let room = if rows { 110.0 } else { 60.0 };
    let highs: Vec<f64> = panels.iter().map(|p| 16.0 * p.height_rem).collect();
    let columns = if beside { panels.len().max(1) } else { 1 } as f64;
    let wide = match rows {
        true => (WIDTH - room - 12.0) / columns - 12.0,
        false => (WIDTH - 12.0) / columns - room,
    };
    let high = if beside {
        highs.iter().copied().fold(0.0, f64::max) + TOP
    } else {
        highs.iter().map(|h| h + TOP + 8.0).sum()
    };
    let high = match &f.drawing {
        Drawing::Space(_) => 22.0 * ALONE_REM,
        _ => high,
    };
    let mut at = (room, top);
    let drawing = html! {
        svg xmlns="http://www.w3.org/2000/svg" class="gravical" width=(WIDTH) height=(top + high + BELOW)
            font-family="DejaVu Sans, Arial, sans-serif" role="img" aria-label=(f.title) {
            style { (PreEscaped(FILE_STYLE)) }
            rect width="100%" height="100%" fill="#fff" {}
            text x="12" y="24" font-size="16" font-weight="700" { (f.title) }
            @for (i, line) in lines.iter().enumerate() {
                text.note x="12" y=(44 + 16 * i) font-size="12" { (line) }
            }
            (file_keys(f, top - 24.0))
            @match &f.drawing {
                Drawing::Space(space) => svg x="12" y=(top) width=(WIDTH - 24.0) height=(high) { (space.markup()) },
                _ => @for (i, (p, high)) in panels.iter().zip(&highs).enumerate() {
                    text x=(at.0) y=(at.1 + 11.0) font-size="12" font-weight="600" { (p.name) @if !p.note.is_empty() { ", " (p.note) } }
                    svg x=(at.0) y=(at.1 + TOP) width=(wide) height=(high) overflow="visible" font-size="11.5" {
                        (plot(p, [wide, *high], beside || i + 1 == panels.len(), !rows || i == 0))
                    }
                    ({
                        at = match beside {
                            true => (at.0 + wide + if rows { 12.0 } else { room }, at.1),
                            false => (at.0, at.1 + high + TOP + 8.0),
                        };
                        ""
                    })
                },
            }
        }
    };
    escape::shown(&drawing.into_string()).into_owned()
}

/// The legend of a file, in one line.
fn file_keys(f: &Figure, y: f64) -> Markup {
    let markup = keys(f).into_string();
    // Each key is an svg and its name, in a span.
    let mut x = 12.0;
    let keys = markup.split("<span>").skip(1).map(|span| {
        let (symbol, rest) = span.split_once("</svg>").unwrap_or(("", span));
        let name = rest.trim_end_matches("</span>").to_owned();
        let symbol = symbol.replacen(
            "<svg ",
            "<svg x=\"0\" y=\"-10\" width=\"24\" height=\"12\" ",
            1,
        );
        let at = x;
        x += 46.0 + 6.6 * name.chars().count() as f64;
        (at, symbol + "</svg>", name)
    });
    html! {
        @for (x, symbol, name) in keys {
            g transform={ "translate(" (x) " " (y + 8.0) ")" } {
                (PreEscaped(symbol)) text.note x="30" font-size="12" { (PreEscaped(name)) }
            }
        }
    }
}

/// A text in lines of at most so many characters.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines
            .last_mut()
            .filter(|l| l.chars().count() + word.chars().count() < most)
        {
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Where round values stand along an axis, as shares of it, about `most` of them, with labels; whether it is zero.
fn ticks(a: &Axis, most: f64) -> Vec<(f64, String, bool)> {
    let [from, to] = a.range;
    let log = a.scale == Scale::Log;
    let raw = (to - from) / most;
    let power = 10_f64.powf(raw.log10().floor());
    let step = match log {
        true => Some(raw.ceil().max(1.0)),
        false => [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * power)
            .into_iter()
            .find(|s| *s >= 0.8 * raw),
    };
    let Some(step) = step.filter(|s| *s > 0.0 && s.is_finite()) else {
        return Vec::new();
    };
    let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    let first = match log {
        true => from.floor(),
        false => (from / step - 1e-6).ceil() * step,
    };
    let values = (0..40).map(|k| first + f64::from(k) * step + 0.0);
    let mantissas: &[f64] = match log && to - from < 2.5 {
        true => &[1.0, 2.0, 5.0],
        false => &[1.0],
    };
    let values = values.flat_map(|v| mantissas.iter().map(move |m| v + m.log10()));
    let inside = values.filter(|v| (from - 1e-9..=to + 1e-9).contains(v));
    let text = |v: f64| match log {
        true if (-4.0..5.0).contains(&v) => format!("{}", (10_f64.powf(v) * 1e6).round() / 1e6),
        true => format!("{:.0e}", 10_f64.powf(v)),
        false => format!("{v:.decimals$}"),
    };
    let is_zero = |v: f64| !log && v.abs() < 1e-6 * step;
    let tick = |v: f64| {
        let text = text(if is_zero(v) { 0.0 } else { v }).replace('-', "−");
        ((v - from) / (to - from), text, is_zero(v))
    };
    inside.map(tick).collect()
}
