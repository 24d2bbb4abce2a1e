//! Boards: which ports there are, and what a board sends.
//!
//! Pure, without clock and without I/O, so that it can be tested row by row: [`wire`]
//! (bytes to messages) over [`lines`]; [`shape`]
//! (what the rows are, by the rules for files) with [`named`] (numbers behind names); [`board`] (settings and
//! commands), [`stamps`] (the board's clock), [`row_counts`], [`live`] (rate, rest, poses)
//! and [`recorder`], the state machine over all of them.
//!
//! With I/O: [`serial`] (a port that is read in a thread of its own), [`ports`] (the list
//! of ports), [`trouble`] (why a port cannot be opened), [`disk`].

pub mod board;
pub mod disk;
pub mod event;
pub mod gap;
pub mod item;
pub mod lines;
pub mod live;
pub mod named;
pub mod ports;
pub mod recorder;
pub mod row_counts;
pub mod serial;
pub mod shape;
pub mod stamps;
pub mod trouble;
pub mod wire;
