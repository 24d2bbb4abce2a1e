//! What the columns say: functions over slices.

mod cells;
mod clock;
mod defects;
mod encoding;
mod resolution;
mod unit;

pub(crate) use cells::{HeldRows, POSSIBLE_C, fill_cells, median, trend};
pub use clock::{Clock, ClockFault, ClockOptions, clock};
pub(crate) use clock::{RATES_HZ, breaks, holds_steps, regular_blanks, steadiness, sum_steps};
pub(crate) use defects::{
    frozen_axes, mark_hung, repeated_rows, repeats_are_proof, slip, unread_runs,
};
pub(crate) use encoding::{Encoding, are_unsigned};
pub use resolution::resolution;
pub use unit::quiet_norm;
pub(crate) use unit::{AccelClaim, accel_unit, shows_gravity, unit_change};
