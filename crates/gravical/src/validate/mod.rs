//! How good is it: errors per placement, the predicted error over all
//! directions, and the checks that a verdict rests on.

pub mod checks;
pub mod errors;
pub mod predicted;
