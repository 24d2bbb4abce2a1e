//! Commands and options within a sentence: what is between backticks. Pages and Markdown set them
//! as code.

/// The parts of `text`, in order, and whether they are code. A backtick without its second is text.
pub(super) fn parts(text: &str) -> impl Iterator<Item = (&str, bool)> {
    let paired = text.matches('`').count() / 2 * 2;
    let parts = text.splitn(paired + 1, '`').enumerate();
    let parts = parts.map(|(i, part)| (part, i % 2 == 1));
    parts.filter(|(part, _)| !part.is_empty())
}
