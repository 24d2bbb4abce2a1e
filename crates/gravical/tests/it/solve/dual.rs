//! Numbers that carry their derivatives, so that a model is written once.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Parameters at the most.
pub const MOST: usize = 9;

/// A value and its derivatives by the parameters.
#[derive(Debug, Clone, Copy)]
pub struct Dual {
    pub value: f64,
    pub by: [f64; MOST],
}

impl Dual {
    pub fn constant(value: f64) -> Self {
        Dual {
            value,
            by: [0.0; MOST],
        }
    }

    pub fn parameter(value: f64, index: usize) -> Self {
        let mut out = Self::constant(value);
        out.by[index] = 1.0;
        out
    }

    /// A function of this by its value and derivative.
    fn chain(self, value: f64, slope: f64) -> Self {
        Dual {
            value,
            by: self.by.map(|d| slope * d),
        }
    }

    pub fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }

    pub fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }

    pub fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    pub fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    pub fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }

    pub fn pow(self, exponent: Dual) -> Self {
        (exponent * self.ln()).exp()
    }

    pub fn square(self) -> Self {
        self * self
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.value, -1.0)
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, o: Dual) -> Dual {
        Dual {
            value: self.value + o.value,
            by: std::array::from_fn(|i| self.by[i] + o.by[i]),
        }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, o: Dual) -> Dual {
        self + -o
    }
}

impl Mul for Dual {
    type Output = Dual;
    #[allow(clippy::suspicious_arithmetic_impl)] // the product rule
    fn mul(self, o: Dual) -> Dual {
        Dual {
            value: self.value * o.value,
            by: std::array::from_fn(|i| self.value * o.by[i] + self.by[i] * o.value),
        }
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, o: Dual) -> Dual {
        self * o.chain(1.0 / o.value, -1.0 / (o.value * o.value))
    }
}

impl Mul<f64> for Dual {
    type Output = Dual;
    fn mul(self, o: f64) -> Dual {
        self.chain(self.value * o, o)
    }
}

impl Add<f64> for Dual {
    type Output = Dual;
    fn add(self, o: f64) -> Dual {
        self.chain(self.value + o, 1.0)
    }
}

impl Sub<f64> for Dual {
    type Output = Dual;
    fn sub(self, o: f64) -> Dual {
        self + -o
    }
}

/// f64 on the left: written as `dual(1.0) - x`.
pub fn dual(value: f64) -> Dual {
    Dual::constant(value)
}
