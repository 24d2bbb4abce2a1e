//! What reports and the page of `gravical live` share: colours, signs, cards, buttons, and the drawing of the board.

use maud::{Markup, PreEscaped, html};

/// Colours, words and signs, buttons, cards.
pub const SHARED: &str = include_str!("shared.css");
/// The drawing of a board; 1em is a millimetre.
pub const BOARD: &str = include_str!("board.css");
/// What drawings of the board refer to, once in a page.
pub const SHEET: &str = include_str!("sheet.html");
/// A board; how it lies are the properties `--attitude` and `--level` around it.
pub const SCENE: &str = include_str!("scene.html");

/// The drawing of a board with these angles, roll, pitch and yaw in degrees. Where it has the `figure` of these angles, it
/// lies as at the cursor.
pub(crate) fn board([roll, pitch, yaw]: [f64; 3], figure: Option<&str>) -> Markup {
    // The y axis of a page points down.
    let there = format!(
        "rotateZ({:.2}deg) rotateY({pitch:.2}deg) rotateX({:.2}deg)",
        -yaw, -roll
    );
    let back = format!(
        "rotateX({roll:.2}deg) rotateY({:.2}deg) rotateZ({yaw:.2}deg)",
        -pitch
    );
    let style = format!("--attitude:{there};--level:{back}");
    html! {
        div.drawing style=(style) data-angles=[figure] aria-hidden="true" { (PreEscaped(SCENE.trim_end())) }
    }
}

/// The angles of a board whose direction `up` points up. Gravity leaves the heading open: the side with the chip is turned
/// to the camera; where it is level, x points to the right.
pub(crate) fn lying([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (roll, pitch) = (y.atan2(z), (-x).clamp(-1.0, 1.0).asin());
    let top = [roll.cos() * pitch.sin(), -roll.sin()];
    let yaw = if top[0].hypot(top[1]) < 0.05 {
        0.0
    } else {
        -0.72 - top[1].atan2(top[0])
    };
    [roll, pitch, yaw].map(f64::to_degrees)
}
