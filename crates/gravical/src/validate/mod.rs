//! How good is it: errors per placement, left out and not, the budget, and the checks
//! that a verdict rests on.

pub mod checks;
pub mod errors;
pub mod trust;
pub mod verdict;
