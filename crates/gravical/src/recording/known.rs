//! Text formats without a header that the lines above the rows tell.

use super::dialect::{Dialect, Header};

/// Columns of the CSV that the PC software of GENEActiv writes below its hundred lines.
const GENEACTIV: [&str; 7] = [
    "time",
    "x (g)",
    "y (g)",
    "z (g)",
    "light (lux)",
    "button",
    "temperature (C)",
];

/// Names the columns of a known format that has no header.
pub(super) fn name_columns(dialect: &mut Dialect) {
    let is_geneactiv = dialect.metadata.iter().any(|line| {
        let mut words = line.split(|c: char| !c.is_alphanumeric());
        line.starts_with("Device Type") && words.any(|w| w.eq_ignore_ascii_case("geneactiv"))
    });
    if is_geneactiv && dialect.fields == GENEACTIV.len() && dialect.header.is_none() {
        dialect.header = Some(Header {
            lines: [0, 0],
            names: GENEACTIV.map(str::to_owned).to_vec(),
            units: Vec::new(),
            texts: Vec::new(),
        });
        dialect.misfit = None;
    }
}
