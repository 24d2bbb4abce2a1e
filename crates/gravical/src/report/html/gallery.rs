//! Figures inside the page.

use maud::{Markup, PreEscaped, html};

use super::DRAWINGS;
use crate::figure::{Arrangement, Figure, svg};

/// The figures of a report, of which each is shown once.
pub(super) struct Gallery<'a> {
    figures: Vec<Option<&'a Figure>>,
    /// Bytes that the page still has for drawings.
    room: usize,
}

impl<'a> Gallery<'a> {
    pub fn new(figures: &'a [Figure]) -> Self {
        Gallery {
            figures: figures.iter().map(Some).collect(),
            room: DRAWINGS,
        }
    }

    /// The figures of these names, in this order, as far as they are there.
    pub fn show(&mut self, names: &[&str]) -> Markup {
        let chosen: Vec<&Figure> = names
            .iter()
            .filter_map(|name| {
                let found = |f: &&mut Option<&'a Figure>| f.is_some_and(|f| f.name == *name);
                self.figures.iter_mut().find(found).and_then(Option::take)
            })
            .collect();
        html! { @for figure in chosen { (self.one(figure)) } }
    }

    /// Whether one of these is there and not shown yet.
    pub fn has(&self, names: &[&str]) -> bool {
        let named = |f: &&Figure| names.contains(&f.name.as_str());
        self.figures.iter().flatten().any(named)
    }

    /// Those that were not asked for.
    pub fn rest(&mut self) -> Option<Markup> {
        let left: Vec<&Figure> = self.figures.iter_mut().filter_map(Option::take).collect();
        let some = !left.is_empty();
        some.then(|| html! { @for figure in left { (self.one(figure)) } })
    }

    fn one(&mut self, figure: &Figure) -> Markup {
        let drawings = svg::inline(figure);
        let size: usize = drawings.iter().map(String::len).sum();
        let fits = size <= self.room;
        self.room -= if fits { size } else { 0 };
        let beside = figure.arrangement == Arrangement::Beside && drawings.len() > 1;
        let id = format!("figure-{}", figure.name);
        html! {
            figure id=(id) aria-labelledby={ (id) "-h" } {
                figcaption { h3 id={ (id) "-h" } { (figure.title) } p { (figure.caption) } }
                @if fits {
                    div.drawings.beside[beside] {
                        @for drawing in &drawings { div.drawing { (PreEscaped(drawing)) } }
                    }
                } @else {
                    p.note {
                        "This drawing would make the page too large; "
                        code { "--figures DIR" } " writes it as a file of its own."
                    }
                }
            }
        }
    }
}
