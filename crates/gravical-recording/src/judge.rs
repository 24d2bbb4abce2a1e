//! What the columns say: functions over slices.

mod cells;
mod clock;
mod defects;
mod encoding;
mod unit;

pub use cells::{hold_slow, median, trend};
pub use clock::{Clock, ClockOptions, breaks, clock, holds_steps, steadiness, sum_steps};
pub(crate) use defects::resolves_noise;
pub use defects::{mark_hung, mark_zeros, slip};
pub use encoding::{Encoding, decode};
pub(crate) use unit::quiet_norms;
pub use unit::{AccelScale, accel_scale};
