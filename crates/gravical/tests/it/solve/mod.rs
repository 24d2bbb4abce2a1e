//! The solver against certified values and dense algebra.

mod dense;
mod dual;
mod nist;
mod problems;
