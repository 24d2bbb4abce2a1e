//! Results for people: as text, 80 columns wide, and as a page ([`html`]). Every
//! number comes from the same value that is written as JSON.

mod calibration;
mod check;
mod compare;
mod denoise;
mod gyroscope;
pub mod html;
mod inspection;
mod motion;
mod temperature;
mod text;
mod truth;

pub use calibration::calibration_text;
pub use check::check_text;
pub use compare::comparison_text;
pub use denoise::denoise_text;
pub use inspection::inspection_text;
pub use motion::motion_text;
pub use temperature::temperature_text;
pub(crate) use text::decimals_for;
pub use text::{findings_text, paragraph};
