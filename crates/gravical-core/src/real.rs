//! The number type of every computation: `f32` or `f64`.

use core::fmt::Debug;

use num_traits::Float;

/// A floating-point number that the computations accept: `f32` or `f64`.
///
/// The tolerances in this crate are stated for these two.
///
/// ```
/// use gravical_core::Real;
///
/// fn half<T: Real>(x: T) -> T {
///     x * T::from_f64(0.5)
/// }
/// assert_eq!(half(3.0_f32), 1.5);
/// ```
pub trait Real: Float + Debug {
    /// The nearest value of this type; infinite where `value` is out of its range.
    fn from_f64(value: f64) -> Self;
}

impl Real for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
}
