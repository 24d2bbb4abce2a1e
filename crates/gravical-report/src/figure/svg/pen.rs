//! Text and lines as SVG elements: rounded, without characters that XML does not allow.

use svg::node::element::{Line, Text};

use super::style::Look;

/// Text at a place.
pub(super) fn text(content: &str, x: f64, y: f64, anchor: &str) -> Text {
    Text::new(clean(content))
        .set("x", round(x))
        .set("y", round(y))
        .set("text-anchor", anchor)
        .set("fill", "#1a1a1a")
}

/// Without the control characters that XML does not allow; file names may have
/// any.
pub(super) fn clean(text: &str) -> String {
    let allowed = |c: char| c >= ' ' && c != '\u{fffe}' && c != '\u{ffff}' && c != '\u{7f}';
    text.chars()
        .map(|c| if allowed(c) { c } else { ' ' })
        .collect()
}

pub(super) fn round(v: f64) -> f64 {
    (100.0 * v).round() / 100.0
}

/// A vertical line in dots of the plot.
pub(super) fn upright(x: f64, from: f64, to: f64) -> Line {
    Line::new()
        .set("x1", round(x))
        .set("x2", round(x))
        .set("y1", round(from))
        .set("y2", round(to))
}

/// Presentation of lines, as attributes.
pub(super) fn paint(look: &Look) -> [(&'static str, String); 4] {
    [
        ("fill", "none".to_owned()),
        ("stroke", look.colour.to_owned()),
        ("stroke-width", look.width.to_string()),
        ("vector-effect", "non-scaling-stroke".to_owned()),
    ]
}
