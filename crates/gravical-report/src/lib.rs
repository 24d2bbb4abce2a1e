//! Results of gravical for people: documents and figures.
//!
//! # Overview
//!
//! [`report`] presents each result as a [`document::Document`], which is written as text or HTML;
//! [`figure`] draws its figures. Nothing is computed here that is not in the result.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, calibrate};
//! use gravical::recording::{ReadOptions, read};
//! use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate_to};
//! use gravical_report::document::Detail;
//! use gravical_report::{figure, report};
//!
//! let folder = tempfile::tempdir()?;
//! let options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions::default()));
//! let (_, files) = simulate_to(&options, folder.path(), false)?;
//! let mut session = Vec::new();
//! for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "csv")) {
//!     session.push(read(path, &ReadOptions::default())?);
//! }
//! let result = calibrate(&session, &CalibrateOptions::default())?;
//! let figures = figure::calibration::figures(&result.calibration, None);
//! let document = report::calibration(&result.calibration, None, &figures);
//! assert!(document.to_text(Detail::Summary).contains("bias"));
//! std::fs::write(folder.path().join("report.html"), document.to_html())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

pub mod document;
pub mod figure;
mod problem;
pub mod report;
pub mod style;

/// The program of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
