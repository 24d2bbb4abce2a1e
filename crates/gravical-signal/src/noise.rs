//! Noise of a sensor at rest: Allan variances, and the fit of their model.

mod allan;
mod fit;
mod model;
mod trend;

pub use allan::{AllanPoint, AllanVariance, allan_variances};
pub use fit::{Estimate, FittedCurve, Misfit, NoiseFit, NoiseLimit, fit_noise};
pub use model::{NoiseModel, NoiseTerm};
pub use trend::{Drift, remove_trend};
