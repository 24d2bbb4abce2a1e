//! Filters for one channel, sample by sample: what a microcontroller runs while
//! it records.
//!
//! - [`biquad`]: one second-order section, and several in a row.
//! - [`butterworth`]: their design as low- or high-pass.
//!
//! A causal filter delays. On a recording that is there as a whole the crate
//! `gravical` runs the same sections forwards and backwards, without delay.
//!
//! # Example
//!
//! ```
//! use gravical_core::filter::biquad::{Biquad, settle, update};
//! use gravical_core::filter::butterworth::{Pass, design};
//!
//! // Fourth order, 20 Hz, at 1 kHz: two sections.
//! let mut filter = [Biquad::<f32>::default(); 2];
//! design(Pass::Low, 4, 20.0, 1000.0, &mut filter)?;
//! // The first reading starts it without a jump.
//! settle(&mut filter, 9.81);
//! let mut smooth_mps2 = 0.0;
//! for reading in [9.83, 9.80, 9.79, 9.82] {
//!     smooth_mps2 = update(&mut filter, reading);
//! }
//! assert!((smooth_mps2 - 9.81).abs() < 0.01);
//! # Ok::<(), gravical_core::filter::butterworth::DesignError>(())
//! ```

pub mod biquad;
pub mod butterworth;
