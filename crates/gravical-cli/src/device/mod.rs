//! Boards at serial ports: which there are, an open one, and the settings of our firmware.

pub mod board;
pub mod ports;
pub mod serial;
