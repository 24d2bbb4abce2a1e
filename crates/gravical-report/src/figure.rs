//! Figures of results: panels with axes and series, drawn as SVG.
//!
//! A [`Figure`] knows nothing of pixels: panels with axes, and series in the units of the result
//! that they come from. [`svg`] draws it, alone or for a page; [`calibration`], [`motion`] and
//! [`noise`] make the figures of a result.
//!
//! # Example
//!
//! ```
//! use gravical_report::figure::{Axis, Figure, Panel, Role, Series, svg};
//!
//! let line = Series::line("calibrated", Role::Result, [(0.0, 0.0), (1.0, 0.4), (2.0, 0.0)]);
//! let panel = Panel::new("", Axis::new("time", "s"), Axis::new("velocity", "m/s"), [line]);
//! let figure = Figure::new("velocity", "Velocity", "One push, one stop.", [panel]);
//! assert!(svg::standalone(&figure).starts_with("<svg"));
//! ```

pub mod calibration;
mod files;
pub mod motion;
pub mod noise;
mod panel;
#[doc(hidden)]
pub mod svg;

pub use files::{check_figures, write_figures};
pub use panel::Figure;
pub(crate) use panel::XYZ;
#[doc(hidden)]
pub use panel::{Axis, Mark, Panel, Role, Scale, Series};
