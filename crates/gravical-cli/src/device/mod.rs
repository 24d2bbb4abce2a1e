//! Boards: what is plugged in, and what comes from it.
//!
//! Pure, without clock and without I/O, so that it can be tested row by row and used
//! by whatever wants samples: [`wire`] (bytes to rows and what else comes) over [`lines`]
//! (of text; a line becomes a row there) and [`frames`] (of the binary format), [`board`]
//! (settings and commands), [`stamps`] (the board's clock), [`account`] (where every row
//! went), [`live`] (what a person wants to see) and [`recorder`], the state machine over
//! all of them.
//!
//! With I/O: [`serial`] (a port that is read in a thread of its own), [`ports`] (which
//! there are), [`trouble`] (why one cannot be opened), [`disk`].

pub mod account;
pub mod board;
pub mod disk;
pub mod event;
pub mod frames;
pub mod gap;
pub mod item;
pub mod lines;
pub mod live;
pub mod ports;
pub mod recorder;
pub mod serial;
pub mod stamps;
pub mod trouble;
pub mod wire;
