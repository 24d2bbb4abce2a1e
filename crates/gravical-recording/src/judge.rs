//! What the columns say: functions over slices.

mod cells;
mod change;
mod clock;
mod defects;
mod encoding;
mod frozen;
mod resolution;
mod unit;

pub(crate) use cells::{HeldRows, fill_cells};
pub use cells::{POSSIBLE_C, median, trend};
pub use change::unit_change;
pub use clock::{
    Clock, ClockFault, ClockOptions, breaks, clock, holds_steps, regular_blanks, steadiness,
    sum_steps,
};
pub use defects::{mark_hung, slip};
pub(crate) use defects::{repeats_are_proof, unread_runs};
pub use encoding::Encoding;
pub(crate) use encoding::are_unsigned;
pub use frozen::{frozen_axes, repeated_rows};
pub use resolution::resolution;
pub use unit::{AccelClaim, accel_unit, quiet_norm, shows_gravity};
