//! Faces: the six ways in which an axis can point straight up or down, read
//! off the data, and what names claim about them.

mod names;

pub use crate::attitude::{AXES, in_words};
pub use crate::axes::{AxisMap, CaseAxes};
pub use gravical_fit::{Face, angle_deg};
#[doc(hidden)]
pub use names::{Claim, claim};

/// Names of the axes that are meant.
pub(crate) fn axes_where(is_meant: impl Fn(usize) -> bool) -> Vec<String> {
    let axes = (0..3).filter(|axis| is_meant(*axis));
    axes.map(|axis| AXES[axis].to_string()).collect()
}
