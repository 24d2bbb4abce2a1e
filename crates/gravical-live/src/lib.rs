//! Guided calibration: a recording that grows and commands in, events out.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! [`Session`] is a state machine without clock and without I/O. It reads the bytes of a recording
//! as they are written to the disk, by the ordinary reader, so that a replay of the recording
//! gives the same events. It finds holds block by block,
//! accepts a pose or says why not, calibrates with [`calibrate`](gravical_calibrate::calibrate::calibrate) after
//! every pose, and asks for the pose that lowers the predicted error most.
//!
//! The states: identify (columns, clock, units) → floor (noise at rest) → wait → capture
//! → accepted or rejected, and again, until the user finishes. Rows may stop at any time
//! ([`Session::lost`]). [`event`] has the events and commands, `docs/live.md` describes them;
//! [`folder`] is the folder of a session, which `gravical calibrate` accepts.
//! [`Guide`] puts the words around a session that its hosts share: the program, and the page in the browser.
//! [`recorder`] makes the recording from the bytes of a board; it has no clock and no I/O, either. [`SimulatedBoard`]
//! takes the place of a board.
//!
//! All rows are held, up to a gigabyte of columns (40 hours at 100 Hz), and judged as a file for every
//! calibration: it is that of [`calibrate`](gravical_calibrate::calibrate::calibrate) for the recording.
//!
//! # Example
//!
//! ```
//! # mod gravical { pub use gravical_live as live; pub use gravical_judge::Error; }
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
#![deny(missing_docs)]

pub mod event;
pub mod folder;
mod guide;
mod options;
mod problem;
pub mod recorder;
mod rest;
mod session;
mod simulated;
mod words;

pub use event::{Command, EVENTS_VERSION, Event, Message, Pose};
pub use guide::Guide;
pub use options::LiveOptions;
pub use session::Session;
pub use simulated::SimulatedBoard;
pub use words::sentence;
