//! Faces: the six ways in which an axis can point straight up or down, read
//! off the data, and what names claim about them.

mod names;

pub use crate::axes::{AXES, AxisMap};
pub use gravical_fit::{Face, angle_deg};
#[doc(hidden)]
pub use names::{Claim, claim};

/// Names of the axes that are meant.
pub(crate) fn axes_where(is_meant: impl Fn(usize) -> bool) -> Vec<String> {
    let axes = (0..3).filter(|axis| is_meant(*axis));
    axes.map(|axis| AXES[axis].to_string()).collect()
}

/// A direction of specific force as an attitude of the case: `x up`, or `x up, tilted 30°, z lowered`.
#[doc(hidden)]
pub fn in_words(n: [f64; 3]) -> String {
    let (face, angle_deg) = Face::nearest(n);
    let name = |face: Face| AXES[face.axis];
    let up = format!("{} {}", name(face), if face.up { "up" } else { "down" });
    if angle_deg < 12.0 {
        return up;
    }
    let moved = |face: Face| {
        let how = if face.up { "raised" } else { "lowered" };
        format!("{} {how}", name(face))
    };
    let mut rest = n;
    rest[face.axis] = 0.0;
    let (second, aside_deg) = Face::nearest(rest);
    rest[second.axis] = 0.0;
    let third = if aside_deg < 15.0 {
        String::new()
    } else {
        format!(", {}", moved(Face::nearest(rest).0))
    };
    format!("{up}, tilted {angle_deg:.0}°, {}{third}", moved(second))
}
