//! Guided calibration: a recording that grows and commands in, events out.
//!
//! # Overview
//!
//! [`Session`] is a state machine without clock and without I/O. It reads the bytes of a recording
//! as they are written to the disk, by the ordinary reader, so that a replay of the recording
//! gives the same events. It finds holds block by block,
//! accepts a pose or says why not, calibrates with [`calibrate`](crate::calibrate::calibrate) after
//! every pose, and asks for the pose that lowers the predicted error most.
//!
//! The states: identify (columns, clock, units) → floor (noise at rest) → wait → capture
//! → accepted or rejected, and again, until the user finishes. Rows may stop at any time
//! ([`Session::lost`]). [`event`] has the events and commands, `docs/live.md` describes them;
//! [`folder`] is the folder of a session, which `gravical calibrate` accepts.
//!
//! All rows are held, up to a gigabyte of columns (40 hours at 100 Hz), and judged as a file for every
//! calibration: it is that of [`calibrate`](crate::calibrate::calibrate) for the recording.
//!
//! # Example
//!
//! ```
//! use gravical::live::{Event, LiveOptions, Session};
//!
//! let mut session = Session::new("desk.csv", LiveOptions::default());
//! let mut text = "t_ms,ax,ay,az\n".to_owned();
//! for i in 0..500_u32 {
//!     let noise = f64::from(i * 7919 % 61) * 1e-3;
//!     text += &format!("{},{noise:.3},{:.3},{:.3}\n", 10 * i, -noise, 9.8 + noise);
//! }
//! let events = session.bytes(text.as_bytes())?;
//! let accepted = |e: &Event| matches!(e, Event::PoseAccepted(p) if p.face.as_deref() == Some("+z"));
//! assert_eq!(events.iter().filter(|m| accepted(&m.event)).count(), 1);
//! # Ok::<(), gravical::Error>(())
//! ```

pub mod event;
pub mod folder;
mod rest;
mod session;

use crate::gravity::Gravity;
use crate::poses::face::Face;
use crate::recording::ReadOptions;

pub use event::{Command, EVENTS_VERSION, Event, Message, Pose};
pub use session::Session;

/// How a session is guided.
#[derive(Debug, Clone)]
pub struct LiveOptions {
    /// How the recording is read where it does not say so itself.
    pub read: ReadOptions,
    /// Local gravity.
    pub gravity: Gravity,
    /// Rest before the noise is known, s. Default 3.
    pub floor_s: f64,
    /// Rest before a capture begins, s. Default 0.5.
    pub settle_s: f64,
    /// Length of a capture, s. Default 2.5: with the rest before it a hold of three seconds.
    pub capture_s: f64,
    /// Accept every steady hold: repeats, and free poses before the faces, too. Default false.
    pub any_pose: bool,
}

impl Default for LiveOptions {
    fn default() -> Self {
        LiveOptions {
            read: ReadOptions::default(),
            gravity: Gravity::default(),
            floor_s: 3.0,
            settle_s: 0.5,
            capture_s: 2.5,
            any_pose: false,
        }
    }
}

/// Poses closer than this are the same, degrees.
const APART_DEG: f64 = 25.0;

/// The face with this name: `+x`; `−x` with a minus sign, too.
pub(crate) fn face_of(name: &str) -> Option<Face> {
    let name = name.replace('−', "-");
    Face::all().into_iter().find(|face| face.name() == name)
}

/// A list: `+x, -y or +z`.
fn any_of(faces: &[Face]) -> String {
    let names: Vec<String> = faces.iter().map(|f| f.name()).collect();
    match &names[..] {
        [] => "another direction".to_owned(),
        [one] => one.clone(),
        [_, _, _, _, _, _] => "any side".to_owned(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}

/// A whole sentence: it begins with a capital letter, unless that is the name of an axis, and ends with a
/// mark. Minus signs before numbers and names of faces are those of the page.
pub fn sentence(text: &str) -> String {
    let text = text.trim();
    let word = text.split(|c: char| !c.is_alphanumeric()).next();
    let is_axis = matches!(word, Some("x" | "y" | "z" | "ax" | "ay" | "az"));
    let is_counted = |c: char| c.is_ascii_digit() || matches!(c, 'x'..='z');
    let mut sentence = String::new();
    for (at, c) in text.char_indices() {
        let before = text[..at].chars().next_back().unwrap_or(' ');
        match c {
            '-' if " (,/“".contains(before) && text[at + 1..].starts_with(is_counted) => {
                sentence.push('−');
            }
            c if at == 0 && !is_axis => sentence.extend(c.to_uppercase()),
            c => sentence.push(c),
        }
    }
    if !text.is_empty() && !sentence.ends_with(['.', '!', '?', '…', ':']) {
        sentence.push('.');
    }
    sentence
}
