//! The solver against certified values, another solver and dense algebra.

mod dense;
mod dual;
mod minpack;
mod nist;
mod problems;
