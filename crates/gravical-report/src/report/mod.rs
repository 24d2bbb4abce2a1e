//! Reports: each result as a [`Document`](crate::document::Document). Every number is one
//! of the JSON result.

mod calibration;
mod check;
mod compare;
mod denoise;
mod inspection;
mod motion;
mod noise;
mod provenance;
mod temperature;

#[cfg(test)]
mod tests;

use gravical::calibration_file::GravitySource;

pub use calibration::calibration;
pub use check::check;
pub use compare::comparison;
pub use denoise::denoise;
pub use inspection::{inspection, origin};
pub use motion::motion;
pub use noise::noise;
pub use provenance::Provenance;

use crate::document::short_name;

/// How local gravity is known.
fn gravity_source(source: GravitySource) -> &'static str {
    match source {
        GravitySource::Given => "given",
        GravitySource::Latitude => "from latitude",
        GravitySource::Standard => "assumed",
    }
}
