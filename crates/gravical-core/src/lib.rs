//! The part of gravical that a microcontroller runs.
#![no_std]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod calibration;
pub mod matrix3;
mod real;
pub mod unit;

pub use real::Real;
