//! Figures of results: panels with axes and series, drawn as SVG.
//!
//! A [`Figure`] knows nothing of pixels: panels with axes, and series in the units of the result that they come from,
//! or a drawing in space. It is drawn as a part of a page, or alone; [`calibration`], [`motion`], [`noise`], [`check`],
//! [`inspection`] and [`sessions`] make the figures of a result.
//!
//! # Example
//!
//! ```
//! use gravical_report::figure::{Axis, Figure, Panel, Role, Series, standalone};
//!
//! let points = [[0.0, 0.0], [1.0, 0.4], [2.0, 0.0]];
//! let line = Series::line("calibrated", Role::Result, points, &[]);
//! let axes = [Axis::new("time, s", "t = {} s", [0.0, 2.0]), Axis::new("", "", [0.0, 0.5])];
//! let panel = Panel::new("velocity", "m/s", axes, [line]);
//! let figure = Figure::new("velocity", "Velocity", "One push, one stop.", [panel]);
//! assert!(standalone(&figure).starts_with("<svg"));
//! ```

pub mod calibration;
pub mod check;
pub mod denoise;
pub(crate) mod draw;
mod drawing;
mod files;
pub mod inspection;
pub mod motion;
pub mod noise;
mod panel;
pub mod sessions;
mod space;

pub use draw::standalone;
#[doc(hidden)]
pub use drawing::Drawing;
pub use drawing::Figure;
pub use files::{check_figures, write_figures};
#[doc(hidden)]
pub use panel::{Axis, Mark, Panel, Role, Scale, Series};
pub(crate) use panel::{XYZ, signs};
