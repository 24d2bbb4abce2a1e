//! Axes and attitudes in words.

use gravical_fit::Face;

/// Names of the axes.
pub const AXES: [char; 3] = ['x', 'y', 'z'];

/// A direction of specific force as an attitude of the case: `x up`, or `x up, tilted 30°, z lowered`.
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
