//! What the columns say: functions over slices.

mod cells;
mod change;
mod clock;
mod defects;
mod encoding;
mod frozen;
mod resolution;
mod unit;

pub(crate) use cells::{GYRO_HELD, Held};
pub use cells::{POSSIBLE_C, fill_cells, median, trend};
pub use change::unit_change;
pub use clock::{
    Clock, ClockFault, ClockOptions, breaks, clock, holds_steps, regular_blanks, steadiness,
    sum_steps,
};
pub(crate) use defects::{MAX_REPEATS, resolves_noise, unread_runs};
pub use defects::{mark_hung, slip};
pub(crate) use encoding::are_unsigned;
pub use encoding::{Encoding, decode};
pub use frozen::{frozen_axes, repeated_rows};
pub use resolution::resolution;
pub use unit::{
    AccelClaim, JudgedUnit, Quiet, UnitDoubt, accel_unit, quiet, quiet_norm, shows_gravity,
};
