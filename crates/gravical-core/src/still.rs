//! Does the sensor rest: sample by sample, from the noise of the sensor itself.
//!
//! At rest the mean over a window agrees with the mean over the seconds before
//! it, but for noise. [`Statistic`] holds the two against each other, in three
//! windows at once, so that a slow move shows as well as a knock. [`Detector`]
//! says with it, live, when a rest began and when it ended; [`onset`] when the
//! motion that was noticed had begun.
//!
//! Constant velocity looks like rest to every accelerometer: hold a rest against
//! the velocity and its uncertainty before setting the velocity to zero.
//!
//! # Example
//!
//! ```
//! use gravical_core::still::{Detector, Event, Plan, RestNoise};
//!
//! // 100 Hz; 0.035 m/s² and 0.0009 rad/s of noise, VIF 1.2.
//! let noise = RestNoise::new([0.035_f32; 3], 1.2, Some(([9e-4; 3], 1.2)));
//! let mut detector: Detector<f32, 128> = Detector::new(Plan::new(100.0_f32), noise)?;
//! let mut events = 0;
//! for i in 0..400 {
//!     let pushed = if i >= 300 { 0.5 } else { 0.0 };
//!     match detector.update([pushed, 0.0, 9.81], Some([0.0; 3])) {
//!         Some(Event::Began { since }) => assert_eq!(since, 0),
//!         Some(Event::Ended { onset }) => assert!((290..=300).contains(&onset)),
//!         None => continue,
//!     }
//!     events += 1;
//! }
//! assert_eq!(events, 2);
//! # Ok::<(), gravical_core::still::TooFewSamples>(())
//! ```

mod detector;
mod learn;
mod onset;
mod plan;
mod statistic;

pub use detector::{Detector, Event, TooFewSamples};
pub use learn::Learner;
pub use onset::onset;
pub use plan::{Plan, RestNoise};
pub use statistic::{Alarm, Statistic};

/// Channels: specific force x, y, z, then angular rate x, y, z.
pub const CHANNELS: usize = 6;
