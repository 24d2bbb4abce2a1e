//! How well one direction of the temperature predicts the other.

use super::fit::Shape;

/// A drift is corrected if each direction explains this share of the variance of the other.
pub const LEAST_R2: f64 = 0.7;

/// Result of the test of one shape.
#[derive(Clone, Copy)]
pub(super) struct Tested {
    pub shape: Shape,
    pub to_warming: f64,
    pub to_cooling: f64,
}

impl Tested {
    pub fn worse(&self) -> f64 {
        self.to_warming.min(self.to_cooling)
    }

    pub fn passes(&self) -> bool {
        self.worse() >= LEAST_R2
    }
}
