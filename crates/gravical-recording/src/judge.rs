//! What the columns say: functions over slices.

mod cells;
mod clock;
mod defects;
mod encoding;
mod resolution;
mod unit;

pub(crate) use crate::units::{Encoding, POSSIBLE_C};
pub(crate) use cells::{are_many, is_sparse, median, trend};
pub use clock::{ClockFault, ClockOptions, Times, clock};
pub(crate) use clock::{
    RATES_HZ, breaks, counts_rows, holds_steps, regular_blanks, regularity, sum_steps,
};
pub(crate) use defects::{count_changes, detect_stuck, frozen_axes, repeated_rows, unread_runs};
pub(crate) use encoding::are_unsigned;
pub use resolution::resolution;
pub use unit::quiet_norm;
pub(crate) use unit::{AccelClaim, accel_unit, refuse_jump, shows_gravity};
