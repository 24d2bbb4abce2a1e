//! What the columns say: functions over slices.

mod cells;
mod change;
mod clock;
mod defects;
mod encoding;
mod frozen;
mod resolution;
mod unit;

pub(crate) use cells::{HeldRows, POSSIBLE_C, fill_cells, median, trend};
pub(crate) use change::unit_change;
pub use clock::{Clock, ClockFault, ClockOptions, clock};
pub(crate) use clock::{breaks, holds_steps, regular_blanks, steadiness, sum_steps};
pub(crate) use defects::{mark_hung, repeats_are_proof, slip, unread_runs};
pub(crate) use encoding::{Encoding, are_unsigned};
pub(crate) use frozen::{frozen_axes, repeated_rows};
pub use resolution::resolution;
pub use unit::quiet_norm;
pub(crate) use unit::{AccelClaim, accel_unit, shows_gravity};
