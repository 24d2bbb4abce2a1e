//! Robust losses of a block's squared length.

/// What is done to the squared length s of a block's residuals. All are s near
/// zero; those with a constant `c` bend away from it at √s ≈ c.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Loss {
    /// s: least squares.
    Squared,
    /// c² ln(1 + s/c²): a far block hardly pulls. Needs a start that is not
    /// far off.
    Cauchy(f64),
}

impl Loss {
    /// ρ(s) and ρ′(s).
    pub(super) fn of(self, s: f64) -> (f64, f64) {
        match self {
            Loss::Squared => (s, 1.0),
            Loss::Cauchy(c) => {
                let c2 = c * c;
                (c2 * (s / c2).ln_1p(), 1.0 / (1.0 + s / c2))
            }
        }
    }
}
