//! A figure: panels, or a drawing in space, under one title.

use super::panel::Panel;
use super::space::Space;

/// A plot under one title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file and anchor in a page: lower case, words joined by `-`.
    pub name: String,
    /// Title.
    pub title: String,
    /// What to look for, in a sentence or two; empty for nothing.
    pub caption: String,
    /// What is drawn.
    pub drawing: Drawing,
}

/// What a figure consists of.
#[derive(Debug, Clone, PartialEq)]
pub enum Drawing {
    /// Panels one below the other over one x axis, which is labelled once; or the columns of one set of rows.
    Panels(Vec<Panel>),
    /// Panels side by side, each with axes of its own.
    Beside(Vec<Panel>),
    /// A drawing in space.
    Space(Space),
}

impl Figure {
    /// A figure of these panels, one below the other or in one set of rows.
    pub fn new(
        name: &str,
        title: &str,
        caption: impl Into<String>,
        panels: impl IntoIterator<Item = Panel>,
    ) -> Self {
        Figure {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: caption.into(),
            drawing: Drawing::Panels(panels.into_iter().collect()),
        }
    }

    /// With the panels side by side.
    pub fn beside(mut self) -> Self {
        if let Drawing::Panels(panels) = self.drawing {
            self.drawing = Drawing::Beside(panels);
        }
        self
    }

    /// Its panels; none of a drawing in space.
    pub fn panels(&self) -> &[Panel] {
        match &self.drawing {
            Drawing::Panels(panels) | Drawing::Beside(panels) => panels,
            Drawing::Space(_) => &[],
        }
    }
}
