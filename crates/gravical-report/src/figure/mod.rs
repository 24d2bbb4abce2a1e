//! What a plot shows, as data; one backend draws it as SVG.
//!
//! A [`Figure`] knows nothing of pixels: panels with axes, and series in the
//! units of the result that they come from. [`svg`] draws it (alone or inside a
//! page). [`calibration`], [`motion`] and [`noise`] make the figures of a result.
//!
//! # Long recordings
//!
//! A series of more than [`thin::LIMIT`] samples is thinned when it is made:
//! of each of [`thin::BUCKETS`] equal stretches of time the smallest and the
//! largest value of every coordinate stay, so that no spike is lost and memory
//! is bounded. [`Series::samples`] says how many samples it stands for.
//!
//! # Example
//!
//! ```
//! use gravical_report::figure::{Axis, Figure, Panel, Role, Series, svg};
//!
//! let panel = Panel::new(Axis::new("time", "s"), Axis::new("velocity", "m/s"))
//!     .with(Series::line("calibrated", Role::Calibrated, vec![0.0, 1.0, 2.0], vec![0.0, 0.4, 0.0]));
//! let figure = Figure::new("velocity", "Velocity", "One push, one stop.").with(panel);
//! assert!(svg::standalone(&figure).starts_with("<svg"));
//! ```

pub mod calibration;
mod model;
pub mod motion;
pub mod noise;
#[doc(hidden)]
pub mod svg;
#[doc(hidden)]
pub mod thin;
mod write;

pub use model::Figure;
#[doc(hidden)]
pub use model::{Arrangement, Axis, Mark, Panel, Role, Scale, Series, Stretch, Symbol};
pub use write::{check_figures, write_figures};
