//! Boards at serial ports: which there are, and an open one.

pub mod ports;
pub mod serial;
