//! Reports: each result as a [`Document`](crate::document::Document). Every number is one
//! of the JSON result.

mod calibration;
mod check;
mod compare;
mod denoise;
mod inspection;
mod motion;
mod moves;
mod noise;
mod placements;
mod provenance;
mod temperature;

#[cfg(test)]
mod tests;

use crate::figure::Figure;

pub use calibration::calibration;
pub use check::check;
pub use compare::comparison;
pub use denoise::denoise;
pub use inspection::inspection;
pub use motion::motion;
pub use noise::noise;
pub use provenance::Provenance;

use crate::document::short_name;

/// The figures with these names, in this order, those that exist.
fn named<'a>(figures: &'a [Figure], names: &[&str]) -> Vec<&'a Figure> {
    let find = |name: &&str| figures.iter().find(|f| f.name == *name);
    names.iter().filter_map(find).collect()
}

/// "+z", "12° off +z", or all three components if no axis is near.
fn direction(n: [f64; 3]) -> String {
    let (face, off) = gravical::poses::face::Face::nearest(n);
    match off {
        off if off < 1.0 => face.name(),
        off if off < 25.0 => format!("{off:.0}° off {}", face.name()),
        _ => format!("({})", n.map(|v| format!("{v:+.2}")).join(", ")),
    }
}
