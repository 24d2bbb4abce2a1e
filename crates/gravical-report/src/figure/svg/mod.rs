//! The one backend: figures as SVG.
//!
//! # Structure, which scripts and style sheets may rely on
//!
//! ```text
//! svg.gv[role=img]            title and desc say what it is
//!   rect.paper                background (alone only)
//!   text.title                (alone only)
//!   g.legend > g.entry[data-name]
//!   g.panel[data-plot="x y w h"][data-view="x0 x1 y0 y1"][data-x][data-xu][data-y][data-yu]
//!       rect.frame, g.grid, g.ticks.tx, g.ticks.ty, text.label.lx, text.label.ly, text.panel-title
//!     svg.plot                clips to the plot; its own units are dots from its corner
//!       g.segments[data-name] > g.data > rect.stretch
//!       g.series.ROLE[data-name][data-mark][data-samples]
//!         g.data              scaled when zooming: paths with class s (stroke) or f (fill)
//!         g.at[data-x][data-y]   symbols, which keep their size; in dots; its title is
//!                                the point's label, which few points show as text too; in
//!                                series of class guide the text is all there is
//! ```
//!
//! `data-view` is the part of the axes that the plot shows, in their units: a dot
//! `(px, py)` of a path stands for x0 + px/w (x1 − x0), y1 − py/h (y1 − y0), to
//! 0.01 of a dot. An axis of names has `data-xnames`, one name a line. Of a logarithmic axis, with
//! `data-xlog` or `data-ylog`, units are decimal logarithms.

mod draw;
mod layout;
mod marks;
mod pen;
mod style;
pub(super) mod ticks;

use svg::node::element::{Description, Group, Rectangle, SVG, Style, Title};

use super::{Arrangement, Figure, Panel};
use draw::{legend, panel};
use layout::{HALF, WIDTH, place};
use pen::{clean, text};

/// The figure as a file of its own, with its title in it.
///
/// Dark where the viewer's page is dark; a program without style sheets draws it
/// light.
#[must_use]
pub fn standalone(figure: &Figure) -> String {
    let figure = &*figure.drawn();
    let (legend, bottom) = legend(figure, WIDTH, 34.0);
    let heading = text(&figure.title, 16.0, 22.0, "start")
        .set("class", "title")
        .set("font-size", 15)
        .set("font-weight", "bold");
    let titled = figure.panels.iter().any(|p| !p.title.is_empty());
    let mut body = Group::new().add(heading).add(legend);
    let height = match figure.arrangement {
        Arrangement::Stacked => {
            let panels: Vec<&Panel> = figure.panels.iter().collect();
            let (placed, height) = place(&panels, WIDTH, bottom + 8.0, false);
            for p in &placed {
                body = body.add(panel(p));
            }
            height
        }
        Arrangement::Beside => {
            let mut top = bottom + 8.0;
            for pair in figure.panels.chunks(2) {
                let mut lowest = top;
                for (i, one) in pair.iter().enumerate() {
                    let (placed, height) = place(&[one], HALF, top, titled);
                    let shift = (WIDTH - HALF) * i as f64;
                    let shifted = Group::new().set("transform", format!("translate({shift} 0)"));
                    body = body.add(placed.iter().fold(shifted, |g, p| g.add(panel(p))));
                    lowest = lowest.max(height);
                }
                top = lowest;
            }
            top
        }
    };
    let paper = Rectangle::new()
        .set("class", "paper")
        .set("width", WIDTH)
        .set("height", height)
        .set("fill", "#ffffff");
    let dark = format!("@media (prefers-color-scheme: dark){{{}}}", style::DARK);
    frame(figure, &figure.name, WIDTH, height)
        .set("xmlns", "http://www.w3.org/2000/svg")
        .set("width", WIDTH)
        .set("height", height)
        .add(Style::new(dark))
        .add(paper)
        .add(body)
        .to_string()
        + "\n"
}

/// The figure for a page: one drawing, or one for each panel where they stand
/// side by side, so that the page can break between them. The page has title and
/// caption; the first drawing carries the legend.
#[must_use]
pub fn inline(figure: &Figure) -> Vec<String> {
    let figure = &*figure.drawn();
    let (legend, bottom) = legend(figure, WIDTH, 4.0);
    let titled = figure.panels.iter().any(|p| !p.title.is_empty());
    match figure.arrangement {
        Arrangement::Stacked => {
            let panels: Vec<&Panel> = figure.panels.iter().collect();
            let (placed, height) = place(&panels, WIDTH, bottom + 6.0, false);
            let drawing = frame(figure, &figure.name, WIDTH, height).add(legend);
            vec![
                placed
                    .iter()
                    .fold(drawing, |d, p| d.add(panel(p)))
                    .to_string(),
            ]
        }
        Arrangement::Beside => {
            let (legend, bottom) = draw::legend(figure, HALF, 4.0);
            let mut legend = Some(legend);
            let drawings = figure.panels.iter().enumerate().map(|(i, one)| {
                // All alike high, with the legend in the first.
                let (placed, height) = place(&[one], HALF, bottom + 6.0, titled);
                let name = format!("{}-{}", figure.name, i + 1);
                let mut drawing = frame(figure, &name, HALF, height);
                if let Some(legend) = legend.take() {
                    drawing = drawing.add(legend);
                }
                placed
                    .iter()
                    .fold(drawing, |d, p| d.add(panel(p)))
                    .to_string()
            });
            drawings.collect()
        }
    }
}

/// Rules that make drawings inside a page dark; `gv` is the class of each.
#[must_use]
pub fn dark_rules() -> &'static str {
    style::DARK
}

/// The outermost element, with what a screen reader says.
fn frame(figure: &Figure, id: &str, width: f64, height: f64) -> SVG {
    let (title, desc) = (format!("{id}-title"), format!("{id}-desc"));
    SVG::new()
        .set("class", "gv")
        .set("viewBox", format!("0 0 {width} {height}"))
        .set("role", "img")
        .set("aria-labelledby", format!("{title} {desc}"))
        .set("font-family", style::FONT)
        .set("font-size", layout::TEXT)
        .add(Title::new(clean(&figure.title)).set("id", title))
        .add(
            Description::new()
                .set("id", desc)
                .add(svg::node::Text::new(clean(&figure.caption))),
        )
}

#[cfg(test)]
mod tests;
