//! Cells of tables, and texts of numbers.

use maud::{Markup, html};

use super::super::text::{decimals_for, decimals_of};

/// A number of the result: `key` is its place in the JSON (a JSON pointer), `text`
/// what is read.
pub(super) fn cell(key: &str, value: f64, text: &str) -> Markup {
    html! { td.n data-k=(key) data-v=[known(value)] { (text) } }
}

/// The same in a sentence.
pub(super) fn number(key: &str, value: f64, text: &str) -> Markup {
    html! { span.n data-k=(key) data-v=[known(value)] { (text) } }
}

/// A number that may be missing, as `text` writes it.
pub(super) fn maybe(key: &str, value: Option<f64>, text: impl Fn(f64) -> String) -> Markup {
    match value {
        Some(v) => cell(key, v, &text(v)),
        None => html! { td.n { "–" } },
    }
}

/// Three cells, one for each axis.
pub(super) fn three(key: &str, values: [f64; 3], text: impl Fn(usize, f64) -> String) -> Markup {
    html! {
        @for (k, v) in values.into_iter().enumerate() {
            (cell(&format!("{key}/{k}"), v, &text(k, v)))
        }
    }
}

/// Empty cells.
pub(super) fn none(count: usize) -> Markup {
    html! { @for _ in 0..count { td.n { "–" } } }
}

/// Heads of columns: the first and those that begin with `<` stand left, over text,
/// the others right, over numbers.
pub(super) fn heads(names: &[&str]) -> Markup {
    html! {
        thead {
            tr {
                @for (i, name) in names.iter().enumerate() {
                    @match name.strip_prefix('<') {
                        Some(text) => th scope="col" { (text) },
                        None => th.n[i > 0] scope="col" { (name) },
                    }
                }
            }
        }
    }
}

/// What stands below a table that was cut.
pub(super) fn more(all: usize, shown: usize) -> Markup {
    html! {
        @if all > shown { p.note { "… and " (all - shown) " more; " code { "--json" } " has all." } }
    }
}

/// A table that scrolls by itself where it is wider than the page.
pub(super) fn table(caption: &str, head: &Markup, body: &Markup) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label=(caption) {
            table { caption { (caption) } (head) tbody { (body) } }
        }
    }
}

/// `value` with `decimals`, a true minus sign, and none before what rounds to zero.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().any(|b| matches!(b, b'1'..=b'9')) => format!("−{size}"),
        Some(size) => size.to_owned(),
        None => text,
    }
}

/// The same, with a plus before what is above zero.
pub(super) fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if value > 0.0 && text.bytes().any(|b| matches!(b, b'1'..=b'9')) {
        format!("+{text}")
    } else {
        text
    }
}

/// `value` with so many significant digits.
pub(super) fn digits(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    fixed(value, decimals_of(value, digits))
}

/// `digits`, or a power of ten where it would only show zeros.
pub(super) fn small(value: f64, count: i32) -> String {
    if value != 0.0 && value.is_finite() && value.abs() < 1e-4 {
        let precision = usize::try_from(count - 1).unwrap_or(0);
        return format!("{value:.precision$e}").replace('-', "−");
    }
    digits(value, count)
}

/// A unit as people write it; files and options say `m/s^2`.
pub(super) fn shown_unit(name: &str) -> String {
    name.replace("m/s^2", "m/s²")
}

/// `value ± sd`: with two digits of the standard deviation where there is one, else
/// with the digits that `scale` is worth.
pub(super) fn decimals_by(sd: Option<f64>, scale: f64) -> usize {
    match sd {
        Some(sd) if sd > 0.0 && sd.is_finite() => decimals_for(sd),
        _ => decimals_of(scale, 6),
    }
}

/// As JSON writes it: nothing for what is no number.
fn known(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-1.25, 1), "−1.2");
        assert_eq!(signed(0.0004, 3), "0.000");
        assert_eq!(signed(1.25, 2), "+1.25");
        assert_eq!(fixed(f64::NAN, 2), "–");
        assert_eq!(small(3.25e-6, 2), "3.2e−6");
    }

    #[test]
    fn values_keep_every_digit() {
        let text = cell("/a/0", 0.1 + 0.2, "0.3").into_string();
        assert_eq!(
            text,
            "<td class=\"n\" data-k=\"/a/0\" data-v=\"0.30000000000000004\">0.3</td>"
        );
        assert!(!cell("/a", f64::NAN, "–").into_string().contains("data-v"));
    }
}
