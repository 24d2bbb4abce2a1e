//! How good is it: errors per placement, left out and not, the predicted error
//! over all directions, the budget, and the checks that a verdict rests on.

pub mod checks;
pub mod errors;
pub mod predicted;
pub mod trust;
pub mod verdict;
